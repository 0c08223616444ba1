// SPDX-License-Identifier: MIT
// PlanTiles: which vertices and faces go into which tile.
#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/tile_codec.h"
#include "proto/wire/tile_options.h"

namespace limn::wire {
namespace {

constexpr std::uint64_t kPositionBytes = 24;
constexpr std::uint64_t kNormalBytes = 12;
constexpr std::uint64_t kIndexBytes = 4;

absl::Status InvalidOption(const char* field, const std::string& message,
                           const std::string& remedy) {
  return MakeError(message, {.reason = Reason::kInvalidOption, .field = field, .remedy = remedy});
}

std::uint64_t VertexBytes(bool normals) { return kPositionBytes + (normals ? kNormalBytes : 0); }
std::uint64_t VertexBytes(const Tessellation& surface) {
  return VertexBytes(!surface.normals.empty());
}

// What a face of a Draco tile adds per corner.
std::uint64_t DracoCornerBytes(std::uint64_t vertex_bytes) {
  return vertex_bytes + 2 * kIndexBytes;
}
// Of a packed tile's bytes, what is kept for the other kind of run.
constexpr std::uint64_t kLeastShare = 64;

// Bytes that a face of this arity adds to a tile at the most. A Draco tile brings a face's vertices
// along, each with its number; how many of them other faces share is not known in advance.
std::uint64_t FaceBytes(const Tessellation& surface, bool draco, std::uint64_t arity) {
  const std::uint64_t arity_bytes = surface.arity == 0 || draco ? kIndexBytes : 0;
  const std::uint64_t corner = draco ? DracoCornerBytes(VertexBytes(surface)) : kIndexBytes;
  return arity_bytes + arity * corner;
}

absl::Status FaceTooLarge(std::uint64_t face, std::uint64_t bytes) {
  return MakeError(absl::StrCat("face ", face, " takes ", bytes, " bytes, more than a tile"),
                   {.reason = Reason::kLimitExceeded,
                    .field = "faces",
                    .index = face,
                    .remedy = "Raise tile_bytes, ask for level 1 or more, or omit connectivity"});
}

std::uint64_t LargestFaceBytes(const Tessellation& surface) {
  std::uint64_t arity = surface.arity;
  for (std::size_t f = 0; f + 1 < surface.face_begin.size(); ++f) {
    arity = std::max<std::uint64_t>(arity, surface.face_begin[f + 1] - surface.face_begin[f]);
  }
  return FaceBytes(surface, false, arity);
}

// Runs of faces that take up to `capacity` bytes each.
absl::Status CutFaces(const Tessellation& surface, bool draco, std::uint64_t capacity,
                      std::vector<TileRange>* tiles) {
  const std::uint64_t faces = surface.face_count();
  if (surface.arity != 0) {
    const std::uint64_t run = capacity / FaceBytes(surface, draco, surface.arity);
    if (run == 0) return FaceTooLarge(0, FaceBytes(surface, draco, surface.arity));
    for (std::uint64_t f = 0; f < faces; f += run) {
      tiles->push_back({.first_face = f, .face_count = std::min(run, faces - f)});
    }
    return absl::OkStatus();
  }
  std::uint64_t used = capacity;
  for (std::uint64_t f = 0; f < faces; ++f) {
    const std::uint64_t arity = surface.face_begin[f + 1] - surface.face_begin[f];
    const std::uint64_t bytes = FaceBytes(surface, draco, arity);
    if (bytes > capacity) return FaceTooLarge(f, bytes);
    if (used + bytes > capacity) {
      tiles->push_back({.first_face = f});
      used = 0;
    }
    ++tiles->back().face_count;
    used += bytes;
  }
  return absl::OkStatus();
}

// Spreads the vertices evenly over the tiles, in order; `per_tile` is what a tile has room for.
void CutVertices(std::uint64_t vertices, std::uint64_t per_tile, std::vector<TileRange>* tiles) {
  tiles->resize(std::max<std::uint64_t>(tiles->size(), (vertices + per_tile - 1) / per_tile),
                TileRange{});
  std::uint64_t first = 0;
  std::uint64_t next_face = 0;
  for (std::size_t i = 0; i < tiles->size(); ++i) {
    TileRange& tile = (*tiles)[i];
    const std::uint64_t left = tiles->size() - i;
    tile.first_vertex = first;
    tile.vertex_count = (vertices - first + left - 1) / left;
    first += tile.vertex_count;
    if (tile.face_count == 0) tile.first_face = next_face;
    next_face = tile.first_face + tile.face_count;
  }
}

// A tile of capacity n holds runs of both kinds; both get the part of it that they are of the
// whole.
absl::StatusOr<std::vector<TileRange>> PlanPacked(const Tessellation& surface,
                                                  const TileOptions& options) {
  std::vector<TileRange> tiles;
  const std::uint64_t vertex_bytes = VertexBytes(surface);
  if (options.omit_connectivity) {
    CutVertices(surface.vertex_count(), options.tile_bytes / vertex_bytes, &tiles);
    return tiles;
  }
  const std::uint64_t all_vertices = surface.vertex_count() * vertex_bytes;
  const std::uint64_t all_faces =
      kIndexBytes * (surface.face_vertices.size() + surface.face_begin.size());
  const std::uint64_t all = std::max<std::uint64_t>(1, all_vertices + all_faces);
  // Never all of it, so that the other kind always advances; room for the largest face if possible.
  const std::uint64_t share = options.tile_bytes * all_faces / all;
  const std::uint64_t for_faces = std::clamp<std::uint64_t>(
      std::max(share, LargestFaceBytes(surface)), kLeastShare, options.tile_bytes - kLeastShare);
  LIMN_RETURN_IF_ERROR(CutFaces(surface, false, for_faces, &tiles));
  CutVertices(surface.vertex_count(), (options.tile_bytes - for_faces) / vertex_bytes, &tiles);
  return tiles;
}

}  // namespace

bool IsDracoTile(v1::MeshEncoding encoding) {
  return encoding == v1::MESH_ENCODING_DRACO || encoding == v1::MESH_ENCODING_DRACO_QUANTIZED;
}

absl::Status CheckTileOptions(const TileOptions& options) {
  if (!v1::MeshEncoding_IsValid(options.encoding)) {
    return InvalidOption("encoding",
                         absl::StrCat("tile encoding ", options.encoding, " is not known"),
                         "Use MESH_ENCODING_PACKED");
  }
  if (options.encoding == v1::MESH_ENCODING_DRACO_QUANTIZED &&
      (options.quantization_bits < kMinQuantizationBits ||
       options.quantization_bits > kMaxQuantizationBits)) {
    return InvalidOption("quantization_bits",
                         absl::StrCat("quantization_bits is ", options.quantization_bits),
                         absl::StrCat("Use ", kMinQuantizationBits, " to ", kMaxQuantizationBits));
  }
  if (options.tile_bytes < kMinTileBytes || options.tile_bytes > kMaxTileBytes) {
    return InvalidOption("tile_bytes", absl::StrCat("tile_bytes is ", options.tile_bytes),
                         absl::StrCat("Use ", kMinTileBytes, " to ", kMaxTileBytes));
  }
  if (options.omit_connectivity && IsDracoTile(options.encoding)) {
    return InvalidOption("omit_connectivity",
                         "a Draco tile cannot be sent without its connectivity",
                         "Use MESH_ENCODING_PACKED, or do not set omit_connectivity");
  }
  return absl::OkStatus();
}

absl::Status FitLargestFace(const PolygonMesh& mesh, bool normals, TileOptions* options) {
  if (options->omit_connectivity) return absl::OkStatus();
  std::uint64_t arity = 0;
  std::uint64_t face = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.arity(f) <= arity) continue;
    arity = mesh.arity(f);
    face = f;
  }
  const std::uint64_t corner =
      IsDracoTile(options->encoding) ? DracoCornerBytes(VertexBytes(normals)) : kIndexBytes;
  const std::uint64_t bytes = kIndexBytes + arity * corner + kLeastShare;
  if (bytes > kMaxTileBytes) {
    return MakeError(absl::StrCat("face ", face, " of ", arity,
                                  " corners is larger than a message of the surface"),
                     {.reason = Reason::kInvalidOption,
                      .field = "surface.level",
                      .index = face,
                      .remedy = "Ask for level 1 or more, whose faces are quads"});
  }
  options->tile_bytes = std::max(options->tile_bytes, static_cast<std::uint32_t>(bytes));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<TileRange>> PlanTiles(const Tessellation& surface,
                                                 const TileOptions& options) {
  LIMN_RETURN_IF_ERROR(CheckTileOptions(options));
  if (!IsDracoTile(options.encoding)) return PlanPacked(surface, options);
  std::vector<TileRange> tiles;
  LIMN_RETURN_IF_ERROR(CutFaces(surface, true, options.tile_bytes, &tiles));
  return tiles;
}

}  // namespace limn::wire
