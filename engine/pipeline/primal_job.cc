// SPDX-License-Identifier: MIT
// Catmull-Clark and Loop surfaces in a job: schemes whose control meshes have the vertices of T^k.
// Sources: Halstead, Kass and DeRose 1993; Chen et al., "Interpolating meshes of arbitrary topology
// by Catmull-Clark surfaces" (series); Cheng et al., "Progressive interpolation using Loop
// subdivision surfaces", 2008.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/blend.h"
#include "engine/constraints/blend_region.h"
#include "engine/constraints/blend_targets.h"
#include "engine/constraints/creases.h"
#include "engine/limit/vertex_limit.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "engine/pipeline/boundary_row.h"
#include "engine/pipeline/scheme_job.h"
#include "engine/refine/boundary_curve.h"
#include "engine/refine/catmull_clark_refine.h"
#include "engine/refine/loop_refine.h"
#include "engine/scheme/sharpness.h"
#include "engine/solve/regularity.h"
#include "engine/stencil/sharp_rows.h"

namespace limn {
namespace {

// The level whose control points blending moves.
constexpr std::uint32_t kBlendLevel = 2;

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
    LIMN_ASSIGN_OR_RETURN(targets_, BlendTargets(context_,
                                                 {.mesh = *mesh_,
                                                  .kind = kind_,
                                                  .hole = sharpness_.hole,
                                                  .points = frame_.input.positions},
                                                 frame_.options.constraints));
    return absl::OkStatus();
  }

  absl::Status LimitPoints(absl::Span<const Vec3> control, absl::Span<Vec3> limits) override {
    const SurfaceLevel level = {*mesh_, sharpness_};
    const VertexLimits out = {.points = limits, .tangents = {}, .normals = {}};
    return kind_ == RingKind::kQuads ? CatmullClarkLimits(context_, level, control, out)
                                     : LoopLimits(context_, level, control, out);
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
    if (!targets_.empty()) {
      LIMN_RETURN_IF_ERROR(frame_.Stage("blend", [this] { return BlendTargetsIn(); }));
    }
    if (frame_.options.surface) return KeepPatches();
    return RefineToPatches();
  }

  absl::StatusOr<ChordLevel> ChooseLevel(double /*tolerance*/) override {
    return ValidateSchemeOptions(frame_.options);
  }

  absl::Status Refine() override {
    ++asked_;
    // Blending may have been there before.
    return asked_ > level_ ? NextLevel() : absl::OkStatus();
  }

  absl::Status Tessellate() override {
    Tessellation& surface = frame_.result.surface;
    surface.level = asked_;
    if (blended_coarse()) {
      LIMN_RETURN_IF_ERROR(TakeBlendedLimits());
    } else {
      LIMN_RETURN_IF_ERROR(TakeFaces());
      // The first step is not the scheme's own: limits are known from T^1 on.
      if (level_ == 0 && bilinear_share() > 0) LIMN_RETURN_IF_ERROR(NextLevel());
      LIMN_RETURN_IF_ERROR(TakeLimits());
    }
    if (frame_.moved) LIMN_RETURN_IF_ERROR(MoveBack(frame_, absl::MakeSpan(surface.positions)));
    return RefineToPatches();
  }

 private:
  double bilinear_share() const { return frame_.result.bilinear_share; }

  // The level that evaluation starts from.
  std::uint32_t patch_level() const {
    if (!targets_.empty()) return kBlendLevel;
    return kind_ == RingKind::kQuads ? 1 : 0;
  }

  absl::Status NextLevel() {
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
    return KeepPatches();
  }

  absl::Status BlendTargetsIn() {
    const std::uint64_t most_points = MostBlendPoints(
        mesh_->vertex_count(), mesh_->half_edge_count(), frame_.options.constraints);
    Buffer<std::uint8_t> stays;
    LIMN_RETURN_IF_ERROR(FindStaying(&stays));
    // Where the first step is not the scheme's own, limits are known from T^1 on.
    const std::uint32_t first = bilinear_share() > 0 ? 1 : 0;
    while (level_ < kBlendLevel) {
      if (blended_coarse() && level_ == frame_.options.level) {
        LIMN_RETURN_IF_ERROR(TakeFaces());
      }
      if (blended_coarse() && level_ == std::max(first, frame_.options.level)) {
        LIMN_RETURN_IF_ERROR(TakeLimits());
      }
      LIMN_RETURN_IF_ERROR(NextLevel());
    }
    PrimalSurface surface = {.kind = kind_,
                             .mesh = *std::move(mesh_),
                             .sharpness = std::move(sharpness_),
                             .points = std::move(points_)};
    Describe(&surface);
    const BlendInput input = {
        .targets = targets_, .stays = stays, .scale = frame_.scale, .most_points = most_points};
    absl::StatusOr<BlendReport> report = Blend(context_, input, &surface);
    mesh_ = std::move(surface.mesh);
    sharpness_ = std::move(surface.sharpness);
    points_ = std::move(surface.points);
    LIMN_ASSIGN_OR_RETURN(frame_.result.blend, std::move(report));
    return absl::OkStatus();
  }

