// SPDX-License-Identifier: MIT
#include "tests/oracle/repair_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "engine/mesh/half_edge_mesh.h"

namespace limn::oracle {
namespace {

using Polygon = std::vector<Index>;
using Edge = std::pair<Index, Index>;

Edge EdgeOf(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

template <class Visit>
void ForEachSide(const Polygon& face, const Visit& visit) {
  for (std::size_t i = 0; i < face.size(); ++i) visit(face[i], face[(i + 1) % face.size()]);
}

// The polygons that a face falls into, also those of one and two corners.
std::vector<Polygon> Pieces(Polygon face) {
  std::vector<Polygon> pieces;
  for (std::size_t j = 1; j < face.size();) {
    const auto at = face.begin() + static_cast<std::ptrdiff_t>(j);
    const auto before = std::find(face.begin(), at, *at);
    if (before == at) {
      ++j;
      continue;
    }
    pieces.emplace_back(before, at);
    j = static_cast<std::size_t>(before - face.begin()) + 1;
    face.erase(before, at);
  }
  pieces.push_back(face);
  return pieces;
}

// The same for every way to write down the same cyclic order, in either direction.
Polygon Canonical(const Polygon& face) {
  Polygon best = face;
  for (const Polygon& way : {face, Polygon(face.rbegin(), face.rend())}) {
    for (std::size_t i = 0; i < way.size(); ++i) {
      Polygon turned(way.begin() + static_cast<std::ptrdiff_t>(i), way.end());
      turned.insert(turned.end(), way.begin(), way.begin() + static_cast<std::ptrdiff_t>(i));
      best = std::min(best, turned);
    }
  }
  return best;
}

Polygon TurnedRound(Polygon face) {
  std::reverse(face.begin() + 1, face.end());
  return face;
}

class Checker {
 public:
  Checker(const PolygonMesh& input, const RepairedMesh& repaired)
      : input_(input), repaired_(repaired), mesh_(repaired.mesh), report_(repaired.report) {}

  void Check() {
    ASSERT_EQ(repaired_.original_vertex.size(), mesh_.vertex_count());
    ASSERT_EQ(repaired_.original_face.size(), mesh_.face_count());
    CleanFaces();
    RemoveRepeats();
    if (!FacesAreThoseThatShouldBeLeft()) return;
    VerticesAreOrderedAndComplete();
    MajoritiesAreKept();
    EdgesAreKeptTogether();
    CountsAgree();
    const auto built = HalfEdgeMesh::Build(Context(), mesh_);
    EXPECT_TRUE(built.ok()) << built.status();
  }

 private:
  struct Face {
    Polygon corners;
    Index original;
  };

  void CleanFaces() {
    for (std::size_t f = 0; f < input_.face_count(); ++f) {
      const Polygon face(input_.face(f).begin(), input_.face(f).end());
      const std::vector<Polygon> pieces = Pieces(face);
      std::size_t left = 0;
      for (const Polygon& piece : pieces) {
        if (piece.size() < 3) continue;
        faces_.push_back({piece, static_cast<Index>(f)});
        ++left;
      }
      expected_.degenerate_faces_removed += left == 0 ? 1 : 0;
      expected_.faces_mended += left > 0 && pieces.size() > 1 ? 1 : 0;
    }
  }

  std::map<Edge, std::vector<std::size_t>> FacesOfEdges() const {
    std::map<Edge, std::vector<std::size_t>> faces;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      ForEachSide(faces_[f].corners, [&](Index a, Index b) { faces[EdgeOf(a, b)].push_back(f); });
    }
    return faces;
  }

  bool Runs(std::size_t f, const Edge& edge) const {
    bool runs = false;
    ForEachSide(faces_[f].corners, [&](Index a, Index b) { runs |= Edge(a, b) == edge; });
    return runs;
  }

  void RemoveRepeats() {
    const auto at_edge = FacesOfEdges();
    std::map<Polygon, std::vector<std::size_t>> groups;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      groups[Canonical(faces_[f].corners)].push_back(f);
    }
    std::set<std::size_t> removed;
    std::set<std::size_t> folded;
    for (const auto& [polygon, faces] : groups) {
      const std::vector<std::size_t>& group = faces;  // clang 14 lets no lambda have a binding
      bool back_to_back = group.size() == 2;
      ForEachSide(polygon, [&](Index a, Index b) {
        back_to_back = back_to_back && at_edge.at(EdgeOf(a, b)).size() == 2 &&
                       Runs(group[0], {a, b}) != Runs(group[1], {a, b});
      });
      if (back_to_back) continue;
      removed.insert(group.begin() + 1, group.end());
      const Edge side = {polygon[0], polygon[1]};
      const auto ways =
          std::count_if(group.begin(), group.end(), [&](std::size_t f) { return Runs(f, side); });
      if (2 * static_cast<std::size_t>(ways) == group.size()) folded.insert(group[0]);
    }
    expected_.repeated_faces_removed = removed.size();
    RemoveFolds(at_edge, folded, &removed);
    expected_.folded_faces_removed = removed.size() - expected_.repeated_faces_removed;
    std::vector<Face> left;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (removed.count(f) == 0) left.push_back(faces_[f]);
    }
    faces_ = left;
  }

