// SPDX-License-Identifier: MIT
#include "tests/benchmarks/comparison/agreement.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limn::comparison {
namespace {

using Coordinates = std::array<std::vector<double>, 4>;

Coordinates CoordinatesOf(const std::vector<Vec3>& points, bool in_order) {
  Coordinates coordinates;
  for (const Vec3& p : points) {
    const double skew = 0.48 * p.x + 0.6 * p.y - 0.64 * p.z;
    const double values[4] = {p.x, p.y, p.z, skew};
    for (std::size_t i = 0; i < 4; ++i) coordinates[i].push_back(values[i]);
  }
  if (in_order) return coordinates;
  for (std::vector<double>& values : coordinates) std::sort(values.begin(), values.end());
  return coordinates;
}

double Largest(const Coordinates& a, const Coordinates& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].size() != b[i].size()) return std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < a[i].size(); ++j) {
      const double difference = std::fabs(a[i][j] - b[i][j]);
      // Also for what is no number.
      if (!(difference <= largest)) largest = difference;
    }
  }
  return largest;
}

}  // namespace

Fingerprint::Fingerprint(const Answer& answer)
    : in_order_(answer.in_order),
      points_(CoordinatesOf(answer.points, answer.in_order)),
      normals_(CoordinatesOf(answer.normals, false)) {
  double square = 0;
  for (std::size_t i = 0; i < 3 && !answer.points.empty(); ++i) {
    const auto [low, high] = std::minmax_element(points_[i].begin(), points_[i].end());
    square += (*high - *low) * (*high - *low);
  }
  if (square > 0) diagonal_ = std::sqrt(square);
}

Difference Fingerprint::From(const Fingerprint& reference) const {
  if (in_order_ != reference.in_order_) return {std::numeric_limits<double>::infinity(), 0};
  return {Largest(points_, reference.points_) / reference.diagonal_,
          normals_[0].empty() ? 0 : Largest(normals_, reference.normals_)};
}

}  // namespace limn::comparison
