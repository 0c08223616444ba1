// SPDX-License-Identifier: MIT
#include "engine/limit/ring_cones.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace limn {
namespace {

void Widen(const ProjectedCone& by, ProjectedCone* cone) {
  cone->angle = std::max(cone->angle, by.angle);
  cone->stretch = std::min(cone->stretch, by.stretch);
}

}  // namespace

NineVertices VerticesOf(const RefinedGrid& grid) {
  NineVertices vertex{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (i + j == 0) continue;
      vertex[j][i] = 0.25 * (grid[j][i] + grid[j][i + 1] + grid[j + 1][i] + grid[j + 1][i + 1]);
    }
  }
  return vertex;
}

void RingCones::ConePair::Add(const ConePair& other) {
  u.Add(other.u);
  v.Add(other.v);
}

RingCones::SectorCones RingCones::SectorCones::Widened(double in_plane, double off_plane) const {
  SectorCones wide = *this;
  for (auto* pairs : {&wide.quarter, &wide.quad}) {
    for (ConePair& pair : *pairs) {
      pair = {pair.u.Widened(in_plane, off_plane), pair.v.Widened(in_plane, off_plane)};
    }
  }
  return wide;
}

RoundFrame::RoundFrame(const Harmonics& harmonics, const Vec3& normal) : normal_(normal) {
  if (normal == Vec3{0, 0, 0}) return;
  const Vec3& t1 = harmonics.t1;
  const Vec3& t2 = harmonics.t2;
  axis_ = NormalizedOrZero(t1);
  side_ = Cross(normal, axis_);
  const double area = Dot(normal, Cross(t1, t2));
  const double size = std::sqrt(area);
  first_ = (size / area) * Cross(t2, normal);
  second_ = (size / area) * Cross(normal, t1);
  // The singular values of (t1, t2) are that factor of sqrt(area) and its reciprocal.
  const double mean = 0.5 * (Dot(t1, t1) + Dot(t2, t2)) / area;
  stretch_ = std::sqrt(mean + std::sqrt(std::max(0.0, mean * mean - 1)));
}

RingCones::RingCones(const RoundFrame& frame, const RingRefiner& first, const PatchRing& ring)
    : frame_(frame),
      first_(first),
      sectors_(ring.sectors > kMostSides || frame.normal() == Vec3{0, 0, 0} ? 0 : ring.sectors),
      mixed_(!ring.closed()) {}

void RingCones::AddGeneration(const RingRefiner& refiner) {
  ProductCone products(frame_.normal());
  for (std::size_t i = 0; i < sectors_; ++i) {
    AddProducts(refiner.grid(i), &products);
    if (mixed_) kept_.push_back(ConesOf(i, refiner.grid(i)));
  }
  cones_.push_back(products.Cone());
}

std::vector<ProjectedCone> RingCones::Finish(const Deviation& remainder) {
  if (sectors_ == 0) {
    cones_.assign(cones_.size(), ProjectedCone());
    return std::move(cones_);
  }
  ProjectedCone rest = Nothing();
  std::vector<SectorCones> beyond;
  for (std::size_t i = 0; i < sectors_; ++i) {
    // Directions are twice the differences of images, which are means of points; or differences of
    // means of these.
    beyond.push_back(ConesOf(i, first_.grid(i))
                         .Widened(4 * frame_.stretch() * remainder.slide, 4 * remainder.height));
    WidenByParts(beyond.back(), &rest);
  }
  for (std::size_t g = cones_.size(); g-- > 0;) {
    if (mixed_) Mix(g, &beyond);
    Widen(cones_[g], &rest);
    cones_[g] = rest;
  }
  return std::move(cones_);
}

void RingCones::AddProducts(const RefinedGrid& grid, ProductCone* products) {
  const NineVertices vertex = VerticesOf(grid);
  const std::array<Vec3, 2> u = {vertex[0][2] - vertex[0][0], vertex[2][2] - vertex[2][0]};
  const std::array<Vec3, 2> v = {vertex[2][0] - vertex[0][0], vertex[2][2] - vertex[0][2]};
  products->Add(u, v);
  for (std::size_t quarter = 1; quarter < 4; ++quarter) {
    const NetDerivatives derivatives = DerivativesOf(QuarterNet(grid, quarter / 2, quarter % 2), 2);
    products->Add(derivatives.u, derivatives.v);
  }
}

ProjectedCone RingCones::ConeOf(const ConePair& pair) const {
  return frame_.Back(limn::ConeOf(frame_.normal(), pair.u, pair.v));
}

ProjectedCone RingCones::Nothing() const {
  return {
      .normal = frame_.normal(), .angle = 0, .stretch = std::numeric_limits<double>::infinity()};
}

void RingCones::WidenByParts(const SectorCones& cones, ProjectedCone* cone) const {
  for (const ConePair& pair : cones.quarter) Widen(ConeOf(pair), cone);
  Widen(ConeOf(cones.quad[2]), cone);
}

// *beyond has the quarters of all later generations and gets those of this one; cones_[g] gets what
// follows for the quads of this one with them.
void RingCones::Mix(std::size_t g, std::vector<SectorCones>* beyond) {
  for (std::size_t i = 0; i < sectors_; ++i) {
    const SectorCones& here = kept_[g * sectors_ + i];
    for (std::size_t quarter = 0; quarter < 3; ++quarter) {
      ConePair& all = (*beyond)[i].quarter[quarter];
      all.Add(here.quarter[quarter]);
      ConePair mixed = all;
      mixed.Add(here.quad[quarter]);
      Widen(ConeOf(mixed), &cones_[g]);
    }
  }
}

RefinedGrid RingCones::Rounded(RefinedGrid grid) const {
  for (auto& row : grid) {
    for (Vec3& p : row) p = frame_.Round(p);
  }
  return grid;
}

// Derivatives by the ring's parameters, which are twice those by a quarter's own.
RingCones::SectorCones RingCones::ConesOf(std::size_t i, const RefinedGrid& refined) const {
  const RefinedGrid grid = Rounded(refined);
  const std::array<ConePair, 3> none = {NoneOf(i, 0, 1), NoneOf(i, 1, 0), NoneOf(i, 1, 1)};
  SectorCones cones = {none, none};
  const NineVertices vertex = VerticesOf(grid);
  for (std::size_t q = 0; q < 3; ++q) {
    const std::size_t number = q + 1;
    const NetDerivatives derivatives = DerivativesOf(QuarterNet(grid, number / 2, number % 2), 2);
    for (const Vec3& a : derivatives.u) cones.quarter[q].u.Add(a);
    for (const Vec3& a : derivatives.v) cones.quarter[q].v.Add(a);
    cones.quad[q].u.Add(vertex[0][2] - vertex[0][0]);
    cones.quad[q].u.Add(vertex[2][2] - vertex[2][0]);
    cones.quad[q].v.Add(vertex[2][0] - vertex[0][0]);
    cones.quad[q].v.Add(vertex[2][2] - vertex[0][2]);
  }
  return cones;
}

// Without directions; the axes are those of F.
RingCones::ConePair RingCones::NoneOf(std::size_t i, std::size_t row, std::size_t column) const {
  const BiquadraticJet middle =
      EvaluateBiquadratic(QuarterNet(Rounded(first_.grid(i)), row, column), 0.5, 0.5);
  const Vec3& normal = frame_.normal();
  return {{normal, NormalizedOrZero(middle.du)}, {normal, NormalizedOrZero(middle.dv)}};
}

}  // namespace limn
