// SPDX-License-Identifier: MIT
// Doo-Sabin surfaces from feature values in a job. Source: Xu and Kondo, section 3.2.
//
// Where there are plane faces, the surface is made, refined and bounded on the mesh that is cut
// along them. Corners are the same in the cut mesh and in the given one, T^0, at every level: so
// the tessellation is put together again by them, and has the connectivity and the numbers that
// engine/limit/tessellation.h promises.
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/constraints.h"
#include "engine/constraints/features.h"
#include "engine/mesh/quad_split.h"
#include "engine/pipeline/doo_sabin_job.h"
#include "engine/refine/average_normal.h"

namespace limn {
namespace {

// Points and normals of T^k on the cut mesh as those of T^k on the given one. Normals at cuts are
// the mean of the sides', and zero where these are opposite.
class Joiner {
 public:
  // given, cut: T^(k - 1), or T^0 for k = 0.
  Joiner(const HalfEdgeMesh& given, const HalfEdgeMesh& cut, const Tessellation& from,
         Tessellation* to)
      : given_(given), cut_(cut), from_(from), to_(*to) {}

  absl::Status Run(const Context& context, bool vertices_only) {
    const std::size_t edges = vertices_only ? 0 : given_.edge_count();
    const std::size_t faces = vertices_only ? 0 : given_.face_count();
    const std::size_t first_face = given_.vertex_count() + edges;
    const std::size_t cut_first_face = cut_.vertex_count() + cut_.edge_count();
    to_.positions.resize(first_face + faces);
    if (!from_.normals.empty()) to_.normals.resize(first_face + faces);
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context, given_.vertex_count(), [&](std::size_t begin, std::size_t end) {
          WithWalk(given_, [&](const auto& walk) {
            for (std::size_t v = begin; v < end; ++v) JoinVertex(walk, v);
          });
        }));
    LIMN_RETURN_IF_ERROR(ParallelFor(context, edges, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) JoinEdge(e);
    }));
    return ParallelFor(context, faces, [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) Copy(cut_first_face + f, first_face + f);
    });
  }

 private:
  // Of a sum of unit vectors; none where they are opposite.
  static Vec3 Direction(const Vec3& sum) {
    return Dot(sum, sum) > 1e-20 ? NormalizedOrZero(sum) : Vec3{0, 0, 0};
  }

  void Copy(std::size_t from, std::size_t to) {
    to_.positions[to] = from_.positions[from];
    if (!to_.normals.empty()) to_.normals[to] = from_.normals[from];
  }

  template <class Walk>
  void JoinVertex(const Walk& walk, std::size_t v) {
    const Index start = given_.vertex_half_edge()[v];
    Index part = cut_.vertex()[start];
    Copy(part, v);
    if (to_.normals.empty() || !cut_.IsBoundary(part)) return;
    // Every part counts once, from where it begins on.
    Vec3 sum = {0, 0, 0};
    VisitFan(walk, given_.twin(), start, [&](Index h) {
      part = cut_.vertex()[h];
      if (cut_.vertex_half_edge()[part] == h) sum += from_.normals[part];
    });
    to_.normals[v] = Direction(sum);
  }

  void JoinEdge(std::size_t e) {
    const Index h = given_.edge_half_edge()[e];
    const Index twin = given_.twin()[h];
    const std::size_t side = cut_.vertex_count() + cut_.edge()[h];
    const std::size_t to = given_.vertex_count() + e;
    Copy(side, to);
    if (to_.normals.empty() || twin == kNoIndex || cut_.twin()[h] != kNoIndex) return;
    const std::size_t other = cut_.vertex_count() + cut_.edge()[twin];
    to_.normals[to] = Direction(from_.normals[side] + from_.normals[other]);
  }

  const HalfEdgeMesh& given_;
  const HalfEdgeMesh& cut_;
  const Tessellation& from_;
  Tessellation& to_;
};

class FeatureJob : public DooSabinJob {
 public:
  using DooSabinJob::DooSabinJob;

  absl::Status Start(HalfEdgeMesh mesh) override {
    LIMN_RETURN_IF_ERROR(ValidateDooSabinNormals(context_, frame_.options.constraints, mesh));
    LIMN_ASSIGN_OR_RETURN(FeatureSurface feature,
                          FeatureSurface::Create(context_, std::move(mesh)));
    feature_.emplace(std::move(feature));
    return absl::OkStatus();
  }

