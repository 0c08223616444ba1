// SPDX-License-Identifier: MIT
// The tridiagonal matrix that conjugate gradients reduce an operator to, and what it tells of the
// spectrum. Source: Golub and van Loan, Matrix Computations, section 10.1 (the Lanczos process
// behind conjugate gradients) and 8.5 (Sturm sequences).
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace limn {

class LanczosMatrix {
 public:
  void Clear() {
    diagonal_.clear();
    off_diagonal_.clear();
  }
  // alpha, beta: length of step k, and the share of its direction in the next one.
  void AddStep(double alpha, double beta) {
    diagonal_.push_back(1 / alpha + carry_ * (diagonal_.empty() ? 0 : 1));
    carry_ = beta / alpha;
    off_diagonal_.push_back(std::sqrt(beta) / alpha);
  }

  // How many of its eigenvalues, the Ritz values, are below x. The least one is never below the
  // operator's but for rounding. Cost: linear in the steps.
  std::size_t CountBelow(double x) const {
    std::size_t count = 0;
    double pivot = 1;
    for (std::size_t i = 0; i < diagonal_.size(); ++i) {
      const double side = i == 0 ? 0 : off_diagonal_[i - 1] * off_diagonal_[i - 1];
      pivot = diagonal_[i] - x - side / pivot;
      if (pivot == 0) pivot = -1e-300;
      if (pivot < 0) ++count;
    }
    return count;
  }

  // The least Ritz value, at most 1, to 1e-6.
  double Least() const {
    double low = 0;
    double high = 1;
    if (CountBelow(high) == 0) return 1;
    while (high - low > 1e-6) {
      const double middle = (low + high) / 2;
      (CountBelow(middle) > 0 ? high : low) = middle;
    }
    return high;
  }

 private:
  std::vector<double> diagonal_;
  std::vector<double> off_diagonal_;
  double carry_ = 0;
};

}  // namespace limn
