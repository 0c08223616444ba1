// SPDX-License-Identifier: MIT
#include "tests/experiments/direct_solve.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>

#include "engine/refine/doo_sabin_rule.h"

namespace limn::experiments {
namespace {

// How much of the point d corners away a face of m corners hands to a vertex.
double FaceWeight(FaceRule rule, std::size_t d, std::size_t m) {
  if (rule == FaceRule::kCentroid) return 1 / static_cast<double>(m);
  return d == 0 ? OwnWeight(m) : OtherWeight(d, m);
}

template <class Solver>
void RequireSuccess(const Solver& solver) {
  if (solver.info() != Eigen::Success) throw std::runtime_error("the matrix is singular");
}

}  // namespace

SparseMatrix LimitMatrix(const HalfEdgeMesh& mesh, const LimitStencil& stencil) {
  using Entry = Eigen::Triplet<double, int>;
  std::vector<Entry> entries;
  entries.reserve(6 * mesh.half_edge_count());
  const auto vertex = [&](Index h) { return static_cast<int>(mesh.vertex()[h]); };
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double own = stencil.row(v).vertex * static_cast<double>(mesh.valence(v));
    entries.emplace_back(static_cast<int>(v), static_cast<int>(v), own);
  }
  // The mean over a vertex's faces, times their number.
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Index begin = mesh.face_begin()[f];
    const Index m = mesh.face_begin()[f + 1] - begin;
    for (Index i = 0; i < m; ++i) {
      const double faces = stencil.row(mesh.vertex()[begin + i]).faces;
      for (Index j = 0; j < m; ++j) {
        const double weight = FaceWeight(stencil.face_rule, (j + m - i) % m, m);
        entries.emplace_back(vertex(begin + i), vertex(begin + j), faces * weight);
      }
    }
  }
  const auto n = static_cast<int>(mesh.vertex_count());
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

Columns RightSide(const HalfEdgeMesh& mesh, absl::Span<const Vec3> points) {
  Columns right(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const auto valence = static_cast<double>(mesh.valence(v));
    const Vec3 scaled = valence * points[v];
    right.row(static_cast<Eigen::Index>(v)) << scaled.x, scaled.y, scaled.z;
  }
  return right;
}

std::string_view DirectMethodName(DirectMethod method) {
  switch (method) {
    case DirectMethod::kDense:
      return "dense Gaussian elimination";
    case DirectMethod::kSparseLdlt:
      return "sparse LDL'";
    case DirectMethod::kSparseLu:
      return "sparse LU";
  }
  return "";
}

DirectSolution SolveDirectly(DirectMethod method, const SparseMatrix& matrix,
                             const Columns& right) {
  DirectSolution solution;
  if (method == DirectMethod::kDense) {
    const Eigen::PartialPivLU<Eigen::MatrixXd> solver{Eigen::MatrixXd(matrix)};
    solution.x = solver.solve(right);
    solution.factor_size = static_cast<std::size_t>(matrix.rows() * matrix.cols());
  } else if (method == DirectMethod::kSparseLdlt) {
    const Eigen::SimplicialLDLT<SparseMatrix> solver(matrix);
    RequireSuccess(solver);
    solution.x = solver.solve(right);
    solution.factor_size = static_cast<std::size_t>(solver.matrixL().nestedExpression().nonZeros());
  } else {
    Eigen::SparseLU<SparseMatrix> solver(matrix);
    RequireSuccess(solver);
    solution.x = solver.solve(right);
    solution.factor_size = static_cast<std::size_t>(solver.nnzL() + solver.nnzU());
  }
  return solution;
}

double LargestDistance(absl::Span<const Vec3> points, const Columns& x) {
  double largest = 0;
  for (std::size_t v = 0; v < points.size(); ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    largest = std::max(largest, Norm(points[v] - Vec3{x(row, 0), x(row, 1), x(row, 2)}));
  }
  return largest;
}

}  // namespace limn::experiments
