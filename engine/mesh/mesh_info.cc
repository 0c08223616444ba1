// SPDX-License-Identifier: MIT
// Counts by sorting edges and merging sets of corners; nothing here presumes a valid mesh.
#include "engine/mesh/mesh_info.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/disjoint_sets.h"

namespace limn {
namespace {

// Counts elements with a defect and remembers the smallest.
class Defect {
 public:
  void Add(std::uint64_t element) {
    first_ = count_ == 0 ? element : std::min(first_, element);
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  // text: after the count; element: what `first` is.
  void Report(Reason reason, const std::string& text, const std::string& element,
              std::vector<MeshProblem>* problems) const {
    if (count_ == 0) return;
    problems->push_back({reason, count_, first_,
                         absl::StrCat(count_, " ", text, "; the first is ", element, " ", first_)});
  }

 private:
  std::uint64_t count_ = 0;
  std::uint64_t first_ = 0;
};

// A side of a face between two different, existing vertices.
struct Side {
  Index low;
  Index high;
  Index corner;  // where it begins

  bool SameEdge(const Side& other) const { return low == other.low && high == other.high; }
};

class Describer {
 public:
  explicit Describer(const PolygonMesh& mesh)
      : mesh_(mesh), fans_(mesh.corner_count()), parts_(mesh.vertex_count()) {}

  MeshInfo Describe() {
    info_.vertices = mesh_.vertex_count();
    info_.corners = mesh_.corner_count();
    DescribePositions();
    if (FaceBeginIsSound()) {
      info_.faces = mesh_.face_count();
      DescribeFaces();
      DescribeEdges();
      DescribeVertices();
      DescribeTopology();
    }
    Report();
    return std::move(info_);
  }

