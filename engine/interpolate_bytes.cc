// SPDX-License-Identifier: MIT
// The arrays that Interpolate holds at a time, stage by stage.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/constraints/blend.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/filter.h"
#include "engine/interpolate.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {
namespace {

// More than can be told.
constexpr double kMost = 1.8e19;

// Counts and bytes are doubles: they cannot overflow, and their last bits do not matter.
double Bytes(double count, double size) { return BufferBytes(count * size); }
double Points(double count) { return Bytes(count, sizeof(Vec3)); }
double Indices(double count) { return Bytes(count, sizeof(Index)); }

// Vertices, edges, faces, half-edges and boundary edges of T^k.
struct Counts {
  double vertices;
  double edges;
  double faces;
  double half_edges;
  double boundary;

  Counts Split() const {
    return {vertices + edges + faces, 2 * edges + half_edges, half_edges, 4 * half_edges,
            2 * boundary};
  }
  // Every triangle into four.
  Counts SplitTriangles() const {
    return {vertices + edges, 2 * edges + half_edges, 4 * faces, 4 * half_edges, 2 * boundary};
  }
};

Counts MakeCounts(std::uint64_t vertices, std::uint64_t faces, std::uint64_t corners,
                  std::uint64_t boundary_edges) {
  return {.vertices = static_cast<double>(vertices),
          .edges = (static_cast<double>(corners) + static_cast<double>(boundary_edges)) / 2,
          .faces = static_cast<double>(faces),
          .half_edges = static_cast<double>(corners),
          .boundary = static_cast<double>(boundary_edges)};
}

std::uint64_t Saturated(double bytes) {
  return bytes >= kMost ? std::numeric_limits<std::uint64_t>::max()
                        : static_cast<std::uint64_t>(bytes);
}

// A mesh from HalfEdgeMesh::Build: vertex, face, twin, edge, fan and room for as many edges; first
// half-edges and fans of vertices; first corners of faces.
double BuiltMesh(const Counts& n) {
  return 6 * Indices(n.half_edges) + 2 * Indices(n.vertices + 1) + Indices(n.faces + 1);
}

// A mesh from SplitIntoQuads: vertex, twin, edge; two indices more.
double SplitMesh(const Counts& n) {
  return 3 * Indices(n.half_edges) + Indices(n.edges) + Indices(n.vertices);
}

// The buckets, before the last arrays of the mesh.
double BuildPeak(const Counts& n) {
  const double without_edges_and_fan = BuiltMesh(n) - 3 * Indices(n.half_edges);
  return std::max(BuiltMesh(n), without_edges_and_fan + Bytes(n.half_edges, 2 * sizeof(Index)) +
                                    2 * Indices(n.vertices + 1));
}

// A BoundaryCurve.
double Curve(const Counts& n) {
  return 3 * Indices(n.boundary) + 3 * Points(n.boundary) + Bytes(n.boundary, 1);
}

// The level that is asked for, or the finest that may be chosen.
std::uint32_t LevelOf(const InterpolateOptions& options) {
  return options.chord_tolerance.has_value() ? options.finest : options.level;
}

bool IsCreased(const Constraints& constraints) {
  return !constraints.creases.empty() || !constraints.corners.empty();
}

// What is sharp in the lists of OpenSubdiv and USD, as they are held while a Sharpness is made.
double SharpListBytes(const Constraints& constraints) {
  double vertices = 0;
  for (const CreaseConstraint& crease : constraints.creases) {
    vertices += static_cast<double>(crease.vertices.size());
  }
  return Bytes(vertices, sizeof(Index) + sizeof(float)) +
         Indices(static_cast<double>(constraints.creases.size())) +
         Bytes(static_cast<double>(constraints.corners.size()), sizeof(Index) + sizeof(float));
}

// A Sharpness, with holes.
double SharpnessBytes(const Counts& n) {
  return Bytes(n.edges, sizeof(float)) + Bytes(n.vertices, sizeof(float)) + Bytes(n.faces, 1);
}

// The operator's order of vertices and faces, and the arrays of the iteration; see Solve and
// SolveControlMesh.
double SolvePeak(const Counts& n, const InterpolateOptions& options) {
  const bool images = options.scheme == Scheme::kDooSabin && options.rule == FirstRule::kStandard;
  const double values = images ? n.half_edges : n.faces;
  const double limit = 2 * (Indices(n.half_edges) + Indices(n.vertices) + Indices(n.faces));
  double sweeps = 3 * Points(n.vertices) + Points(values);
  double weights = 0;
  if (options.scheme != Scheme::kDooSabin) {
    // Neighbours, rows and x of the sweep before; conjugate gradients, for symmetric operators or
    // for others; rows of vertices where something is sharp.
    const bool creased = IsCreased(options.constraints);
    sweeps = std::max(sweeps + Points(n.vertices), (creased ? 7 : 5) * Points(n.vertices) +
                                                       Bytes(n.vertices, sizeof(double)) +
                                                       Points(values));
    weights = Indices(n.half_edges) + Bytes(n.vertices, 2 * sizeof(std::uint16_t));
    // A growing list holds its old half too.
    if (creased) {
      weights += 4 * Bytes(n.half_edges, sizeof(double)) + SharpnessBytes(n) +
                 3 * Bytes(n.vertices, sizeof(Index) + sizeof(std::size_t));
    }
  }
  if (options.solve.method == SolveMethod::kJacobi) {
    sweeps += Bytes(n.vertices, sizeof(double)) + Bytes(values, sizeof(double));
  } else if (options.solve.method == SolveMethod::kGaussSeidel) {
    sweeps += Points(n.faces);
  } else if (options.solve.method == SolveMethod::kConjugateGradient) {
    sweeps += 2 * Points(n.vertices) + Bytes(n.vertices, sizeof(double));
  }
  if (images) sweeps = std::max(sweeps, Indices(n.half_edges));
  double known = 0;
  if (n.boundary > 0 || options.constraints.interpolate.has_value()) {
    known = 2 * Bytes(n.vertices, 1) + Bytes(n.vertices, sizeof(std::uint16_t));
  }
  if (n.boundary > 0) known += Points(n.vertices) + Points(n.boundary) + 2 * Bytes(n.boundary, 1);
  return BuiltMesh(n) + limit + sweeps + weights + known;
}

// Constraints by vertex.
double Plan(const Counts& n, const Constraints& constraints) {
  const auto specials =
      static_cast<double>(constraints.normals.size() + constraints.shape_handles.size());
  if (specials == 0 && !constraints.interpolate.has_value()) return 0;
  // A growing list holds its old half too.
  return Bytes(n.vertices, 1) + 3 * Bytes(specials, sizeof(SpecialVertex));
}

// The tessellation with T^(level - 1), or with the input at level 0.
double TessellationBytes(const Counts& n, const InterpolateOptions& options) {
  const Counts surface = LevelOf(options) == 0 ? n : n.Split();
  return Points(surface.vertices) * (options.normals ? 2 : 1) +
         (LevelOf(options) == 0 ? Indices(n.faces + 1) + Indices(n.half_edges)
                                : Indices(4 * n.half_edges));
}

// What Fair holds beside the patches: some 400 bytes a corner, and T^1 with the points of M^2.
double FairBytes(const Counts& n) {
  const Counts split = n.Split();
  return Bytes(n.half_edges, 400) + SplitMesh(split) + Points(split.half_edges) + Curve(split) +
         Indices(2 * n.half_edges) + 2 * Indices(n.vertices + n.faces + 1);
}

bool Blends(const Constraints& constraints) {
  return !constraints.normals.empty() || !constraints.surface_points.empty();
}

// Blending: the points that each constraint moves, in two lists, and what else a constraint takes.
double BlendBytes(const Counts& n, const Constraints& constraints) {
  // With constraints anywhere, what may be met together: sparse rows and columns.
  const bool together = !constraints.surface_points.empty();
  const double point_bytes = together ? 240 : 40;
  const double constraint_bytes = together ? 8192 : 1024;
  const auto points = MostBlendPoints(static_cast<std::uint64_t>(n.vertices),
                                      static_cast<std::uint64_t>(n.half_edges), constraints);
  // The dense decomposition of a few.
  const double dense = together ? 8.0 * (1 << 20) : 0;
  return dense + point_bytes * static_cast<double>(points) + Bytes(n.vertices, 1) +
         constraint_bytes *
             static_cast<double>(constraints.normals.size() + constraints.surface_points.size());
}

// T^k of a Catmull-Clark or Loop surface with its points.
double PrimalLevel(const Counts& n, bool given) {
  return (given ? BuiltMesh(n) : SplitMesh(n)) + Points(n.vertices) + SharpnessBytes(n);
}

// The same of Catmull-Clark and Loop: T^k with its points, and T^(k+1); then the limits.
double PrimalSurfacePeak(Counts n, const InterpolateOptions& options) {
  const bool loop = options.scheme == Scheme::kLoop;
  const auto split = [loop](const Counts& counts) {
    return loop ? counts.SplitTriangles() : counts.Split();
  };
  const bool blends = Blends(options.constraints);
  const std::uint32_t level = LevelOf(options);
  // Blending works on T^2; at level 0 T^1 may be made for limits.
  const std::uint32_t finest = std::max<std::uint32_t>(options.surface ? level : 0, blends ? 2 : 1);
  double held = blends ? BlendBytes(n, options.constraints) : 0;
  double peak = PrimalLevel(n, true) + Points(n.faces);
  double last = PrimalLevel(n, true);
  for (std::uint32_t k = 0; k <= finest && peak < kMost; ++k) {
    if (k > 0) {
      n = split(n);
      const double next = PrimalLevel(n, false);
      peak = std::max(peak, held + last + next);
      last = next;
    }
    const std::uint32_t patch_level = blends ? 2 : (loop ? 0 : 1);
    if (options.keep_patches && k == patch_level) held += last + Indices(n.faces + 1);
    if (options.surface && k == level) {
      // Once more where blending changes some.
      held += Points(n.vertices) * (options.normals ? 2 : 1) * (blends && level < 2 ? 2 : 1) +
              Indices(n.half_edges) + Indices(n.faces + 1);
    }
    peak = std::max(peak, held + last);
  }
  return peak;
}

// What ChooseLevel holds beside the patches: T^1, M^2 and its bounds.
double ChooseLevelBytes(const Counts& n) {
  const Counts split = n.Split();
  return SplitMesh(split) + Points(split.half_edges) + Bytes(split.half_edges, 280) + Curve(split) +
         Indices(2 * n.half_edges) + 2 * Indices(n.vertices + n.faces + 1);
}

// The most of the surface's stages. `n`: of the mesh that it is made on.
double DooSabinPeak(Counts n, const InterpolateOptions& options) {
  double mesh = BuiltMesh(n);
  const double patches = mesh + Points(n.half_edges) + Curve(n);
  double peak = patches;
  if (options.fair) peak += FairBytes(n);
  if (options.chord_tolerance.has_value()) peak = std::max(peak, patches + ChooseLevelBytes(n));
  if (!options.surface) return peak;
  double fans = options.keep_patches ? patches : 0;
  if (LevelOf(options) >= 2) {
    // At most every vertex and face is extraordinary.
    fans += Indices(2 * n.half_edges) + 2 * Indices(n.vertices + n.faces + 1);
  }
  for (std::uint32_t k = 1; k < LevelOf(options) && peak < kMost; ++k) {
    const Counts split = n.Split();
    const double coarse = mesh;
    mesh = SplitMesh(split);
    // The points of both levels, and then those of the finer one and both connectivities.
    peak = std::max(peak, fans + coarse + Curve(n) + Curve(split) + Points(split.half_edges) +
                              std::max(Points(n.half_edges), mesh));
    n = split;
  }
  return std::max(peak,
                  fans + mesh + Curve(n) + Points(n.half_edges) + TessellationBytes(n, options));
}

// What FeatureSurface::Make holds beside the surface: values by corner, points, marks of vertices,
// planes and what becomes of their corners, and the curve's control points.
double FeatureBytes(const Counts& n) {
  return 2 * Bytes(n.half_edges, sizeof(double)) + Bytes(n.half_edges, 1) + 2 * Bytes(n.faces, 1) +
         2 * Points(n.vertices) + 2 * Bytes(n.vertices, 1) + 2 * Points(n.faces) +
         2 * Points(n.boundary) + Bytes(n.boundary, 1);
}

// The most of the surface's stages. `n`: of the input.
double SurfacePeak(const Counts& n, const InterpolateOptions& options) {
  const std::optional<FeatureValues>& features = options.constraints.features;
  if (!features.has_value()) return DooSabinPeak(n, options);
  if (!features->has_planes()) return FeatureBytes(n) + DooSabinPeak(n, options);
  // Cut at most along every edge; the given mesh is there too, and refined for the tessellation.
  // The corners of plane faces are kept with their normals, 32 bytes each.
  const Counts cut = {.vertices = n.half_edges,
                      .edges = n.half_edges,
                      .faces = n.faces,
                      .half_edges = n.half_edges,
                      .boundary = n.half_edges};
  return FeatureBytes(cut) + BuildPeak(cut) + Bytes(n.half_edges, 32) + DooSabinPeak(cut, options) +
         DooSabinPeak(n, options);
}

}  // namespace

