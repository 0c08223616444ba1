// SPDX-License-Identifier: MIT
#include "engine/mesh/validate.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// What a block of a checking loop found: how many, and the first.
struct Finding {
  std::uint64_t count = 0;
  std::uint64_t first = std::numeric_limits<std::uint64_t>::max();
  void Add(std::uint64_t at) {
    ++count;
    first = std::min(first, at);
  }
  void Add(const Finding& other) {
    count += other.count;
    first = std::min(first, other.first);
  }
};

// Runs check(i, findings) for all i; findings has one entry per kind.
template <std::size_t kKinds, class Check>
absl::Status FindAll(const Context& context, std::size_t n, const Check& check,
                     std::array<Finding, kKinds>* total) {
  std::vector<std::array<Finding, kKinds>> blocks((n + kScanBlock - 1) / kScanBlock);
  LIMN_RETURN_IF_ERROR(ParallelBlocks(context, n, kScanBlock,
                                      [&](std::size_t block, std::size_t begin, std::size_t end) {
                                        for (std::size_t i = begin; i < end; ++i)
                                          check(i, &blocks[block]);
                                      }));
  for (const auto& block : blocks) {
    for (std::size_t kind = 0; kind < kKinds; ++kind) (*total)[kind].Add(block[kind]);
  }
  return absl::OkStatus();
}

bool HasRepeatedVertex(absl::Span<const Index> face) {
  constexpr std::size_t kSmall = 16;
  if (face.size() <= kSmall) {
    for (std::size_t i = 1; i < face.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (face[i] == face[j]) return true;
      }
    }
    return false;
  }
  std::vector<Index> sorted(face.begin(), face.end());
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
}

absl::Status CheckLimit(const std::string& what, std::uint64_t value, std::uint64_t limit) {
  if (value <= limit) return absl::OkStatus();
  return MakeError(absl::StrCat("the mesh has ", value, " ", what, ", the limit is ", limit),
                   {.reason = Reason::kLimitExceeded,
                    .field = absl::StrCat("mesh.", what),
                    .remedy = "Send a smaller mesh or raise the limit"});
}

absl::Status CheckSizes(const Context& context, const PolygonMesh& mesh) {
  if (mesh.vertex_count() == 0 || mesh.face_count() == 0) {
    return MakeError(
        mesh.vertex_count() == 0 ? "the mesh has no vertices" : "the mesh has no faces",
        {.reason = Reason::kEmptyMesh,
         .field = mesh.vertex_count() == 0 ? "mesh.vertices" : "mesh.faces",
         .remedy = "Give a mesh of at least one face"});
  }
  LIMN_RETURN_IF_ERROR(
      CheckLimit("vertices", mesh.vertex_count(),
                 std::min<std::uint64_t>(context.limits().max_vertices, kNoIndex - 1)));
  const std::uint64_t corners = std::min<std::uint64_t>(context.limits().max_corners, kNoIndex - 1);
  LIMN_RETURN_IF_ERROR(CheckLimit("corners", mesh.corner_count(), corners));
  // Only faces without corners can be more.
  return CheckLimit("faces", mesh.face_count(), corners);
}

enum class FaceChecks { kAll, kIndicesOnly };

absl::Status CheckFaces(const Context& context, const PolygonMesh& mesh, FaceChecks checks) {
  LIMN_RETURN_IF_ERROR(CheckSizes(context, mesh));
  const std::size_t faces = mesh.face_count();
  const std::size_t vertices = mesh.vertex_count();
  const bool all = checks == FaceChecks::kAll;
  enum Kind : std::size_t { kDecreasing, kSmall, kRange, kRepeated, kKinds };
  std::array<Finding, kKinds> found;
  LIMN_RETURN_IF_ERROR(FindAll<kKinds>(
      context, faces,
      [&](std::size_t f, std::array<Finding, kKinds>* findings) {
        const Index begin = mesh.face_begin[f];
        const Index end = mesh.face_begin[f + 1];
        if (end < begin || end > mesh.corner_count()) return (*findings)[kDecreasing].Add(f);
        const absl::Span<const Index> face = mesh.face(f);
        if (all && face.size() < 3) return (*findings)[kSmall].Add(f);
        for (const Index v : face) {
          if (v >= vertices) return (*findings)[kRange].Add(f);
        }
        if (all && HasRepeatedVertex(face)) (*findings)[kRepeated].Add(f);
      },
      &found));
  if (found[kDecreasing].count > 0 || mesh.face_begin[0] != 0 ||
      mesh.face_begin[faces] != mesh.corner_count()) {
    return MakeError("the arities of the faces do not add up to the number of corners",
                     {.reason = Reason::kMalformedRequest,
                      .field = "mesh.faces",
                      .remedy = "Send the arity of every face"});
  }
  const auto refuse = [&](const Finding& finding, Reason reason, const std::string& kind,
                          const std::string& remedy) {
    return MakeError(
        absl::StrCat(kind, ": ", finding.count, " faces, first face ", finding.first),
        {.reason = reason, .field = "mesh.faces", .index = finding.first, .remedy = remedy});
  };
  if (found[kSmall].count > 0) {
    return refuse(found[kSmall], Reason::kFaceTooSmall, "faces with fewer than three corners",
                  OrRepair("Remove them"));
  }
  if (found[kRange].count > 0) {
    return refuse(found[kRange], Reason::kIndexOutOfRange, "vertex indices out of range",
                  absl::StrCat("Indices must be from 0 to ", vertices - 1));
  }
  if (found[kRepeated].count > 0) {
    return refuse(found[kRepeated], Reason::kRepeatedVertex, "faces that visit a vertex twice",
                  OrRepair("Remove the repeated corners"));
  }
  return absl::OkStatus();
}

}  // namespace

