// SPDX-License-Identifier: MIT
// Half-edges for generate.cc on which edges can be flipped and removed, which makes regular meshes
// irregular. Every operation leaves an oriented 2-manifold without repeated vertices or edges.
#pragma once

#include <cstddef>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/mesh/generate_random.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::generate {

// What Flip and Merge may lead to.
struct RemixLimits {
  Index min_valence = 3;
  Index max_valence = 9;
  Index max_arity = 8;
  // Least sine of the outer angle at a corner: positive keeps faces convex.
  double min_turn = 0.03;
};

class Remix {
 public:
  // The mesh is a valid oriented manifold; `normals` has a direction per vertex, in whose plane
  // convexity is judged. Both must outlive this.
  Remix(const PolygonMesh& mesh, absl::Span<const Vec3> normals, const RemixLimits& limits);

  // Tries to replace random edges between triangles by the other diagonal.
  void FlipSome(double share_of_edges, Random* random);

  // Moves the vertices of triangles that are not on the boundary towards the mean of their
  // neighbours, which takes slivers out, unless that would fold a face. `place` puts a point back
  // onto the surface; `mesh` is that of the constructor.
  using Place = Vec3 (*)(const Vec3& point);
  void Smooth(const Place& place, PolygonMesh* mesh) const;

  // Removes random edges where that is allowed, at most `wanted`, those at vertices above
  // max_valence first. Returns how many.
  std::size_t MergeSome(std::size_t wanted, Random* random);

  // Faces of the mesh now, in order of their first corner in the mesh of the constructor.
  void TakeFaces(PolygonMesh* mesh) const;

  // Calls visit(face) for the faces around a corner's vertex, counter-clockwise; closed meshes
  // only.
  template <class Visit>
  void ForEachFaceAround(Index first_corner, const Visit& visit) const {
    Index h = first_corner;
    do {
      visit(face_[h]);
      h = twin_[prev_[h]];
    } while (h != first_corner);
  }

  // A corner of each vertex.
  Buffer<Index> FirstCorners() const;
  // Present vertex and face of a corner; while nothing is merged, all corners and faces exist.
  Index vertex_of(Index corner) const { return vertex_[corner]; }
  Index face_of(Index corner) const { return face_[corner]; }

 private:
  void PairTwins();
  bool Flip(Index h);
  bool Merge(Index h);
  bool Adjacent(Index corner, Index other) const;
  bool ShareOnlyEdge(Index h) const;
  bool Convex(Index a, Index b, Index c) const;
  bool OnBoundary(Index corner) const;
  bool Folds(Index corner) const;
  Buffer<Index> EdgesInRandomOrder(Random* random) const;

  const PolygonMesh& mesh_;
  absl::Span<const Vec3> normals_;
  RemixLimits limits_;
  // Per half-edge, numbered as the corner where it begins. A removed one has vertex kNoIndex.
  Buffer<Index> vertex_;
  Buffer<Index> next_;
  Buffer<Index> prev_;
  Buffer<Index> twin_;  // kNoIndex on the boundary
  Buffer<Index> face_;
  Buffer<Index> arity_;    // per face
  Buffer<Index> valence_;  // per vertex
};

}  // namespace limn::generate
