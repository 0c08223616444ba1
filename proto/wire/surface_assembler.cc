// SPDX-License-Identifier: MIT
// SurfaceAssembler: tiles -> the tessellation they were cut from.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/tile_codec.h"

namespace limn::wire {
namespace {

absl::Status Malformed(const char* field, const std::string& message) {
  return MakeError(message, {.reason = Reason::kMalformedEncoding, .field = field});
}

std::uint64_t IdOf(const DecodedTile& tile, std::size_t i) {
  return tile.vertex_ids.empty() ? tile.first_vertex + i : tile.vertex_ids[i];
}

// One more than the largest vertex number, and the number of vertices that came.
struct VertexRange {
  std::uint64_t end = 0;
  std::uint64_t came = 0;
  bool any_normals = false;
};

VertexRange FindRange(const std::vector<DecodedTile>& tiles) {
  VertexRange range;
  for (const DecodedTile& tile : tiles) {
    if (tile.positions.empty()) continue;
    range.came += tile.positions.size();
    range.end = std::max(range.end, IdOf(tile, tile.positions.size() - 1) + 1);
    range.any_normals = range.any_normals || !tile.normals.empty();
  }
  return range;
}

// Runs never overlap; Draco tiles share the vertices of their rims.
absl::Status PlaceVertices(const DecodedTile& tile, std::vector<bool>* placed,
                           Tessellation* surface) {
  const bool with_normals = !surface->normals.empty();
  if (with_normals && tile.normals.size() != tile.positions.size()) {
    return Malformed("normals", "some tiles have normals and others have not");
  }
  for (std::size_t i = 0; i < tile.positions.size(); ++i) {
    const std::uint64_t id = IdOf(tile, i);
    if ((*placed)[id]) continue;
    (*placed)[id] = true;
    surface->positions[id] = tile.positions[i];
    if (with_normals) surface->normals[id] = tile.normals[i];
  }
  return absl::OkStatus();
}

absl::Status BuildVertices(const std::vector<DecodedTile>& tiles, Tessellation* surface) {
  const VertexRange range = FindRange(tiles);
  // Before anything is allocated: the numbers must be covered by what came.
  if (range.end > range.came) {
    return Malformed("vertices", absl::StrCat("vertices up to ", range.end, " are named, but ",
                                              range.came, " came: tiles are missing"));
  }
  surface->positions.resize(range.end);
  if (range.any_normals) surface->normals.resize(range.end);
  std::vector<bool> placed(range.end);
  for (const DecodedTile& tile : tiles) {
    LIMN_RETURN_IF_ERROR(PlaceVertices(tile, &placed, surface));
  }
  const auto missing = std::find(placed.begin(), placed.end(), false);
  if (missing != placed.end()) {
    return Malformed("vertices", absl::StrCat("no tile brought vertex ", missing - placed.begin()));
  }
  return absl::OkStatus();
}

absl::Status CheckOverlap(const std::vector<DecodedTile>& tiles) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> runs;
  for (const DecodedTile& tile : tiles) {
    // Draco tiles bring faces with their vertices; only pure runs must not overlap.
    if (tile.is_run && !tile.positions.empty()) {
      runs.emplace_back(tile.first_vertex, tile.first_vertex + tile.positions.size());
    }
  }
  std::sort(runs.begin(), runs.end());
  for (std::size_t i = 1; i < runs.size(); ++i) {
    if (runs[i].first < runs[i - 1].second) {
      return Malformed("vertices",
                       absl::StrCat("vertex ", runs[i].first, " comes with more than one tile"));
    }
  }
  return absl::OkStatus();
}

// tiles: in the order of their faces.
absl::Status BuildFaces(const std::vector<DecodedTile>& tiles, Tessellation* surface) {
  std::uint64_t next = 0;
  for (const DecodedTile& tile : tiles) {
    if (tile.arities.empty()) continue;
    if (tile.first_face != next) {
      return Malformed("faces", absl::StrCat("a tile begins with face ", tile.first_face,
                                             ", but the one before ends at ", next));
    }
    next += tile.arities.size();
    for (const std::uint32_t arity : tile.arities) {
      surface->face_begin.push_back(static_cast<Index>(surface->face_vertices.size()));
      surface->face_vertices.resize(surface->face_vertices.size() + arity);
    }
    std::copy(
        tile.face_vertices.begin(), tile.face_vertices.end(),
        surface->face_vertices.end() - static_cast<std::ptrdiff_t>(tile.face_vertices.size()));
    for (const std::uint32_t v : tile.face_vertices) {
      if (v >= surface->vertex_count()) {
        return Malformed("faces",
                         absl::StrCat("a face names vertex ", v, " of ", surface->vertex_count()));
      }
    }
  }
  return absl::OkStatus();
}

// face_begin of equal arities says nothing that `arity` does not.
void SetArity(Tessellation* surface) {
  if (surface->face_begin.empty()) return;
  surface->face_begin.push_back(static_cast<Index>(surface->face_vertices.size()));
  const Index arity = surface->face_begin[1];
  for (std::size_t f = 0; f + 1 < surface->face_begin.size(); ++f) {
    if (surface->face_begin[f + 1] - surface->face_begin[f] != arity) return;
  }
  surface->arity = arity;
  surface->face_begin.clear();
}

}  // namespace

SurfaceAssembler::SurfaceAssembler(std::uint64_t vertex_limit, std::uint64_t face_limit)
    : vertex_limit_(vertex_limit), face_limit_(face_limit) {}

absl::Status SurfaceAssembler::Add(const v1::SurfaceTile& tile) {
  return Guarded("receiving the surface", Reason::kInternal, [&]() -> absl::Status {
    LIMN_ASSIGN_OR_RETURN(DecodedTile decoded, DecodeTile(tile));
    if (!decoded.positions.empty() &&
        IdOf(decoded, decoded.positions.size() - 1) >= vertex_limit_) {
      return Malformed("vertices", absl::StrCat("the surface has more than the ", vertex_limit_,
                                                " vertices that it can have"));
    }
    faces_ += decoded.arities.size();
    corners_ += decoded.face_vertices.size();
    if (faces_ > face_limit_ || corners_ >= kNoIndex) {
      return Malformed("faces", absl::StrCat("the surface has more than the ", face_limit_,
                                             " faces that it can have"));
    }
    tiles_.push_back(std::move(decoded));
    return absl::OkStatus();
  });
}

absl::StatusOr<Tessellation> SurfaceAssembler::Finish() {
  return Guarded(
      "putting the surface together", Reason::kInternal, [&]() -> absl::StatusOr<Tessellation> {
        std::vector<DecodedTile> tiles = std::exchange(tiles_, {});
        faces_ = corners_ = 0;
        std::stable_sort(
            tiles.begin(), tiles.end(),
            [](const DecodedTile& a, const DecodedTile& b) { return a.first_face < b.first_face; });
        Tessellation surface;
        LIMN_RETURN_IF_ERROR(CheckOverlap(tiles));
        LIMN_RETURN_IF_ERROR(BuildVertices(tiles, &surface));
        LIMN_RETURN_IF_ERROR(BuildFaces(tiles, &surface));
        SetArity(&surface);
        return surface;
      });
}

}  // namespace limn::wire
