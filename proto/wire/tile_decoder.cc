// SPDX-License-Identifier: MIT
// DecodeTile: SurfaceTile -> runs of vertices and faces.
#include <bit>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/draco_decoder.h"
#include "proto/wire/polygon_check.h"
#include "proto/wire/tile_codec.h"
#include "proto/wire/tile_options.h"

namespace limn::wire {
namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(Vec3) == 24);

// Triangles of a Draco tile at the most; kMaxTileBytes holds fewer.
constexpr std::uint64_t kMaxTileTriangles = kMaxTileBytes / 4;

absl::Status Malformed(const char* field, const std::string& message) {
  return MakeError(message,
                   {.reason = Reason::kMalformedEncoding, .field = absl::StrCat("tile.", field)});
}

absl::Status WrongSize(const char* field, std::size_t bytes, std::uint64_t expected) {
  return Malformed(
      field, absl::StrCat("a tile's ", field, " have ", bytes, " bytes instead of ", expected));
}

template <class T>
std::vector<T> Values(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

// Numbers are Index, so a run must end within its range.
absl::Status CheckRuns(const v1::SurfaceTile& tile) {
  const auto fits = [](std::uint64_t first, std::uint64_t count) {
    return first <= kNoIndex && first + count <= kNoIndex;
  };
  if (!fits(tile.first_vertex(), tile.vertex_count())) {
    return Malformed("first_vertex", "a tile's vertices end beyond 2^32");
  }
  if (!fits(tile.first_face(), tile.face_count())) {
    return Malformed("first_face", "a tile's faces end beyond 2^32");
  }
  if (tile.arity() == 1 || tile.arity() == 2) {
    return Malformed("arity", absl::StrCat("a tile has faces of ", tile.arity(), " sides"));
  }
  return absl::OkStatus();
}

absl::Status ReadPackedVertices(const v1::SurfaceTile& tile, DecodedTile* out) {
  const std::uint64_t count = tile.vertex_count();
  if (tile.positions().size() != count * sizeof(Vec3)) {
    return WrongSize("positions", tile.positions().size(), count * sizeof(Vec3));
  }
  if (!tile.normals().empty() && tile.normals().size() != count * 3 * sizeof(float)) {
    return WrongSize("normals", tile.normals().size(), count * 3 * sizeof(float));
  }
  out->first_vertex = tile.first_vertex();
  out->positions = Values<Vec3>(tile.positions());
  const std::vector<float> normals = Values<float>(tile.normals());
  out->normals.reserve(normals.size() / 3);
  for (std::size_t i = 0; i + 2 < normals.size(); i += 3) {
    out->normals.push_back({normals[i], normals[i + 1], normals[i + 2]});
  }
  return absl::OkStatus();
}

absl::Status ReadPackedFaces(const v1::SurfaceTile& tile, DecodedTile* out) {
  const std::uint64_t count = tile.face_count();
  std::uint64_t corners = count * tile.arity();
  if (tile.arity() == 0) {
    if (tile.arities().size() != count * sizeof(std::uint32_t)) {
      return WrongSize("arities", tile.arities().size(), count * sizeof(std::uint32_t));
    }
    out->arities = Values<std::uint32_t>(tile.arities());
    for (const std::uint32_t arity : out->arities) {
      if (arity < 3) return Malformed("arities", absl::StrCat("a face has ", arity, " sides"));
      corners += arity;
    }
  } else if (!tile.arities().empty()) {
    return WrongSize("arities", tile.arities().size(), 0);
  }
  // Divided, not multiplied: face_count times arity may be anything yet.
  if (tile.face_vertices().size() % sizeof(std::uint32_t) != 0 ||
      tile.face_vertices().size() / sizeof(std::uint32_t) != corners) {
    return Malformed("face_vertices",
                     absl::StrCat("a tile's face_vertices have ", tile.face_vertices().size(),
                                  " bytes for ", corners, " corners"));
  }
  // Only now is face_count known to be honest.
  if (tile.arity() != 0) out->arities.assign(count, tile.arity());
  out->face_vertices = Values<std::uint32_t>(tile.face_vertices());
  return absl::OkStatus();
}

absl::Status CheckDracoCounts(const v1::SurfaceTile& tile, const DecodedTile& out) {
  if (out.positions.size() != tile.vertex_count() || out.arities.size() != tile.face_count()) {
    return Malformed(
        "draco", absl::StrCat("a tile's Draco mesh has ", out.positions.size(), " vertices and ",
                              out.arities.size(), " faces instead of ", tile.vertex_count(),
                              " and ", tile.face_count()));
  }
  for (const std::uint32_t arity : out.arities) {
    if (tile.arity() != 0 && arity != tile.arity()) {
      return Malformed("draco", absl::StrCat("a tile's Draco mesh has a face of ", arity,
                                             " sides instead of ", tile.arity()));
    }
  }
  return absl::OkStatus();
}

absl::Status ReadDracoTile(const v1::SurfaceTile& tile, DecodedTile* out) {
  if (tile.face_count() == 0 && tile.vertex_count() == 0 && tile.draco().empty()) {
    return absl::OkStatus();
  }
  const DracoBounds bounds = {.max_vertices = tile.vertex_count(),
                              .max_triangles = kMaxTileTriangles,
                              .max_bytes = std::numeric_limits<std::uint64_t>::max(),
                              .want_normals = true};
  LIMN_ASSIGN_OR_RETURN(const DracoOutput draco, DecodeDraco(Context(), tile.draco(), bounds));
  LIMN_RETURN_IF_ERROR(CheckPolygons(Context(), draco.mesh, kReceived));
  // Ids 0, 1, 2 ... are not written out.
  out->is_run = false;
  out->vertex_ids.assign(draco.original_ids.begin(), draco.original_ids.end());
  out->positions.assign(draco.mesh.positions.begin(), draco.mesh.positions.end());
  out->normals.assign(draco.normals.begin(), draco.normals.end());
  out->face_vertices.reserve(draco.mesh.corner_count());
  for (const Index v : draco.mesh.corner_vertex) {
    out->face_vertices.push_back(out->vertex_ids.empty() ? v : out->vertex_ids[v]);
  }
  for (std::size_t f = 0; f < draco.mesh.face_count(); ++f) {
    out->arities.push_back(static_cast<std::uint32_t>(draco.mesh.arity(f)));
  }
  return CheckDracoCounts(tile, *out);
}

}  // namespace

absl::StatusOr<DecodedTile> DecodeTile(const v1::SurfaceTile& tile) {
  return Guarded(
      "decoding a tile", Reason::kMalformedEncoding, [&]() -> absl::StatusOr<DecodedTile> {
        LIMN_RETURN_IF_ERROR(CheckRuns(tile));
        DecodedTile out;
        out.first_face = tile.first_face();
        if (IsDracoTile(tile.encoding())) {
          LIMN_RETURN_IF_ERROR(ReadDracoTile(tile, &out));
          return out;
        }
        if (!v1::MeshEncoding_IsValid(tile.encoding())) {
          return Malformed("encoding",
                           absl::StrCat("tile encoding ", tile.encoding(), " is not known"));
        }
        LIMN_RETURN_IF_ERROR(ReadPackedVertices(tile, &out));
        LIMN_RETURN_IF_ERROR(ReadPackedFaces(tile, &out));
        return out;
      });
}

}  // namespace limn::wire
