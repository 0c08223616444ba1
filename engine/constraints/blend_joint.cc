// SPDX-License-Identifier: MIT
#include "engine/constraints/blend_joint.h"

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cstddef>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "engine/base/error.h"
#include "engine/constraints/blend_region.h"
#include "engine/limit/evaluate.h"

namespace limn {
namespace {

// Corrections of what rounding and early ends leave of the first step.
constexpr int kSteps = 4;
// Of the largest singular value; below lie combinations of aims that nothing can move.
constexpr double kRank = 1e-10;
constexpr Eigen::Index kMostDense = 1 << 18;
constexpr int kMostIterations = 5000;
constexpr double kIterationTolerance = 1e-13;

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// The smallest z for which system z is nearest to a given right side.
class LeastSolver {
 public:
  explicit LeastSolver(SparseRows system) : system_(std::move(system)) {
    dense_ = system_.rows() * system_.cols() <= kMostDense;
    if (dense_) {
      decomposition_.setThreshold(kRank);
      decomposition_.compute(Eigen::MatrixXd(system_));
      return;
    }
    transposed_ = system_.transpose();
    // Aims that nothing moves have empty rows.
    scale_.resize(system_.rows());
    for (Eigen::Index i = 0; i < system_.rows(); ++i) {
      const double norm = system_.row(i).squaredNorm();
      scale_[i] = norm > 0 ? 1 / norm : 0;
    }
  }

  absl::StatusOr<Eigen::MatrixX3d> Solve(const Context& context,
                                         const Eigen::MatrixX3d& right) const {
    if (dense_) {
      LIMN_RETURN_IF_ERROR(context.Check());
      return Eigen::MatrixX3d(decomposition_.solve(right));
    }
    Eigen::MatrixX3d result(system_.cols(), 3);
    for (int i = 0; i < 3; ++i) {
      LIMN_ASSIGN_OR_RETURN(const Eigen::VectorXd multipliers, Iterate(context, right.col(i)));
      result.col(i) = transposed_ * multipliers;
    }
    return result;
  }

 private:
  // Conjugate gradients on system system' x = right, with its diagonal.
  absl::StatusOr<Eigen::VectorXd> Iterate(const Context& context,
                                          const Eigen::VectorXd& right) const {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(right.size());
    Eigen::VectorXd residual = right;
    Eigen::VectorXd direction = scale_.cwiseProduct(residual);
    double product = residual.dot(direction);
    const double end = kIterationTolerance * kIterationTolerance * product;
    for (int i = 0; i < kMostIterations && product > end; ++i) {
      LIMN_RETURN_IF_ERROR(context.Check());
      const Eigen::VectorXd image = system_ * (transposed_ * direction);
      const double curvature = direction.dot(image);
      if (!(curvature > 0)) break;
      const double step = product / curvature;
      x += step * direction;
      residual -= step * image;
      const Eigen::VectorXd scaled = scale_.cwiseProduct(residual);
      const double next = residual.dot(scaled);
      direction = scaled + next / product * direction;
      product = next;
    }
    return x;
  }

  const SparseRows system_;
  bool dense_ = false;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition_;
  SparseRows transposed_;
  Eigen::VectorXd scale_;
};

struct Samples {
  explicit Samples(std::size_t n) : point(n), du(n), dv(n) {}
  SurfaceSamples Spans() {
    return {.points = absl::MakeSpan(point), .du = absl::MakeSpan(du), .dv = absl::MakeSpan(dv)};
  }
  std::vector<Vec3> point;
  std::vector<Vec3> du;
  std::vector<Vec3> dv;
};

class Joint {
 public:
  Joint(const Context& context, const JointProblem& problem, PrimalSurface* surface)
      : context_(context), problem_(problem), surface_(*surface) {
    for (std::size_t i = 0; i < problem.vertices.size(); ++i) column_[problem.vertices[i]] = i;
    for (const JointAim& aim : problem.aims) {
      first_row_.push_back(rows_);
      rows_ += 1 + Eigen::Index{aim.has_du} + Eigen::Index{aim.has_dv};
      places_.push_back(aim.place);
    }
  }

  absl::Status Run() {
    LIMN_RETURN_IF_ERROR(FindResponses());
    LIMN_RETURN_IF_ERROR(context_.Check());
    const SparseRows spread = Spread();
    SparseRows responses(rows_, static_cast<Eigen::Index>(problem_.vertices.size()));
    responses.setFromTriplets(responses_.begin(), responses_.end());
    const LeastSolver solver(SparseRows(responses * spread));
    for (int step = 0; step < kSteps; ++step) {
      LIMN_ASSIGN_OR_RETURN(const Eigen::MatrixX3d missing, Missing());
      LIMN_ASSIGN_OR_RETURN(const Eigen::MatrixX3d solution, solver.Solve(context_, missing));
      const Eigen::MatrixX3d moves = spread * solution;
      for (std::size_t i = 0; i < problem_.vertices.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        surface_.points[problem_.vertices[i]] += Vec3{moves(row, 0), moves(row, 1), moves(row, 2)};
      }
    }
    return absl::OkStatus();
  }