  // folded: faces that stand for as many faces of either way round.
  static void RemoveFolds(const std::map<Edge, std::vector<std::size_t>>& at_edge,
                          const std::set<std::size_t>& folded, std::set<std::size_t>* removed) {
    // Folded faces that have a common edge with no others, again and again.
    std::map<std::size_t, std::size_t> fold;
    for (const std::size_t f : folded) fold[f] = f;
    std::map<Edge, std::vector<std::size_t>> folded_at;
    std::map<Edge, std::size_t> others_at;
    for (const auto& [edge, at] : at_edge) {
      for (const std::size_t f : at) {
        if (removed->count(f) != 0) continue;
        if (folded.count(f) != 0) {
          folded_at[edge].push_back(f);
        } else {
          ++others_at[edge];
        }
      }
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (const auto& [edge, at] : folded_at) {
        for (const std::size_t f : at) {
          if (others_at[edge] > 0 || fold[f] == fold[at[0]]) continue;
          fold[f] = fold[at[0]] = std::min(fold[f], fold[at[0]]);
          changed = true;
        }
      }
    }
    std::set<std::size_t> hanging;
    std::set<std::size_t> held;
    for (const auto& [edge, at] : folded_at) {
      for (const std::size_t f : at) {
        if (others_at[edge] == 1) held.insert(fold[f]);
        if (others_at[edge] > 1) hanging.insert(fold[f]);
      }
    }
    for (const auto& [f, name] : fold) {
      if (hanging.count(name) != 0 && held.count(name) == 0) removed->insert(f);
    }
  }

