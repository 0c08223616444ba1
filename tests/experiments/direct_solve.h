// SPDX-License-Identifier: MIT
// The interpolation equations as a matrix, and direct solvers for them: what Limn does not do, to
// compare with. Sources: Zheng and Cai 2005, Eq. 6 and section 3.5 (Gaussian elimination); Nasri
// 1987 (the same with the scheme's own rule, [ZC Eq. 1]).
#pragma once

#include <cstddef>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/stencil/limit_stencil.h"

namespace limn::experiments {

using SparseMatrix = Eigen::SparseMatrix<double>;
// One row per vertex.
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// M L: the operator of the stencil, row v times the valence of v, which makes it symmetric and
// positive definite. mesh: from HalfEdgeMesh::Build, closed. stencil: of Doo-Sabin with all
// vertices interpolated (DooSabinModifiedStencil, DooSabinStandardStencil). Cost: sum of squared
// arities.
SparseMatrix LimitMatrix(const HalfEdgeMesh& mesh, const LimitStencil& stencil);

// M I: the points to interpolate, times the valences.
Columns RightSide(const HalfEdgeMesh& mesh, absl::Span<const Vec3> points);

enum class DirectMethod {
  // Gaussian elimination with partial pivoting on the full matrix, as in [ZC section 3.5].
  kDense,
  // L D L' with an approximate minimum degree ordering.
  kSparseLdlt,
  // L U with partial pivoting and column ordering: does not use that the matrix is symmetric.
  kSparseLu,
};

std::string_view DirectMethodName(DirectMethod method);

struct DirectSolution {
  Columns x;
  // Numbers in the factors.
  std::size_t factor_size = 0;
};

// X with matrix * X = right, factorised anew. Throws std::runtime_error for a matrix that the
// method finds singular.
DirectSolution SolveDirectly(DirectMethod method, const SparseMatrix& matrix, const Columns& right);

// Largest distance between two solutions, in model units.
double LargestDistance(absl::Span<const Vec3> points, const Columns& x);

}  // namespace limn::experiments