 private:
  template <class Visit>
  void VisitRows(std::size_t aim, const Samples& samples, std::size_t sample,
                 const Visit& visit) const {
    Eigen::Index row = first_row_[aim];
    visit(row++, samples.point[sample], problem_.aims[aim].point);
    if (problem_.aims[aim].has_du) visit(row++, samples.du[sample], problem_.aims[aim].du);
    if (problem_.aims[aim].has_dv) visit(row++, samples.dv[sample], problem_.aims[aim].dv);
  }

  // What each control point adds to each aim: the surface of points that are zero but for one in
  // x, one in y and one in z is a combination of three columns.
  absl::Status FindResponses() {
    Buffer<Vec3> points(surface_.points.size());
    std::fill(points.begin(), points.end(), Vec3{0, 0, 0});
    std::swap(points, surface_.points);
    const absl::Status status = FindResponsesOfUnits();
    std::swap(points, surface_.points);
    return status;
  }

  absl::Status FindResponsesOfUnits() {
    LIMN_ASSIGN_OR_RETURN(const SurfaceEvaluator evaluator,
                          SurfaceEvaluator::Create(context_, surface_));
    Samples sample(1);
    for (std::size_t a = 0; a < problem_.aims.size(); ++a) {
      std::vector<Index> moving;
      for (const Index v : problem_.aims[a].support) {
        if (column_.contains(v)) moving.push_back(v);
      }
      for (std::size_t i = 0; i < moving.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, moving.size() - i);
        for (std::size_t j = 0; j < count; ++j) {
          surface_.points[moving[i + j]] = {j == 0 ? 1.0 : 0, j == 1 ? 1.0 : 0, j == 2 ? 1.0 : 0};
        }
        LIMN_RETURN_IF_ERROR(evaluator.Evaluate(context_, {&places_[a], 1}, sample.Spans()));
        VisitRows(a, sample, 0, [&](Eigen::Index row, const Vec3& value, const Vec3& /*aim*/) {
          const double parts[3] = {value.x, value.y, value.z};
          for (std::size_t j = 0; j < count; ++j) {
            responses_.emplace_back(row, static_cast<Eigen::Index>(column_[moving[i + j]]),
                                    parts[j]);
          }
        });
        for (std::size_t j = 0; j < count; ++j) surface_.points[moving[i + j]] = {0, 0, 0};
      }
    }
    return absl::OkStatus();
  }

  // Movements are averages of those of the vertices around, so that they are smooth, and fade with
  // the weights.
  SparseRows Spread() const {
    const auto n = static_cast<Eigen::Index>(problem_.vertices.size());
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < problem_.vertices.size(); ++i) {
      std::size_t around = 0;
      const auto count = [&around](Index /*w*/) { ++around; };
      VisitRing(surface_.mesh, problem_.vertices[i], count);
      const auto row = static_cast<Eigen::Index>(i);
      entries.emplace_back(row, row, 0.5 * problem_.weights[i]);
      const double share = 0.5 * problem_.weights[i] / static_cast<double>(around);
      VisitRing(surface_.mesh, problem_.vertices[i], [&](Index w) {
        const auto found = column_.find(w);
        if (found == column_.end()) return;
        entries.emplace_back(row, static_cast<Eigen::Index>(found->second), share);
      });
    }
    SparseRows spread(n, n);
    spread.setFromTriplets(entries.begin(), entries.end());
    return spread;
  }

  absl::StatusOr<Eigen::MatrixX3d> Missing() const {
    Samples now(places_.size());
    LIMN_RETURN_IF_ERROR(EvaluateSurface(context_, surface_, places_, now.Spans()));
    Eigen::MatrixX3d missing(rows_, 3);
    for (std::size_t a = 0; a < places_.size(); ++a) {
      VisitRows(a, now, a, [&](Eigen::Index row, const Vec3& value, const Vec3& aim) {
        const Vec3 way = aim - value;
        missing.row(row) << way.x, way.y, way.z;
      });
    }
    return missing;
  }

  const Context& context_;
  const JointProblem& problem_;
  PrimalSurface& surface_;
  // Of the vertices that may move.
  absl::flat_hash_map<Index, std::size_t> column_;
  std::vector<SurfaceParameter> places_;
  std::vector<Eigen::Index> first_row_;
  Eigen::Index rows_ = 0;
  std::vector<Eigen::Triplet<double>> responses_;
};

}  // namespace

absl::Status MeetJointly(const Context& context, const JointProblem& problem,
                         PrimalSurface* surface) {
  return Joint(context, problem, surface).Run();
}

}  // namespace limn
