// SPDX-License-Identifier: MIT
#include "engine/solve/least_eigenvalue.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/mesh/generate.h"
#include "engine/stencil/limit_stencil.h"
#include "tests/oracle/dense.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/mesh.h"

namespace limn {
namespace {

using oracle::Matrix;
using oracle::Real;

// n (n + 5) times the row of each vertex of valence n, from the words of CatmullClarkStencil, and
// n (n + 5).
struct Dense {
  Matrix matrix;
  std::vector<Real> weight;
};

Dense DenseEquations(const oracle::Mesh& mesh) {
  const std::size_t vertices = mesh.points.size();
  Dense dense = {Matrix(vertices, std::vector<Real>(vertices, 0)), std::vector<Real>(vertices, 0)};
  std::vector<int> valence(vertices, 0);
  for (const oracle::Face& face : mesh.faces) {
    const std::size_t m = face.size();
    for (std::size_t i = 0; i < m; ++i) {
      const auto v = static_cast<std::size_t>(face[i]);
      ++valence[v];
      // Each edge is seen from both of its faces.
      dense.matrix[v][static_cast<std::size_t>(face[(i + 1) % m])] += 1;
      dense.matrix[v][static_cast<std::size_t>(face[(i + m - 1) % m])] += 1;
      for (const int u : face) {
        dense.matrix[v][static_cast<std::size_t>(u)] += 4 / static_cast<Real>(m);
      }
    }
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    const Real n = valence[v];
    dense.matrix[v][v] += n * (n - 1);
    dense.weight[v] = n * (n + 5);
  }
  return dense;
}

// Whether an eigenvalue is below `bound`, by Sylvester's law of inertia: the signs of the pivots of
// matrix - bound weight.
bool HasBelow(Dense dense, Real bound) {
  const std::size_t n = dense.weight.size();
  Matrix& a = dense.matrix;
  for (std::size_t v = 0; v < n; ++v) a[v][v] -= bound * dense.weight[v];
  for (std::size_t k = 0; k < n; ++k) {
    if (a[k][k] < 0) return true;
    for (std::size_t i = k + 1; i < n; ++i) {
      const Real factor = a[i][k] / a[k][k];
      if (factor == 0) continue;
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
    }
  }
  return false;
}

absl::StatusOr<bool> Probe(const PolygonMesh& mesh, double bound,
                           const Context& context = Context()) {
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  const auto stencil = CatmullClarkStencil(Context(), built);
  EXPECT_TRUE(stencil.ok());
  const auto limit = LimitOperator::Make(Context(), built, *stencil);
  EXPECT_TRUE(limit.ok());
  return HasEigenvalueBelow(context, *limit, bound);
}

class LeastEigenvalueTest : public oracle::ClosedMeshTest {};

TEST_P(LeastEigenvalueTest, WhatIsFoundIsThereAndWhatIsAHundredthBelowIsFound) {
  const Dense dense = DenseEquations(given_);
  for (const double bound : {1.0 / 32, 0.06, 0.1, 0.15, 0.2, 0.3}) {
    SCOPED_TRACE(bound);
    LIMN_ASSERT_OK_AND_ASSIGN(const bool found, Probe(mesh_, bound));
    EXPECT_TRUE(found || !HasBelow(dense, bound - 0.01));
    EXPECT_TRUE(!found || HasBelow(dense, bound + 1e-6));
  }
}

LIMN_FOR_CLOSED_MESHES(LeastEigenvalueTest);

TEST(LeastEigenvalue, IsFoundOnLargeMeshesOfValenceThreeOnly) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(absl::StrCat("seed: ", seed));
    LIMN_ASSERT_OK_AND_ASSIGN(
        const PolygonMesh mesh,
        GenerateMesh({.kind = MeshKind::kNgons, .vertices = 20000, .seed = seed}));
    LIMN_ASSERT_OK_AND_ASSIGN(const bool found, Probe(mesh, 1.0 / 32));
    EXPECT_TRUE(found);
  }
}

TEST(LeastEigenvalue, IsTheSameForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh, GenerateMesh({.vertices = 20000, .seed = 4}));
  for (const double bound : {0.03, 0.05, 0.055, 0.06, 0.1}) {
    const auto run = [&](int threads) {
      return oracle::WithThreads(threads, [&] { return *Probe(mesh, bound); });
    };
    EXPECT_EQ(run(1), run(4)) << bound;
  }
}

TEST(LeastEigenvalue, EndsWhenTheJobIsCancelled) {
  Context context;
  context.Cancel();
  oracle::ExpectError(Probe(oracle::Dodecahedron(), 0.03, context).status(), {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