std::string OrRepair(std::string_view remedy) {
  return std::string(remedy).append(", or ask for repair (--repair)");
}

absl::Status ValidatePositions(const Context& context, absl::Span<const Vec3> positions,
                               BoundingBox* box) {
  if (positions.empty()) {
    return MakeError("the mesh has no vertices", {.reason = Reason::kEmptyMesh,
                                                  .field = "mesh.vertices",
                                                  .remedy = "Give at least one face"});
  }
  struct Block {
    Finding non_finite;
    Finding large;
    Vec3 min;
    Vec3 max;
  };
  std::vector<Block> blocks((positions.size() + kScanBlock - 1) / kScanBlock);
  LIMN_RETURN_IF_ERROR(ParallelBlocks(
      context, positions.size(), kScanBlock,
      [&](std::size_t block, std::size_t begin, std::size_t end) {
        Block& b = blocks[block];
        b.min = b.max = positions[begin];
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3& p = positions[i];
          b.min = {std::min(b.min.x, p.x), std::min(b.min.y, p.y), std::min(b.min.z, p.z)};
          b.max = {std::max(b.max.x, p.x), std::max(b.max.y, p.y), std::max(b.max.z, p.z)};
          // One comparison on the good path: it fails for NaN too.
          if (MaxAbs(p) <= kMaxCoordinate && IsFinite(p)) continue;
          (IsFinite(p) ? b.large : b.non_finite).Add(i);
        }
      }));
  Finding non_finite;
  Finding large;
  *box = {blocks[0].min, blocks[0].max};
  for (const Block& b : blocks) {
    non_finite.Add(b.non_finite);
    large.Add(b.large);
    box->min = {std::min(box->min.x, b.min.x), std::min(box->min.y, b.min.y),
                std::min(box->min.z, b.min.z)};
    box->max = {std::max(box->max.x, b.max.x), std::max(box->max.y, b.max.y),
                std::max(box->max.z, b.max.z)};
  }
  if (non_finite.count > 0) {
    return MakeError(absl::StrCat("non-finite coordinates: ", non_finite.count,
                                  " vertices, first vertex ", non_finite.first),
                     {.reason = Reason::kNonFiniteCoordinate,
                      .field = "mesh.vertices",
                      .index = non_finite.first,
                      .remedy = "Coordinates must be finite numbers"});
  }
  if (large.count > 0) {
    return MakeError(absl::StrCat("coordinates too large: ", large.count,
                                  " vertices, first vertex ", large.first),
                     {.reason = Reason::kCoordinateTooLarge,
                      .field = "mesh.vertices",
                      .index = large.first,
                      .remedy = "Coordinates must be at most 1e100 in magnitude"});
  }
  return absl::OkStatus();
}

absl::Status ValidateFaces(const Context& context, const PolygonMesh& mesh) {
  return CheckFaces(context, mesh, FaceChecks::kAll);
}

absl::Status ValidateIndices(const Context& context, const PolygonMesh& mesh) {
  return CheckFaces(context, mesh, FaceChecks::kIndicesOnly);
}

absl::Status DiagnoseEdges(const PolygonMesh& mesh) {
  // Edges as (smaller vertex, larger vertex, direction, face).
  std::vector<std::tuple<Index, Index, bool, Index>> edges;
  edges.reserve(mesh.corner_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const absl::Span<const Index> face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Index a = face[i];
      const Index b = face[(i + 1) % face.size()];
      edges.emplace_back(std::min(a, b), std::max(a, b), a < b, static_cast<Index>(f));
    }
  }
  std::sort(edges.begin(), edges.end());
  Finding crowded;
  Finding twisted;
  std::size_t crowded_at = 0;
  std::size_t twisted_at = 0;
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && std::get<0>(edges[end]) == std::get<0>(edges[begin]) &&
           std::get<1>(edges[end]) == std::get<1>(edges[begin])) {
      ++end;
    }
    if (end - begin > 2) {
      if (crowded.count == 0) crowded_at = begin;
      crowded.Add(begin);
    } else if (end - begin == 2 && std::get<2>(edges[begin]) == std::get<2>(edges[begin + 1])) {
      if (twisted.count == 0) twisted_at = begin;
      twisted.Add(begin);
    }
  }
  const auto describe = [&](std::size_t at) {
    return absl::StrCat("first edge (", std::get<0>(edges[at]), ", ", std::get<1>(edges[at]),
                        ") of face ", std::get<3>(edges[at]));
  };
  if (crowded.count > 0) {
    return MakeError(absl::StrCat("non-manifold edges (more than two faces): ", crowded.count,
                                  " edges, ", describe(crowded_at)),
                     {.reason = Reason::kNonManifoldEdge,
                      .field = "mesh.faces",
                      .index = std::get<3>(edges[crowded_at]),
                      .remedy = OrRepair("Remove repeated faces and split off the surplus ones")});
  }
  if (twisted.count > 0) {
    return MakeError(absl::StrCat("inconsistent orientation (two faces walk an edge in the same "
                                  "direction): ",
                                  twisted.count, " edges, ", describe(twisted_at)),
                     {.reason = Reason::kInconsistentOrientation,
                      .field = "mesh.faces",
                      .index = std::get<3>(edges[twisted_at]),
                      .remedy = OrRepair("Turn faces so that neighbours agree")});
  }
  return absl::OkStatus();
}

}  // namespace limn
