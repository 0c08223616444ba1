// SPDX-License-Identifier: MIT
#include "engine/stencil/limit_stencil.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "engine/limit/vertex_limit.h"
#include "tests/oracle/creased_level.h"
#include "tests/oracle/dense.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/limits_of.h"

namespace limn {
namespace {

using oracle::Matrix;
using oracle::Real;
using oracle::Rule;

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

// A stencil and the factors that make its operator symmetric: row v times factor[v].
struct Symmetric {
  LimitStencil stencil;
  std::vector<Real> factors;
};
Symmetric SymmetricFor(Rule rule, const HalfEdgeMesh& mesh, double bilinear) {
  Symmetric result;
  auto made = rule == Rule::kLoop ? LoopStencil(Context(), mesh)
                                  : CatmullClarkStencil(Context(), mesh, bilinear);
  EXPECT_TRUE(made.ok()) << made.status();
  result.stencil = *std::move(made);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Real n = static_cast<Real>(mesh.valence(v));
    result.factors.push_back(rule == Rule::kLoop ? n / (1 - result.stencil.row(v).vertex)
                                                 : n * (n + 5));
  }
  return result;
}

// Eigenvalues of the part of the operator that belongs to these vertices.
std::vector<Real> SpectrumOfPart(const Matrix& matrix, const std::vector<Real>& factors,
                                 const std::vector<std::size_t>& vertices) {
  Matrix part;
  for (const std::size_t v : vertices) {
    part.emplace_back();
    for (const std::size_t u : vertices) {
      part.back().push_back(matrix[v][u] * std::sqrt(factors[v] / factors[u]));
    }
  }
  return oracle::SymmetricEigenvalues(part);
}

constexpr double kShares[] = {0, 0.5, 1};

class SchemeStencilTest : public testing::TestWithParam<std::tuple<Rule, std::string>> {
 protected:
  SchemeStencilTest()
      : given_(oracle::MeshFor(rule(), std::get<1>(GetParam()))),
        mesh_(oracle::BuildOrDie(given_)) {
    for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
      if (mesh_.twin()[mesh_.vertex_half_edge()[v]] != kNoIndex) interior_.push_back(v);
    }
  }
  static Rule rule() { return std::get<0>(GetParam()); }

  const PolygonMesh given_;
  const HalfEdgeMesh mesh_;
  std::vector<std::size_t> interior_;
};

TEST_P(SchemeStencilTest, RowsAreTheLimitsOfTheScheme) {
  for (const double bilinear : kShares) {
    if (rule() == Rule::kLoop && bilinear != 0) continue;
    const Symmetric made = SymmetricFor(rule(), mesh_, bilinear);
    oracle::CreasedLevel level(given_, rule(), {});
    level.Refine(bilinear);
    std::vector<Vec3> limits(mesh_.vertex_count());
    const VertexLimits output = {absl::MakeSpan(limits), {}, {}};
    ASSERT_TRUE((rule() == Rule::kLoop
                     ? LoopLimits(Context(), level.level(), level.points, output)
                     : CatmullClarkLimits(Context(), level.level(), level.points, output))
                    .ok());
    const std::vector<Vec3> points(given_.positions.begin(), given_.positions.end());
    const std::vector<Vec3> rows = oracle::LimitsOf(mesh_, made.stencil, points);
    std::vector<Vec3> expected = points;
    for (const std::size_t v : interior_) expected[v] = limits[v];
    for (std::size_t v = 0; v < points.size(); ++v) {
      ASSERT_LE(MaxAbs(rows[v] - expected[v]), 1e-14) << v;
    }
    for (const LimitRow& row : made.stencil.rows) {
      EXPECT_GE(row.vertex, 0);
      EXPECT_GE(row.edges, 0);
      EXPECT_GE(row.faces, 0);
      EXPECT_NEAR(row.vertex + row.edges + row.faces, 1, 1e-15);
    }
  }
}

TEST_P(SchemeStencilTest, SpectrumIsWithinTheProvenBounds) {
  if (interior_.empty() || interior_.size() > 110) return;
  for (const double bilinear : kShares) {
    if (rule() == Rule::kLoop && bilinear != 0) continue;
    const Symmetric made = SymmetricFor(rule(), mesh_, bilinear);
    EXPECT_EQ(made.stencil.spectrum_high, 1);
    const Matrix matrix = DenseOperator(mesh_, made.stencil);
    std::vector<std::size_t> third;
    for (std::size_t i = 0; i < interior_.size(); i += 3) third.push_back(interior_[i]);
    for (const auto& vertices : {interior_, third}) {
      const std::vector<Real> values = SpectrumOfPart(matrix, made.factors, vertices);
      EXPECT_GE(values.front(), made.stencil.spectrum_low - 1e-13);
      EXPECT_LE(values.back(), 1 + 1e-13);
    }
  }
}

