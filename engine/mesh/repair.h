// SPDX-License-Identifier: MIT
// Makes a mesh that HalfEdgeMesh::Build would refuse into one that it accepts, on request, and says
// what was changed and where everything came from. Nothing is moved and nothing is invented: faces
// are left out, turned round or cut apart, and vertices are doubled.
//
// The steps, in this order:
//   1. Degenerate faces. A face that visits a vertex more than once becomes the simple polygons it
//      consists of: its corners are walked, and whenever a vertex comes again, what was walked
//      since its first visit is cut off as a polygon of its own. (A corner that repeats the one
//      before it, and a spike a-b-a, are such polygons of one and two corners.) Polygons of fewer
//      than three corners are left out.
//   2. Repeated faces. Of faces with the same vertices in the same cyclic order, forwards or
//      backwards, the first stays. The exception are two faces back to back that share all their
//      edges with no other face: they are a closed surface of two faces, and a sound one.
//      Folds. A face that stayed for as many faces one way round as the other is part of a fold
//      without thickness or of a wall between two solids. Such faces, together with those that
//      they share edges with that no other faces have, go altogether if they hang on others, and
//      at every edge where they do on two or more: what they hang on is as closed without them.
//   3. Orientation. Components are what hangs together by edges of two faces. In each, the
//      orientation that most of its faces have wins, with as many of either that of its first
//      face; the other faces are turned round (their first corner stays). Where there is no
//      orientation that suits all, as on a Moebius strip, the edges at which a breadth-first walk
//      from the component's first face meets itself the wrong way are cut open.
//   4. Edges of more than two faces are taken apart into pairs of faces that walk them in opposite
//      directions, and single ones. First those pairs that close an umbrella at one of the edge's
//      ends, so that a fin falls off a surface and surfaces that touch are let go of each other;
//      then faces of the same component, then of the larger components, then the first faces.
//   5. Vertices. The faces around a vertex that hang together across pairs form an umbrella; each
//      umbrella gets a vertex of its own, at the same point. The umbrella of the first face keeps
//      the vertex.
//      Two pairs of the same edge can still share both umbrellas, which no list of faces can say:
//      then all but one pair are split off, that is, their faces get a corner of their own at the
//      edge's end of smaller number.
//   6. Isolated vertices, those that no face uses any more, are left out.
// Source of the idea that the vertices of a repaired mesh are the classes of corners joined across
// edges: Gueziec, Taubin, Lazarus and Horn, "Cutting and stitching: converting sets of polygons to
// manifold surfaces", IEEE TVCG 2001.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// What to repair. A defect whose repair is off stays in the mesh, for HalfEdgeMesh::Build to
// refuse.
struct RepairOptions {
  // Step 1.
  bool degenerate_faces = true;
  // Step 2. Off: repeated faces are taken apart like any others.
  bool repeated_faces = true;
  // Step 2, the second part, which needs the first.
  bool folds = true;
  // Step 3.
  bool orientation = true;
  // Steps 4 and 5.
  bool non_manifold = true;
  // Step 6.
  bool isolated_vertices = true;
};

// What was changed. All 0: nothing.
struct RepairReport {
  // Input faces of which nothing is left after step 1.
  std::uint64_t degenerate_faces_removed = 0;
  // Input faces that visited a vertex more than once and of which something is left.
  std::uint64_t faces_mended = 0;
  // Faces left out by step 2: those that repeat an earlier one, and the earlier ones in folds.
  std::uint64_t repeated_faces_removed = 0;
  std::uint64_t folded_faces_removed = 0;
  // Faces turned round.
  std::uint64_t faces_reoriented = 0;
  // Edges of two faces that were cut open because no orientation suits both.
  std::uint64_t edges_cut = 0;
  // Edges of more than two faces.
  std::uint64_t edges_split = 0;
  // Faces that got a corner of their own in step 5.
  std::uint64_t faces_split_off = 0;
  // Input vertices that became several.
  std::uint64_t vertices_split = 0;
  // How many more there are of them now.
  std::uint64_t vertices_added = 0;
  // Vertices left out by step 6, of the input those that no face is left of.
  std::uint64_t isolated_vertices_removed = 0;

  friend bool operator==(const RepairReport& a, const RepairReport& b) = default;
};

struct RepairedMesh {
  // Vertices: those of the input that are kept, in the input's order, then the added ones, in the
  // order of the vertices they are copies of, copies of the same one in the order of their first
  // faces. Faces: in the input's order, the polygons of one input face one after the other, in the
  // order in which the walk closes them.
  PolygonMesh mesh;
  // For each vertex of `mesh` the input vertex that it comes from; the first kept_vertices of them
  // increase.
  Buffer<Index> original_vertex;
  // For each face of `mesh` the input face that it comes from; never decreases.
  Buffer<Index> original_face;
  // Vertices of `mesh` that are no copies.
  std::size_t kept_vertices = 0;
  RepairReport report;
};

// Repairs a mesh.
//
// Guarantees, with all options on: HalfEdgeMesh::Build accepts the result. A mesh that Build
// accepts comes back as it was, bit for bit, with a report of zeros. Positions keep their bits. The
// result is the same for any number of threads.
//
// mesh: any arities, also below 3. Errors, those of what is not repaired: NON_FINITE_COORDINATE and
// COORDINATE_TOO_LARGE (of any vertex, also an isolated one), INDEX_OUT_OF_RANGE,
// MALFORMED_REQUEST (face_begin), EMPTY_MESH (also when no face is left), LIMIT_EXCEEDED (also when
// doubled vertices exceed the limit), OUT_OF_MEMORY, CANCELLED, DEADLINE_EXCEEDED.
//
// Cost: linear in vertices, faces and corners, times the logarithm of the number of faces at a
// vertex; mostly one thread. Memory: EstimateRepairBytes. Cancel and deadline are looked at every
// few thousand elements. Reports progress as the stage "repair". Thread-safe; runs in the caller's
// arena.
[[nodiscard]] absl::StatusOr<RepairedMesh> Repair(const Context& context, const PolygonMesh& mesh,
                                                  const RepairOptions& options = {});

// Bytes of the arrays that Repair holds at its peak for a mesh of such a size, whatever is wrong
// with it: its result among them, the input not. Saturates. Cost: constant.
[[nodiscard]] std::uint64_t EstimateRepairBytes(std::uint64_t vertices, std::uint64_t faces,
                                                std::uint64_t corners);

// Whether Repair mends what HalfEdgeMesh::Build refuses for this reason. Never throws.
[[nodiscard]] bool RepairMends(Reason reason);

// Where the given vertices of the input are in the repaired mesh: for each the vertex that kept its
// place (its copies are left alone), or kNoIndex if it was left out or is none of the input's.
// Cost: logarithmic in the vertices, for each. Thread-safe.
[[nodiscard]] Buffer<Index> RepairedVertices(const RepairedMesh& repaired,
                                             absl::Span<const Index> input_vertices);

}  // namespace limn
