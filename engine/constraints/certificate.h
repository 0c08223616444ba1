// SPDX-License-Identifier: MIT
// How far a surface is from the points that it was asked to pass through and from the normals that
// it was asked to have there, vertex by vertex.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/constraints/constraints.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

struct Certificate {
  // Vertices whose points were checked.
  std::uint64_t points_checked = 0;
  // Largest Euclidean distance to a target, in model units; infinite for a position that is not
  // finite.
  double max_error = 0;
  // Mean distance over the checked vertices, in model units.
  double mean_error = 0;
  // Vertex of the largest distance, the first of them; 0 when nothing was checked.
  Index max_error_vertex = 0;
  // Diagonal of the targets' bounding box, in model units; of all targets, checked or not.
  double bounding_box_diagonal = 0;
  // Prescribed normals that were checked.
  std::uint64_t normals_checked = 0;
  // Largest angle between the lines along a prescribed normal and the surface's normal, in radians,
  // 0 to pi/2; pi/2 where the surface's normal is (0, 0, 0) or not finite.
  double max_normal_deviation = 0;
  // Vertex of the largest deviation, the first of them; 0 when nothing was checked.
  Index max_normal_deviation_vertex = 0;
};

// The angle between the lines along a and b, in radians, 0 to pi/2, with a relative error of some
// units in the last place of a unit vector: 1e-10 can be seen. pi/2 where a or b is zero or not
// finite. a and -a are the same line; lengths do not matter.
[[nodiscard]] double AngleBetweenLines(const Vec3& a, const Vec3& b);

// Collects positions and normals at vertices from runs that come in any order. The first vertices
// of a tessellation are the limit points of the input's, in order, so that whole tiles can be
// given; what lies beyond the targets, at vertices that are not interpolated or without a
// prescribed normal is ignored. Not thread-safe.
class CertificateBuilder {
 public:
  // targets: one point per input vertex; finite. constraints: those of the job, which have been
  // found valid (ValidateConstraints): its subset, all vertices without one, and its normals.
  // Memory: 8 bytes per target beside them, 40 per normal. Cost: linear; n log n in the normals.
  explicit CertificateBuilder(Buffer<Vec3> targets, const Constraints& constraints = {});

  // Bytes that it takes beside the targets.
  static std::uint64_t Bytes(std::uint64_t targets, std::uint64_t normals);

  // The surface is at `position` at this vertex. Told again, the larger distance counts.
  void Add(std::uint64_t vertex, const Vec3& position);
  // The surface is at these positions at the vertices from first_vertex on.
  void AddRun(std::uint64_t first_vertex, absl::Span<const Vec3> positions);

  // The surface has this normal, of any length, at this vertex. Told again, the larger deviation
  // counts. Cost: logarithmic in the prescribed normals.
  void AddNormal(std::uint64_t vertex, const Vec3& normal);
  // The surface has these normals at the vertices from first_vertex on.
  void AddNormalRun(std::uint64_t first_vertex, absl::Span<const Vec3> normals);

  // Whether the vertex's point counts. Prescribed normals stand at such vertices only.
  bool counts(std::uint64_t vertex) const {
    return vertex < distances_.size() && distances_[vertex] > kIgnored;
  }
  std::uint64_t target_count() const { return targets_.size(); }
  // Whether all that counts has been told.
  bool complete() const { return checked_ == wanted_ && normals_checked_ == normals_.size(); }

  // The sums run in vertex order, whatever the order of the runs: same bits for the same surface.
  // Cost: linear in the targets.
  [[nodiscard]] Certificate Finish() const;

 private:
  struct Normal {
    Index vertex;
    // Unit length.
    Vec3 direction;
    // Negative where nothing was told yet.
    double deviation;
  };
  // In distances_, which are 0 or more once told.
  static constexpr double kUnchecked = -1;
  static constexpr double kIgnored = -2;

  void TellNormal(Normal* normal, const Vec3& found);
  void FinishNormals(Certificate* certificate) const;

  Buffer<Vec3> targets_;
  // Distance per target.
  Buffer<double> distances_;
  // Vertices that count, and those of them that were told.
  std::uint64_t wanted_ = 0;
  std::uint64_t checked_ = 0;
  // By vertex.
  std::vector<Normal> normals_;
  std::uint64_t normals_checked_ = 0;
};

}  // namespace limn