  bool FacesAreThoseThatShouldBeLeft() {
    EXPECT_EQ(mesh_.face_count(), faces_.size());
    if (mesh_.face_count() != faces_.size()) return false;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      EXPECT_EQ(repaired_.original_face[f], faces_[f].original) << f;
      Polygon back;
      for (const Index v : mesh_.face(f)) back.push_back(repaired_.original_vertex[v]);
      const bool same = back == faces_[f].corners;
      EXPECT_TRUE(same || back == TurnedRound(faces_[f].corners)) << f;
      turned_.push_back(!same);
      expected_.faces_reoriented += same ? 0 : 1;
    }
    return true;
  }

  void VerticesAreOrderedAndComplete() {
    std::map<Index, std::set<Index>> copies;  // of input vertices
    std::map<Index, Index> first_face;        // of repaired vertices
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
      for (const Index v : mesh_.face(f)) {
        copies[repaired_.original_vertex[v]].insert(v);
        first_face.emplace(v, static_cast<Index>(f));
      }
    }
    std::vector<Index> kept;
    std::vector<Index> added;
    for (const auto& [original, places] : copies) {
      kept.push_back(original);
      expected_.vertices_split += places.size() > 1 ? 1 : 0;
      expected_.vertices_added += places.size() - 1;
      // The smallest number is the kept one, and copies come in the order of their first faces.
      Index last = 0;
      for (const Index v : places) {
        EXPECT_TRUE(v == *places.begin() || first_face.at(v) > last) << v;
        last = first_face.at(v);
        if (v != *places.begin()) added.push_back(original);
      }
    }
    expected_.isolated_vertices_removed = input_.vertex_count() - kept.size();
    EXPECT_EQ(repaired_.kept_vertices, kept.size());
    kept.insert(kept.end(), added.begin(), added.end());
    EXPECT_EQ(
        std::vector<Index>(repaired_.original_vertex.begin(), repaired_.original_vertex.end()),
        kept);
    for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
      EXPECT_EQ(mesh_.positions[v], input_.positions[repaired_.original_vertex[v]]);
    }
  }

  // Whether face f, turned or not as it came back, runs from a to b.
  bool RunsNow(std::size_t f, const Edge& edge) const {
    return turned_[f] ? Runs(f, {edge.second, edge.first}) : Runs(f, edge);
  }

  void MajoritiesAreKept() {
    const auto at_edge = FacesOfEdges();
    std::vector<std::size_t> name(faces_.size());
    for (std::size_t f = 0; f < name.size(); ++f) name[f] = f;
    for (bool changed = true; changed;) {
      changed = false;
      for (const auto& [edge, at] : at_edge) {
        if (at.size() != 2 || name[at[0]] == name[at[1]]) continue;
        name[at[0]] = name[at[1]] = std::min(name[at[0]], name[at[1]]);
        changed = true;
      }
    }
    for (std::size_t root = 0; root < name.size(); ++root) {
      if (name[root] != root) continue;
      std::ptrdiff_t majority = 0;
      for (std::size_t f = 0; f < name.size(); ++f) {
        if (name[f] == root) majority += turned_[f] ? -1 : 1;
      }
      EXPECT_GE(majority, 0) << root;
      EXPECT_TRUE(majority > 0 || !turned_[root]) << root;
    }
    // Only a component without an orientation is cut.
    std::set<std::size_t> cut;
    for (const auto& [edge, at] : at_edge) {
      if (at.size() != 2) continue;
      if (RunsNow(at[0], edge) == RunsNow(at[1], edge)) {
        cut.insert(name[at[0]]);
        ++expected_.edges_cut;
      }
    }
    for (const std::size_t root : cut) EXPECT_FALSE(Orientable(root, name, at_edge)) << root;
  }

  bool Orientable(std::size_t root, const std::vector<std::size_t>& name,
                  const std::map<Edge, std::vector<std::size_t>>& at_edge) const {
    std::vector<int> side(faces_.size(), 0);
    side[root] = 1;
    for (bool changed = true; changed;) {
      changed = false;
      for (const auto& [edge, at] : at_edge) {
        if (at.size() != 2 || name[at[0]] != root) continue;
        const int sign = Runs(at[0], edge) == Runs(at[1], edge) ? -1 : 1;
        for (const auto& [f, g] : {std::pair(at[0], at[1]), std::pair(at[1], at[0])}) {
          if (side[f] == 0) continue;
          if (side[g] == -sign * side[f]) return false;
          changed = changed || side[g] == 0;
          side[g] = sign * side[f];
        }
      }
    }
    return true;
  }

  // Faces that share an edge still do, unless one was split off there.
  void EdgesAreKeptTogether() {
    std::map<Edge, std::vector<std::size_t>> now;  // edges of the result
    std::map<Index, std::size_t> uses;             // of vertices of the result
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
      const Polygon face(mesh_.face(f).begin(), mesh_.face(f).end());
      ForEachSide(face, [&](Index a, Index b) {
        now[EdgeOf(a, b)].push_back(f);
        ++uses[a];
      });
    }
    std::map<Edge, std::size_t> pairs;  // of edges of the input
    std::set<std::pair<Edge, std::size_t>> alone;
    std::set<std::pair<Edge, std::size_t>> off;
    for (const auto& [edge, at] : now) {
      ASSERT_LE(at.size(), 2U);
      const Edge original =
          EdgeOf(repaired_.original_vertex[edge.first], repaired_.original_vertex[edge.second]);
      if (at.size() == 2) {
        ++pairs[original];
        EXPECT_NE(RunsNow(at[0], original), RunsNow(at[1], original));
        continue;
      }
      alone.insert({original, at[0]});
      if (uses[edge.first] == 1 || uses[edge.second] == 1) off.insert({original, at[0]});
    }
    for (const auto& [edge, at] : FacesOfEdges()) {
      std::size_t up = 0;
      bool split_off = false;
      for (const std::size_t f : at) {
        up += RunsNow(f, edge) ? 1 : 0;
        split_off = split_off || off.count({edge, f}) != 0;
      }
      const std::size_t most = std::min(up, at.size() - up);
      EXPECT_LE(pairs[edge], most);
      if (report_.faces_split_off == 0 || !split_off) {
        EXPECT_EQ(pairs[edge], most) << edge.first << " " << edge.second;
      }
      expected_.edges_split += at.size() > 2 ? 1 : 0;
    }
  }

  void CountsAgree() {
    EXPECT_EQ(report_.degenerate_faces_removed, expected_.degenerate_faces_removed);
    EXPECT_EQ(report_.faces_mended, expected_.faces_mended);
    EXPECT_EQ(report_.repeated_faces_removed, expected_.repeated_faces_removed);
    EXPECT_EQ(report_.folded_faces_removed, expected_.folded_faces_removed);
    EXPECT_EQ(report_.faces_reoriented, expected_.faces_reoriented);
    EXPECT_EQ(report_.edges_cut, expected_.edges_cut);
    EXPECT_EQ(report_.edges_split, expected_.edges_split);
    EXPECT_EQ(report_.vertices_split, expected_.vertices_split);
    EXPECT_EQ(report_.vertices_added, expected_.vertices_added);
    EXPECT_EQ(report_.isolated_vertices_removed, expected_.isolated_vertices_removed);
    EXPECT_LE(report_.faces_split_off, mesh_.face_count());
  }

  const PolygonMesh& input_;
  const RepairedMesh& repaired_;
  const PolygonMesh& mesh_;
  const RepairReport& report_;
  RepairReport expected_;
  // After steps 1 and 2, and whether they came back turned round.
  std::vector<Face> faces_;
  std::vector<bool> turned_;
};

}  // namespace

void ExpectRepaired(const PolygonMesh& input, const RepairedMesh& repaired) {
  Checker(input, repaired).Check();
}

std::size_t BoundarySides(const PolygonMesh& mesh) {
  std::map<Edge, int> count;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Polygon face(mesh.face(f).begin(), mesh.face(f).end());
    ForEachSide(face, [&](Index a, Index b) { ++count[EdgeOf(a, b)]; });
  }
  return static_cast<std::size_t>(std::count_if(
      count.begin(), count.end(), [](const auto& entry) { return entry.second == 1; }));
}

}  // namespace limn::oracle
