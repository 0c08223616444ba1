// SPDX-License-Identifier: MIT
#include "engine/limit/certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace limn {
namespace {

constexpr double kUnchecked = -1;

// |a - b|, scaled so that squares neither under- nor overflow.
double Distance(const Vec3& a, const Vec3& b) {
  const Vec3 d = a - b;
  if (!IsFinite(d)) return std::numeric_limits<double>::infinity();
  const double scale = MaxAbs(d);
  if (scale == 0) return 0;
  return scale * Norm({d.x / scale, d.y / scale, d.z / scale});
}

double BoundingBoxDiagonal(absl::Span<const Vec3> points) {
  if (points.empty()) return 0;
  Vec3 low = points.front();
  Vec3 high = low;
  for (const Vec3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return Distance(high, low);
}

}  // namespace

CertificateBuilder::CertificateBuilder(Buffer<Vec3> targets) : targets_(std::move(targets)) {
  distances_.resize(targets_.size(), kUnchecked);
}

void CertificateBuilder::Add(std::uint64_t vertex, const Vec3& position) {
  if (vertex >= targets_.size()) return;
  double& distance = distances_[vertex];
  if (distance < 0) ++checked_;
  distance = std::max(distance, Distance(position, targets_[vertex]));
}

void CertificateBuilder::AddRun(std::uint64_t first_vertex, absl::Span<const Vec3> positions) {
  if (first_vertex >= targets_.size()) return;
  const std::uint64_t count =
      std::min<std::uint64_t>(positions.size(), targets_.size() - first_vertex);
  for (std::uint64_t i = 0; i < count; ++i) Add(first_vertex + i, positions[i]);
}

Certificate CertificateBuilder::Finish() const {
  Certificate certificate;
  certificate.points_checked = checked_;
  certificate.bounding_box_diagonal = BoundingBoxDiagonal(targets_);
  double sum = 0;
  double largest = kUnchecked;
  for (std::size_t v = 0; v < distances_.size(); ++v) {
    if (distances_[v] < 0) continue;
    sum += distances_[v];
    if (distances_[v] > largest) {
      largest = distances_[v];
      certificate.max_error_vertex = static_cast<Index>(v);
    }
  }
  certificate.max_error = std::max(largest, 0.0);
  if (checked_ > 0) certificate.mean_error = sum / static_cast<double>(checked_);
  return certificate;
}

}  // namespace limn
