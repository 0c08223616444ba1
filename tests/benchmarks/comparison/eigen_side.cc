// SPDX-License-Identifier: MIT
// Solvers of the interpolation equations in the comparison: Eigen's, and CHOLMOD through Eigen. The
// matrix is the operator of Doo-Sabin's modified stencil, row v times the valence of v (see
// tests/experiments/direct_solve.h), gathered row by row, which is several times faster than from
// triplets.
#include <dlfcn.h>

#include <Eigen/CholmodSupport>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <algorithm>
#include <stdexcept>

#include "engine/mesh/half_edge_mesh.h"
#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {
namespace {

using ByColumns = Eigen::SparseMatrix<double>;
using ByRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// Which part of the symmetric matrix is stored.
enum class Part { kAll, kLower };

// Matrix: ByColumns or ByRows; the same numbers.
template <class Matrix>
Matrix Assemble(const HalfEdgeMesh& mesh, Part part) {
  const auto n = static_cast<int>(mesh.vertex_count());
  std::vector<int> begin(mesh.vertex_count() + 1, 0);
  std::vector<std::pair<int, double>> entries;
  entries.reserve(4 * mesh.half_edge_count());
  // Where the row has its entry of a column, if that is not before the row.
  std::vector<std::size_t> place(mesh.vertex_count(), 0);
  for (int v = 0; v < n; ++v) {
    const auto row = static_cast<std::size_t>(v);
    const std::size_t first = entries.size();
    const auto add = [&](int u, double weight) {
      std::size_t& at = place[static_cast<std::size_t>(u)];
      if (at > first) {
        entries[at - 1].second += weight;
        return;
      }
      entries.emplace_back(u, weight);
      at = entries.size();
    };
    add(v, 0.5 * static_cast<double>(mesh.valence(row)));
    for (Index i = mesh.fan_begin()[row]; i < mesh.fan_begin()[row + 1]; ++i) {
      const Index f = mesh.face()[mesh.fan()[i]];
      const Index end = mesh.face_begin()[f + 1];
      const double weight = 0.5 / (end - mesh.face_begin()[f]);
      for (Index h = mesh.face_begin()[f]; h < end; ++h) {
        const auto u = static_cast<int>(mesh.vertex()[h]);
        if (part == Part::kAll || u >= v) add(u, weight);
      }
    }
    std::sort(entries.begin() + static_cast<std::ptrdiff_t>(first), entries.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    begin[row + 1] = static_cast<int>(entries.size());
  }
  Matrix matrix(n, n);
  matrix.resizeNonZeros(static_cast<Eigen::Index>(entries.size()));
  std::copy(begin.begin(), begin.end(), matrix.outerIndexPtr());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    matrix.innerIndexPtr()[i] = entries[i].first;
    matrix.valuePtr()[i] = entries[i].second;
  }
  return matrix;
}

// Of Eigen (OpenMP) and of whatever BLAS there is, if it has a say in it.
void SetThreads(int threads) {
  Eigen::setNbThreads(threads);
  static void* const blas = dlopen("libblas.so.3", RTLD_LAZY | RTLD_NOLOAD);
  static auto* const set_threads =
      blas == nullptr ? nullptr
                      : reinterpret_cast<void (*)(int)>(dlsym(blas, "openblas_set_num_threads"));
  if (set_threads != nullptr) set_threads(threads);
}

enum class Method { kCholmod, kLdlt, kLu, kConjugateGradient, kBiCgStab };

class EigenSide : public Contestant {
 public:
  EigenSide(const PolygonMesh& given, Method method, double tolerance, int threads)
      : mesh_(HalfEdgeMesh::Build(Context(), given).value()),
        method_(method),
        tolerance_(tolerance),
        threads_(threads),
        points_(static_cast<Eigen::Index>(given.vertex_count()), 3) {
    for (std::size_t v = 0; v < given.vertex_count(); ++v) {
      const Vec3& p = given.positions[v];
      points_.row(static_cast<Eigen::Index>(v)) << p.x, p.y, p.z;
    }
  }
  void Prepare() override {
    SetThreads(threads_);
    x_ = Columns();
  }
  void Run() override {
    Columns right = points_;
    for (Eigen::Index v = 0; v < right.rows(); ++v) {
      right.row(v) *= static_cast<double>(mesh_.valence(static_cast<std::size_t>(v)));
    }
    switch (method_) {
      case Method::kCholmod:
        Direct(Eigen::CholmodDecomposition<ByColumns, Eigen::Lower>(), Part::kLower, right);
        break;
      case Method::kLdlt:
        Direct(Eigen::SimplicialLDLT<ByColumns, Eigen::Lower>(), Part::kLower, right);
        break;
      case Method::kLu:
        Direct(Eigen::SparseLU<ByColumns>(), Part::kAll, right);
        break;
      case Method::kConjugateGradient:
        Iterate<Eigen::ConjugateGradient<ByRows, Eigen::Lower | Eigen::Upper>>(right);
        break;
      case Method::kBiCgStab:
        Iterate<Eigen::BiCGSTAB<ByRows>>(right);
        break;
    }
  }
  Answer GetAnswer() override {
    Answer answer = {{}, {}, true};
    for (Eigen::Index v = 0; v < x_.rows(); ++v) {
      answer.points.push_back({x_(v, 0), x_(v, 1), x_(v, 2)});
    }
    return answer;
  }

