// SPDX-License-Identifier: MIT
#include "engine/constraints/certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace limn {
namespace {

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

double AngleBetweenLines(const Vec3& a, const Vec3& b) {
  constexpr double kRightAngle = 1.5707963267948966;
  const Vec3 unit_a = NormalizedOrZero(a);
  const Vec3 unit_b = NormalizedOrZero(b);
  const double sine = Norm(Cross(unit_a, unit_b));
  const double cosine = std::fabs(Dot(unit_a, unit_b));
  // Unit vectors cannot have both zero; written so that NaN is a right angle too.
  if (!(sine > 0 || cosine > 0)) return kRightAngle;
  return std::atan2(sine, cosine);
}

CertificateBuilder::CertificateBuilder(Buffer<Vec3> targets, const Constraints& constraints)
    : targets_(std::move(targets)) {
  const bool all = constraints.interpolates_all();
  distances_.resize(targets_.size(), all ? kUnchecked : kIgnored);
  if (all) wanted_ = targets_.size();
  if (constraints.interpolate.has_value()) {
    wanted_ = constraints.interpolate->size();
    for (const Index v : *constraints.interpolate) distances_[v] = kUnchecked;
  }
  normals_.reserve(constraints.normals.size());
  for (const NormalConstraint& c : constraints.normals) {
    normals_.push_back(
        {.vertex = c.vertex, .direction = NormalizedOrZero(c.normal), .deviation = kUnchecked});
  }
  std::sort(normals_.begin(), normals_.end(),
            [](const Normal& a, const Normal& b) { return a.vertex < b.vertex; });
}

std::uint64_t CertificateBuilder::Bytes(std::uint64_t targets, std::uint64_t normals) {
  return targets * sizeof(double) + normals * sizeof(Normal);
}

void CertificateBuilder::Add(std::uint64_t vertex, const Vec3& position) {
  if (!counts(vertex)) return;
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

void CertificateBuilder::TellNormal(Normal* normal, const Vec3& found) {
  if (normal->deviation < 0) ++normals_checked_;
  normal->deviation = std::max(normal->deviation, AngleBetweenLines(normal->direction, found));
}

void CertificateBuilder::AddNormal(std::uint64_t vertex, const Vec3& normal) {
  AddNormalRun(vertex, {&normal, 1});
}

void CertificateBuilder::AddNormalRun(std::uint64_t first_vertex, absl::Span<const Vec3> normals) {
  auto at = std::lower_bound(
      normals_.begin(), normals_.end(), first_vertex,
      [](const Normal& normal, std::uint64_t vertex) { return normal.vertex < vertex; });
  for (; at != normals_.end() && at->vertex - first_vertex < normals.size(); ++at) {
    TellNormal(&*at, normals[at->vertex - first_vertex]);
  }
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
  FinishNormals(&certificate);
  return certificate;
}

void CertificateBuilder::FinishNormals(Certificate* certificate) const {
  certificate->normals_checked = normals_checked_;
  double largest = kUnchecked;
  for (const Normal& normal : normals_) {
    if (normal.deviation <= largest) continue;
    largest = normal.deviation;
    certificate->max_normal_deviation_vertex = normal.vertex;
  }
  certificate->max_normal_deviation = std::max(largest, 0.0);
}

}  // namespace limn
