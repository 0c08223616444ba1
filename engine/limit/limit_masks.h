// SPDX-License-Identifier: MIT
// Weights by which the points around a vertex give its limit point and tangents, for Catmull-Clark
// (one ring of quads) and Loop (one ring of triangles).
// Sources: Halstead, Kass and DeRose, "Efficient, Fair Interpolation using Catmull-Clark Surfaces",
// 1993, and Loop 1987 (smooth vertices); Hoppe et al. 1994 (creases). Masks of boundaries, creases,
// corners and darts are derived here: those published (Biermann, Levin and Zorin 2000; OpenSubdiv)
// belong to other rules and fit these only for one and two quads, one to three triangles.
//
// Notation. V is the vertex, E_i the ends of its edges, F_i the fourth vertex of the quad between
// E_i and E_(i+1), counter-clockwise. One refinement maps this ring to a smaller one by a matrix M,
// so a left eigenvector l of M, l M = lambda l, measures what shrinks by lambda: after k
// refinements of a ring P the ring is S + sum over eigenvalues of lambda^k r (l P), r the right
// eigenvectors with l r = 1. l for eigenvalue 1 gives the limit point S, the next two the tangents.
// Away from sharp edges M is a convolution over the ring, and l and r are waves:
//   E_i: cos(i a) or sin(i a),   F_i: left or right times cos or sin of ((i + 1/2) a),
// with a = 2 pi j / n around a smooth vertex, and sin with a = pi j / f in a sector of f faces
// between two sharp edges, which the ring outside does not influence.
// All tangents' weights add up to 0: apply them to differences to V, which needs no weight then.
#pragma once

#include <cstddef>
#include <vector>

namespace limn {

// What lies around a vertex: quads that refine by Catmull and Clark's rules, triangles by Loop's.
enum class RingKind { kQuads, kTriangles };

// A wave of angle a: its eigenvalue and the factors at the F_i (0 for triangles).
// Quads, with c = cos(a / 2) and r = sqrt(c^2 + 4): 1/4 + c (c + r) / 8, left 1 / (c + r), right
// 4 / (c + r). Triangles: 3/8 + cos(a) / 4.
struct Wave {
  double eigenvalue = 0;
  double left = 0;
  double right = 0;
};
[[nodiscard]] Wave WaveOf(RingKind kind, double angle);

// V + edge sum(E_i - V) + face sum(F_i - V): the limit point of a smooth vertex of valence n >= 2.
// Quads: 4 / (n (n + 5)) and 1 / (n (n + 5)). Triangles: 1 / (n + 3 n / (8 w)), w as in LoopRefine.
struct PointMask {
  double edge = 0;
  double face = 0;
};
[[nodiscard]] PointMask SmoothPointMask(RingKind kind, std::size_t n);

// u = edge sum cos(i a) E_i + face sum cos((i + 1/2) a) F_i with a = 2 pi / n; v with sines.
// Scaled so that E_i ~ S + lambda^k (cos(i a) u + sin(i a) v). Two quads have no such plane: u is
// half of E_0 - E_1, v half of F_0 - F_1; two triangles have v = 0.
[[nodiscard]] PointMask SmoothTangentMask(RingKind kind, std::size_t n);

// In a sector of f faces, E_0 and E_f its sharp ends, a = pi / f:
//   edge sum sin(i a) (E_i - V) + face sum sin((i + 1/2) a) (F_i - V) + ends (E_0 + E_f - 2 V),
// scaled so that E_i ~ S + lambda^k sin(i a) v for this part. f >= 2.
struct SectorMask {
  double edge = 0;
  double face = 0;
  double ends = 0;
};
// Where V moves with the curve of E_0 and E_f: on a boundary or a crease.
[[nodiscard]] SectorMask CreaseMask(RingKind kind, std::size_t f);
// Where V stays. It is an eigenvector in sectors wide enough that this part shrinks more slowly
// than E_0 - V does, f >= 3 quads or f >= 4 triangles; else `ends` is 0.
[[nodiscard]] SectorMask CornerMask(RingKind kind, std::size_t f);

// At a dart, E_0 the end of the sharp edge, n >= 2: weights of E_i - V and F_i - V (the latter
// empty for triangles). Edge 0 breaks the ring's symmetry, so the smooth masks do not fit
// (OpenSubdiv uses them). Of the two tangents that across the crease is the smooth v. Cost: linear
// in n.
struct DartMask {
  std::vector<double> edge;
  std::vector<double> face;
};
// Of the limit point.
[[nodiscard]] DartMask DartPointMask(RingKind kind, std::size_t n);
// Of the tangent along the crease, scaled as the smooth u where the ring is the smooth one's wave.
[[nodiscard]] DartMask DartTangentMask(RingKind kind, std::size_t n);

}  // namespace limn
