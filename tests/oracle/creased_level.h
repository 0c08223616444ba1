// SPDX-License-Identifier: MIT
// A level of a Catmull-Clark or Loop surface by the engine and by the oracle, side by side.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "engine/refine/catmull_clark_refine.h"
#include "engine/refine/loop_refine.h"
#include "tests/oracle/creased.h"
#include "tests/oracle/creases.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/test_meshes.h"

namespace limn::oracle {

// Closed and open test meshes by name.
inline std::vector<std::string> AllMeshNames() {
  std::vector<std::string> names = ClosedMeshNames();
  for (const std::string& name : OpenMeshNames()) names.push_back(name);
  return names;
}
inline PolygonMesh AnyMesh(const std::string& name) {
  for (const std::string& open : OpenMeshNames()) {
    if (open == name) return OpenMesh(name);
  }
  return ClosedMesh(name);
}
// The same, of triangles for Loop.
inline PolygonMesh MeshFor(Rule rule, const std::string& name) {
  const PolygonMesh mesh = AnyMesh(name);
  return rule == Rule::kLoop ? Triangulated(mesh) : mesh;
}

// The engine's T^k: connectivity, sharpness and points.
struct CreasedLevel {
  CreasedLevel(const PolygonMesh& given, Rule scheme, const Creases& creases)
      : rule(scheme), mesh(BuildOrDie(given)), points(given.positions) {
    auto made = MakeSharpness(Context(), mesh, creases.input());
    EXPECT_TRUE(made.ok()) << made.status();
    sharpness = *std::move(made);
  }

  SurfaceLevel level() const { return {mesh, sharpness}; }

  absl::StatusOr<HalfEdgeMesh> Split(const Context& context = {}) const {
    return rule == Rule::kLoop ? SplitIntoTriangles(context, mesh) : SplitIntoQuads(context, mesh);
  }

  void Refine(double bilinear = 0) {
    const Context context;
    LIMN_ASSERT_OK_AND_ASSIGN(HalfEdgeMesh split, Split());
    Buffer<Vec3> refined(split.vertex_count());
    ASSERT_TRUE((rule == Rule::kLoop ? RefineLoop(context, level(), points, absl::MakeSpan(refined))
                                     : RefineCatmullClark(context, level(), points,
                                                          absl::MakeSpan(refined), bilinear))
                    .ok());
    LIMN_ASSERT_OK_AND_ASSIGN(sharpness, RefineSharpness(context, mesh, split, sharpness));
    mesh = std::move(split);
    points = std::move(refined);
  }

  // Whether the corner rule holds at a vertex.
  bool IsCorner(std::size_t v) const {
    std::size_t sharp = 0;
    std::size_t faces = 0;
    const Index entering = WithWalk(mesh, [&](auto walk) {
      return VisitFan(walk, mesh.twin(), mesh.vertex_half_edge()[v], [&](Index h) {
        ++faces;
        if (sharpness.creased() && sharpness.edge[mesh.edge()[h]] > 0) ++sharp;
      });
    });
    if (sharpness.creased()) {
      return sharpness.vertex[v] > 0 || sharp + (entering != kNoIndex ? 1 : 0) > 2;
    }
    return entering != kNoIndex && faces == 1 && sharpness.boundary == BoundaryRule::kEdgeAndCorner;
  }

  Rule rule;
  HalfEdgeMesh mesh;
  Sharpness sharpness;
  Buffer<Vec3> points;
};

}  // namespace limn::oracle
