// SPDX-License-Identifier: MIT
#include "engine/solve/regularity.h"

#include <cstdint>
#include <vector>

#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/solve/least_eigenvalue.h"
#include "engine/solve/solve.h"
#include "engine/stencil/limit_operator.h"

namespace limn {
namespace {

// Looks for components whose vertices all have a row that alternating signs vanish in.
class Bipartition {
 public:
  Bipartition(const Context& context, const SurfaceLevel& level, const VertexPlan& plan)
      : context_(context), level_(level), plan_(plan) {}

  absl::StatusOr<bool> FindSingular() {
    const HalfEdgeMesh& mesh = level_.mesh;
    side_.assign(mesh.vertex_count(), kUnseen);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      if (v % kDefaultGrain == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      if (IsIndefinite(v)) return true;
      if (side_[v] != kUnseen || !IsCandidate(v)) continue;
      LIMN_ASSIGN_OR_RETURN(const bool singular, Walk(static_cast<Index>(v)));
      if (singular) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint8_t kUnseen = 2;

  bool IsSmoothUnknown(std::size_t v) const {
    const HalfEdgeMesh& mesh = level_.mesh;
    if (!plan_.interpolated(v)) return false;
    if (mesh.IsBoundary(v)) return false;
    if (!level_.sharpness.creased()) return true;
    if (level_.sharpness.vertex[v] > 0) return false;
    for (Index i = mesh.fan_begin()[v]; i < mesh.fan_begin()[v + 1]; ++i) {
      if (level_.sharpness.edge[mesh.edge()[mesh.fan()[i]]] > 0) return false;
    }
    return true;
  }
  bool IsIndefinite(std::size_t v) const {
    return level_.mesh.valence(v) == 2 && IsSmoothUnknown(v);
  }
  bool IsCandidate(std::size_t v) const {
    return level_.mesh.valence(v) == 3 && IsSmoothUnknown(v);
  }

  // Colours the component of v with two sides, as long as it can be singular. A face of odd arity
  // is an odd cycle.
  absl::StatusOr<bool> Walk(Index v) {
    const HalfEdgeMesh& mesh = level_.mesh;
    const PolygonWalk walk(mesh);
    bool singular = true;
    std::vector<Index> open = {v};
    side_[v] = 0;
    for (std::size_t seen = 0; !open.empty(); ++seen) {
      if (seen % kDefaultGrain == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      const Index at = open.back();
      open.pop_back();
      for (Index i = mesh.fan_begin()[at]; i < mesh.fan_begin()[at + 1]; ++i) {
        const Index other = mesh.vertex()[walk.Next(mesh.fan()[i])];
        if (side_[other] == side_[at] || !IsCandidate(other)) singular = false;
        if (side_[other] != kUnseen) continue;
        side_[other] = 1 - side_[at];
        if (IsCandidate(other)) open.push_back(other);
      }
    }
    return singular;
  }

  const Context& context_;
  const SurfaceLevel& level_;
  const VertexPlan& plan_;
  Buffer<std::uint8_t> side_;
};

// Gershgorin: whether the disk of a sharp vertex's row is to the right of kLeastRegularEigenvalue.
bool OwnPointDominates(const HalfEdgeMesh& mesh, const WeightedRows& rows, std::size_t r) {
  const Index fan = mesh.fan_begin()[rows.vertex[r]];
  double own = 1;
  for (std::size_t i = rows.begin[r]; i < rows.begin[r + 1]; ++i) {
    const Index f = mesh.face()[mesh.fan()[fan + (i - rows.begin[r])]];
    const double arity = mesh.face_begin()[f + 1] - mesh.face_begin()[f];
    own -= rows.edge[i] + rows.face[i] * (1 - 1 / arity);
  }
  // No weight is negative, and they add up to 1.
  return own - (1 - own) >= kLeastRegularEigenvalue;
}

}  // namespace

absl::StatusOr<bool> CatmullClarkIsSingular(const Context& context, const SurfaceLevel& level,
                                            const VertexPlan& plan) {
  return Bipartition(context, level, plan).FindSingular();
}

absl::StatusOr<bool> IsNearlySingular(const Context& context, const InteriorEquations& equations) {
  if (equations.smooth.spectrum_low >= kLeastRegularEigenvalue) return false;
  const HalfEdgeMesh& mesh = equations.mesh;
  Buffer<std::uint8_t> known(mesh.vertex_count());
  LIMN_RETURN_IF_ERROR(ParallelFor(context, known.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      known[v] = mesh.IsBoundary(v) || !equations.plan.interpolated(v) ? 1 : 0;
    }
  }));
  const WeightedRows& sharp = equations.sharp;
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, sharp.vertex.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
          if (OwnPointDominates(mesh, sharp, r)) known[sharp.vertex[r]] = 1;
        }
      }));
  LimitStencil stencil = equations.smooth;
  LIMN_RETURN_IF_ERROR(FixVertices(context, known, &stencil));
  LIMN_ASSIGN_OR_RETURN(const LimitOperator limit, LimitOperator::Make(context, mesh, stencil));
  return HasEigenvalueBelow(context, limit, kLeastRegularEigenvalue);
}

}  // namespace limn
