// SPDX-License-Identifier: MIT
#include "engine/scheme/sharpness.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/triangle_split.h"

namespace limn {
namespace {

// One entry of a list, as errors name it.
struct Entry {
  std::string_view list;
  std::size_t index = 0;
};

absl::Status Refuse(Reason reason, const Entry& entry, std::string_view message,
                    std::string_view remedy) {
  std::string field = absl::StrCat(std::string(entry.list), "[", entry.index, "]");
  std::string text = absl::StrCat(field, ": ", std::string(message));
  return MakeError(text, {.reason = reason,
                          .field = std::move(field),
                          .index = entry.index,
                          .remedy = std::string(remedy)});
}

absl::Status RefuseSize(std::string_view list, std::size_t size, std::size_t wanted) {
  return MakeError(absl::StrCat(std::string(list), " has ", size, " entries, not ", wanted),
                   {.reason = Reason::kInvalidOption,
                    .field = std::string(list),
                    .remedy = "Give one entry for each crease or corner, or for each crease edge"});
}

absl::Status CheckRange(const Entry& entry, Index index, std::size_t size,
                        const char* what = "vertex") {
  if (index < size) return absl::OkStatus();
  return Refuse(Reason::kIndexOutOfRange, entry,
                absl::StrCat("there is no ", what, " ", index, ", the mesh has ", size),
                "Vertices and faces are counted from 0");
}

absl::Status CheckSharpness(const Entry& entry, float sharpness) {
  if (sharpness >= 0) return absl::OkStatus();
  return Refuse(Reason::kInvalidOption, entry, absl::StrCat("the sharpness is ", sharpness),
                "It must be 0 or more");
}

// The edge between two vertices, or kNoIndex.
Index FindEdge(const HalfEdgeMesh& mesh, Index a, Index b) {
  if (mesh.valence(b) < mesh.valence(a)) std::swap(a, b);
  const PolygonWalk walk(mesh);
  for (Index i = mesh.fan_begin()[a]; i < mesh.fan_begin()[a + 1]; ++i) {
    const Index h = mesh.fan()[i];
    if (mesh.vertex()[walk.Next(h)] == b) return mesh.edge()[h];
    // The last edge of a boundary vertex only enters it.
    if (mesh.vertex()[walk.Prev(h)] == b) return mesh.edge()[walk.Prev(h)];
  }
  return kNoIndex;
}

constexpr std::size_t kEntriesPerCheck = std::size_t{1} << 12;
constexpr std::size_t kStepsPerCheck = std::size_t{1} << 16;

// Fills a Sharpness from what is asked for.
class SharpnessMaker {
 public:
  SharpnessMaker(const Context& context, const HalfEdgeMesh& mesh, const CreaseInput& input)
      : context_(context), mesh_(mesh), input_(input) {}

  absl::StatusOr<Sharpness> Make() {
    out_.boundary = input_.boundary;
    LIMN_RETURN_IF_ERROR(context_.Check());
    LIMN_RETURN_IF_ERROR(CheckSizes());
    if (!input_.crease_lengths.empty() || !input_.corner_indices.empty()) {
      out_.edge.assign(mesh_.edge_count(), 0);
      out_.vertex.assign(mesh_.vertex_count(), 0);
    }
    LIMN_RETURN_IF_ERROR(SetCreases());
    LIMN_RETURN_IF_ERROR(SetCorners());
    LIMN_RETURN_IF_ERROR(SetHoles());
    if (input_.boundary == BoundaryRule::kNone) LIMN_RETURN_IF_ERROR(MakeBoundaryFacesHoles());
    if (out_.transient == 0 && !out_.lasting) {
      out_.edge = {};
      out_.vertex = {};
    }
    if (out_.creased()) LIMN_RETURN_IF_ERROR(SharpenBoundary());
    return std::move(out_);
  }

 private:
  absl::Status CheckSizes() {
    std::uint64_t vertices = 0;
    for (std::size_t i = 0; i < input_.crease_lengths.size(); ++i) {
      const Index length = input_.crease_lengths[i];
      if (length < 2) {
        return Refuse(Reason::kInvalidOption, {"crease_lengths", i},
                      absl::StrCat("a crease of ", length, " vertices"),
                      "A crease has at least two vertices");
      }
      vertices += length;
    }
    if (vertices != input_.crease_indices.size()) {
      return RefuseSize("crease_indices", input_.crease_indices.size(), vertices);
    }
    const std::size_t creases = input_.crease_lengths.size();
    const std::size_t given = input_.crease_sharpnesses.size();
    if (given != creases && given != vertices - creases) {
      return RefuseSize("crease_sharpnesses", given, creases);
    }
    if (input_.corner_sharpnesses.size() != input_.corner_indices.size()) {
      return RefuseSize("corner_sharpnesses", input_.corner_sharpnesses.size(),
                        input_.corner_indices.size());
    }
    return absl::OkStatus();
  }

