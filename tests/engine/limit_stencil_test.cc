// SPDX-License-Identifier: MIT
#include "engine/scheme/limit_stencil.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/oracle/dense.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/limits_of.h"

namespace limn {
namespace {

using oracle::Matrix;
using oracle::Real;

// The operator L of the engine, one column per unit vector.
Matrix DenseOperator(const HalfEdgeMesh& mesh, const LimitStencil& stencil) {
  const std::size_t n = mesh.vertex_count();
  Matrix matrix(n, std::vector<Real>(n, 0));
  for (std::size_t column = 0; column < n; ++column) {
    std::vector<Vec3> points(n, Vec3{0, 0, 0});
    points[column].x = 1;
    const std::vector<Vec3> limits = oracle::LimitsOf(mesh, stencil, points);
    for (std::size_t row = 0; row < n; ++row) matrix[row][column] = limits[row].x;
  }
  return matrix;
}

class LimitStencilTest : public oracle::ClosedMeshTest {};

TEST_P(LimitStencilTest, RowsArePositiveAndAddUpToOne) {
  const LimitStencil stencil = DooSabinModifiedStencil();
  for (const LimitRow& row : stencil.rows) {
    EXPECT_GE(row.vertex, 0);
    EXPECT_GE(row.edges, 0);
    EXPECT_GE(row.faces, 0);
    EXPECT_EQ(row.vertex + row.edges + row.faces, 1);
  }
  for (const auto& row : DenseOperator(oracle::BuildOrDie(mesh_), stencil)) {
    Real sum = 0;
    for (const Real weight : row) {
      EXPECT_GE(weight, 0);
      sum += weight;
    }
    EXPECT_NEAR(static_cast<double>(sum), 1, 1e-14);
  }
}

// Eq. 6 row by row: 2 m_v L.
TEST_P(LimitStencilTest, IsEquationSixOfThePaper) {
  const Matrix engine = DenseOperator(oracle::BuildOrDie(mesh_), DooSabinModifiedStencil());
  const Matrix paper = oracle::Equation6(given_);
  const std::vector<int> m = oracle::FacesAround(given_);
  for (std::size_t v = 0; v < engine.size(); ++v) {
    for (std::size_t u = 0; u < engine.size(); ++u) {
      ASSERT_NEAR(static_cast<double>(2 * m[v] * engine[v][u]), static_cast<double>(paper[v][u]),
                  1e-13 * m[v])
          << v << ", " << u;
    }
  }
}

// Eigenvalues of the operator. diag(m) L is symmetric, so L is similar to
// diag(sqrt m) L diag(1 / sqrt m).
std::vector<Real> SpectrumOf(Matrix matrix, const std::vector<int>& m) {
  for (std::size_t v = 0; v < m.size(); ++v) {
    for (std::size_t u = 0; u < m.size(); ++u) {
      matrix[v][u] *= std::sqrt(static_cast<Real>(m[v]) / m[u]);
    }
  }
  return oracle::SymmetricEigenvalues(matrix);
}

TEST_P(LimitStencilTest, SpectrumIsWithinTheProvenBounds) {
  EXPECT_EQ(DooSabinModifiedStencil().spectrum_low, 0.5);
  EXPECT_EQ(DooSabinStandardStencil().spectrum_low, 0.25);
  // Dense eigenvalues of large meshes take too long to be worth it.
  if (given_.points.size() > 110) return;
  const std::vector<int> m = oracle::FacesAround(given_);
  for (const LimitStencil& stencil : {DooSabinModifiedStencil(), DooSabinStandardStencil()}) {
    EXPECT_EQ(stencil.spectrum_high, 1);
    const std::vector<Real> values =
        SpectrumOf(DenseOperator(oracle::BuildOrDie(mesh_), stencil), m);
    EXPECT_GE(values.front(), stencil.spectrum_low - 1e-13);
    EXPECT_LE(values.back(), 1 + 1e-13);
    // The constant vector belongs to 1.
    EXPECT_NEAR(static_cast<double>(values.back()), 1, 1e-13);
  }
}

// Vertices that are not interpolated leave a principal submatrix and an identity.
TEST_P(LimitStencilTest, SubsetsKeepTheBoundsOfTheSpectrum) {
  if (given_.points.size() > 110) return;
  const std::vector<int> m = oracle::FacesAround(given_);
  std::vector<std::uint8_t> fixed(m.size(), 0);
  for (std::size_t v = 0; v < m.size(); v += 3) fixed[v] = 1;
  for (LimitStencil stencil : {DooSabinModifiedStencil(), DooSabinStandardStencil()}) {
    ASSERT_TRUE(FixVertices(context_, fixed, &stencil).ok());
    const Matrix all = DenseOperator(oracle::BuildOrDie(mesh_), stencil);
    Matrix part;
    std::vector<int> part_m;
    for (std::size_t v = 0; v < m.size(); ++v) {
      if (fixed[v] != 0) {
        for (std::size_t u = 0; u < m.size(); ++u) EXPECT_EQ(all[v][u], u == v ? 1 : 0);
        continue;
      }
      part_m.push_back(m[v]);
      part.emplace_back();
      for (std::size_t u = 0; u < m.size(); ++u) {
        if (fixed[u] == 0) part.back().push_back(all[v][u]);
      }
    }
    if (part.empty()) continue;
    const std::vector<Real> values = SpectrumOf(part, part_m);
    EXPECT_GE(values.front(), stencil.spectrum_low - 1e-13);
    EXPECT_LE(values.back(), 1 + 1e-13);
  }
}

LIMN_FOR_CLOSED_MESHES(LimitStencilTest);

}  // namespace
}  // namespace limn