 private:
  void DescribePositions() {
    bool first = true;
    for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
      const Vec3& p = mesh_.positions[v];
      if (!IsFinite(p)) {
        non_finite_.Add(v);
        continue;
      }
      if (MaxAbs(p) > kMaxCoordinate) too_large_.Add(v);
      BoundingBox& box = info_.box;
      if (first) box = {p, p};
      first = false;
      box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)};
      box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)};
    }
  }

  bool FaceBeginIsSound() {
    const Buffer<Index>& begin = mesh_.face_begin;
    sound_ = begin.empty() ? mesh_.corner_vertex.empty()
                           : begin.front() == 0 && begin.back() == mesh_.corner_count() &&
                                 std::is_sorted(begin.begin(), begin.end());
    return sound_;
  }

  void DescribeFaces() {
    used_.resize(mesh_.vertex_count(), 0);
    Buffer<Index> sorted;
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
      const absl::Span<const Index> face = mesh_.face(f);
      ++info_.arities[face.size()];
      if (face.size() < 3) too_small_.Add(f);
      sorted.assign(face.begin(), face.end());
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) repeated_.Add(f);
      if (!sorted.empty() && sorted.back() >= mesh_.vertex_count()) {
        out_of_range_.Add(f);
      } else {
        AddSides(f);
      }
    }
  }

  void AddSides(std::size_t f) {
    const Index begin = mesh_.face_begin[f];
    const Index end = mesh_.face_begin[f + 1];
    for (Index c = begin; c < end; ++c) {
      const Index v = mesh_.corner_vertex[c];
      const Index w = mesh_.corner_vertex[c + 1 == end ? begin : c + 1];
      if (v != w) sides_.push_back({std::min(v, w), std::max(v, w), c});
      used_[v] = 1;
    }
  }

  // The corner at the given end of a side.
  Index CornerAt(const Side& side, Index vertex) const {
    if (mesh_.corner_vertex[side.corner] == vertex) return side.corner;
    const std::size_t f = FaceOf(side.corner);
    return side.corner + 1 == mesh_.face_begin[f + 1] ? mesh_.face_begin[f] : side.corner + 1;
  }
  std::size_t FaceOf(Index corner) const {
    const auto after = std::upper_bound(mesh_.face_begin.begin(), mesh_.face_begin.end(), corner);
    return static_cast<std::size_t>(after - mesh_.face_begin.begin()) - 1;
  }
  bool Ascends(const Side& side) const { return mesh_.corner_vertex[side.corner] == side.low; }

  void DescribeEdges() {
    std::sort(sides_.begin(), sides_.end(), [](const Side& a, const Side& b) {
      return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
    });
    valence_.resize(mesh_.vertex_count(), 0);
    for (std::size_t begin = 0; begin < sides_.size();) {
      std::size_t end = begin + 1;
      while (end < sides_.size() && sides_[end].SameEdge(sides_[begin])) ++end;
      DescribeEdge({sides_.data() + begin, end - begin});
      begin = end;
    }
  }

  void DescribeEdge(absl::Span<const Side> sides) {
    const Side& first = sides.front();
    ++info_.edges;
    ++valence_[first.low];
    ++valence_[first.high];
    parts_.Merge(first.low, first.high);
    if (sides.size() == 1) {
      ++info_.boundary_edges;
      boundary_.push_back(first);
    } else if (sides.size() > 2) {
      non_manifold_edges_.Add(FaceOf(first.corner));
    } else if (Ascends(sides[0]) == Ascends(sides[1])) {
      disoriented_.Add(FaceOf(first.corner));
    }
    for (const Side& side : sides.subspan(1)) {
      fans_.Merge(CornerAt(first, first.low), CornerAt(side, first.low));
      fans_.Merge(CornerAt(first, first.high), CornerAt(side, first.high));
    }
  }

  void DescribeVertices() {
    Buffer<Index> fan_count(mesh_.vertex_count(), 0);
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
      for (Index c = mesh_.face_begin[f]; c < mesh_.face_begin[f + 1]; ++c) {
        const Index v = mesh_.corner_vertex[c];
        if (v < mesh_.vertex_count() && fans_.Find(c) == c) ++fan_count[v];
      }
    }
    for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
      ++info_.valences[valence_[v]];
      if (fan_count[v] == 0) isolated_.Add(v);
      if (fan_count[v] > 1) non_manifold_vertices_.Add(v);
    }
  }

  void DescribeTopology() {
    std::int64_t used = 0;
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      if (used_[v] == 0) continue;
      ++used;
      if (parts_.Find(v) == v) ++info_.components;
    }
    info_.boundary_loops = CountLoops();
    info_.euler_characteristic =
        used - static_cast<std::int64_t>(info_.edges) + static_cast<std::int64_t>(info_.faces);
    const bool manifold = too_small_.count() + out_of_range_.count() + repeated_.count() +
                              non_manifold_edges_.count() + disoriented_.count() +
                              non_manifold_vertices_.count() ==
                          0;
    if (!manifold || info_.faces == 0) return;
    // Euler: V - E + F = 2 * components - 2 * genus - loops.
    info_.genus = (2 * static_cast<std::int64_t>(info_.components) -
                   static_cast<std::int64_t>(info_.boundary_loops) - info_.euler_characteristic) /
                  2;
  }

  // A boundary edge joins the fans at its ends; a loop is what hangs together so.
  std::uint64_t CountLoops() {
    DisjointSets loops(mesh_.corner_count());
    for (const Side& side : boundary_) {
      loops.Merge(fans_.Find(CornerAt(side, side.low)), fans_.Find(CornerAt(side, side.high)));
    }
    Buffer<Index> names;
    for (const Side& side : boundary_) {
      names.push_back(loops.Find(fans_.Find(CornerAt(side, side.low))));
    }
    std::sort(names.begin(), names.end());
    return static_cast<std::uint64_t>(std::unique(names.begin(), names.end()) - names.begin());
  }

  void Report() {
    std::vector<MeshProblem>* problems = &info_.problems;
    if (info_.vertices == 0 || mesh_.face_count() == 0) {
      problems->push_back({Reason::kEmptyMesh, 1, 0,
                           info_.vertices == 0 ? "there are no vertices" : "there are no faces"});
    } else if (!sound_) {
      problems->push_back({Reason::kMalformedRequest, 1, 0,
                           "face_begin does not begin at 0, decreases, or ends elsewhere than at "
                           "the number of corners"});
    }
    too_small_.Report(Reason::kFaceTooSmall, "faces have fewer than three corners", "face",
                      problems);
    out_of_range_.Report(Reason::kIndexOutOfRange, "faces name vertices that are not there", "face",
                         problems);
    repeated_.Report(Reason::kRepeatedVertex, "faces visit a vertex more than once", "face",
                     problems);
    non_manifold_edges_.Report(Reason::kNonManifoldEdge, "edges have more than two faces",
                               "one of face", problems);
    disoriented_.Report(Reason::kInconsistentOrientation,
                        "edges have two faces that walk it in the same direction", "one of face",
                        problems);
    non_manifold_vertices_.Report(Reason::kNonManifoldVertex,
                                  "vertices have faces that do not form one fan", "vertex",
                                  problems);
    isolated_.Report(Reason::kIsolatedVertex, "vertices are used by no face", "vertex", problems);
    non_finite_.Report(Reason::kNonFiniteCoordinate,
                       "vertices have a coordinate that is not finite", "vertex", problems);
    too_large_.Report(Reason::kCoordinateTooLarge,
                      absl::StrCat("vertices have a coordinate beyond ", kMaxCoordinate), "vertex",
                      problems);
  }

  const PolygonMesh& mesh_;
  MeshInfo info_;
  bool sound_ = false;
  Buffer<Side> sides_;
  Buffer<Side> boundary_;
  std::vector<char> used_;  // per vertex
  Buffer<Index> valence_;   // per vertex
  DisjointSets fans_;       // of corners: those around a vertex that are joined by edges
  DisjointSets parts_;      // of vertices
  Defect non_finite_, too_large_, too_small_, out_of_range_, repeated_;
  Defect non_manifold_edges_, disoriented_, non_manifold_vertices_, isolated_;
};

}  // namespace

MeshInfo DescribeMesh(const PolygonMesh& mesh) { return Describer(mesh).Describe(); }

}  // namespace limn
