// SPDX-License-Identifier: MIT
// TriangulateMarked: cuts polygons along diagonals that repeat no edge.
#include <algorithm>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/edge_table.h"
#include "proto/wire/triangulation.h"

namespace limn::wire {
namespace {

constexpr char kRemedy[] = "Use MESH_ENCODING_PACKED or MESH_ENCODING_DRACO";

// Largest face that is searched completely, and number of fans tried in larger ones.
constexpr std::size_t kMaxSearch = 128;

// What the table holds for the edge of two vertices, the smaller first.
enum EdgeUse : std::uint32_t { kUnused = 0, kUpward = 1, kDownward = 2, kDiagonal = 3 };

absl::Status FaceError(Reason reason, std::size_t face, const std::string& what) {
  return MakeError(absl::StrCat("face ", face, " ", what),
                   {.reason = reason, .field = "faces", .index = face, .remedy = kRemedy});
}

class Triangulator {
 public:
  Triangulator(const Context& context, const PolygonView& faces)
      : context_(context),
        faces_(faces),
        // Closed meshes have half as many edges as corners; open ones make the table grow.
        edges_(faces.corner_vertex.size() / 2 + faces.triangle_count() - faces.face_count()) {}

  absl::StatusOr<MarkedTriangles> Run() {
    LIMN_RETURN_IF_ERROR(EnterEdges());
    const std::size_t triangles = faces_.triangle_count();
    out_.corner_vertex.reserve(3 * triangles);
    if (triangles != faces_.face_count()) out_.added.reserve(3 * triangles);
    for (std::size_t f = 0; f < faces_.face_count(); ++f) {
      if (context_.stop_requested()) return context_.Check();
      LIMN_RETURN_IF_ERROR(Cut(f));
    }
    if (triangles == faces_.face_count()) out_.added.clear();
    return std::move(out_);
  }

 private:
  absl::Status EnterEdges() {
    for (std::size_t f = 0; f < faces_.face_count(); ++f) {
      const absl::Span<const Index> face = faces_.face(f);
      for (std::size_t i = 0; i < face.size(); ++i) {
        const Index a = face[i];
        const Index b = face[i + 1 == face.size() ? 0 : i + 1];
        if (a == b) return FaceError(Reason::kRepeatedVertex, f, "visits a vertex twice");
        std::uint32_t* use = Edge(a, b);
        const std::uint32_t direction = a < b ? kUpward : kDownward;
        if ((*use & direction) != 0) {
          return FaceError(Reason::kNonManifoldEdge, f,
                           absl::StrCat("walks the edge from vertex ", a, " to ", b,
                                        " as another face does; this encoding cannot keep it"));
        }
        *use |= direction;
      }
    }
    return absl::OkStatus();
  }

  std::uint32_t* Edge(Index a, Index b) {
    return edges_.FindOrInsert(std::min(a, b), std::max(a, b), kUnused);
  }

  bool Free(Index a, Index b) {
    return a != b && edges_.Find(std::min(a, b), std::max(a, b)) == nullptr;
  }

  absl::Status Cut(std::size_t f) {
    const absl::Span<const Index> face = faces_.face(f);
    if (face.size() == 3) {
      Emit(face[0], face[1], face[2], 0);
      return absl::OkStatus();
    }
    // A repeated vertex would make two diagonals one.
    sorted_.assign(face.begin(), face.end());
    std::sort(sorted_.begin(), sorted_.end());
    if (std::adjacent_find(sorted_.begin(), sorted_.end()) != sorted_.end()) {
      return FaceError(Reason::kRepeatedVertex, f, "visits a vertex twice");
    }
    const std::size_t tries = std::min(face.size(), kMaxSearch);
    for (std::size_t first = 0; first < tries; ++first) {
      if (FanIsFree(face, first)) {
        EmitFan(face, first);
        return absl::OkStatus();
      }
    }
    if (face.size() <= kMaxSearch && Search(face)) {
      EmitSearched(face, 0, face.size() - 1);
      return absl::OkStatus();
    }
    return FaceError(Reason::kInvalidOption, f,
                     "cannot be cut into triangles without repeating an edge of the mesh");
  }

  bool FanIsFree(absl::Span<const Index> face, std::size_t first) {
    for (std::size_t i = 2; i + 1 < face.size(); ++i) {
      if (!Free(face[first], face[(first + i) % face.size()])) return false;
    }
    return true;
  }

  void EmitFan(absl::Span<const Index> face, std::size_t first) {
    const std::size_t m = face.size();
    for (std::size_t i = 1; i + 1 < m; ++i) {
      const Index a = face[first];
      const Index b = face[(first + i) % m];
      if (i > 1) *Edge(a, b) = kDiagonal;
      // The added edge of all but the first triangle, a -> b, is opposite to its third corner.
      Emit(a, b, face[(first + i + 1) % m], i > 1 ? 3 : 0);
    }
  }

  // Fills split_: split_[i * m + j] is a k between i and j such that triangle (i, k, j) and what
  // lies beyond its two other sides can be cut; 0 where there is none. Cost: m^3.
  bool Search(absl::Span<const Index> face) {
    const std::size_t m = face.size();
    split_.assign(m * m, 0);
    const auto solved = [&](std::size_t i, std::size_t j) {
      return i + 1 == j || split_[i * m + j] != 0;
    };
    for (std::size_t span = 2; span < m; ++span) {
      for (std::size_t i = 0; i + span < m; ++i) {
        const std::size_t j = i + span;
        if (span + 1 < m && !Free(face[i], face[j])) continue;
        for (std::size_t k = i + 1; k < j; ++k) {
          if (solved(i, k) && solved(k, j)) {
            split_[i * m + j] = k;
            break;
          }
        }
      }
    }
    return split_[m - 1] != 0;
  }

  // Depth of the recursion: at most kMaxSearch.
  void EmitSearched(absl::Span<const Index> face, std::size_t i, std::size_t j) {
    if (i + 1 == j) return;
    const bool root = j - i + 1 == face.size();
    const std::size_t k = split_[i * face.size() + j];
    if (!root) *Edge(face[i], face[j]) = kDiagonal;
    // The added edge, j -> i, is opposite to the second corner.
    Emit(face[i], face[k], face[j], root ? 0 : 2);
    EmitSearched(face, i, k);
    EmitSearched(face, k, j);
  }

  // mark: 1 to 3, the corner opposite to an added edge; 0 for none.
  void Emit(Index a, Index b, Index c, int mark) {
    out_.corner_vertex.insert(out_.corner_vertex.end(), {a, b, c});
    for (int i = 1; i <= 3; ++i) out_.added.push_back(mark == i ? 1 : 0);
  }

  const Context& context_;
  const PolygonView faces_;
  EdgeTable edges_;
  MarkedTriangles out_;
  std::vector<Index> sorted_;
  std::vector<std::size_t> split_;
};

}  // namespace

absl::StatusOr<MarkedTriangles> TriangulateMarked(const Context& context,
                                                  const PolygonView& faces) {
  return Triangulator(context, faces).Run();
}

}  // namespace limn::wire
