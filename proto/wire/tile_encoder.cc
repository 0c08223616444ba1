// SPDX-License-Identifier: MIT
// EncodeTile: a run of a tessellation -> SurfaceTile.
#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/draco_encoder.h"
#include "proto/wire/tile_codec.h"
#include "proto/wire/tile_options.h"

namespace limn::wire {
namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(Vec3) == 24);

absl::Status BadRange(const char* what, std::uint64_t end, std::uint64_t size) {
  return MakeError(
      absl::StrCat("the tile's ", what, " end at ", end, ", but the surface has ", size),
      {.reason = Reason::kInvalidOption,
       .field = "range",
       .remedy = "Use the ranges that PlanTiles gives for this surface"});
}

absl::Status CheckRange(const Tessellation& surface, const TileRange& range) {
  const std::uint64_t vertices = surface.vertex_count();
  const std::uint64_t faces = surface.face_count();
  if (range.vertex_count > vertices || range.first_vertex > vertices - range.vertex_count) {
    return BadRange("vertices", range.first_vertex + range.vertex_count, vertices);
  }
  if (range.face_count > faces || range.first_face > faces - range.face_count) {
    return BadRange("faces", range.first_face + range.face_count, faces);
  }
  return absl::OkStatus();
}

// The range's faces as a mesh of their own: face_begin from 0, corners with global numbers.
struct TileFaces {
  Buffer<Index> face_begin;
  absl::Span<const Index> corners;
};

TileFaces SliceFaces(const Tessellation& surface, const TileRange& range) {
  TileFaces faces;
  const auto begin_of = [&](std::uint64_t f) -> std::uint64_t {
    return surface.arity != 0 ? f * surface.arity : surface.face_begin[f];
  };
  const std::uint64_t first = range.face_count == 0 ? 0 : begin_of(range.first_face);
  faces.face_begin.resize(range.face_count + 1);
  faces.face_begin[0] = 0;
  for (std::uint64_t i = 1; i <= range.face_count; ++i) {
    faces.face_begin[i] = static_cast<Index>(begin_of(range.first_face + i) - first);
  }
  faces.corners =
      absl::MakeConstSpan(surface.face_vertices).subspan(first, faces.face_begin.back());
  return faces;
}

template <class T>
std::string Bytes(absl::Span<const T> values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

std::string NormalBytes(absl::Span<const Vec3> normals) {
  std::string bytes(normals.size() * 3 * sizeof(float), '\0');
  char* out = bytes.data();
  for (const Vec3& n : normals) {
    const float v[3] = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
    std::memcpy(out, v, sizeof(v));
    out += sizeof(v);
  }
  return bytes;
}

void FillPacked(const Tessellation& surface, const TileRange& range, const TileFaces& faces,
                v1::SurfaceTile* tile) {
  tile->set_first_vertex(range.first_vertex);
  tile->set_vertex_count(static_cast<std::uint32_t>(range.vertex_count));
  tile->set_positions(Bytes(
      absl::MakeConstSpan(surface.positions).subspan(range.first_vertex, range.vertex_count)));
  if (!surface.normals.empty()) {
    tile->set_normals(NormalBytes(
        absl::MakeConstSpan(surface.normals).subspan(range.first_vertex, range.vertex_count)));
  }
  tile->set_face_vertices(Bytes(faces.corners));
  if (surface.arity != 0) return;
  std::vector<std::uint32_t> arities;
  for (std::size_t f = 0; f < range.face_count; ++f) {
    arities.push_back(faces.face_begin[f + 1] - faces.face_begin[f]);
  }
  tile->set_arities(Bytes(absl::MakeConstSpan(arities)));
}

// The vertices that a tile's faces use, in the order of their global numbers.
struct LocalMesh {
  std::vector<Index> ids;
  Buffer<Index> corners;
  Buffer<Vec3> positions;
  Buffer<Vec3> normals;
};

absl::StatusOr<LocalMesh> Gather(const Tessellation& surface, absl::Span<const Index> corners) {
  LocalMesh local;
  local.ids.assign(corners.begin(), corners.end());
  std::sort(local.ids.begin(), local.ids.end());
  local.ids.erase(std::unique(local.ids.begin(), local.ids.end()), local.ids.end());
  if (!local.ids.empty() && local.ids.back() >= surface.vertex_count()) {
    return BadRange("corners", local.ids.back(), surface.vertex_count());
  }
  local.corners.reserve(corners.size());
  for (const Index corner : corners) {
    const auto at = std::lower_bound(local.ids.begin(), local.ids.end(), corner);
    local.corners.push_back(static_cast<Index>(at - local.ids.begin()));
  }
  for (const Index id : local.ids) {
    local.positions.push_back(surface.positions[id]);
    if (!surface.normals.empty()) local.normals.push_back(surface.normals[id]);
  }
  return local;
}

absl::Status FillDraco(const Context& context, const Tessellation& surface, const TileFaces& faces,
                       const TileOptions& options, v1::SurfaceTile* tile) {
  LIMN_ASSIGN_OR_RETURN(const LocalMesh local, Gather(surface, faces.corners));
  tile->set_vertex_count(static_cast<std::uint32_t>(local.ids.size()));
  if (local.ids.empty()) return absl::OkStatus();
  const DracoInput input = {.faces = {local.ids.size(), faces.face_begin, local.corners},
                            .positions = local.positions,
                            .normals = local.normals,
                            .original_ids = local.ids};
  absl::StatusOr<std::string> bytes;
  if (options.encoding == v1::MESH_ENCODING_DRACO) {
    bytes = EncodeDracoLossless(context, input);
  } else {
    std::optional<QuantizationGrid> grid = options.grid;
    if (!grid.has_value()) {
      LIMN_ASSIGN_OR_RETURN(grid, FitGrid(context, surface.positions, surface.normals));
    }
    bytes = EncodeDracoQuantized(context, input, *grid, options.quantization_bits);
  }
  LIMN_RETURN_IF_ERROR(bytes.status());
  tile->set_draco(*std::move(bytes));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::SurfaceTile> EncodeTile(const Context& context, const Tessellation& surface,
                                           const TileRange& range, std::uint32_t index,
                                           const TileOptions& options) {
  return Guarded("encoding a tile", Reason::kInternal, [&]() -> absl::StatusOr<v1::SurfaceTile> {
    LIMN_RETURN_IF_ERROR(CheckTileOptions(options));
    LIMN_RETURN_IF_ERROR(CheckRange(surface, range));
    LIMN_RETURN_IF_ERROR(context.Check());
    const TileFaces faces = SliceFaces(surface, range);
    v1::SurfaceTile tile;
    tile.set_index(index);
    tile.set_encoding(options.encoding == v1::MESH_ENCODING_UNSPECIFIED ? v1::MESH_ENCODING_PACKED
                                                                        : options.encoding);
    tile.set_first_face(range.first_face);
    tile.set_face_count(static_cast<std::uint32_t>(range.face_count));
    tile.set_arity(surface.arity);
    if (IsDracoTile(options.encoding)) {
      LIMN_RETURN_IF_ERROR(FillDraco(context, surface, faces, options, &tile));
    } else {
      FillPacked(surface, range, faces, &tile);
    }
    LIMN_RETURN_IF_ERROR(context.Check());
    return tile;
  });
}

}  // namespace limn::wire