  // What wears off and what stays, unless it would be sharp without a wish.
  void Note(float sharpness, bool boundary) {
    if (sharpness < kSharpForever) {
      if (!boundary) out_.transient = std::max(out_.transient, sharpness);
    } else {
      out_.lasting = out_.lasting || !boundary;
    }
  }

  absl::Status SetCreases() {
    const bool per_crease = input_.crease_sharpnesses.size() == input_.crease_lengths.size();
    std::size_t at = 0;
    std::size_t edge_number = 0;
    for (std::size_t c = 0; c < input_.crease_lengths.size(); ++c) {
      const std::size_t end = at + input_.crease_lengths[c];
      LIMN_RETURN_IF_ERROR(
          CheckRange({"crease_indices", at}, input_.crease_indices[at], mesh_.vertex_count()));
      for (++at; at < end; ++at, ++edge_number) {
        if (edge_number % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context_.Check());
        LIMN_RETURN_IF_ERROR(SetCreaseEdge(at, per_crease ? c : edge_number));
      }
    }
    return NoteAll(mesh_.edge_count(), out_.edge, [&](std::size_t e) { return IsBoundary(e); });
  }

  absl::Status SetCreaseEdge(std::size_t at, std::size_t value) {
    const Index b = input_.crease_indices[at];
    LIMN_RETURN_IF_ERROR(CheckRange({"crease_indices", at}, b, mesh_.vertex_count()));
    const Index a = input_.crease_indices[at - 1];
    LIMN_ASSIGN_OR_RETURN(const Index edge, EdgeBetween(a, b));
    if (edge == kNoIndex) {
      return Refuse(Reason::kInvalidOption, {"crease_indices", at},
                    absl::StrCat("no edge joins the vertices ", a, " and ", b),
                    "A crease follows edges of the mesh");
    }
    const float sharpness = input_.crease_sharpnesses[value];
    LIMN_RETURN_IF_ERROR(CheckSharpness({"crease_sharpnesses", value}, sharpness));
    out_.edge[edge] = sharpness;
    return absl::OkStatus();
  }

  // A fan is walked once for each pair of vertices at the most where fans are large: each edge is
  // between few large fans then, so that all walks together are short. Stops are seen by the length
  // of the walks.
  absl::StatusOr<Index> EdgeBetween(Index a, Index b) {
    constexpr std::size_t kLarge = 64;
    const std::size_t steps = std::min(mesh_.valence(a), mesh_.valence(b));
    if (steps <= kLarge) return FindEdge(mesh_, a, b);
    const auto [at, fresh] = found_.try_emplace({std::min(a, b), std::max(a, b)}, kNoIndex);
    if (!fresh) return at->second;
    walked_ += steps;
    if (walked_ >= kStepsPerCheck) {
      walked_ = 0;
      LIMN_RETURN_IF_ERROR(context_.Check());
    }
    at->second = FindEdge(mesh_, a, b);
    return at->second;
  }

  absl::Status SetCorners() {
    for (std::size_t i = 0; i < input_.corner_indices.size(); ++i) {
      if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      const Index v = input_.corner_indices[i];
      LIMN_RETURN_IF_ERROR(CheckRange({"corner_indices", i}, v, mesh_.vertex_count()));
      const float sharpness = input_.corner_sharpnesses[i];
      LIMN_RETURN_IF_ERROR(CheckSharpness({"corner_sharpnesses", i}, sharpness));
      out_.vertex[v] = sharpness;
    }
    return NoteAll(mesh_.vertex_count(), out_.vertex, [&](std::size_t v) { return IsCorner(v); });
  }

