// SPDX-License-Identifier: MIT
#include "server/job_memory.h"

#include <algorithm>
#include <limits>

#include "engine/base/error.h"
#include "engine/constraints/certificate.h"
#include "engine/mesh/repair.h"
#include "proto/wire/chunks.h"
#include "proto/wire/mesh_memory.h"
#include "proto/wire/samples.h"
#include "server/constraints_from_proto.h"

namespace limn {
namespace {

// Two encoded tiles wait, one is written, one is made; a chunk arrives.
constexpr std::uint64_t kMessagesInFlight = 5;
// One block of parameters is answered, one waits, one arrives.
constexpr std::uint64_t kBlocksInFlight = 3;
// What LargeFaces may keep for each corner.
constexpr std::uint64_t kLargeFaceBytes = 12;

std::uint64_t Sum(std::initializer_list<std::uint64_t> terms) {
  std::uint64_t sum = 0;
  for (const std::uint64_t term : terms) {
    sum += term;
    if (sum < term) return std::numeric_limits<std::uint64_t>::max();
  }
  return sum;
}

wire::MeshCounts CountsOf(const JobSpec& spec) {
  return {spec.mesh.vertex_count(), spec.mesh.face_count(), spec.mesh.corner_count()};
}

// Of the mesh that is interpolated. What may come of repair at the worst: every corner gets a
// vertex of its own, and faces fall into triangles.
wire::MeshCounts InterpolatedCounts(const JobSpec& spec) {
  wire::MeshCounts counts = CountsOf(spec);
  if (!spec.repair) return counts;
  counts.vertices = std::max(counts.vertices, counts.corners);
  counts.faces = std::max(counts.faces, counts.corners / 3);
  return counts;
}

// Boundary edges that a mesh of such counts may have. With E edges, b of them on the boundary,
// 2 E = corners + b and V - E + F = 2 - loops for each sphere with holes, and a loop has three
// edges or more. Closed meshes of higher genus have none, and fall below.
std::uint64_t MostBoundaryEdges(const wire::MeshCounts& counts) {
  const std::uint64_t both = 2 * (counts.vertices + counts.faces);
  return std::min(counts.corners, 3 * (both - std::min(both, counts.corners)));
}

// Kept from the beginning to the end. The call keeps its copy of the constraints, and the job has
// one.
std::uint64_t AlwaysHeld(const JobSpec& spec) {
  return 2 * ConstraintBytes(spec.engine.constraints);
}

// The constraints of a repaired mesh, which name what came of each vertex and face that was named.
// A list that has grown may be twice as long.
std::uint64_t RenumberedBytes(const Constraints& given, const wire::MeshCounts& repaired) {
  const auto list = [](std::uint64_t entries, std::uint64_t most, std::uint64_t size) {
    return entries == 0 ? 0 : 2 * most * size;
  };
  const std::uint64_t vertices = repaired.vertices;
  return Sum({list(given.interpolate ? given.interpolate->size() : 0, vertices, sizeof(Index)),
              list(given.normals.size(), vertices, sizeof(NormalConstraint)),
              list(given.shape_handles.size(), vertices, sizeof(ShapeHandle)),
              list(given.surface_points.size(), vertices, sizeof(SurfaceConstraint)),
              list(given.corners.size(), vertices, sizeof(CornerConstraint)),
              list(given.holes.size(), repaired.faces, sizeof(Index))});
}

wire::TileOptions LargestTiles(const JobSpec& spec) {
  wire::TileOptions tiles = spec.tiles;
  // Large faces of level 0 may raise it.
  if (spec.send_surface && spec.may_have_level_0()) tiles.tile_bytes = wire::kMaxTileBytes;
  return tiles;
}

// What is left of the computation when the answer is made.
std::uint64_t ResultBytes(const JobSpec& spec, const wire::MeshCounts& counts,
                          std::uint64_t boundary) {
  // The points to interpolate, which the certificate keeps.
  const std::uint64_t targets = counts.vertices * sizeof(Vec3);
  if (!spec.send_surface) return targets;
  const std::uint64_t surface =
      EstimateSurfaceBytes(counts.vertices, counts.faces, counts.corners, spec.engine, boundary);
  // The plan of its tiles, which are 4 KiB or more.
  return Sum({targets, surface, surface / 64});
}

}  // namespace

void FitFinestLevel(const Limits& limits, JobSpec* spec) {
  if (!spec->engine.chord_tolerance.has_value()) return;
  spec->engine.finest = limits.max_level;
  while (spec->engine.finest > 0 && EstimateJobBytes(*spec) > limits.max_bytes) {
    --spec->engine.finest;
  }
}

std::uint64_t EstimateUploadBytes(const JobSpec& spec) {
  // The room for the bytes grows with them, and is held twice while it does.
  return Sum({2 * spec.mesh.byte_count(), AlwaysHeld(spec), 2 * wire::kMaxChunkBytes});
}

absl::StatusOr<std::uint64_t> EstimateDecodeBytes(const JobSpec& spec,
                                                  std::string_view encoded_mesh) {
  LIMN_ASSIGN_OR_RETURN(const std::uint64_t decoding, wire::DecodeMemory(spec.mesh, encoded_mesh));
  return std::max(EstimateUploadBytes(spec),
                  Sum({encoded_mesh.size(), decoding, AlwaysHeld(spec)}));
}

std::uint64_t EstimateJobBytes(const JobSpec& spec) {
  // The claims are held against limits below 2^33 before this is called, so products fit.
  const wire::MeshCounts counts = InterpolatedCounts(spec);
  const std::uint64_t boundary = MostBoundaryEdges(counts);
  const std::uint64_t mesh = wire::MeshMemory(counts);
  const std::uint64_t decoding = Sum({spec.mesh.byte_count(), wire::DecodeMemory(spec.mesh)});
  std::uint64_t repairing = 0;
  std::uint64_t mapping = 0;
  if (spec.repair) {
    repairing = Sum({wire::MeshMemory(CountsOf(spec)),
                     EstimateRepairBytes(spec.mesh.vertex_count(), spec.mesh.face_count(),
                                         spec.mesh.corner_count())});
    mapping = Sum({(counts.vertices + counts.faces) * sizeof(Index),
                   RenumberedBytes(spec.engine.constraints, counts)});
  }
  std::uint64_t computing = Sum(
      {mesh, EstimateBytes(counts.vertices, counts.faces, counts.corners, spec.engine, boundary)});
  if (spec.filter.has_value()) {
    computing = std::max(
        computing, Sum({mesh, EstimateFilterBytes(counts.vertices, counts.faces, counts.corners,
                                                  spec.engine, boundary)}));
  }
  if (spec.engine.keep_patches) {
    computing = Sum({computing, kLargeFaceBytes * counts.corners,
                     kBlocksInFlight * wire::kMaxBlockParameters * sizeof(SurfaceParameter)});
  }
  const std::uint64_t result = ResultBytes(spec, counts, boundary);
  std::uint64_t encoding = 0;
  std::uint64_t encoded = 0;
  if (spec.send_control_mesh) {
    encoding = Sum({result, mesh, wire::EncodeMemory(counts, spec.control_mesh)});
    encoded = wire::MostEncodedBytes(counts);
  }
  const wire::TileOptions tiles = LargestTiles(spec);
  const std::uint64_t sending =
      Sum({result, encoded, wire::TileMemory(tiles), kMessagesInFlight * tiles.tile_bytes});
  return Sum(
      {std::max({EstimateUploadBytes(spec), decoding, repairing, computing, encoding, sending}),
       mapping, AlwaysHeld(spec),
       CertificateBuilder::Bytes(counts.vertices, spec.engine.constraints.normals.size())});
}

}  // namespace limn
