// SPDX-License-Identifier: MIT
#include "engine/stencil/limit_stencil.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/triangle_split.h"
#include "engine/refine/loop_refine.h"

namespace limn {
namespace {

// Gives every vertex the row of its valence, row_of_valence(n), and boundary vertices an identity.
template <class RowOfValence>
absl::Status SetRows(const Context& context, const HalfEdgeMesh& mesh,
                     const RowOfValence& row_of_valence, LimitStencil* stencil) {
  constexpr std::uint16_t kNone = ~std::uint16_t{0};
  // Distinct valences are few: their sum is at most the number of corners. Boundary vertices count
  // as valence 0.
  Buffer<std::uint16_t> row;
  const auto valence = [&](std::size_t v) { return mesh.IsBoundary(v) ? 0 : mesh.valence(v); };
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (v % kScanBlock == 0) LIMN_RETURN_IF_ERROR(context.Check());
    const std::size_t n = valence(v);
    if (n >= row.size()) row.resize(n + 1, kNone);
    if (row[n] != kNone) continue;
    row[n] = static_cast<std::uint16_t>(stencil->rows.size());
    stencil->rows.push_back(n == 0 ? LimitRow{} : row_of_valence(n));
  }
  stencil->row_of.resize(mesh.vertex_count());
  std::uint16_t* const row_of = stencil->row_of.data();
  return ParallelFor(context, mesh.vertex_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) row_of[v] = row[valence(v)];
  });
}

// Sets spectrum_low to the least low(f) over all faces, and at most 1.
template <class Low>
absl::Status SetLow(const Context& context, const HalfEdgeMesh& mesh, const Low& low,
                    LimitStencil* stencil) {
  double most = 0;
  LIMN_RETURN_IF_ERROR(ParallelMax(
      context, mesh.face_count(), -1,
      [&](std::size_t begin, std::size_t end) {
        double least = 1;
        for (std::size_t f = begin; f < end; ++f) least = std::min(least, low(f));
        return -least;
      },
      &most));
  stencil->spectrum_low = -most;
  return absl::OkStatus();
}

// The least eigenvalue of a triangle, given the weights b of its corners inside the mesh.
double LoopTriangleLow(const double* b, std::size_t corners) {
  if (corners < 2) return corners == 0 ? 1 : b[0];
  if (corners == 2) {
    const double apart = b[0] - b[1];
    return (b[0] + b[1] - std::sqrt(apart * apart + (1 - b[0]) * (1 - b[1]))) / 2;
  }
  const double s[3] = {(3 * b[0] - 1) / 2, (3 * b[1] - 1) / 2, (3 * b[2] - 1) / 2};
  const double d[3] = {s[0] - s[1], s[1] - s[2], s[2] - s[0]};
  return (s[0] + s[1] + s[2]) / 3 - std::sqrt((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / 18);
}

}  // namespace

bool LimitStencil::uses_edges() const {
  return !weighted.empty() ||
         std::any_of(rows.begin(), rows.end(), [](const LimitRow& r) { return r.edges != 0; });
}

LimitStencil DooSabinModifiedStencil() {
  LimitStencil stencil;
  stencil.rows = {{.vertex = 0.5, .edges = 0, .faces = 0.5}};
  stencil.spectrum_low = 0.5;
  stencil.spectrum_high = 1;
  return stencil;
}

LimitStencil DooSabinStandardStencil() {
  LimitStencil stencil;
  stencil.rows = {{.vertex = 0, .edges = 0, .faces = 1}};
  stencil.face_rule = FaceRule::kDooSabinImage;
  stencil.spectrum_low = 0.25;
  stencil.spectrum_high = 1;
  return stencil;
}

absl::StatusOr<LimitStencil> CatmullClarkStencil(const Context& context, const HalfEdgeMesh& mesh,
                                                 double bilinear) {
  LimitStencil stencil;
  LIMN_RETURN_IF_ERROR(SetRows(
      context, mesh,
      [&](std::size_t valence) {
        const double n = static_cast<double>(valence);
        return LimitRow{.vertex = (n - 1 + 3 * bilinear) / (n + 5),
                        .edges = 2 / (n + 5),
                        .faces = (4 - 3 * bilinear) / (n + 5)};
      },
      &stencil));
  LIMN_RETURN_IF_ERROR(SetLow(
      context, mesh,
      [&](std::size_t f) {
        const Index first = mesh.face_begin()[f];
        const Index last = mesh.face_begin()[f + 1];
        const double m = last - first;
        const double cycle = (last - first) % 2 == 0 ? 2 : 2 * std::cos(std::numbers::pi / m);
        double least = 1;
        for (Index h = first; h < last; ++h) {
          const Index v = mesh.vertex()[h];
          if (mesh.IsBoundary(v)) continue;
          const double n = static_cast<double>(mesh.valence(v));
          least = std::min(least, (n - 1 + 3 * bilinear - cycle) / (n + 5));
        }
        return least;
      },
      &stencil));
  return stencil;
}

absl::StatusOr<LimitStencil> LoopStencil(const Context& context, const HalfEdgeMesh& mesh) {
  LIMN_RETURN_IF_ERROR(RequireTriangles(mesh));
  LimitStencil stencil;
  LIMN_RETURN_IF_ERROR(SetRows(
      context, mesh,
      [](std::size_t n) {
        const double own = 3 / (3 + 8 * LoopNeighbourWeight(n));
        return LimitRow{.vertex = own, .edges = 1 - own, .faces = 0};
      },
      &stencil));
  LIMN_RETURN_IF_ERROR(SetLow(
      context, mesh,
      [&](std::size_t f) {
        double own[3];
        std::size_t corners = 0;
        for (std::size_t h = 3 * f; h < 3 * f + 3; ++h) {
          const Index v = mesh.vertex()[h];
          if (!mesh.IsBoundary(v)) own[corners++] = stencil.row(v).vertex;
        }
        return LoopTriangleLow(own, corners);
      },
      &stencil));
  return stencil;
}

absl::Status SetWeightedRows(const Context& context, std::size_t vertex_count, WeightedRows rows,
                             LimitStencil* stencil) {
  if (rows.empty()) return absl::OkStatus();
  stencil->weighted_row = static_cast<std::uint16_t>(stencil->rows.size());
  stencil->rows.emplace_back();
  if (stencil->row_of.empty()) stencil->row_of.resize(vertex_count, 0);
  stencil->spectrum_low = 0;
  stencil->weighted = std::move(rows);
  for (std::size_t r = 0; r < stencil->weighted.vertex.size(); ++r) {
    if (r % kScanBlock == 0) LIMN_RETURN_IF_ERROR(context.Check());
    stencil->row_of[stencil->weighted.vertex[r]] = stencil->weighted_row;
  }
  return absl::OkStatus();
}

absl::Status FixVertices(const Context& context, absl::Span<const std::uint8_t> fixed,
                         LimitStencil* stencil) {
  const auto identity = static_cast<std::uint16_t>(stencil->rows.size());
  stencil->rows.push_back({.vertex = 1, .edges = 0, .faces = 0});
  const bool same_row = stencil->row_of.empty();
  stencil->row_of.resize(fixed.size());
  std::uint16_t* const row = stencil->row_of.data();
  return ParallelFor(context, fixed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (same_row) row[v] = 0;
      if (fixed[v] != 0) row[v] = identity;
    }
  });
}

}  // namespace limn
