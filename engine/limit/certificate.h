// SPDX-License-Identifier: MIT
// How far a surface is from the points that it was asked to pass through, vertex by vertex.
#pragma once

#include <cstdint>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

struct Certificate {
  // Vertices that were checked.
  std::uint64_t points_checked = 0;
  // Largest Euclidean distance to a target, in model units; infinite for a position that is not
  // finite.
  double max_error = 0;
  // Mean distance over the checked vertices, in model units.
  double mean_error = 0;
  // Vertex of the largest distance, the first of them; 0 when nothing was checked.
  Index max_error_vertex = 0;
  // Diagonal of the targets' bounding box, in model units.
  double bounding_box_diagonal = 0;
};

// Collects distances from runs of positions that come in any order. The first vertices of a
// tessellation are the limit points of the input's, in order, so that whole tiles can be given;
// what lies beyond the targets is ignored. Not thread-safe.
class CertificateBuilder {
 public:
  // targets: one point per input vertex; finite. Memory: 8 bytes per target beside them.
  explicit CertificateBuilder(Buffer<Vec3> targets);

  // The surface is at `position` at this vertex. Told again, the larger distance counts.
  void Add(std::uint64_t vertex, const Vec3& position);

  // The surface is at these positions at the vertices from first_vertex on.
  void AddRun(std::uint64_t first_vertex, absl::Span<const Vec3> positions);

  // Whether all targets have been checked.
  bool complete() const { return checked_ == targets_.size(); }
  std::uint64_t target_count() const { return targets_.size(); }

  // The sums run in vertex order, whatever the order of the runs: same bits for the same
  // positions. Cost: linear in the targets.
  [[nodiscard]] Certificate Finish() const;

 private:
  Buffer<Vec3> targets_;
  // Distance per target; negative where nothing was told yet.
  Buffer<double> distances_;
  std::uint64_t checked_ = 0;
};

}  // namespace limn