 private:
  template <class Solver>
  void Direct(Solver&& solver, Part part, const Columns& right) {
    const auto matrix = Assemble<ByColumns>(mesh_, part);
    solver.compute(matrix);
    if (solver.info() != Eigen::Success) throw std::runtime_error("the matrix is singular");
    x_ = solver.solve(right);
  }
  // From the given points, as Limn does, with the diagonal as preconditioner.
  template <class Solver>
  void Iterate(const Columns& right) {
    const auto matrix = Assemble<ByRows>(mesh_, Part::kAll);
    Solver solver;
    solver.setTolerance(tolerance_);
    solver.compute(matrix);
    x_ = solver.solveWithGuess(right, points_);
    if (solver.info() != Eigen::Success) throw std::runtime_error("no convergence");
  }

  const HalfEdgeMesh mesh_;
  const Method method_;
  const double tolerance_;
  const int threads_;
  Columns points_;
  Columns x_;
};

}  // namespace

std::vector<Entry> EigenEntries(Task task) {
  if (task != Task::kSolve6 && task != Task::kSolve12) return {};
  const double tolerance = task == Task::kSolve6 ? 1e-6 : 1e-12;
  std::vector<Entry> entries;
  const auto add = [&](const char* name, Method method, bool direct, int threads) {
    // Iterations stop by the 2-norm of the residual, which says less of the largest error.
    entries.push_back({.name = name,
                       .rival = direct ? "direct" : "iterative",
                       .threads = threads,
                       .agreement = direct ? 1e-11 : 1e3 * tolerance,
                       .make = [=](const PolygonMesh& mesh) {
                         return std::make_unique<EigenSide>(mesh, method, tolerance, threads);
                       }});
  };
  add("CHOLMOD", Method::kCholmod, true, 1);
  add("CHOLMOD", Method::kCholmod, true, 2);
  add("Eigen SimplicialLDLT", Method::kLdlt, true, 1);
  add("Eigen SparseLU", Method::kLu, true, 1);
  add("Eigen ConjugateGradient", Method::kConjugateGradient, false, 1);
  add("Eigen ConjugateGradient", Method::kConjugateGradient, false, 2);
  add("Eigen BiCGSTAB", Method::kBiCgStab, false, 1);
  add("Eigen BiCGSTAB", Method::kBiCgStab, false, 2);
  return entries;
}

}  // namespace limn::comparison
