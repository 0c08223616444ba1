// SPDX-License-Identifier: MIT
#include "engine/stencil/limit_operator.h"

#include <algorithm>
#include <utility>

#include "engine/refine/doo_sabin_rule.h"

namespace limn {

absl::StatusOr<LimitOperator> LimitOperator::Make(const Context& context, const HalfEdgeMesh& mesh,
                                                  const LimitStencil& stencil) {
  LimitOperator result;
  result.stencil_ = {.rows = stencil.rows,
                     .row_of = {},
                     .weighted = {},
                     .weighted_row = stencil.weighted_row,
                     .face_rule = stencil.face_rule,
                     .spectrum_low = stencil.spectrum_low,
                     .spectrum_high = stencil.spectrum_high};
  result.uses_edges_ = stencil.uses_edges();
  LIMN_ASSIGN_OR_RETURN(result.faces_, GatherPlan::Make(context, mesh.face_begin(), {}, 1));
  LIMN_ASSIGN_OR_RETURN(result.vertices_, GatherPlan::Make(context, mesh.fan_begin(),
                                                           stencil.row_of, stencil.rows.size()));
  const absl::Span<const Index> vertex_slot = result.vertices_.slot_of_row();
  result.corner_count_ = mesh.half_edge_count();
  LIMN_RETURN_IF_ERROR(result.faces_.Fill(context, mesh.face_begin(),
                                          [&](Index h) { return vertex_slot[mesh.vertex()[h]]; }));
  LIMN_RETURN_IF_ERROR(result.FillVertices(context, mesh));
  if (result.uses_edges_) LIMN_RETURN_IF_ERROR(result.FillNeighbours(context, mesh));
  if (!stencil.weighted.empty()) {
    LIMN_RETURN_IF_ERROR(result.FillWeights(context, mesh, stencil));
  }
  return result;
}

absl::Status LimitOperator::FillNeighbours(const Context& context, const HalfEdgeMesh& mesh) {
  neighbours_.resize(mesh.half_edge_count());
  const absl::Span<const Index> vertex_slot = vertices_.slot_of_row();
  const PolygonWalk walk(mesh);
  return vertices_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    Index item = run.item;
    for (Index slot = run.begin; slot < run.end; ++slot) {
      const Index fan = mesh.fan_begin()[vertices_.row_of_slot()[slot]];
      for (Index j = 0; j < run.length; ++j) {
        neighbours_[item++] = vertex_slot[mesh.vertex()[walk.Next(mesh.fan()[fan + j])]];
      }
    }
  });
}

absl::Status LimitOperator::FillWeights(const Context& context, const HalfEdgeMesh& mesh,
                                        const LimitStencil& stencil) {
  edge_weights_.resize(mesh.half_edge_count());
  face_weights_.resize(mesh.half_edge_count());
  const WeightedRows& rows = stencil.weighted;
  return vertices_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    if (run.kind != stencil.weighted_row) return;
    Index item = run.item;
    for (Index slot = run.begin; slot < run.end; ++slot, item += run.length) {
      const Index v = vertices_.row_of_slot()[slot];
      const auto row = std::lower_bound(rows.vertex.begin(), rows.vertex.end(), v);
      const std::size_t first = rows.begin[static_cast<std::size_t>(row - rows.vertex.begin())];
      for (Index j = 0; j < run.length; ++j) {
        edge_weights_[item + j] = rows.edge[first + j];
        face_weights_[item + j] = rows.face[first + j];
      }
    }
  });
}

// The face values that each vertex adds up.
absl::Status LimitOperator::FillVertices(const Context& context, const HalfEdgeMesh& mesh) {
  const absl::Span<const Index> fan = mesh.fan();
  if (stencil_.face_rule == FaceRule::kCentroid) {
    const absl::Span<const Index> slot = faces_.slot_of_row();
    return vertices_.Fill(context, mesh.fan_begin(),
                          [&](Index i) { return slot[mesh.face()[fan[i]]]; });
  }
  // The values of a face stand where its vertices' indices do.
  Buffer<Index> place(mesh.half_edge_count());
  LIMN_RETURN_IF_ERROR(faces_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    Index item = run.item;
    for (Index slot = run.begin; slot < run.end; ++slot) {
      const Index first = mesh.face_begin()[faces_.row_of_slot()[slot]];
      for (Index j = 0; j < run.length; ++j) place[first + j] = item++;
    }
  }));
  return vertices_.Fill(context, mesh.fan_begin(), [&](Index i) { return place[fan[i]]; });
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

absl::Status LimitOperator::FaceValues(const Context& context, absl::Span<const Vec3> points,
                                       absl::Span<Vec3> values) const {
  if (stencil_.face_rule == FaceRule::kDooSabinImage) {
    return faces_.ForEachRun(context, [&](const GatherPlan::Run& run) {
      const Index* item = faces_.items(run);
      Vec3* out = values.data() + run.item;
      for (Index slot = run.begin; slot < run.end; ++slot) {
        FaceImages(
            run.length, [&](std::size_t j) { return points[item[j]]; },
            [&](std::size_t j, const Vec3& image) { out[j] = image; });
        item += run.length;
        out += run.length;
      }
    });
  }
  return faces_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    const double scale = 1.0 / run.length;
    Vec3* const out = values.data();
    faces_.VisitSums(run, points.data(),
                     [=](Index slot, const Vec3& sum) { out[slot] = scale * sum; });
  });
}

absl::Status LimitOperator::SymmetricWeights(const Context& context,
                                             absl::Span<double> weights) const {
  return vertices_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    const LimitRow& row = stencil_.rows[run.kind];
    // What a vertex takes from a neighbour, and that from it, becomes equal: edges / valence and
    // faces / valence are in a fixed proportion in every row of a scheme.
    const double taken = row.edges != 0 ? row.edges : row.faces;
    const double weight = taken == 0 ? 1 : run.length / taken;
    std::fill(weights.begin() + run.begin, weights.begin() + run.end, weight);
  });
}

absl::Status LimitOperator::Diagonal(const Context& context, absl::Span<double> diagonal) const {
  // Of each face value, the part that the vertex's own point has in it.
  Buffer<double> own(face_value_count());
  LIMN_RETURN_IF_ERROR(faces_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    if (stencil_.face_rule == FaceRule::kCentroid) {
      for (Index slot = run.begin; slot < run.end; ++slot) own[slot] = 1.0 / run.length;
      return;
    }
    const auto first = own.begin() + run.item;
    std::fill(first, first + std::ptrdiff_t{run.end - run.begin} * run.length,
              OwnWeight(run.length));
  }));
  return vertices_.ForEachRun(context, [&](const GatherPlan::Run& run) {
    const LimitRow& row = stencil_.rows[run.kind];
    const Index* value = vertices_.items(run);
    for (Index slot = run.begin; slot < run.end; ++slot, value += run.length) {
      double sum = 0;
      if (run.kind == stencil_.weighted_row) {
        const Index item = run.item + (slot - run.begin) * run.length;
        for (Index j = 0; j < run.length; ++j) {
          sum -= edge_weights_[item + j] + face_weights_[item + j] * (1 - own[value[j]]);
        }
        diagonal[slot] = 1 + sum;
        continue;
      }
      for (Index j = 0; j < run.length; ++j) sum += own[value[j]];
      diagonal[slot] = row.vertex + row.faces * sum / run.length;
    }
  });
}

}  // namespace limn
