// SPDX-License-Identifier: MIT
#include "engine/constraints/feature_values.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

constexpr std::size_t kEntriesPerCheck = 4096;

// One entry of a list, as errors name it.
struct Entry {
  std::string_view list;
  std::size_t index = 0;
  std::string_view member = "";

  Entry At(std::string_view of) const { return {list, index, of}; }
};

absl::Status Refuse(Reason reason, const Entry& entry, std::string_view message,
                    std::string_view remedy) {
  std::string field = absl::StrCat("constraints.features.", std::string(entry.list), "[",
                                   entry.index, "].", std::string(entry.member));
  std::string text = absl::StrCat(field, ": ", std::string(message));
  return MakeError(text, {.reason = reason,
                          .field = std::move(field),
                          .index = entry.index,
                          .remedy = std::string(remedy)});
}

// Written so that NaN is none.
bool IsValue(double value) { return value >= 0 && value <= 1; }

absl::Status CheckDefault(std::string_view name, double value) {
  if (IsValue(value)) return absl::OkStatus();
  std::string field = absl::StrCat("constraints.features.", std::string(name));
  std::string text = absl::StrCat(field, ": ", value, " is not a number from 0 to 1");
  return MakeError(text, {.reason = Reason::kInvalidOption,
                          .field = std::move(field),
                          .remedy = "Give a number from 0 to 1, or leave it out"});
}

class TableMaker {
 public:
  TableMaker(const Context& context, const HalfEdgeMesh& mesh, const FeatureValues& values)
      : context_(context), mesh_(mesh), walk_(mesh), values_(values) {}

  absl::StatusOr<FeatureTable> Run() {
    LIMN_RETURN_IF_ERROR(CheckDefault("default_edge", values_.default_edge));
    LIMN_RETURN_IF_ERROR(CheckDefault("default_vertex", values_.default_vertex));
    LIMN_RETURN_IF_ERROR(Fill(values_.default_edge, &table_.edge));
    LIMN_RETURN_IF_ERROR(Fill(values_.default_vertex, &table_.vertex));
    LIMN_RETURN_IF_ERROR(TakeFaces());
    if (!values_.edges.empty()) LIMN_RETURN_IF_ERROR(TakeEdges());
    if (!values_.vertices.empty()) LIMN_RETURN_IF_ERROR(TakeVertices());
    return std::move(table_);
  }

 private:
  // What has been named: a corner as such, and as one of its element's.
  static constexpr std::uint8_t kInFace = 1;
  static constexpr std::uint8_t kElement = 2;

  // One value per corner.
  absl::Status Fill(double value, Buffer<double>* values) const {
    values->resize(mesh_.half_edge_count());
    return ParallelFor(context_, values->size(), [&](std::size_t begin, std::size_t end) {
      std::fill(values->begin() + static_cast<std::ptrdiff_t>(begin),
                values->begin() + static_cast<std::ptrdiff_t>(end), value);
    });
  }

