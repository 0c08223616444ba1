// SPDX-License-Identifier: MIT
// The operator L of a limit stencil on a mesh, matrix-free: gather what each face hands to its
// vertices, then gather per vertex. Points and face values are kept in an order of the operator's
// own ("slots") in which both gathers run fast; see GatherPlan.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/stencil/gather_plan.h"
#include "engine/stencil/limit_stencil.h"

namespace limn {

// Thread-safe once made.
class LimitOperator {
 public:
  // mesh: from HalfEdgeMesh::Build, not needed afterwards. Errors: CANCELLED, DEADLINE_EXCEEDED,
  // as for every function below. Cost: a few passes over corners; two indices a corner are kept.
  [[nodiscard]] static absl::StatusOr<LimitOperator> Make(const Context& context,
                                                          const HalfEdgeMesh& mesh,
                                                          const LimitStencil& stencil);

  std::size_t vertex_count() const { return vertices_.size(); }
  std::size_t face_count() const { return faces_.size(); }
  // Values that faces hand out: one per face, or one per corner.
  std::size_t face_value_count() const {
    return stencil_.face_rule == FaceRule::kCentroid ? faces_.size() : corner_count_;
  }
  double spectrum_low() const { return stencil_.spectrum_low; }
  double spectrum_high() const { return stencil_.spectrum_high; }
  // Whether limit points see neighbours' points directly, not through centroids only.
  bool uses_edges() const { return uses_edges_; }
  bool symmetric() const { return edge_weights_.empty(); }

  // slots[slot of v] = points[v], and back.
  [[nodiscard]] absl::Status ToSlots(const Context& context, absl::Span<const Vec3> points,
                                     absl::Span<Vec3> slots) const;
  [[nodiscard]] absl::Status FromSlots(const Context& context, absl::Span<const Vec3> slots,
                                       absl::Span<Vec3> points) const;

  // What the faces hand to their vertices. points: one per vertex, in slots; values:
  // face_value_count(), in the operator's order. Cost: one pass over corners.
  [[nodiscard]] absl::Status FaceValues(const Context& context, absl::Span<const Vec3> points,
                                        absl::Span<Vec3> values) const;

  // Calls visit(slot, limit point) for every vertex, given points and their face values. *largest
  // becomes the largest value that visit returned, and at least 0.
  template <class Visit>
  [[nodiscard]] absl::Status VisitLimits(const Context& context, const Vec3* points,
                                         const Vec3* values, const Visit& visit,
                                         double* largest) const {
    return vertices_.MaxOverRuns(
        context,
        [&](const GatherPlan::Run& run) {
          double most = 0;
          if (run.kind == stencil_.weighted_row) {
            for (Index slot = run.begin; slot < run.end; ++slot) {
              most = std::max(most, visit(slot, WeightedLimit(run, slot, points, values)));
            }
            return most;
          }
          const LimitRow row = stencil_.rows[run.kind];
          const double faces = row.faces / run.length;
          if (row.edges == 0) {
            vertices_.VisitSums(run, values, [&](Index slot, const Vec3& sum) {
              most = std::max(most, visit(slot, row.vertex * points[slot] + faces * sum));
            });
            return most;
          }
          // Interior vertices: as many edges as faces.
          const double edges = row.edges / run.length;
          vertices_.VisitSums(run, values, [&](Index slot, const Vec3& sum) {
            const Index* neighbour =
                neighbours_.data() + run.item + (slot - run.begin) * run.length;
            Vec3 around = points[neighbour[0]];
            for (Index i = 1; i < run.length; ++i) around += points[neighbour[i]];
            most = std::max(most,
                            visit(slot, row.vertex * points[slot] + faces * sum + edges * around));
          });
          return most;
        },
        largest);
  }

  // Positive weights w, in slots, for which diag(w) L is symmetric; 1 where the row is an identity.
  // Only if symmetric().
  [[nodiscard]] absl::Status SymmetricWeights(const Context& context,
                                              absl::Span<double> weights) const;

  // The diagonal of L, the weight of each vertex's own point in its limit point, in slots.
  [[nodiscard]] absl::Status Diagonal(const Context& context, absl::Span<double> diagonal) const;

 private:
  LimitOperator() = default;
  [[nodiscard]] absl::Status FillVertices(const Context& context, const HalfEdgeMesh& mesh);
  [[nodiscard]] absl::Status FillNeighbours(const Context& context, const HalfEdgeMesh& mesh);
  [[nodiscard]] absl::Status FillWeights(const Context& context, const HalfEdgeMesh& mesh,
                                         const LimitStencil& stencil);

  // By differences, so that points far from the origin lose nothing.
  Vec3 WeightedLimit(const GatherPlan::Run& run, Index slot, const Vec3* points,
                     const Vec3* values) const {
    const Index item = run.item + (slot - run.begin) * run.length;
    const Index* face = vertices_.items(run) + (item - run.item);
    Vec3 sum = {0, 0, 0};
    for (Index i = 0; i < run.length; ++i) {
      sum += edge_weights_[item + i] * (points[neighbours_[item + i]] - points[slot]);
      sum += face_weights_[item + i] * (values[face[i]] - points[slot]);
    }
    return points[slot] + sum;
  }

  // Without the rows of single vertices, which are below, and the rows' vertices.
  LimitStencil stencil_;
  bool uses_edges_ = false;
  std::size_t corner_count_ = 0;
  GatherPlan faces_;
  GatherPlan vertices_;
  // Neighbour along each half-edge of the fans, at the places of the vertices' indices. Empty when
  // the stencil does not use edges.
  Buffer<Index> neighbours_;
  // At the same places. Empty when no vertex has a row of its own.
  Buffer<double> edge_weights_;
  Buffer<double> face_weights_;
};

}  // namespace limn
