// SPDX-License-Identifier: MIT
#include "engine/constraints/renumber.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kEntriesPerCheck = 4096;

// An entry of a list, as errors name it: before + [index] + after.
struct Entry {
  std::string before;
  std::size_t index = 0;
  std::string_view after = "";
};

absl::Status Refuse(Reason reason, const Entry& entry, std::string_view message,
                    std::string_view remedy) {
  std::string field = absl::StrCat(entry.before, "[", entry.index, "]", std::string(entry.after));
  std::string text = absl::StrCat(field, ": ", std::string(message));
  return MakeError(text, {.reason = reason,
                          .field = std::move(field),
                          .index = entry.index,
                          .remedy = std::string(remedy)});
}

absl::Status CheckRange(const Entry& entry, Index index, std::size_t count,
                        const char* what = "vertex") {
  if (index < count) return absl::OkStatus();
  return Refuse(Reason::kIndexOutOfRange, entry,
                absl::StrCat("there is no ", what, " ", index, ", the mesh has ", count),
                "Vertices and faces are counted from 0");
}

class Renumberer {
 public:
  Renumberer(const Context& context, const Constraints& given, const RepairOrigin& origin)
      : context_(context), given_(given), origin_(origin) {}

  absl::StatusOr<Constraints> Run() {
    LIMN_RETURN_IF_ERROR(FindDescendants());
    if (given_.interpolate.has_value()) {
      result_.interpolate.emplace();
      LIMN_RETURN_IF_ERROR(ForEach(
          *given_.interpolate, {"constraints.interpolate.vertices"}, [](Index v) { return v; },
          [&](Index v, Index) { result_.interpolate->push_back(v); }));
    }
    LIMN_RETURN_IF_ERROR(ForEach(
        given_.normals, {"constraints.normals", 0, ".vertex"},
        [](const NormalConstraint& wish) { return wish.vertex; },
        [&](Index v, const NormalConstraint& wish) {
          result_.normals.push_back({v, wish.normal});
        }));
    LIMN_RETURN_IF_ERROR(ForEach(
        given_.shape_handles, {"constraints.shape_handles", 0, ".vertex"},
        [](const ShapeHandle& wish) { return wish.vertex; },
        [&](Index v, const ShapeHandle& wish) {
          result_.shape_handles.push_back({v, wish.value});
        }));
    LIMN_RETURN_IF_ERROR(RenumberSurfacePoints());
    for (std::size_t c = 0; c < given_.creases.size(); ++c) {
      LIMN_RETURN_IF_ERROR(RenumberCrease(c));
    }
    LIMN_RETURN_IF_ERROR(RenumberCorners());
    LIMN_RETURN_IF_ERROR(RenumberHoles());
    LIMN_RETURN_IF_ERROR(TakeFeatures());
    return std::move(result_);
  }

 private:
  using Pair = std::pair<Index, Index>;

  // The vertices that come from each input vertex.
  absl::Status FindDescendants() {
    pairs_.reserve(origin_.vertex.size());
    for (std::size_t v = 0; v < origin_.vertex.size(); ++v) {
      pairs_.emplace_back(origin_.vertex[v], static_cast<Index>(v));
    }
    LIMN_RETURN_IF_ERROR(context_.Check());
    std::sort(pairs_.begin(), pairs_.end());
    return context_.Check();
  }

  // Calls take(v) for each vertex v that comes from `original`.
  template <class Take>
  absl::Status Visit(Index original, const Entry& entry, const Take& take) {
    if (++visits_ % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context_.Check());
    LIMN_RETURN_IF_ERROR(CheckRange(entry, original, origin_.vertex_count));
    auto at = std::lower_bound(pairs_.begin(), pairs_.end(), Pair{original, 0});
    if (at == pairs_.end() || at->first != original) {
      return Refuse(Reason::kInvalidOption, entry,
                    absl::StrCat("repair has left out vertex ", original, ", which no face uses"),
                    "Leave the constraint out");
    }
    for (; at != pairs_.end() && at->first == original; ++at) take(at->second);
    return absl::OkStatus();
  }

  template <class List, class VertexOf, class Take>
  absl::Status ForEach(const List& list, Entry entry, const VertexOf& vertex_of, const Take& take) {
    for (entry.index = 0; entry.index < list.size(); ++entry.index) {
      const auto& wish = list[entry.index];
      LIMN_RETURN_IF_ERROR(Visit(vertex_of(wish), entry, [&](Index v) { take(v, wish); }));
    }
    return absl::OkStatus();
  }

