// SPDX-License-Identifier: MIT
#include "engine/constraints/renumber.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {
namespace {

// The vertices that come from each input vertex.
class Descendants {
 public:
  explicit Descendants(absl::Span<const Index> original_vertex) {
    pairs_.reserve(original_vertex.size());
    for (std::size_t v = 0; v < original_vertex.size(); ++v) {
      pairs_.emplace_back(original_vertex[v], static_cast<Index>(v));
    }
    std::sort(pairs_.begin(), pairs_.end());
  }

  // Calls take(vertex) for each. field: of the constraint, for the error.
  template <class Take>
  absl::Status ForEach(Index original, const std::string& field, const Take& take) const {
    auto at = std::lower_bound(pairs_.begin(), pairs_.end(), std::pair<Index, Index>{original, 0});
    if (at == pairs_.end() || at->first != original) {
      return MakeError(
          absl::StrCat(field, ": repair has left out vertex ", original, ", which no face uses"),
          {.reason = Reason::kInvalidOption, .field = field, .remedy = "Leave the constraint out"});
    }
    for (; at != pairs_.end() && at->first == original; ++at) take(at->second);
    return absl::OkStatus();
  }

 private:
  std::vector<std::pair<Index, Index>> pairs_;
};

absl::Status RenumberSharp(const Descendants& descendants, const Constraints& constraints,
                           Constraints* result) {
  for (std::size_t c = 0; c < constraints.creases.size(); ++c) {
    CreaseConstraint crease = {.vertices = {}, .sharpness = constraints.creases[c].sharpness};
    for (std::size_t i = 0; i < constraints.creases[c].vertices.size(); ++i) {
      const std::string field = absl::StrCat("constraints.creases[", c, "].vertices[", i, "]");
      const Index original = constraints.creases[c].vertices[i];
      LIMN_RETURN_IF_ERROR(
          descendants.ForEach(original, field, [&](Index v) { crease.vertices.push_back(v); }));
      if (crease.vertices.size() == i + 1) continue;
      return MakeError(absl::StrCat(field, ": repair has split vertex ", original),
                       {.reason = Reason::kInvalidOption,
                        .field = field,
                        .index = i,
                        .remedy = "Leave the crease out, or send the repaired mesh"});
    }
    result->creases.push_back(std::move(crease));
  }
  for (std::size_t i = 0; i < constraints.corners.size(); ++i) {
    const CornerConstraint& wish = constraints.corners[i];
    LIMN_RETURN_IF_ERROR(descendants.ForEach(
        wish.vertex, absl::StrCat("constraints.corners[", i, "].vertex"), [&](Index v) {
          result->corners.push_back({v, wish.sharpness});
        }));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Constraints> RenumberConstraints(const Constraints& constraints,
                                                absl::Span<const Index> original_vertex,
                                                absl::Span<const Index> original_face) {
  const Descendants descendants(original_vertex);
  Constraints result;
  if (constraints.interpolate.has_value()) {
    result.interpolate.emplace();
    for (std::size_t i = 0; i < constraints.interpolate->size(); ++i) {
      LIMN_RETURN_IF_ERROR(descendants.ForEach(
          (*constraints.interpolate)[i], absl::StrCat("constraints.interpolate.vertices[", i, "]"),
          [&](Index v) { result.interpolate->push_back(v); }));
    }
  }
  for (std::size_t i = 0; i < constraints.normals.size(); ++i) {
    const NormalConstraint& wish = constraints.normals[i];
    LIMN_RETURN_IF_ERROR(descendants.ForEach(
        wish.vertex, absl::StrCat("constraints.normals[", i, "].vertex"), [&](Index v) {
          result.normals.push_back({v, wish.normal});
        }));
  }
  for (std::size_t i = 0; i < constraints.shape_handles.size(); ++i) {
    const ShapeHandle& wish = constraints.shape_handles[i];
    LIMN_RETURN_IF_ERROR(descendants.ForEach(
        wish.vertex, absl::StrCat("constraints.shape_handles[", i, "].vertex"), [&](Index v) {
          result.shape_handles.push_back({v, wish.value});
        }));
  }
  LIMN_RETURN_IF_ERROR(RenumberSharp(descendants, constraints, &result));
  // Faces that were left out are no holes any more.
  std::vector<Index> holes = constraints.holes;
  std::sort(holes.begin(), holes.end());
  for (std::size_t f = 0; f < original_face.size() && !holes.empty(); ++f) {
    if (std::binary_search(holes.begin(), holes.end(), original_face[f])) {
      result.holes.push_back(static_cast<Index>(f));
    }
  }
  return result;
}

}  // namespace limn
