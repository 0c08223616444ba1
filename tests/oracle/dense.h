// SPDX-License-Identifier: MIT
// Dense linear algebra of the simplest kind.
#pragma once

#include <vector>

#include "tests/oracle/mesh.h"

namespace limn::oracle {

using Matrix = std::vector<std::vector<Real>>;

// X with matrix * X = right, by Gaussian elimination with partial pivoting. The matrix must not be
// singular (std::runtime_error).
Points SolveDense(Matrix matrix, Points right);

// Eigenvalues of a symmetric matrix in increasing order, by Jacobi rotations.
std::vector<Real> SymmetricEigenvalues(Matrix matrix);

}  // namespace limn::oracle