  // Whether the tessellation is of a level that refinement has left behind.
  bool blended_coarse() const {
    return !targets_.empty() && frame_.options.surface && frame_.options.level < kBlendLevel;
  }

  // What a surface is beside the arrays of this level.
  void Describe(PrimalSurface* surface) const {
    const bool quads = kind_ == RingKind::kQuads;
    if (quads) surface->face_begin = frame_.input.face_begin;
    surface->depth = level_ - (quads ? 1 : 0);
    surface->origin = frame_.origin;
  }

  // Points that blending must not move: those that are interpolated, and corners of the boundary.
  absl::Status FindStaying(Buffer<std::uint8_t>* stays) const {
    stays->resize(mesh_->vertex_count());
    const bool corners = sharpness_.boundary != BoundaryRule::kEdgeOnly;
    return ParallelFor(context_, stays->size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const bool corner = corners && mesh_->valence(v) == 1;
        (*stays)[v] = corner || frame_.plan.interpolated(v) ? 1 : 0;
      }
    });
  }

  absl::Status RefineToPatches() {
    if (!frame_.options.keep_patches) return absl::OkStatus();
    while (level_ < patch_level()) LIMN_RETURN_IF_ERROR(NextLevel());
    return KeepPatches();
  }

  // Keeps this level for evaluation if it is that one.
  absl::Status KeepPatches() {
    std::optional<LimitSurface>& patches = frame_.result.patches;
    const bool ready = level_ == patch_level() && (targets_.empty() || frame_.result.blend);
    if (!frame_.options.keep_patches || !ready || patches.has_value()) return absl::OkStatus();
    const bool last = !frame_.options.surface;
    PrimalSurface surface = {.kind = kind_,
                             .mesh = last ? *std::move(mesh_) : *mesh_,
                             .sharpness = last ? std::move(sharpness_) : sharpness_,
                             .points = last ? std::move(points_) : points_};
    Describe(&surface);
    patches = std::move(surface);
    return context_.Check();
  }

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

  // Faces of this level, without holes, and the number of its vertices.
  absl::Status TakeFaces() {
    Tessellation* surface = &frame_.result.surface;
    vertices_ = mesh_->vertex_count();
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

  // Limits at the vertices of the level that the faces are of.
  absl::Status TakeLimits() {
    Tessellation& surface = frame_.result.surface;
    surface.positions.resize(vertices_);
    if (frame_.options.normals) surface.normals.resize(vertices_);
    return FindLimits({.points = absl::MakeSpan(surface.positions),
                       .tangents = {},
                       .normals = absl::MakeSpan(surface.normals)});
  }

  absl::Status FindLimits(const VertexLimits& limits) const {
    const SurfaceLevel level = {*mesh_, sharpness_};
    return kind_ == RingKind::kQuads ? CatmullClarkLimits(context_, level, points_, limits)
                                     : LoopLimits(context_, level, points_, limits);
  }

  // Of a tessellation that is coarser than T^2: the limits of what blending has changed. The others
  // keep the bits that they have without.
  absl::Status TakeBlendedLimits() {
    Buffer<std::uint8_t> changed(vertices_);
    std::fill(changed.begin(), changed.end(), std::uint8_t{0});
    const auto note = [&](Index v) {
      if (v < vertices_) changed[v] = 1;
    };
    for (const Index v : frame_.result.blend->moved) {
      note(v);
      VisitRing(*mesh_, v, note);
    }
    Buffer<Vec3> points(vertices_);
    Buffer<Vec3> normals(frame_.options.normals ? vertices_ : 0);
    LIMN_RETURN_IF_ERROR(FindLimits(
        {.points = absl::MakeSpan(points), .tangents = {}, .normals = absl::MakeSpan(normals)}));
    Tessellation& surface = frame_.result.surface;
    return ParallelFor(context_, vertices_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (changed[v] == 0) continue;
        surface.positions[v] = points[v];
        if (!normals.empty()) surface.normals[v] = normals[v];
      }
    });
  }

  JobFrame& frame_;
  const Context& context_;
  const RingKind kind_;
  BoundaryControl boundary_control_;
  // What is asked for beside the points of vertices.
  std::vector<BlendTarget> targets_;
  // Refinements asked for, and made.
  std::uint32_t asked_ = 0;
  std::uint32_t level_ = 0;
  // Of the tessellation.
  std::size_t vertices_ = 0;
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
