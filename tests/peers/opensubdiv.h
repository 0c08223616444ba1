// SPDX-License-Identifier: MIT
// OpenSubdiv's uniform refinement (Far) of a mesh of ours, with answers in our numbering and in
// float64.
#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/polygon_mesh.h"
#include "tests/oracle/creased.h"
#include "tests/oracle/creases.h"

namespace limn::peers {

// A point as OpenSubdiv adds them up.
struct PeerPoint {
  Vec3 value = {0, 0, 0};
  void Clear() { value = {0, 0, 0}; }
  void AddWithWeight(const PeerPoint& other, double weight) { value += weight * other.value; }
};

class Peer {
 public:
  // Refines `levels` times.
  Peer(const PolygonMesh& mesh, oracle::Rule rule, const oracle::Creases& creases, int levels);

  // Goes to T^0, then T^1 and so on; mesh is the engine's T^level. What follows is about it.
  void GoTo(int level, const HalfEdgeMesh& mesh);

  Vec3 Position(std::size_t v) const { return positions_[Of(vertices_, v)].value; }
  float EdgeSharpness(std::size_t e) const;
  float VertexSharpness(std::size_t v) const;
  bool IsHole(std::size_t f) const;
  // The vertex at the other end of the edge that OpenSubdiv counts first around v.
  std::size_t FirstNeighbour(std::size_t v) const;
  // Of the edges around v in its order, the sharp ones' other ends.
  std::vector<std::size_t> SharpNeighbours(std::size_t v) const;

  // At the last level.
  struct Limits {
    std::vector<Vec3> points;
    std::vector<Vec3> u;
    std::vector<Vec3> v;
  };
  Limits FindLimits() const;

 private:
  using Far = OpenSubdiv::Far::TopologyLevel;
  static std::size_t Of(const std::vector<int>& map, std::size_t i) {
    return static_cast<std::size_t>(map[i]);
  }
  Far level() const { return refiner_->GetLevel(level_); }
  void MapEdgesAndFaces(const HalfEdgeMesh& mesh);
  std::size_t OtherEnd(int edge, std::size_t v) const;

  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
  int level_ = 0;
  // Our numbers to OpenSubdiv's, and for vertices back.
  std::vector<int> vertices_;
  std::vector<int> edges_;
  std::vector<int> faces_;
  std::vector<std::size_t> vertices_back_;
  // In OpenSubdiv's order.
  std::vector<PeerPoint> positions_;
};

}  // namespace limn::peers
