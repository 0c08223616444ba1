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
                    .remedy = "Send a smaller mesh or raise the limit",
                    .limit = absl::StrCat("max-", what)});
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
  if (const double diagonal = box->diagonal(); diagonal > 0 && diagonal < kMinDiagonal) {
    return MakeError(absl::StrCat("the mesh is too small: the diagonal of its box is ", diagonal),
                     {.reason = Reason::kExtentTooSmall,
                      .field = "mesh.vertices",
                      .remedy = "Scale it: the diagonal must be at least 1e-300, or 0"});
  }
  return absl::OkStatus();
}

absl::Status ValidateFaces(const Context& context, const PolygonMesh& mesh) {
  return CheckFaces(context, mesh, FaceChecks::kAll);
}

absl::Status ValidateIndices(const Context& context, const PolygonMesh& mesh) {
  return CheckFaces(context, mesh, FaceChecks::kIndicesOnly);
}

namespace {

// An edge with its first half-edge, in the order of (smaller end, larger end).
struct FirstEdge {
  std::uint64_t count = 0;
  Index low = kNoIndex;
  Index high = kNoIndex;
  Index half_edge = kNoIndex;

  void Add(const FirstEdge& other) {
    count += other.count;
    if (std::tie(other.low, other.high) < std::tie(low, high)) {
      low = other.low;
      high = other.high;
      half_edge = other.half_edge;
    }
  }
  std::string Describe(Index face) const {
    return absl::StrCat(count, " edges, first edge (", low, ", ", high, ") of face ", face);
  }
};

struct EdgeFindings {
  FirstEdge crowded;
  FirstEdge twisted;
};

void DiagnoseBucket(const PolygonMesh& mesh, Index v, std::vector<EdgeUse>* uses,
                    EdgeFindings* findings) {
  const auto leaves_larger_end = [&](Index h) { return mesh.corner_vertex[h] != v; };
  std::sort(uses->begin(), uses->end(), [&](const EdgeUse& a, const EdgeUse& b) {
    const bool a_up = !leaves_larger_end(a.half_edge);
    const bool b_up = !leaves_larger_end(b.half_edge);
    return std::tie(a.other_end, a_up, a.half_edge) < std::tie(b.other_end, b_up, b.half_edge);
  });
  for (std::size_t begin = 0, end = 0; begin < uses->size(); begin = end) {
    const EdgeUse& first = (*uses)[begin];
    while (end < uses->size() && (*uses)[end].other_end == first.other_end) ++end;
    const FirstEdge edge = {1, v, first.other_end, first.half_edge};
    if (end - begin > 2) {
      findings->crowded.Add(edge);
    } else if (end - begin == 2 && leaves_larger_end(first.half_edge) ==
                                       leaves_larger_end((*uses)[begin + 1].half_edge)) {
      findings->twisted.Add(edge);
    }
  }
}

Index FaceOf(const PolygonMesh& mesh, Index half_edge) {
  return static_cast<Index>(
      std::upper_bound(mesh.face_begin.begin(), mesh.face_begin.end(), half_edge) -
      mesh.face_begin.begin() - 1);
}

}  // namespace

absl::Status DiagnoseEdges(const Context& context, const PolygonMesh& mesh,
                           const EdgeBuckets& buckets) {
  const std::size_t vertices = mesh.vertex_count();
  std::vector<EdgeFindings> blocks((vertices + kDefaultGrain - 1) / kDefaultGrain);
  LIMN_RETURN_IF_ERROR(ParallelBlocks(
      context, vertices, kDefaultGrain, [&](std::size_t block, std::size_t begin, std::size_t end) {
        std::vector<EdgeUse> uses;
        for (std::size_t v = begin; v < end; ++v) {
          uses.assign(buckets.uses.begin() + buckets.begin[v],
                      buckets.uses.begin() + buckets.begin[v + 1]);
          DiagnoseBucket(mesh, static_cast<Index>(v), &uses, &blocks[block]);
        }
      }));
  EdgeFindings found;
  for (const EdgeFindings& block : blocks) {
    found.crowded.Add(block.crowded);
    found.twisted.Add(block.twisted);
  }
  if (found.crowded.count > 0) {
    const Index face = FaceOf(mesh, found.crowded.half_edge);
    return MakeError(
        absl::StrCat("non-manifold edges (more than two faces): ", found.crowded.Describe(face)),
        {.reason = Reason::kNonManifoldEdge,
         .field = "mesh.faces",
         .index = face,
         .remedy = OrRepair("Remove repeated faces and split off the surplus ones")});
  }
  if (found.twisted.count > 0) {
    const Index face = FaceOf(mesh, found.twisted.half_edge);
    return MakeError(absl::StrCat("inconsistent orientation (two faces walk an edge in the same "
                                  "direction): ",
                                  found.twisted.Describe(face)),
                     {.reason = Reason::kInconsistentOrientation,
                      .field = "mesh.faces",
                      .index = face,
                      .remedy = OrRepair("Turn faces so that neighbours agree")});
  }
  return absl::OkStatus();
}

}  // namespace limn
