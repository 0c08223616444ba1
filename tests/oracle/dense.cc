// SPDX-License-Identifier: MIT
#include "tests/oracle/dense.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace limn::oracle {

Points SolveDense(Matrix matrix, Points right) {
  const std::size_t n = matrix.size();
  for (std::size_t column = 0; column < n; ++column) {
    std::size_t pivot = column;
    for (std::size_t row = column + 1; row < n; ++row) {
      if (std::abs(matrix[row][column]) > std::abs(matrix[pivot][column])) pivot = row;
    }
    if (matrix[pivot][column] == 0) throw std::runtime_error("singular matrix");
    std::swap(matrix[pivot], matrix[column]);
    std::swap(right[pivot], right[column]);
    for (std::size_t row = column + 1; row < n; ++row) {
      const Real factor = matrix[row][column] / matrix[column][column];
      if (factor == 0) continue;
      for (std::size_t k = column; k < n; ++k) matrix[row][k] -= factor * matrix[column][k];
      right[row] = right[row] - factor * right[column];
    }
  }
  for (std::size_t row = n; row-- > 0;) {
    for (std::size_t k = row + 1; k < n; ++k) right[row] = right[row] - matrix[row][k] * right[k];
    right[row] = (1 / matrix[row][row]) * right[row];
  }
  return right;
}

namespace {

// The rotation that makes matrix[p][q] zero.
void Rotate(Matrix* matrix, std::size_t p, std::size_t q) {
  Matrix& a = *matrix;
  if (a[p][q] == 0) return;
  const Real theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const Real t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
  const Real c = 1 / std::sqrt(t * t + 1);
  const Real s = t * c;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Real kp = a[k][p];
    const Real kq = a[k][q];
    a[k][p] = c * kp - s * kq;
    a[k][q] = s * kp + c * kq;
  }
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Real pk = a[p][k];
    const Real qk = a[q][k];
    a[p][k] = c * pk - s * qk;
    a[q][k] = s * pk + c * qk;
  }
}

}  // namespace

std::vector<Real> SymmetricEigenvalues(Matrix matrix) {
  const std::size_t n = matrix.size();
  for (int sweep = 0; sweep < 100; ++sweep) {
    Real off = 0;
    Real all = 0;
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t q = 0; q < n; ++q) {
        all += matrix[p][q] * matrix[p][q];
        if (p != q) off += matrix[p][q] * matrix[p][q];
      }
    }
    if (off <= 1e-32L * all) break;
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t q = p + 1; q < n; ++q) Rotate(&matrix, p, q);
    }
  }
  std::vector<Real> values;
  for (std::size_t i = 0; i < n; ++i) values.push_back(matrix[i][i]);
  std::sort(values.begin(), values.end());
  return values;
}

}  // namespace limn::oracle