  // Serial: it is a maximum, and nothing beside the walk along half-edges.
  template <class IsSharp>
  absl::Status NoteAll(std::size_t size, const Buffer<float>& values, const IsSharp& is_sharp) {
    if (values.empty()) return absl::OkStatus();
    for (std::size_t i = 0; i < size; ++i) {
      if (i % kScanBlock == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      if (values[i] > 0) Note(values[i], is_sharp(i));
    }
    return absl::OkStatus();
  }

  absl::Status SetHoles() {
    if (input_.hole_indices.empty()) return absl::OkStatus();
    out_.hole.assign(mesh_.face_count(), 0);
    for (std::size_t i = 0; i < input_.hole_indices.size(); ++i) {
      if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      const Index f = input_.hole_indices[i];
      LIMN_RETURN_IF_ERROR(CheckRange({"hole_indices", i}, f, mesh_.face_count(), "face"));
      out_.hole[f] = 1;
    }
    return absl::OkStatus();
  }

  bool IsBoundary(std::size_t e) const {
    return mesh_.twin()[mesh_.edge_half_edge()[e]] == kNoIndex;
  }
  // A vertex of one face, when such vertices are sharp.
  bool IsCorner(std::size_t v) const {
    return out_.boundary == BoundaryRule::kEdgeAndCorner && mesh_.valence(v) == 1;
  }
  bool WasSharpened(Index h) const {
    return out_.creased() && out_.edge[mesh_.edge()[h]] >= kSharpForever;
  }

  absl::Status MakeBoundaryFacesHoles() {
    if (mesh_.boundary_edge_count() == 0) return absl::OkStatus();
    if (out_.hole.empty()) out_.hole.assign(mesh_.face_count(), 0);
    const PolygonWalk walk(mesh_);
    const auto is_open = [&](Index v) {
      const Index first = mesh_.fan()[mesh_.fan_begin()[v]];
      if (mesh_.twin()[first] != kNoIndex) return false;
      const Index last = mesh_.fan()[mesh_.fan_begin()[v + 1] - 1];
      return !WasSharpened(first) || !WasSharpened(walk.Prev(last));
    };
    return ParallelFor(context_, mesh_.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        for (Index h = mesh_.face_begin()[f]; h < mesh_.face_begin()[f + 1]; ++h) {
          if (is_open(mesh_.vertex()[h])) out_.hole[f] = 1;
        }
      }
    });
  }

  absl::Status SharpenBoundary() {
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, mesh_.edge_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t e = begin; e < end; ++e) {
            if (IsBoundary(e)) out_.edge[e] = kSharpForever;
          }
        }));
    return ParallelFor(context_, mesh_.vertex_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (IsCorner(v)) out_.vertex[v] = kSharpForever;
      }
    });
  }

  const Context& context_;
  const HalfEdgeMesh& mesh_;
  const CreaseInput& input_;
  // Edges between large fans.
  std::map<std::pair<Index, Index>, Index> found_;
  std::size_t walked_ = 0;
  Sharpness out_;
};

absl::Status RefineValues(const Context& context, const HalfEdgeMesh& mesh,
                          const HalfEdgeMesh& refined, const Sharpness& in, Sharpness* out) {
  out->edge.assign(refined.edge_count(), 0);
  out->vertex.assign(refined.vertex_count(), 0);
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.vertex_count(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) out->vertex[v] = Worn(in.vertex[v]);
      }));
  const bool quads = refined.arity() == 4;
  return WithWalk(mesh, [&](auto walk) {
    return ParallelFor(context, mesh.edge_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        if (!(in.edge[e] > 0)) continue;
        const Index h = mesh.edge_half_edge()[e];
        const Index next = walk.Next(h);
        const Index near_half = quads ? 4 * h : 3 * CornerTriangle(h);
        const Index far_half = quads ? 4 * next + 3 : 3 * CornerTriangle(next) + 2;
        out->edge[refined.edge()[near_half]] = Worn(in.edge[e]);
        out->edge[refined.edge()[far_half]] = Worn(in.edge[e]);
      }
    });
  });
}

absl::Status RefineHoles(const Context& context, const HalfEdgeMesh& mesh,
                         const HalfEdgeMesh& refined, const Buffer<std::uint8_t>& in,
                         Buffer<std::uint8_t>* out) {
  out->resize(refined.face_count());
  const bool quads = refined.arity() == 4;
  return WithWalk(mesh, [&](auto walk) {
    return ParallelFor(context, refined.face_count(), [&](std::size_t begin, std::size_t end) {
      for (Index f = static_cast<Index>(begin); f < end; ++f) {
        (*out)[f] = in[quads ? walk.Face(f) : f / 4];
      }
    });
  });
}

}  // namespace

absl::StatusOr<Sharpness> MakeSharpness(const Context& context, const HalfEdgeMesh& mesh,
                                        const CreaseInput& input) {
  return SharpnessMaker(context, mesh, input).Make();
}

absl::StatusOr<Sharpness> RefineSharpness(const Context& context, const HalfEdgeMesh& mesh,
                                          const HalfEdgeMesh& refined, const Sharpness& sharpness) {
  LIMN_RETURN_IF_ERROR(context.Check());
  Sharpness out;
  out.boundary = sharpness.boundary;
  out.transient = Worn(sharpness.transient);
  out.lasting = sharpness.lasting;
  if (sharpness.creased() && (out.transient > 0 || out.lasting)) {
    LIMN_RETURN_IF_ERROR(RefineValues(context, mesh, refined, sharpness, &out));
  }
  if (!sharpness.hole.empty()) {
    LIMN_RETURN_IF_ERROR(RefineHoles(context, mesh, refined, sharpness.hole, &out.hole));
  }
  return out;
}

}  // namespace limn