  // The given mesh is the control mesh.
  absl::Status FindControlMesh() override {
    InterpolateResult& result = frame_.result;
    result.control_positions.assign(frame_.points.begin(), frame_.points.end());
    result.rule = FirstRule::kFeatures;
    result.solve = {.sweeps = 0, .converged = true};
    return absl::OkStatus();
  }

  absl::Status StartSurface() override {
    LIMN_RETURN_IF_ERROR(frame_.Stage("first_refinement", [&] {
      return feature_->Make(context_, {.points = frame_.input.positions,
                                       .constraints = frame_.options.constraints,
                                       .origin = frame_.origin});
    }));
    given_ = std::move(*feature_).TakeGiven();
    patches_ = std::move(*feature_).TakeSurface();
    if (given_.has_value() && frame_.options.normals) LIMN_RETURN_IF_ERROR(FindPlaneNormals());
    feature_.reset();
    KeepPatches();
    return absl::OkStatus();
  }

  absl::Status Refine() override {
    LIMN_RETURN_IF_ERROR(DooSabinJob::Refine());
    if (!given_.has_value() || level_ < 2) return absl::OkStatus();
    LIMN_ASSIGN_OR_RETURN(given_, SplitIntoQuads(context_, *given_));
    return absl::OkStatus();
  }

  absl::Status Tessellate() override {
    LIMN_RETURN_IF_ERROR(DooSabinJob::Tessellate());
    if (!given_.has_value()) return absl::OkStatus();
    Tessellation& surface = frame_.result.surface;
    LIMN_RETURN_IF_ERROR(SetPlaneNormals(&surface));
    Tessellation joined = {.level = surface.level};
    const bool vertices_only = level_ == 0;
    LIMN_RETURN_IF_ERROR(
        Joiner(*given_, patches_->mesh, surface, &joined).Run(context_, vertices_only));
    surface.positions = std::move(joined.positions);
    surface.normals = std::move(joined.normals);
    if (vertices_only) return absl::OkStatus();
    return QuadVertices(context_, *given_, absl::MakeSpan(surface.face_vertices));
  }

 private:
  // A corner of a plane face, a component of its own in the cut mesh.
  struct PlaneCorner {
    Index vertex;
    Vec3 normal;
  };

  absl::Status FindPlaneNormals() {
    const HalfEdgeMesh& cut = patches_->mesh;
    std::size_t corners = 0;
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context_, cut.face_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t f = begin; f < end; ++f) {
            if (IsPlane(f)) corners += cut.face_begin()[f + 1] - cut.face_begin()[f];
          }
        }));
    plane_corners_.reserve(corners);
    return ForInOrder(context_, cut.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        if (IsPlane(f)) FindPlaneNormal(f);
      }
    });
  }

  bool IsPlane(std::size_t f) const { return feature_->IsPlane(static_cast<Index>(f)); }

  void FindPlaneNormal(std::size_t f) {
    const HalfEdgeMesh& cut = patches_->mesh;
    const BoundaryCurve& curve = patches_->boundary;
    const Index first = cut.face_begin()[f];
    const std::size_t m = cut.face_begin()[f + 1] - first;
    const auto point = [&](std::size_t j) {
      return curve.centre[curve.Find(first + static_cast<Index>(j))] - curve.origin;
    };
    Vec3 sum = {0, 0, 0};
    for (std::size_t j = 0; j < m; ++j) sum += point(j);
    const Vec3 normal = AverageNormal(m, (1.0 / static_cast<double>(m)) * sum, point);
    for (std::size_t j = 0; j < m; ++j) plane_corners_.push_back({cut.vertex()[first + j], normal});
  }

  // Also where a plane region's parameters meet at a straight angle, which shows none.
  absl::Status SetPlaneNormals(Tessellation* surface) const {
    if (surface->normals.empty()) return absl::OkStatus();
    return ParallelFor(context_, plane_corners_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        surface->normals[plane_corners_[i].vertex] = plane_corners_[i].normal;
      }
    });
  }

  std::optional<FeatureSurface> feature_;
  // T^(level - 1), not cut; only where patches_ are cut.
  std::optional<HalfEdgeMesh> given_;
  std::vector<PlaneCorner> plane_corners_;
};

}  // namespace

std::unique_ptr<SchemeJob> MakeFeatureJob(JobFrame* frame) {
  return std::make_unique<FeatureJob>(frame);
}

}  // namespace limn
