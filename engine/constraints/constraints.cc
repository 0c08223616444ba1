// SPDX-License-Identifier: MIT
#include "engine/constraints/constraints.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kEntriesPerCheck = std::size_t{1} << 16;

// One entry of a list, as errors name it.
struct Entry {
  std::string_view list;
  std::size_t index = 0;
  // Of the entry, with its dot; empty for plain numbers.
  std::string_view member = "";
};

absl::Status Refuse(Reason reason, const Entry& entry, std::string_view message,
                    std::string_view remedy) {
  std::string field = absl::StrCat("constraints.", std::string(entry.list), "[", entry.index, "]",
                                   std::string(entry.member));
  std::string text = absl::StrCat(field, ": ", std::string(message));
  return MakeError(text, {.reason = reason,
                          .field = std::move(field),
                          .index = entry.index,
                          .remedy = std::string(remedy)});
}

absl::Status Repeated(const Entry& entry, Index vertex, std::size_t first) {
  return Refuse(Reason::kInvalidOption, entry,
                absl::StrCat("vertex ", vertex, " is named before, at index ", first),
                "Name each vertex once");
}

absl::Status NotInterpolated(const Entry& entry, Index vertex) {
  return Refuse(Reason::kInvalidOption, entry,
                absl::StrCat("vertex ", vertex, " is not interpolated"),
                "Add it to constraints.interpolate.vertices, or leave its normal out");
}

absl::Status CheckRange(const Entry& entry, Index vertex, std::size_t vertex_count) {
  if (vertex < vertex_count) return absl::OkStatus();
  return Refuse(Reason::kIndexOutOfRange, entry,
                absl::StrCat("there is no vertex ", vertex, ", the mesh has ", vertex_count),
                "Vertices are counted from 0");
}

// The entry before `end` that names the vertex, or `end`.
template <class List, class VertexOf>
std::size_t FindVertex(const List& list, std::size_t end, Index vertex, const VertexOf& vertex_of) {
  std::size_t i = 0;
  while (i < end && vertex_of(list[i]) != vertex) ++i;
  return i;
}

// Clears the bit of every vertex that is named; refuses vertices that are not there and bits that
// are not set. check(i): what else an entry has to meet.
template <class List, class VertexOf, class Check>
absl::Status TakeEach(const Context& context, const List& list, const Entry& place,
                      std::vector<bool>* may_be_named, const VertexOf& vertex_of,
                      const Check& check) {
  Entry entry = place;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context.Check());
    entry.index = i;
    const Index vertex = vertex_of(list[i]);
    LIMN_RETURN_IF_ERROR(CheckRange(entry, vertex, may_be_named->size()));
    if (!(*may_be_named)[vertex]) {
      const std::size_t first = FindVertex(list, i, vertex, vertex_of);
      return first < i ? Repeated(entry, vertex, first) : NotInterpolated(entry, vertex);
    }
    (*may_be_named)[vertex] = false;
    LIMN_RETURN_IF_ERROR(check(i));
  }
  return absl::OkStatus();
}

absl::Status CheckNormal(std::size_t i, const Vec3& normal) {
  const Entry entry = {.list = "normals", .index = i, .member = ".normal"};
  if (!IsFinite(normal)) {
    return Refuse(Reason::kInvalidOption, entry, "the normal is not finite",
                  "Give three finite numbers");
  }
  if (!(MaxAbs(normal) > 0)) {
    return Refuse(Reason::kInvalidOption, entry, "the normal is zero",
                  "Give a direction of any length above zero");
  }
  return absl::OkStatus();
}

absl::Status CheckHandle(std::size_t i, double value) {
  // Written so that NaN is refused.
  if (value >= kLeastHandle && value <= kLargestHandle) return absl::OkStatus();
  return Refuse(Reason::kInvalidOption, {.list = "shape_handles", .index = i, .member = ".value"},
                absl::StrCat(value, " is not from ", kLeastHandle, " to ", kLargestHandle),
                "1 changes nothing, less sharpens and more flattens");
}

absl::Status CheckSubset(const Context& context, const std::vector<Index>& vertices,
                         std::size_t vertex_count) {
  std::vector<bool> free(vertex_count, true);
  return TakeEach(
      context, vertices, {.list = "interpolate.vertices"}, &free, [](Index v) { return v; },
      [](std::size_t) { return absl::OkStatus(); });
}

// Takes one bit a vertex: set where a normal may still be prescribed.
absl::Status CheckNormals(const Context& context, const Constraints& constraints,
                          std::size_t vertex_count) {
  const std::optional<std::vector<Index>>& subset = constraints.interpolate;
  std::vector<bool> free(vertex_count, constraints.interpolates_all());
  if (subset.has_value()) {
    for (const Index v : *subset) free[v] = true;
  }
  return TakeEach(
      context, constraints.normals, {.list = "normals", .member = ".vertex"}, &free,
      [](const NormalConstraint& c) { return c.vertex; },
      [&](std::size_t i) { return CheckNormal(i, constraints.normals[i].normal); });
}

absl::Status CheckHandles(const Context& context, const std::vector<ShapeHandle>& handles,
                          std::size_t vertex_count) {
  std::vector<bool> free(vertex_count, true);
  return TakeEach(
      context, handles, {.list = "shape_handles", .member = ".vertex"}, &free,
      [](const ShapeHandle& h) { return h.vertex; },
      [&](std::size_t i) { return CheckHandle(i, handles[i].value); });
}

}  // namespace

absl::Status ValidateConstraints(const Context& context, const Constraints& constraints,
                                 std::size_t vertex_count) {
  LIMN_RETURN_IF_ERROR(context.Check());
  if (constraints.interpolate.has_value()) {
    LIMN_RETURN_IF_ERROR(CheckSubset(context, *constraints.interpolate, vertex_count));
  }
  if (!constraints.normals.empty()) {
    LIMN_RETURN_IF_ERROR(CheckNormals(context, constraints, vertex_count));
  }
  if (!constraints.shape_handles.empty()) {
    LIMN_RETURN_IF_ERROR(CheckHandles(context, constraints.shape_handles, vertex_count));
  }
  return absl::OkStatus();
}

absl::Status ValidateDooSabinNormals(const Context& context, const Constraints& constraints,
                                     const HalfEdgeMesh& mesh) {
  for (std::size_t i = 0; i < constraints.normals.size(); ++i) {
    if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context.Check());
    const Index v = constraints.normals[i].vertex;
    if (mesh.IsBoundary(v) || mesh.valence(v) != 2) continue;
    return Refuse(Reason::kInvalidOption, {.list = "normals", .index = i, .member = ".vertex"},
                  absl::StrCat("vertex ", v, " has two faces only, the surface no normal there"),
                  "Leave its normal out, or cut one of its faces through it");
  }
  return absl::OkStatus();
}

}  // namespace limn
