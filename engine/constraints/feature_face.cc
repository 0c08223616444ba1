// SPDX-License-Identifier: MIT
#include "engine/constraints/feature_face.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace limn {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// The square of the sine from which on the paper's rule holds unchanged.
constexpr double kOrdinarySine = 1.0 / 64;
// Points nearer to C than this part of their vertex' distance have no direction.
constexpr double kAtCentre = 1e-12;
// Steps of directions.
constexpr double kSteps = 1099511627776.0;

Vec3 CentreOf(absl::Span<const Vec3> point) {
  Vec3 sum = {0, 0, 0};
  for (std::size_t i = 1; i < point.size(); ++i) sum += point[i] - point[0];
  return point[0] + (1.0 / static_cast<double>(point.size())) * sum;
}

// W_i - V_i. to_next, to_previous: from V_i.
Vec3 Crossing(const Vec3& to_next, const Vec3& to_previous, const Vec3& to_centre, double before,
              double after) {
  const Vec3 middle = 0.5 * (before + after) * to_centre;
  if (before == after) return middle;
  const Vec3 u = NormalizedOrZero(to_next);
  const Vec3 w = NormalizedOrZero(to_previous);
  const Vec3 normal = Cross(u, w);
  // a and b without their common divisor, the square of the sine.
  const double a = Dot(Cross(to_centre, w), normal);
  const double b = Dot(Cross(u, to_centre), normal);
  const double factor = 0.5 * (after - before) / std::max(Dot(normal, normal), kOrdinarySine);
  return middle + factor * (b * w - a * u);
}

// Angles as seen along a unit normal.
struct Seen {
  Vec3 normal;

  // From a to b, in (-pi, pi].
  double Angle(const Vec3& a, const Vec3& b) const {
    return std::atan2(Dot(normal, Cross(a, b)), Along(a, b));
  }
  double Along(const Vec3& a, const Vec3& b) const {
    return Dot(a, b) - Dot(a, normal) * Dot(b, normal);
  }
  double Distance(const Vec3& a) const { return Norm(a - Dot(a, normal) * normal); }
};

std::int64_t Rounded(double angle) {
  return static_cast<std::int64_t>(std::llround(angle * (kSteps / kTurn)));
}

}  // namespace

void FeatureImages::Make(const FeatureFace& face, absl::Span<Vec3> images) {
  const std::size_t m = face.point.size();
  const Vec3 centre = CentreOf(face.point);
  bool differ = false;
  for (std::size_t i = 0; i < m; ++i) {
    const std::size_t previous = i == 0 ? m - 1 : i - 1;
    const std::size_t next = i + 1 == m ? 0 : i + 1;
    const Vec3& own = face.point[i];
    images[i] = own + Crossing(face.point[next] - own, face.point[previous] - own, centre - own,
                               face.edge[previous], face.edge[i]);
    differ = differ || face.edge[previous] != face.edge[i];
  }
  // Equal values shrink the face, which keeps every order.
  if (differ) Reorder(face.point, centre, images);
  for (std::size_t i = 0; i < m; ++i) {
    if (face.vertex[i] == 1) continue;
    images[i] = face.point[i] + face.vertex[i] * (images[i] - face.point[i]);
  }
}

void FeatureImages::Reorder(absl::Span<const Vec3> point, const Vec3& centre,
                            absl::Span<Vec3> crossings) {
  const std::size_t m = point.size();
  Vec3 area = {0, 0, 0};
  for (std::size_t i = 0; i < m; ++i) {
    area += Cross(point[i] - centre, point[i + 1 == m ? 0 : i + 1] - centre);
  }
  const Seen seen = {NormalizedOrZero(area)};
  if (seen.normal == Vec3{0, 0, 0}) return;
  // Nearly always all is well, which is cheaper to see: each step of the W is to the left, and each
  // W within a right angle of its V, so that steps of less than half a turn are those of the
  // sequence.
  std::size_t well = 0;
  while (well < m) {
    const Vec3 to = crossings[well] - centre;
    const Vec3 next = crossings[well + 1 == m ? 0 : well + 1] - centre;
    if (!(seen.Along(point[well] - centre, to) > 0)) break;
    if (!(Dot(seen.normal, Cross(to, next)) > 0)) break;
    ++well;
  }
  if (well == m) return;
  directions_.clear();
  double vertex_angle = 0;
  std::int64_t turns = 0;
  const auto one_turn = static_cast<std::int64_t>(kSteps);
  for (std::size_t i = 0; i < m; ++i) {
    const Vec3 from = point[i] - centre;
    const Vec3 to = crossings[i] - centre;
    const bool at_centre = seen.Distance(to) <= kAtCentre * seen.Distance(from);
    const std::int64_t angle = Rounded(vertex_angle + (at_centre ? 0 : seen.Angle(from, to)));
    const std::int64_t turn = angle < 0 ? -1 : angle / one_turn;
    turns += turn;
    directions_.push_back(
        {.angle = angle - turn * one_turn,
         .place = static_cast<std::int64_t>(i) - turn * static_cast<std::int64_t>(m),
         .corner = static_cast<std::uint32_t>(i)});
    const double step = seen.Angle(from, point[i + 1 == m ? 0 : i + 1] - centre);
    // Written so that NaN ends it too.
    if (!(step > 0 && step < std::numbers::pi)) return;
    vertex_angle += step;
  }
  if (!(vertex_angle < 1.5 * kTurn)) return;
  std::sort(directions_.begin(), directions_.end(), [](const Direction& a, const Direction& b) {
    return a.angle != b.angle ? a.angle < b.angle : a.place < b.place;
  });
  sorted_.assign(crossings.begin(), crossings.end());
  const auto size = static_cast<std::int64_t>(m);
  for (std::int64_t i = 0; i < size; ++i) {
    const std::int64_t from = ((i + turns) % size + size) % size;
    crossings[static_cast<std::size_t>(i)] =
        sorted_[directions_[static_cast<std::size_t>(from)].corner];
  }
}

}  // namespace limn
