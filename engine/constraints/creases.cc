// SPDX-License-Identifier: MIT
#include "engine/constraints/creases.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
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

absl::Status CheckSize(std::size_t crease, const CreaseConstraint& wish) {
  const std::string path = absl::StrCat("constraints.creases[", crease, "]");
  if (wish.vertices.size() < 2) {
    return MakeError(absl::StrCat(path, ".vertices: a crease of ", wish.vertices.size(),
                                  " vertices has no edge"),
                     {.reason = Reason::kInvalidOption,
                      .field = absl::StrCat(path, ".vertices"),
                      .index = crease,
                      .remedy = "Name two or more vertices along the crease"});
  }
  const std::size_t given = wish.sharpness.size();
  if (given == 1 || given + 1 == wish.vertices.size()) return absl::OkStatus();
  return MakeError(
      absl::StrCat(path, ".sharpness: ", given, " values for ", wish.vertices.size() - 1, " edges"),
      {.reason = Reason::kInvalidOption,
       .field = absl::StrCat(path, ".sharpness"),
       .index = crease,
       .remedy = "Give one value for the crease, or one for each of its edges"});
}

absl::StatusOr<Lists> ListsOf(const Constraints& constraints) {
  Lists lists;
  for (std::size_t c = 0; c < constraints.creases.size(); ++c) {
    const CreaseConstraint& wish = constraints.creases[c];
    LIMN_RETURN_IF_ERROR(CheckSize(c, wish));
    lists.vertices.insert(lists.vertices.end(), wish.vertices.begin(), wish.vertices.end());
    lists.lengths.push_back(static_cast<Index>(wish.vertices.size()));
    for (std::size_t i = 0; i + 1 < wish.vertices.size(); ++i) {
      lists.sharpnesses.push_back(wish.sharpness[wish.sharpness.size() == 1 ? 0 : i]);
    }
  }
  for (const CornerConstraint& wish : constraints.corners) {
    lists.corners.push_back(wish.vertex);
    lists.corner_sharpnesses.push_back(wish.sharpness);
  }
  return lists;
}

// The path of entry `index` of all creases' vertices (extra = 0) or edges (extra = 1).
std::string CreasePath(const Constraints& constraints, std::size_t index, std::size_t extra,
                       std::string_view member) {
  std::size_t c = 0;
  while (c + 1 < constraints.creases.size() &&
         index >= constraints.creases[c].vertices.size() - extra) {
    index -= constraints.creases[c].vertices.size() - extra;
    ++c;
  }
  // One sharpness may stand for all edges.
  if (extra == 1 && constraints.creases[c].sharpness.size() == 1) index = 0;
  return absl::StrCat("constraints.creases[", c, "].", std::string(member), "[", index, "]");
}

std::string PathOf(const Constraints& constraints, const std::string& field, std::size_t index) {
  if (absl::StartsWith(field, "crease_indices")) {
    return CreasePath(constraints, index, 0, "vertices");
  }
  if (absl::StartsWith(field, "crease_sharpnesses")) {
    return CreasePath(constraints, index, 1, "sharpness");
  }
  if (absl::StartsWith(field, "corner_indices")) {
    return absl::StrCat("constraints.corners[", index, "].vertex");
  }
  if (absl::StartsWith(field, "corner_sharpnesses")) {
    return absl::StrCat("constraints.corners[", index, "].sharpness");
  }
  if (absl::StartsWith(field, "hole_indices")) {
    return absl::StrCat("constraints.holes[", index, "]");
  }
  return field;
}

absl::Status InWordsOfTheContract(const absl::Status& status, const Constraints& constraints) {
  std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail.has_value() || !detail->index.has_value()) return status;
  absl::string_view message = status.message();
  if (!detail->remedy.empty()) message.remove_suffix(detail->remedy.size() + 2);
  if (absl::StartsWith(message, detail->field)) message.remove_prefix(detail->field.size());
  detail->field = PathOf(constraints, detail->field, *detail->index);
  return MakeError(absl::StrCat(detail->field, message), *detail);
}

}  // namespace

absl::StatusOr<Sharpness> SharpnessOf(const Context& context, const HalfEdgeMesh& mesh,
                                      const Constraints& constraints, BoundaryRule boundary) {
  LIMN_ASSIGN_OR_RETURN(const Lists lists, ListsOf(constraints));
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
