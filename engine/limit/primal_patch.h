// SPDX-License-Identifier: MIT
// A quad of a Catmull-Clark surface or a triangle of a Loop surface with all that shapes it: the
// rings of its corners. Evaluated exactly at any parameter, by refining the patch alone.
// Source: the idea of Stam, "Exact evaluation of Catmull-Clark subdivision surfaces at arbitrary
// parameter values", 1998, with refinements made one by one instead of by eigenvectors, which holds
// for everything that can be sharp.
//
// After one refinement, what is irregular is at one corner of a child at most, and after as many as
// the largest sharpness that wears off, along no side. So a parameter other than an irregular
// corner itself is in a child that is one polynomial after log2 (1 / distance) refinements.
// Children are kept relative to their first corner, and twice as large as they are, so that
// derivatives and normals are as exact near an irregular vertex as anywhere.
#pragma once

#include <array>
#include <cstddef>

#include "engine/base/vec3.h"
#include "engine/limit/patch_place.h"
#include "engine/limit/patch_sample.h"
#include "engine/limit/regular_ring.h"
#include "engine/limit/ring_limit.h"

namespace limn {

// The ring of a corner, and which of its faces is the patch.
struct PatchCorner {
  VertexRing ring;
  std::size_t face = 0;
};

// Used again for one parameter after the other, so that no memory is allocated.
class PrimalPatch {
 public:
  explicit PrimalPatch(RingKind kind) : kind_(kind) {}

  std::size_t sides() const { return kind_ == RingKind::kQuads ? 4 : 3; }
  // Corner i of the patch, counter-clockwise, to be filled in before Evaluate.
  PatchCorner& corner(std::size_t i) { return corners_[i]; }

  // From corner 0, u along the side that leaves it and v along the side that enters it. Quads: both
  // in [0, 1]. Triangles: both and their sum. Consumes the corners. At irregular corners
  // derivatives are RingCorner's tangents. Cost: the sum of the corners' valences, per refinement.
  PatchSample Evaluate(double u, double v);

  // Points of rings that the last evaluation refined: what it cost.
  std::size_t work() const { return work_; }

 private:
  void Start(double u, double v);
  // Fills in regular_, of a corner and of all, if it is so.
  bool IsRegular(std::size_t corner);
  bool FindSpline();
  void Refine();
  void EnterChild(std::size_t corner);
  void EnterMiddle();
  void Magnify();
  void SetVertex(std::size_t corner, std::size_t place);
  void SetEdge(std::size_t side, std::size_t face, std::size_t place);
  void SetCentre(std::size_t face, std::size_t place);
  // A point of the refined rings: that of the side from corner i on, and of the middle.
  Vec3 SidePoint(std::size_t i) const;
  Vec3 Centre() const;
  double LocalSize() const;

  PatchSample SplineSample() const;
  PatchSample CornerSample(std::size_t corner);
  Vec3 ToModel(const Vec3& local) const;

  const RingKind kind_;
  std::array<PatchCorner, 4> corners_;
  std::array<PatchCorner, 4> children_;
  std::array<RegularRing, 4> regular_;
  // The corner whose child is entered, or sides() for the middle triangle.
  std::size_t kept_ = 0;
  // Derivatives are scaled as the patch is.
  PatchPlace place_;
  // Refinements so far: points are relative to origin_ and taken times 2^depth_.
  int depth_ = 0;
  Vec3 origin_;
  // Magnitude of the coordinates given, and of the patch at first.
  double magnitude_ = 0;
  double first_size_ = 0;
  std::size_t work_ = 0;
};

}  // namespace limn