std::string SchemeAndMesh(const testing::TestParamInfo<std::tuple<Rule, std::string>>& info) {
  return (std::get<0>(info.param) == Rule::kLoop ? "Loop_" : "CatmullClark_") +
         std::get<1>(info.param);
}
INSTANTIATE_TEST_SUITE_P(All, SchemeStencilTest,
                         testing::Combine(testing::Values(Rule::kCatmullClark, Rule::kLoop),
                                          testing::ValuesIn(oracle::AllMeshNames())),
                         SchemeAndMesh);

double CatmullClarkLow(const PolygonMesh& mesh, double bilinear) {
  return SymmetricFor(Rule::kCatmullClark, oracle::BuildOrDie(mesh), bilinear).stencil.spectrum_low;
}

TEST(LimitStencil, CatmullClarkBoundsAreThoseOfTheHeader) {
  // Valence 3 and 2 with even faces: nothing is proved, rightly.
  EXPECT_EQ(CatmullClarkLow(oracle::Cube(), 0), 0);
  EXPECT_EQ(CatmullClarkLow(oracle::Prism(6), 0), 0);
  EXPECT_LT(CatmullClarkLow(oracle::Pillow(4), 0), 0);
  EXPECT_EQ(CatmullClarkLow(oracle::Cube(), 0.5), 3.0 / 16);
  EXPECT_EQ(CatmullClarkLow(oracle::Cube(), 1), 3.0 / 8);
  EXPECT_NEAR(CatmullClarkLow(oracle::Pillow(4), 0.5), 1.0 / 14, 1e-15);
  EXPECT_NEAR(CatmullClarkLow(oracle::Pillow(4), 1), 2.0 / 7, 1e-15);
  EXPECT_NEAR(CatmullClarkLow(oracle::TorusOfQuads(5, 4), 0), 1.0 / 9, 1e-15);
  // Odd faces help.
  EXPECT_NEAR(CatmullClarkLow(oracle::Tetrahedron(), 0), 1.0 / 8, 1e-15);
  // Boundary vertices do not count.
  EXPECT_EQ(CatmullClarkLow(oracle::SinglePolygon(5), 0), 1);
}

// Where every vertex is interpolated, some bounds are eigenvalues.
TEST(LimitStencil, SomeCatmullClarkBoundsAreMet) {
  for (const PolygonMesh& given : {oracle::Cube(), oracle::Prism(6), oracle::Pillow(4)}) {
    const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
    std::vector<std::size_t> all;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) all.push_back(v);
    for (const double bilinear : kShares) {
      const Symmetric made = SymmetricFor(Rule::kCatmullClark, mesh, bilinear);
      const Real least =
          SpectrumOfPart(DenseOperator(mesh, made.stencil), made.factors, all).front();
      EXPECT_NEAR(static_cast<double>(least), made.stencil.spectrum_low, 1e-13);
    }
  }
}

TEST(LimitStencil, LoopBoundsAreThoseOfTheHeader) {
  const auto low = [](const PolygonMesh& mesh) {
    return SymmetricFor(Rule::kLoop, oracle::BuildOrDie(mesh), 0).stencil.spectrum_low;
  };
  // One valence: (3 b - 1) / 2. b is 2/5 for valence 3, 24/55 for 4, 1/2 for 6.
  EXPECT_NEAR(low(oracle::Tetrahedron()), 0.1, 1e-15);
  EXPECT_NEAR(low(oracle::Octahedron()), (3 * 24.0 / 55 - 1) / 2, 1e-15);
  EXPECT_NEAR(low(oracle::TorusOfTriangles(5, 4)), 0.25, 1e-15);
  // The least valence has the least bound.
  EXPECT_NEAR(low(oracle::Pillow(3)), 1.0 / 14, 1e-15);
  // Triangles with corners of both kinds do better than their worst corner alone.
  EXPECT_GT(low(oracle::Triangulated(oracle::Cube())), (3 * 24.0 / 55 - 1) / 2);
  // One interior vertex, of valence 3: its own weight.
  EXPECT_NEAR(low(oracle::TriangleFan(3)), 0.4, 1e-15);
}

TEST(LimitStencil, LoopRefusesOtherFaces) {
  oracle::ExpectError(LoopStencil(Context(), oracle::BuildOrDie(oracle::Cube())).status(),
                      {Reason::kInvalidOption, "mesh.faces", 0});
}

TEST(LimitStencil, SchemesEndWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Octahedron());
  oracle::ExpectError(CatmullClarkStencil(cancelled, mesh).status(), {Reason::kCancelled});
  oracle::ExpectError(LoopStencil(cancelled, mesh).status(), {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
