// SPDX-License-Identifier: MIT
// What a scheme contributes to a job: its limit stencil and boundary rule when the control mesh is
// solved for, its refinement rule, its limit points. Everything else is engine/interpolate.cc's.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/interpolate.h"
#include "engine/limit/chord_bound.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/solve/control_mesh.h"

namespace limn {

// What every job has. Lives as long as the job.
struct JobFrame {
  const Context& context;
  const PolygonMesh& input;
  const InterpolateOptions& options;
  // The points to interpolate, relative to the origin. Far from the origin of the model coordinates
  // leave few bits for the shape, so that jobs run on points around one of their own.
  absl::Span<const Vec3> points = {};
  Vec3 origin = {0, 0, 0};
  // Whether points are not the input's own.
  bool moved = false;
  // Diagonal of the bounding box; 1 if that is 0.
  double scale = 1;
  VertexPlan plan = {};
  // The result so far.
  InterpolateResult result = {};

  ControlMeshProblem Problem(const HalfEdgeMesh& mesh) const {
    return {.mesh = mesh,
            .model_points = input.positions,
            .points = points,
            .origin = origin,
            .plan = plan,
            .scale = scale};
  }

  // Runs f() as a stage: progress when it begins, its time when it ends.
  template <class F>
  absl::Status Stage(std::string_view name, const F& f) {
    context.Report({.stage = name});
    const auto begin = std::chrono::steady_clock::now();
    absl::Status status = f();
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - begin;
    result.stages.push_back({.stage = name, .milliseconds = elapsed.count()});
    return status;
  }
};

// Calls come in the order of the declarations. Errors of all: what is wrong with the options and
// constraints for the scheme, and as Interpolate.
class SchemeJob {
 public:
  SchemeJob() = default;
  SchemeJob(const SchemeJob&) = delete;
  SchemeJob& operator=(const SchemeJob&) = delete;
  virtual ~SchemeJob() = default;

  // Takes T^0. In the stage "build".
  virtual absl::Status Start(HalfEdgeMesh mesh) = 0;
  // The surface's points at the vertices, for these control points; both one per vertex, relative
  // to one origin. After Start, and before anything else.
  virtual absl::Status LimitPoints(absl::Span<const Vec3> control, absl::Span<Vec3> limits) = 0;
  // Sets result.control_positions, relative to the origin, and what the result tells of the solve.
  // In the stage "solve".
  virtual absl::Status FindControlMesh() = 0;
  // Boundary vertices whose control points are known in the model's frame.
  virtual const BoundaryControl& boundary_control() const = 0;
  // Stages of its own after the solve: from the control mesh to a surface that meets everything.
  virtual absl::Status StartSurface() = 0;
  // The level that a chord tolerance needs, at most options.finest. In the stage "choose_level".
  virtual absl::StatusOr<ChordLevel> ChooseLevel(double tolerance) = 0;
  // The next level. In the stage "refine", `level` times.
  virtual absl::Status Refine() = 0;
  // result.surface, after that many refinements. In the stage "limit".
  virtual absl::Status Tessellate() = 0;
};

// frame must outlive the job.
[[nodiscard]] std::unique_ptr<SchemeJob> MakeDooSabinJob(JobFrame* frame);
// Doo-Sabin with options.constraints.features.
[[nodiscard]] std::unique_ptr<SchemeJob> MakeFeatureJob(JobFrame* frame);
// Catmull-Clark and Loop.
[[nodiscard]] std::unique_ptr<SchemeJob> MakePrimalJob(JobFrame* frame);

// points[i] += the frame's origin.
[[nodiscard]] absl::Status MoveBack(const JobFrame& frame, absl::Span<Vec3> points);

}  // namespace limn
