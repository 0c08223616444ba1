// SPDX-License-Identifier: MIT
#include "engine/constraints/creases.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine/base/error.h"

namespace limn {
namespace {

// The lists of a CreaseInput.
struct Lists {
  std::vector<Index> vertices;
  std::vector<Index> lengths;
  std::vector<float> sharpnesses;
  std::vector<Index> corners;
  std::vector<float> corner_sharpnesses;
};

constexpr std::size_t kCreasesPerCheck = 4096;

absl::Status RefuseSize(std::size_t crease, std::string_view member, std::string_view message,
                        std::string_view remedy) {
  std::string field = absl::StrCat("constraints.creases[", crease, "].", std::string(member));
  std::string text = absl::StrCat(field, ": ", std::string(message));
  return MakeError(text, {.reason = Reason::kInvalidOption,
                          .field = std::move(field),
                          .index = crease,
                          .remedy = std::string(remedy)});
}

absl::Status CheckSize(std::size_t crease, const CreaseConstraint& wish) {
  const std::size_t vertices = wish.vertices.size();
  if (vertices < 2) {
    return RefuseSize(crease, "vertices",
                      absl::StrCat("a crease of ", vertices, " vertices has no edge"),
                      "Name two or more vertices along the crease");
  }
  const std::size_t given = wish.sharpness.size();
  if (given == 1 || given + 1 == vertices) return absl::OkStatus();
  return RefuseSize(crease, "sharpness",
                    absl::StrCat(given, " values for ", vertices - 1, " edges"),
                    "Give one value for the crease, or one for each of its edges");
}

absl::StatusOr<Lists> ListsOf(const Context& context, const Constraints& constraints) {
  Lists lists;
  std::size_t vertices = 0;
  for (const CreaseConstraint& wish : constraints.creases) vertices += wish.vertices.size();
  lists.vertices.reserve(vertices);
  lists.sharpnesses.reserve(vertices);
  lists.lengths.reserve(constraints.creases.size());
  for (std::size_t c = 0; c < constraints.creases.size(); ++c) {
    if (c % kCreasesPerCheck == 0) LIMN_RETURN_IF_ERROR(context.Check());
    const CreaseConstraint& wish = constraints.creases[c];
    LIMN_RETURN_IF_ERROR(CheckSize(c, wish));
    lists.vertices.insert(lists.vertices.end(), wish.vertices.begin(), wish.vertices.end());
    lists.lengths.push_back(static_cast<Index>(wish.vertices.size()));
    for (std::size_t i = 0; i + 1 < wish.vertices.size(); ++i) {
      lists.sharpnesses.push_back(wish.sharpness[wish.sharpness.size() == 1 ? 0 : i]);
    }
  }
  lists.corners.reserve(constraints.corners.size());
  lists.corner_sharpnesses.reserve(constraints.corners.size());
  for (const CornerConstraint& wish : constraints.corners) {
    lists.corners.push_back(wish.vertex);
    lists.corner_sharpnesses.push_back(wish.sharpness);
  }
  return lists;
}

// Where an entry stands: its path, and the last index in it.
struct Place {
  std::string path;
  std::size_t index = 0;
};

// Of entry `index` of all creases' vertices (extra = 0) or edges (extra = 1).
Place CreasePlace(const Constraints& constraints, std::size_t index, std::size_t extra,
                  std::string_view member) {
  std::size_t c = 0;
  while (c + 1 < constraints.creases.size() &&
         index >= constraints.creases[c].vertices.size() - extra) {
    index -= constraints.creases[c].vertices.size() - extra;
    ++c;
  }
  // One sharpness may stand for all edges.
  if (extra == 1 && constraints.creases[c].sharpness.size() == 1) index = 0;
  return {absl::StrCat("constraints.creases[", c, "].", std::string(member), "[", index, "]"),
          index};
}

Place PlaceOf(const Constraints& constraints, const std::string& field, std::size_t index) {
  if (absl::StartsWith(field, "crease_indices")) {
    return CreasePlace(constraints, index, 0, "vertices");
  }
  if (absl::StartsWith(field, "crease_sharpnesses")) {
    return CreasePlace(constraints, index, 1, "sharpness");
  }
  if (absl::StartsWith(field, "corner_indices")) {
    return {absl::StrCat("constraints.corners[", index, "].vertex"), index};
  }
  if (absl::StartsWith(field, "corner_sharpnesses")) {
    return {absl::StrCat("constraints.corners[", index, "].sharpness"), index};
  }
  if (absl::StartsWith(field, "hole_indices")) {
    return {absl::StrCat("constraints.holes[", index, "]"), index};
  }
  return {field, index};
}

absl::Status InWordsOfTheContract(const absl::Status& status, const Constraints& constraints) {
  std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail.has_value() || !detail->index.has_value()) return status;
  absl::string_view message = status.message();
  if (!detail->remedy.empty()) message.remove_suffix(detail->remedy.size() + 2);
  if (absl::StartsWith(message, detail->field)) message.remove_prefix(detail->field.size());
  Place place = PlaceOf(constraints, detail->field, *detail->index);
  detail->field = std::move(place.path);
  detail->index = place.index;
  return MakeError(absl::StrCat(detail->field, message), *detail);
}

}  // namespace

absl::StatusOr<Sharpness> SharpnessOf(const Context& context, const HalfEdgeMesh& mesh,
                                      const Constraints& constraints, BoundaryRule boundary) {
  LIMN_ASSIGN_OR_RETURN(const Lists lists, ListsOf(context, constraints));
  absl::StatusOr<Sharpness> made = MakeSharpness(context, mesh,
                                                 {.crease_indices = lists.vertices,
                                                  .crease_lengths = lists.lengths,
                                                  .crease_sharpnesses = lists.sharpnesses,
                                                  .corner_indices = lists.corners,
                                                  .corner_sharpnesses = lists.corner_sharpnesses,
                                                  .hole_indices = constraints.holes,
                                                  .boundary = boundary});
  if (!made.ok()) return InWordsOfTheContract(made.status(), constraints);
  return made;
}

}  // namespace limn
