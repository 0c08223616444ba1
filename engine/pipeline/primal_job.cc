// SPDX-License-Identifier: MIT
// Catmull-Clark and Loop surfaces in a job: schemes whose control meshes have the vertices of T^k.
// Sources: Halstead, Kass and DeRose 1993; Chen et al., "Interpolating meshes of arbitrary topology
// by Catmull-Clark surfaces" (series); Cheng et al., "Progressive interpolation using Loop
// subdivision surfaces", 2008.
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/creases.h"
#include "engine/limit/vertex_limit.h"
#include "engine/pipeline/boundary_row.h"
#include "engine/pipeline/scheme_job.h"
#include "engine/refine/boundary_curve.h"
#include "engine/refine/catmull_clark_refine.h"
#include "engine/refine/loop_refine.h"
#include "engine/refine/quad_split.h"
#include "engine/refine/triangle_split.h"
#include "engine/scheme/sharp_rows.h"
#include "engine/scheme/sharpness.h"
#include "engine/solve/regularity.h"

namespace limn {
namespace {

class PrimalJob : public SchemeJob {
 public:
  explicit PrimalJob(JobFrame* frame)
      : frame_(*frame),
        context_(frame->context),
        kind_(frame->options.scheme == Scheme::kLoop ? RingKind::kTriangles : RingKind::kQuads) {}

  absl::Status Start(HalfEdgeMesh mesh) override {
    if (kind_ == RingKind::kTriangles) LIMN_RETURN_IF_ERROR(RequireTriangles(mesh));
    mesh_ = std::move(mesh);
    LIMN_ASSIGN_OR_RETURN(
        sharpness_, SharpnessOf(context_, *mesh_, frame_.options.constraints,
                                frame_.options.boundary.value_or(BoundaryRule::kEdgeAndCorner)));
    return absl::OkStatus();
  }

  absl::Status FindControlMesh() override {
    const ControlMeshProblem problem = frame_.Problem(*mesh_);
    LIMN_ASSIGN_OR_RETURN(const BoundaryCurve curve, FindBoundary(context_, *mesh_));
    BoundaryProblem boundary = {.curve = curve, .stencil = kCubicCurve};
    SetBoundaryRows({*mesh_, sharpness_}, &boundary);
    LIMN_ASSIGN_OR_RETURN(boundary_control_, SolveBoundary(context_, problem, boundary));
    std::vector<double> shares = {0};
    const bool quads = kind_ == RingKind::kQuads;
    if (quads && frame_.options.rule == FirstRule::kBilinear) shares = {1};
    if (quads && !frame_.options.rule.has_value() && !frame_.options.strict) shares = {0, 0.5};
    for (const double share : shares) {
      LIMN_ASSIGN_OR_RETURN(const bool good, TrySolve(problem, share));
      if (good) break;
    }
    return absl::OkStatus();
  }

  const BoundaryControl& boundary_control() const override { return boundary_control_; }

  absl::Status StartSurface() override {
    points_.assign(frame_.result.control_positions.begin(), frame_.result.control_positions.end());
    return absl::OkStatus();
  }

  absl::StatusOr<ChordLevel> ChooseLevel(double /*tolerance*/) override {
    return ValidateSchemeOptions(frame_.options);
  }

  absl::Status Refine() override {
    const double bilinear = level_ == 0 ? bilinear_share() : 0;
    const bool quads = kind_ == RingKind::kQuads;
    LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh refined, quads ? SplitIntoQuads(context_, *mesh_)
                                                      : SplitIntoTriangles(context_, *mesh_));
    Buffer<Vec3> points(refined.vertex_count());
    const SurfaceLevel level = {*mesh_, sharpness_};
    LIMN_RETURN_IF_ERROR(
        quads ? RefineCatmullClark(context_, level, points_, absl::MakeSpan(points), bilinear)
              : RefineLoop(context_, level, points_, absl::MakeSpan(points)));
    points_ = std::move(points);
    LIMN_ASSIGN_OR_RETURN(sharpness_, RefineSharpness(context_, *mesh_, refined, sharpness_));
    mesh_ = std::move(refined);
    ++level_;
    return absl::OkStatus();
  }

  absl::Status Tessellate() override {
    Tessellation& surface = frame_.result.surface;
    surface.level = level_;
    const std::size_t vertices = mesh_->vertex_count();
    surface.positions.resize(vertices);
    if (frame_.options.normals) surface.normals.resize(vertices);
    LIMN_RETURN_IF_ERROR(TakeFaces(&surface));
    // The first step is not the scheme's own: limits are known from T^1 on.
    if (level_ == 0 && bilinear_share() > 0) LIMN_RETURN_IF_ERROR(Refine());
    const VertexLimits limits = {.points = absl::MakeSpan(surface.positions),
                                 .tangents = {},
                                 .normals = absl::MakeSpan(surface.normals)};
    LIMN_RETURN_IF_ERROR(kind_ == RingKind::kQuads
                             ? CatmullClarkLimits(context_, {*mesh_, sharpness_}, points_, limits)
                             : LoopLimits(context_, {*mesh_, sharpness_}, points_, limits));
    return frame_.moved ? MoveBack(frame_, absl::MakeSpan(surface.positions)) : absl::OkStatus();
  }

