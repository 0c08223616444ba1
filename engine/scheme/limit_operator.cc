// SPDX-License-Identifier: MIT
#include "engine/scheme/limit_operator.h"

#include <utility>

namespace limn {

absl::StatusOr<LimitOperator> LimitOperator::Make(const Context& context, const HalfEdgeMesh& mesh,
                                                  const LimitStencil& stencil) {
  LimitOperator result;
  result.stencil_ = {.rows = stencil.rows,
                     .row_of = {},
                     .spectrum_low = stencil.spectrum_low,
                     .spectrum_high = stencil.spectrum_high};
  LIMN_ASSIGN_OR_RETURN(result.faces_, GatherPlan::Make(context, mesh.face_begin(), {}, 1));
  LIMN_ASSIGN_OR_RETURN(result.vertices_, GatherPlan::Make(context, mesh.fan_begin(),
                                                           stencil.row_of, stencil.rows.size()));
  const absl::Span<const Index> vertex_slot = result.vertices_.slot_of_row();
  const absl::Span<const Index> face_slot = result.faces_.slot_of_row();
  LIMN_RETURN_IF_ERROR(result.faces_.Fill(context, mesh.face_begin(),
                                          [&](Index h) { return vertex_slot[mesh.vertex()[h]]; }));
  LIMN_RETURN_IF_ERROR(result.vertices_.Fill(
      context, mesh.fan_begin(), [&](Index i) { return face_slot[mesh.face()[mesh.fan()[i]]]; }));
  if (!stencil.uses_edges()) return result;
  result.neighbours_.resize(mesh.half_edge_count());
  const PolygonWalk walk(mesh);
  LIMN_RETURN_IF_ERROR(result.vertices_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    Index item = run.item;
    for (Index slot = run.begin; slot < run.end; ++slot) {
      const Index fan = mesh.fan_begin()[result.vertices_.row_of_slot()[slot]];
      for (Index j = 0; j < run.length; ++j) {
        result.neighbours_[item++] = vertex_slot[mesh.vertex()[walk.Next(mesh.fan()[fan + j])]];
      }
    }
  }));
  return result;
}

absl::Status LimitOperator::ToSlots(const Context& context, absl::Span<const Vec3> points,
                                    absl::Span<Vec3> slots) const {
  const absl::Span<const Index> row = vertices_.row_of_slot();
  return ParallelFor(context, row.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) slots[slot] = points[row[slot]];
  });
}

absl::Status LimitOperator::FromSlots(const Context& context, absl::Span<const Vec3> slots,
                                      absl::Span<Vec3> points) const {
  const absl::Span<const Index> slot = vertices_.slot_of_row();
  return ParallelFor(context, slot.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) points[v] = slots[slot[v]];
  });
}

absl::Status LimitOperator::FaceCentroids(const Context& context, absl::Span<const Vec3> points,
                                          absl::Span<Vec3> centroids) const {
  return faces_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    const double scale = 1.0 / run.length;
    Vec3* const out = centroids.data();
    faces_.VisitSums(run, points.data(),
                     [=](Index slot, const Vec3& sum) { out[slot] = scale * sum; });
  });
}

absl::Status LimitOperator::Diagonal(const Context& context, absl::Span<double> diagonal) const {
  Buffer<double> inverse_arity(face_count());
  LIMN_RETURN_IF_ERROR(faces_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    for (Index slot = run.begin; slot < run.end; ++slot) inverse_arity[slot] = 1.0 / run.length;
  }));
  return vertices_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    const LimitRow& row = stencil_.rows[run.kind];
    const Index* face = vertices_.items(run);
    for (Index slot = run.begin; slot < run.end; ++slot, face += run.length) {
      double sum = 0;
      for (Index j = 0; j < run.length; ++j) sum += inverse_arity[face[j]];
      diagonal[slot] = row.vertex + row.faces * sum / run.length;
    }
  });
}

}  // namespace limn
