// SPDX-License-Identifier: MIT
// Shorthands of the tests of repair.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "engine/mesh/repair.h"
#include "tests/oracle/repair_check.h"

namespace limn {

using Faces = std::vector<std::vector<Index>>;

inline RepairedMesh RepairOrDie(const PolygonMesh& mesh, const RepairOptions& options = {}) {
  auto repaired = Repair(Context(), mesh, options);
  EXPECT_TRUE(repaired.ok()) << repaired.status();
  return repaired.ok() ? *std::move(repaired) : RepairedMesh();
}

// Repairs and holds the result against the oracle.
inline RepairedMesh Checked(const PolygonMesh& mesh) {
  RepairedMesh repaired = RepairOrDie(mesh);
  oracle::ExpectRepaired(mesh, repaired);
  return repaired;
}

inline void ExpectUntouched(const PolygonMesh& mesh) {
  const RepairedMesh repaired = RepairOrDie(mesh);
  EXPECT_EQ(repaired.mesh, mesh);
  EXPECT_EQ(repaired.report, RepairReport());
  EXPECT_EQ(repaired.kept_vertices, mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) ASSERT_EQ(repaired.original_vertex[v], v);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) ASSERT_EQ(repaired.original_face[f], f);
}

// Vertices on a helix, so that no two of their differences are alike.
inline PolygonMesh WithFaces(std::size_t vertices, const Faces& faces) {
  PolygonMesh mesh;
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto t = static_cast<double>(v);
    mesh.positions.push_back({std::cos(t), std::sin(t), 0.1 * t});
  }
  for (const auto& face : faces) mesh.AddFace(face);
  return mesh;
}

inline Faces FacesOf(const PolygonMesh& mesh) {
  Faces faces;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    faces.emplace_back(mesh.face(f).begin(), mesh.face(f).end());
  }
  return faces;
}

}  // namespace limn