 private:
  double bilinear_share() const { return frame_.result.bilinear_share; }

  // Solves with this share of the bilinear rule. False: the equations are not to be solved with it,
  // which half of it always cures: its bound is proved.
  absl::StatusOr<bool> TrySolve(const ControlMeshProblem& problem, double share) {
    InterpolateResult& result = frame_.result;
    result.rule = share > 0 ? FirstRule::kBilinear : FirstRule::kStandard;
    result.bilinear_share = share;
    if (kind_ == RingKind::kQuads && share == 0 && !frame_.options.rule.has_value()) {
      LIMN_ASSIGN_OR_RETURN(const bool singular,
                            CatmullClarkIsSingular(context_, {*mesh_, sharpness_}, frame_.plan));
      if (singular && frame_.options.strict) return NotRegular();
      if (singular) return false;
    }
    LimitStencil stencil;
    if (kind_ == RingKind::kQuads) {
      LIMN_ASSIGN_OR_RETURN(stencil, CatmullClarkStencil(context_, *mesh_, share));
    } else {
      LIMN_ASSIGN_OR_RETURN(stencil, LoopStencil(context_, *mesh_));
    }
    LIMN_ASSIGN_OR_RETURN(WeightedRows rows,
                          SharpRows(context_, kind_, {*mesh_, sharpness_}, share));
    if (!frame_.options.rule.has_value() && share == 0) {
      LIMN_ASSIGN_OR_RETURN(const bool nearly,
                            IsNearlySingular(context_, {*mesh_, frame_.plan, stencil, rows}));
      if (nearly && frame_.options.strict) return NotRegular();
      if (nearly) return false;
    }
    LIMN_RETURN_IF_ERROR(
        SetWeightedRows(context_, mesh_->vertex_count(), std::move(rows), &stencil));
    LIMN_ASSIGN_OR_RETURN(result.solve, SolveControlMesh(context_, problem, boundary_control_,
                                                         {.stencil = std::move(stencil),
                                                          .options = frame_.options.solve},
                                                         absl::MakeSpan(result.control_positions)));
    return true;
  }

  absl::Status NotRegular() const {
    return MakeError(
        "solve.strict: the interpolation problem of this mesh is singular or nearly so",
        {.reason = Reason::kIllConditioned,
         .field = "solve.strict",
         .remedy = "Leave strict out, which takes half of the first refinement bilinear, or "
                   "interpolate fewer vertices"});
  }

  // Faces of T^level, without holes.
  absl::Status TakeFaces(Tessellation* surface) {
    const bool given = level_ == 0;
    const std::size_t faces = mesh_->face_count();
    if (given) {
      surface->face_begin = frame_.input.face_begin;
      surface->face_vertices = frame_.input.corner_vertex;
    } else {
      surface->arity = kind_ == RingKind::kQuads ? 4 : 3;
      surface->face_vertices.assign(mesh_->vertex().begin(), mesh_->vertex().end());
    }
    if (sharpness_.hole.empty()) return absl::OkStatus();
    // In place: what is kept moves forward.
    std::size_t to_face = 0;
    std::size_t to = 0;
    for (std::size_t f = 0; f < faces; ++f) {
      if (f % kScanBlock == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      if (sharpness_.hole[f] != 0) continue;
      const std::size_t first = given ? mesh_->face_begin()[f] : f * surface->arity;
      const std::size_t last = given ? mesh_->face_begin()[f + 1] : first + surface->arity;
      for (std::size_t h = first; h < last; ++h) {
        surface->face_vertices[to++] = surface->face_vertices[h];
      }
      ++to_face;
      if (given) surface->face_begin[to_face] = static_cast<Index>(to);
    }
    surface->face_vertices.resize(to);
    if (given) surface->face_begin.resize(to_face + 1);
    return absl::OkStatus();
  }

  JobFrame& frame_;
  const Context& context_;
  const RingKind kind_;
  BoundaryControl boundary_control_;
  std::uint32_t level_ = 0;
  // T^level with its sharpness and control points.
  std::optional<HalfEdgeMesh> mesh_;
  Sharpness sharpness_;
  Buffer<Vec3> points_;
};

}  // namespace

std::unique_ptr<SchemeJob> MakePrimalJob(JobFrame* frame) {
  return std::make_unique<PrimalJob>(frame);
}

}  // namespace limn
