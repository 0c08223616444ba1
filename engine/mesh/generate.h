// SPDX-License-Identifier: MIT
// Made-up meshes for trying, testing and measuring: irregular polygons of every sort, in any size,
// the same for the same options on every platform (all arithmetic is +, -, *, / and sqrt of IEEE
// doubles on the numbers of std::mt19937_64).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

enum class MeshKind {
  // A bumpy sphere of polygons of 3 to 8 sides, valences 3 to 9. Exactly `vertices`.
  kIrregularSphere,
  // A torus of quads, some of them split into triangles, some merged. Exactly `vertices`.
  kTorus,
  // A scaffold of quads with a handle for every hole between its bars. `vertices` rounded down to
  // a multiple of 8.
  kHighGenus,
  // A sphere of triangles whose first vertex has valence vertices / 2 (3 where there are 8).
  // Exactly `vertices`.
  kHub,
  // A bumpy sphere of polygons of 3 to 12 sides with three at every vertex. `vertices` rounded
  // down to an even number, as Euler's formula wants it.
  kNgons,
  // A box of quads whose edge lengths grow away from one corner. At most `vertices`, and at least
  // 9/10 of them from 200 on.
  kCube,
  // An open, wavy rectangle of quads, some of them split or merged. Exactly `vertices`.
  kGrid,
  // An open, wavy disk of polygons of 3 to 8 sides. Exactly `vertices`.
  kDisk,
  // A box of quads whose grid lines crowd at its edges, as in a mesh for flow along walls: lengths
  // grow up to about fifty-fold from each edge to the middle. Counts as kCube.
  kGradedBox,
};

struct GenerateOptions {
  MeshKind kind = MeshKind::kIrregularSphere;
  // Wanted number of vertices, from MinGeneratedVertices(kind) to kMaxGeneratedVertices. How close
  // the result comes is said at each kind.
  std::uint64_t vertices = 11540;
  // Meshes of different seeds differ in connectivity, where the kind leaves a choice, and in shape.
  std::uint64_t seed = 1;
};

inline constexpr std::uint64_t kMaxGeneratedVertices = std::uint64_t{1} << 26;

// All kinds, in the order of the enum.
absl::Span<const MeshKind> AllMeshKinds();

// The kind's name, such as "irregular_sphere".
std::string_view MeshKindName(MeshKind kind);

// The kind of that name. INVALID_OPTION, naming all kinds, if there is none.
[[nodiscard]] absl::StatusOr<MeshKind> ParseMeshKind(std::string_view name);

// Whether meshes of this kind have no boundary.
bool IsClosedKind(MeshKind kind);

// The fewest vertices that a mesh of this kind can have; between 4 and 32.
std::uint64_t MinGeneratedVertices(MeshKind kind);

// A valid, oriented, connected 2-manifold, counter-clockwise seen from outside (open kinds: from
// above). Errors: INVALID_OPTION for `vertices` out of range, OUT_OF_MEMORY. Cost: up to 3 s
// for a million vertices. Thread-safe.
[[nodiscard]] absl::StatusOr<PolygonMesh> GenerateMesh(const GenerateOptions& options);

}  // namespace limn
