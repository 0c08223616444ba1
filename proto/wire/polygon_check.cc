// SPDX-License-Identifier: MIT
// See polygon_check.h.
#include "proto/wire/polygon_check.h"

#include <algorithm>
#include <atomic>
#include <limits>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "engine/base/parallel.h"

namespace limn::wire {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

void LowerTo(std::size_t value, std::atomic<std::size_t>* lowest) {
  std::size_t seen = lowest->load(std::memory_order_relaxed);
  while (value < seen && !lowest->compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
}

// The smallest i in [0, n) with bad(i), or kNone.
template <class Bad>
absl::StatusOr<std::size_t> FirstBad(const Context& context, std::size_t n, const Bad& bad) {
  std::atomic<std::size_t> first{kNone};
  LIMN_RETURN_IF_ERROR(ParallelFor(context, n, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (bad(i)) {
        LowerTo(i, &first);
        return;
      }
    }
  }));
  return first.load();
}

absl::Status FaceError(const PolygonMesh& mesh, std::size_t face, Reason reason) {
  const std::int64_t arity = std::int64_t{mesh.face_begin[face + 1]} - mesh.face_begin[face];
  return MakeError(
      absl::StrCat("face ", face, " has ", arity, " corners"),
      {.reason = reason,
       .field = "faces",
       .index = face,
       .remedy = reason == Reason::kFaceTooSmall
                     ? "Give every face 3 corners or more, or ask for repair (--repair) "
                       "of a mesh that is sent packed"
                     : "Give every face 3 corners or more"});
}

absl::Status IndexError(const PolygonMesh& mesh, std::size_t corner, Reason reason) {
  const auto after = std::upper_bound(mesh.face_begin.begin(), mesh.face_begin.end(), corner);
  const std::size_t face = static_cast<std::size_t>(after - mesh.face_begin.begin()) - 1;
  return MakeError(
      absl::StrCat("face ", face, " names vertex ", mesh.corner_vertex[corner],
                   ", but the mesh has ", mesh.vertex_count(), " vertices, numbered from 0"),
      {.reason = reason,
       .field = "faces",
       .index = face,
       .remedy = absl::StrCat("Use vertex numbers below ", mesh.vertex_count())});
}

}  // namespace

absl::Status CheckPolygons(const Context& context, const PolygonMesh& mesh,
                           const PolygonRules& rules) {
  const std::size_t faces = mesh.face_count();
  if (mesh.positions.empty() || faces == 0) {
    return MakeError(
        absl::StrCat("the mesh has ", mesh.vertex_count(), " vertices and ", faces, " faces"),
        {.reason = Reason::kEmptyMesh,
         .field = mesh.positions.empty() ? "vertices" : "faces",
         .remedy = "Give at least one face"});
  }
  if (mesh.face_begin.front() != 0 || mesh.face_begin.back() != mesh.corner_count()) {
    return MakeError("face_begin does not run from 0 to the number of corners",
                     {.reason = rules.index_out_of_range, .field = "faces"});
  }
  LIMN_ASSIGN_OR_RETURN(const std::size_t face, FirstBad(context, faces, [&](std::size_t f) {
                          return mesh.face_begin[f + 1] <
                                 std::uint64_t{mesh.face_begin[f]} + rules.least_arity;
                        }));
  if (face != kNone) return FaceError(mesh, face, rules.face_too_small);
  const std::size_t vertices = mesh.vertex_count();
  LIMN_ASSIGN_OR_RETURN(const std::size_t corner,
                        FirstBad(context, mesh.corner_count(),
                                 [&](std::size_t c) { return mesh.corner_vertex[c] >= vertices; }));
  if (corner != kNone) return IndexError(mesh, corner, rules.index_out_of_range);
  return absl::OkStatus();
}

}  // namespace limn::wire