  absl::Status TakeFaces() {
    if (values_.has_planes()) {
      const bool plane = values_.default_face == FaceKind::kPlane;
      table_.plane.assign(mesh_.face_count(), plane ? 1 : 0);
    }
    if (values_.faces.empty()) return absl::OkStatus();
    std::vector<bool> named(mesh_.face_count(), false);
    for (std::size_t i = 0; i < values_.faces.size(); ++i) {
      if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      const Entry entry = {"faces", i, "face"};
      const Index face = values_.faces[i].face;
      LIMN_RETURN_IF_ERROR(CheckFace(entry, face));
      if (named[face]) return Repeated(entry, absl::StrCat("face ", face));
      named[face] = true;
      if (table_.plane.empty()) continue;
      table_.plane[face] = values_.faces[i].kind == FaceKind::kPlane ? 1 : 0;
    }
    bool any = false;
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context_, table_.plane.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t f = begin; f < end; ++f) any = any || table_.plane[f] != 0;
        }));
    if (!any) table_.plane.clear();
    return absl::OkStatus();
  }

  absl::Status TakeEdges() {
    named_.assign(mesh_.half_edge_count(), 0);
    for (std::size_t i = 0; i < values_.edges.size(); ++i) {
      if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      const Entry entry = {"edges", i};
      const EdgeFeature& wish = values_.edges[i];
      LIMN_RETURN_IF_ERROR(CheckVertex(entry.At("from"), wish.from));
      LIMN_RETURN_IF_ERROR(CheckVertex(entry.At("to"), wish.to));
      LIMN_RETURN_IF_ERROR(CheckValue(entry, wish.value));
      const Index h = EdgeBetween(wish.from, wish.to);
      if (h == kNoIndex) {
        return Refuse(Reason::kInvalidOption, entry.At("to"),
                      absl::StrCat("no edge joins vertices ", wish.from, " and ", wish.to),
                      "Name two vertices that are next to each other in a face");
      }
      const Index twin = mesh_.twin()[h];
      if (!wish.face.has_value()) {
        LIMN_RETURN_IF_ERROR(Take(entry, kElement, h, wish.value, &table_.edge));
        if (twin == kNoIndex) continue;
        LIMN_RETURN_IF_ERROR(Take(entry, kElement, twin, wish.value, &table_.edge));
        continue;
      }
      LIMN_RETURN_IF_ERROR(CheckFace(entry.At("face"), *wish.face));
      Index in_face = kNoIndex;
      if (mesh_.face()[h] == *wish.face) in_face = h;
      if (twin != kNoIndex && mesh_.face()[twin] == *wish.face) in_face = twin;
      if (in_face == kNoIndex) return NotInFace(entry, *wish.face);
      LIMN_RETURN_IF_ERROR(Take(entry, kInFace, in_face, wish.value, &table_.edge));
    }
    return absl::OkStatus();
  }

  absl::Status TakeVertices() {
    named_.assign(mesh_.half_edge_count(), 0);
    for (std::size_t i = 0; i < values_.vertices.size(); ++i) {
      if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      const Entry entry = {"vertices", i};
      const VertexFeature& wish = values_.vertices[i];
      LIMN_RETURN_IF_ERROR(CheckVertex(entry.At("vertex"), wish.vertex));
      LIMN_RETURN_IF_ERROR(CheckValue(entry, wish.value));
      if (!wish.face.has_value()) {
        for (const Index h : FanOf(wish.vertex)) {
          LIMN_RETURN_IF_ERROR(Take(entry, kElement, h, wish.value, &table_.vertex));
        }
        continue;
      }
      LIMN_RETURN_IF_ERROR(CheckFace(entry.At("face"), *wish.face));
      const Index h = CornerIn(*wish.face, wish.vertex);
      if (h == kNoIndex) return NotInFace(entry, *wish.face);
      LIMN_RETURN_IF_ERROR(Take(entry, kInFace, h, wish.value, &table_.vertex));
    }
    return absl::OkStatus();
  }

  // Sets the value at a corner, unless it has one of its own.
  absl::Status Take(const Entry& entry, std::uint8_t how, Index h, double value,
                    Buffer<double>* values) {
    if ((named_[h] & how) != 0) {
      const std::string_view element = entry.list == "edges" ? "from" : "vertex";
      return Repeated(entry.At(how == kInFace ? "face" : element), NameOf(entry));
    }
    named_[h] |= how;
    if (how == kInFace || (named_[h] & kInFace) == 0) (*values)[h] = value;
    return absl::OkStatus();
  }
  // What an entry of edges or vertices is about.
  std::string NameOf(const Entry& entry) const {
    if (entry.list == "vertices") {
      return absl::StrCat("vertex ", values_.vertices[entry.index].vertex);
    }
    const EdgeFeature& edge = values_.edges[entry.index];
    return absl::StrCat("the edge from ", edge.from, " to ", edge.to);
  }

  absl::Status CheckVertex(const Entry& entry, Index vertex) const {
    if (vertex < mesh_.vertex_count()) return absl::OkStatus();
    return Refuse(
        Reason::kIndexOutOfRange, entry,
        absl::StrCat("there is no vertex ", vertex, ", the mesh has ", mesh_.vertex_count()),
        "Vertices are counted from 0");
  }
  absl::Status CheckFace(const Entry& entry, Index face) const {
    if (face < mesh_.face_count()) return absl::OkStatus();
    return Refuse(Reason::kIndexOutOfRange, entry,
                  absl::StrCat("there is no face ", face, ", the mesh has ", mesh_.face_count()),
                  "Faces are counted from 0");
  }
  static absl::Status CheckValue(const Entry& entry, double value) {
    if (IsValue(value)) return absl::OkStatus();
    return Refuse(Reason::kInvalidOption, entry.At("value"),
                  absl::StrCat(value, " is not a number from 0 to 1"), "Give a number from 0 to 1");
  }
  static absl::Status Repeated(const Entry& entry, const std::string& name) {
    return Refuse(Reason::kInvalidOption, entry, absl::StrCat(name, " is named before"),
                  "Name each element once, and once in a face");
  }
  absl::Status NotInFace(const Entry& entry, Index face) const {
    return Refuse(Reason::kInvalidOption, entry.At("face"),
                  absl::StrCat(NameOf(entry), " is not in face ", face),
                  "Name a face that has it, or none for all of them");
  }

  absl::Span<const Index> FanOf(Index v) const {
    return mesh_.fan().subspan(mesh_.fan_begin()[v], mesh_.valence(v));
  }

  // A half-edge between two vertices, or kNoIndex.
  Index EdgeBetween(Index a, Index b) const {
    if (mesh_.valence(b) < mesh_.valence(a)) std::swap(a, b);
    for (const Index h : FanOf(a)) {
      if (mesh_.vertex()[walk_.Next(h)] == b) return h;
      if (mesh_.vertex()[walk_.Prev(h)] == b) return walk_.Prev(h);
    }
    return kNoIndex;
  }

  // The corner of a face at a vertex, or kNoIndex.
  Index CornerIn(Index face, Index v) const {
    const Index begin = walk_.FaceBegin(face);
    const Index end = walk_.FaceEnd(face);
    if (end - begin <= mesh_.valence(v)) {
      for (Index h = begin; h < end; ++h) {
        if (mesh_.vertex()[h] == v) return h;
      }
      return kNoIndex;
    }
    for (const Index h : FanOf(v)) {
      if (mesh_.face()[h] == face) return h;
    }
    return kNoIndex;
  }

  const Context& context_;
  const HalfEdgeMesh& mesh_;
  const PolygonWalk walk_;
  const FeatureValues& values_;
  Buffer<std::uint8_t> named_;
  FeatureTable table_;
};

}  // namespace

bool FeatureValues::has_planes() const {
  return default_face == FaceKind::kPlane ||
         std::any_of(faces.begin(), faces.end(),
                     [](const FaceFeature& f) { return f.kind == FaceKind::kPlane; });
}

absl::StatusOr<FeatureTable> MakeFeatureTable(const Context& context, const HalfEdgeMesh& mesh,
                                              const FeatureValues& values) {
  return TableMaker(context, mesh, values).Run();
}

}  // namespace limn
