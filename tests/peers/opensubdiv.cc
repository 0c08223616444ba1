// SPDX-License-Identifier: MIT
#include "tests/peers/opensubdiv.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <set>
#include <stdexcept>

namespace limn::peers {
namespace {

namespace Osd = OpenSubdiv;
using Descriptor = Osd::Far::TopologyDescriptor;
using Options = Osd::Sdc::Options;

Options::VtxBoundaryInterpolation BoundaryOf(BoundaryRule rule) {
  switch (rule) {
    case BoundaryRule::kNone:
      return Options::VTX_BOUNDARY_NONE;
    case BoundaryRule::kEdgeOnly:
      return Options::VTX_BOUNDARY_EDGE_ONLY;
    default:
      return Options::VTX_BOUNDARY_EDGE_AND_CORNER;
  }
}

std::vector<int> Ints(absl::Span<const Index> values) { return {values.begin(), values.end()}; }

}  // namespace

Peer::Peer(const PolygonMesh& mesh, oracle::Rule rule, const oracle::Creases& creases, int levels) {
  std::vector<int> arities;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    arities.push_back(static_cast<int>(mesh.arity(f)));
  }
  const std::vector<int> corners = Ints(mesh.corner_vertex);
  std::vector<int> pairs;
  std::vector<float> weights;
  std::size_t at = 0;
  for (std::size_t c = 0; c < creases.lengths.size(); ++c) {
    for (std::size_t i = 1; i < creases.lengths[c]; ++i) {
      pairs.push_back(static_cast<int>(creases.indices[at + i - 1]));
      pairs.push_back(static_cast<int>(creases.indices[at + i]));
      weights.push_back(creases.sharpnesses[c]);
    }
    at += creases.lengths[c];
  }
  const std::vector<int> sharp_vertices = Ints(creases.corners);
  const std::vector<int> holes = Ints(creases.holes);
  Descriptor descriptor;
  descriptor.numVertices = static_cast<int>(mesh.vertex_count());
  descriptor.numFaces = static_cast<int>(mesh.face_count());
  descriptor.numVertsPerFace = arities.data();
  descriptor.vertIndicesPerFace = corners.data();
  descriptor.numCreases = static_cast<int>(weights.size());
  descriptor.creaseVertexIndexPairs = pairs.data();
  descriptor.creaseWeights = weights.data();
  descriptor.numCorners = static_cast<int>(sharp_vertices.size());
  descriptor.cornerVertexIndices = sharp_vertices.data();
  descriptor.cornerWeights = creases.corner_sharpnesses.data();
  descriptor.numHoles = static_cast<int>(holes.size());
  descriptor.holeIndices = holes.data();
  Options options;
  options.SetVtxBoundaryInterpolation(BoundaryOf(creases.boundary));
  const auto scheme =
      rule == oracle::Rule::kLoop ? Osd::Sdc::SCHEME_LOOP : Osd::Sdc::SCHEME_CATMARK;
  refiner_.reset(
      Osd::Far::TopologyRefinerFactory<Descriptor>::Create(descriptor, {scheme, options}));
  if (refiner_ == nullptr) throw std::runtime_error("OpenSubdiv refuses the mesh");
  Osd::Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = true;
  if (levels > 0) refiner_->RefineUniform(uniform);
  for (const Vec3& p : mesh.positions) positions_.push_back({p});
}

void Peer::GoTo(int level, const HalfEdgeMesh& mesh) {
  std::vector<int> vertices;
  if (level == 0) {
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) vertices.push_back(static_cast<int>(v));
  } else {
    const Far parent = refiner_->GetLevel(level_);
    for (const int v : vertices_) vertices.push_back(parent.GetVertexChildVertex(v));
    for (const int e : edges_) vertices.push_back(parent.GetEdgeChildVertex(e));
    if (mesh.arity() == 4) {
      for (const int f : faces_) vertices.push_back(parent.GetFaceChildVertex(f));
    }
    std::vector<PeerPoint> refined(
        static_cast<std::size_t>(refiner_->GetLevel(level).GetNumVertices()));
    Osd::Far::PrimvarRefinerReal<double>(*refiner_).Interpolate(level, positions_, refined);
    positions_ = std::move(refined);
  }
  level_ = level;
  vertices_ = std::move(vertices);
  vertices_back_.assign(vertices_.size(), 0);
  for (std::size_t v = 0; v < vertices_.size(); ++v) vertices_back_.at(Of(vertices_, v)) = v;
  MapEdgesAndFaces(mesh);
}

void Peer::MapEdgesAndFaces(const HalfEdgeMesh& mesh) {
  const Far far = level();
  edges_.clear();
  faces_.clear();
  WithWalk(mesh, [&](auto walk) {
    for (const Index h : mesh.edge_half_edge()) {
      const int edge =
          far.FindEdge(vertices_[mesh.vertex()[h]], vertices_[mesh.vertex()[walk.Next(h)]]);
      if (edge < 0) throw std::runtime_error("OpenSubdiv has no such edge");
      edges_.push_back(edge);
    }
    for (Index f = 0; f < mesh.face_count(); ++f) {
      std::set<int> corners;
      for (Index h = walk.FaceBegin(f); h < walk.FaceEnd(f); ++h) {
        corners.insert(vertices_[mesh.vertex()[h]]);
      }
      int found = level_ == 0 ? static_cast<int>(f) : -1;
      for (const int face : far.GetVertexFaces(*corners.begin())) {
        const auto others = far.GetFaceVertices(face);
        if (found < 0 && std::set<int>(others.begin(), others.end()) == corners) found = face;
      }
      if (found < 0) throw std::runtime_error("OpenSubdiv has no such face");
      faces_.push_back(found);
    }
  });
}

float Peer::EdgeSharpness(std::size_t e) const { return level().GetEdgeSharpness(edges_[e]); }
float Peer::VertexSharpness(std::size_t v) const {
  return level().GetVertexSharpness(vertices_[v]);
}
bool Peer::IsHole(std::size_t f) const { return level().IsFaceHole(faces_[f]); }

std::size_t Peer::OtherEnd(int edge, std::size_t v) const {
  const auto ends = level().GetEdgeVertices(edge);
  const int other = ends[0] == vertices_[v] ? ends[1] : ends[0];
  return vertices_back_[static_cast<std::size_t>(other)];
}

std::size_t Peer::FirstNeighbour(std::size_t v) const {
  return OtherEnd(level().GetVertexEdges(vertices_[v])[0], v);
}

std::vector<std::size_t> Peer::SharpNeighbours(std::size_t v) const {
  std::vector<std::size_t> neighbours;
  for (const int edge : level().GetVertexEdges(vertices_[v])) {
    if (level().GetEdgeSharpness(edge) > 0) neighbours.push_back(OtherEnd(edge, v));
  }
  return neighbours;
}

Peer::Limits Peer::FindLimits() const {
  std::vector<PeerPoint> points(positions_.size());
  std::vector<PeerPoint> u(positions_.size());
  std::vector<PeerPoint> v(positions_.size());
  Osd::Far::PrimvarRefinerReal<double>(*refiner_).Limit(positions_, points, u, v);
  Limits limits;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    limits.points.push_back(points[Of(vertices_, i)].value);
    limits.u.push_back(u[Of(vertices_, i)].value);
    limits.v.push_back(v[Of(vertices_, i)].value);
  }
  return limits;
}

}  // namespace limn::peers