  absl::Status RenumberSurfacePoints() {
    Entry entry = {"constraints.surface_points", 0, ".vertex"};
    for (; entry.index < given_.surface_points.size(); ++entry.index) {
      const SurfaceConstraint& given = given_.surface_points[entry.index];
      if (given.parameter.has_value() || !given.region.empty()) {
        entry.after = given.parameter.has_value() ? ".parameter" : ".region";
        return Refuse(Reason::kInvalidOption, entry, "repair may have turned faces around",
                      "Send the repaired mesh, or name a vertex and no region");
      }
      // Without a vertex there is nothing to renumber: it is refused later.
      if (!given.vertex.has_value()) {
        result_.surface_points.push_back(given);
        continue;
      }
      LIMN_RETURN_IF_ERROR(Visit(*given.vertex, entry, [&](Index v) {
        result_.surface_points.push_back(given);
        result_.surface_points.back().vertex = v;
      }));
    }
    return absl::OkStatus();
  }

  absl::Status RenumberCrease(std::size_t c) {
    const CreaseConstraint& given = given_.creases[c];
    CreaseConstraint crease = {.vertices = {}, .sharpness = given.sharpness};
    Entry entry = {absl::StrCat("constraints.creases[", c, "].vertices")};
    for (; entry.index < given.vertices.size(); ++entry.index) {
      const Index original = given.vertices[entry.index];
      std::size_t copies = 0;
      Index last = 0;
      LIMN_RETURN_IF_ERROR(Visit(original, entry, [&](Index v) {
        last = v;
        ++copies;
      }));
      if (copies > 1) {
        return Refuse(Reason::kInvalidOption, entry,
                      absl::StrCat("repair has split vertex ", original),
                      "Leave the crease out, or send the repaired mesh");
      }
      crease.vertices.push_back(last);
    }
    result_.creases.push_back(std::move(crease));
    return absl::OkStatus();
  }

  absl::Status RenumberCorners() {
    Entry entry = {"constraints.corners", 0, ".vertex"};
    // By vertex; of equal ones the last is first.
    std::vector<std::pair<Index, std::size_t>> order;
    order.reserve(given_.corners.size());
    for (; entry.index < given_.corners.size(); ++entry.index) {
      const Index vertex = given_.corners[entry.index].vertex;
      LIMN_RETURN_IF_ERROR(CheckRange(entry, vertex, origin_.vertex_count));
      order.emplace_back(vertex, given_.corners.size() - entry.index);
    }
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i > 0 && order[i].first == order[i - 1].first) continue;
      entry.index = given_.corners.size() - order[i].second;
      const float sharpness = given_.corners[entry.index].sharpness;
      LIMN_RETURN_IF_ERROR(Visit(order[i].first, entry, [&](Index v) {
        result_.corners.push_back({v, sharpness});
      }));
    }
    return absl::OkStatus();
  }

  // Faces that were left out are no holes any more.
  absl::Status RenumberHoles() {
    if (given_.holes.empty()) return absl::OkStatus();
    Entry entry = {"constraints.holes"};
    for (; entry.index < given_.holes.size(); ++entry.index) {
      LIMN_RETURN_IF_ERROR(
          CheckRange(entry, given_.holes[entry.index], origin_.face_count, "face"));
    }
    std::vector<bool> is_hole(origin_.face_count);
    for (const Index f : given_.holes) is_hole[f] = true;
    for (std::size_t f = 0; f < origin_.face.size(); ++f) {
      if (is_hole[origin_.face[f]]) result_.holes.push_back(static_cast<Index>(f));
    }
    return context_.Check();
  }

  // Defaults need no numbers.
  absl::Status TakeFeatures() {
    result_.features = given_.features;
    if (!given_.features.has_value() || !given_.features->names_elements()) {
      return absl::OkStatus();
    }
    return MakeError("constraints.features: repair has given the elements other numbers",
                     {.reason = Reason::kInvalidOption,
                      .field = "constraints.features",
                      .remedy = "Send the repaired mesh, or defaults only"});
  }

  const Context& context_;
  const Constraints& given_;
  const RepairOrigin& origin_;
  std::vector<Pair> pairs_;
  std::size_t visits_ = 0;
  Constraints result_;
};

}  // namespace

absl::StatusOr<Constraints> RenumberConstraints(const Context& context,
                                                const Constraints& constraints,
                                                const RepairOrigin& origin) {
  return Renumberer(context, constraints, origin).Run();
}

}  // namespace limn