std::uint64_t EstimateSurfaceBytes(std::uint64_t vertices, std::uint64_t faces,
                                   std::uint64_t corners, const InterpolateOptions& options,
                                   std::uint64_t boundary_edges) {
  if (!options.surface) return 0;
  Counts n = MakeCounts(vertices, faces, corners, boundary_edges);
  if (options.scheme == Scheme::kLoop) {
    for (std::uint32_t k = 0; k < LevelOf(options) && n.vertices < kMost; ++k)
      n = n.SplitTriangles();
    return Saturated(Points(n.vertices) * (options.normals ? 2 : 1) + Indices(n.half_edges) +
                     Indices(n.faces + 1));
  }
  for (std::uint32_t k = 1; k < LevelOf(options) && n.vertices < kMost; ++k) n = n.Split();
  return Saturated(TessellationBytes(n, options));
}

std::uint64_t EstimateBytes(std::uint64_t vertices, std::uint64_t faces, std::uint64_t corners,
                            const InterpolateOptions& options, std::uint64_t boundary_edges) {
  const Counts n = MakeCounts(vertices, faces, corners, boundary_edges);
  // The control points, and the input's where they are moved to the origin.
  const double control = 2 * Points(n.vertices) + Plan(n, options.constraints) + Curve(n) +
                         Points(n.boundary) + Indices(n.boundary) +
                         SharpListBytes(options.constraints);
  double peak = control + std::max(BuildPeak(n), SolvePeak(n, options));
  if (options.surface || options.keep_patches)
    peak = std::max(
        peak, control + (options.scheme == Scheme::kDooSabin ? SurfacePeak(n, options)
                                                             : PrimalSurfacePeak(n, options)));
  // Lists of blocks and of runs.
  peak += peak / 64 + 4096;
  return Saturated(peak);
}

std::uint64_t EstimateFilterBytes(std::uint64_t vertices, std::uint64_t faces,
                                  std::uint64_t corners, const InterpolateOptions& surface,
                                  std::uint64_t boundary_edges) {
  const Counts n = MakeCounts(vertices, faces, corners, boundary_edges);
  // The rest, the sum and the limits; what limits of the scheme need beside them.
  const double limits =
      surface.scheme == Scheme::kDooSabin
          ? Points(n.half_edges) + 2 * Curve(n)
          : SharpnessBytes(n) + SharpListBytes(surface.constraints) + Points(n.faces) + Curve(n);
  const double peak = std::max(BuildPeak(n), BuiltMesh(n) + 3 * Points(n.vertices) + limits);
  return Saturated(peak + peak / 64 + 4096);
}

}  // namespace limn
