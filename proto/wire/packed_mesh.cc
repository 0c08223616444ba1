// SPDX-License-Identifier: MIT
// See packed_mesh.h.
#include "proto/wire/packed_mesh.h"

#include <bit>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn::wire {
namespace {

// Arrays travel as they lie in memory.
static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(Vec3) == 24 && sizeof(Index) == 4);

// Bytes per chunk of a parallel copy.
constexpr std::size_t kCopyGrain = std::size_t{256} << 10;

absl::Status Copy(const Context& context, const void* from, std::size_t bytes, void* to) {
  return ParallelFor(context, bytes, kCopyGrain, [&](std::size_t begin, std::size_t end) {
    std::memcpy(static_cast<char*>(to) + begin, static_cast<const char*>(from) + begin,
                end - begin);
  });
}

Index ArityAt(const char* arities, std::size_t face) {
  Index arity;
  std::memcpy(&arity, arities + face * sizeof(Index), sizeof(Index));
  return arity;
}

// Sums the arities into face_begin; the sum is taken in 64 bits and has to be `corners`.
absl::Status ReadArities(const Context& context, const char* arities, std::uint64_t corners,
                         Buffer<Index>* face_begin) {
  std::uint64_t total = 0;
  LIMN_RETURN_IF_ERROR(ParallelNumber(
      context, face_begin->size() - 1,
      [&](std::size_t begin, std::size_t end) {
        std::uint64_t sum = 0;
        for (std::size_t f = begin; f < end; ++f) sum += ArityAt(arities, f);
        return sum;
      },
      [&](std::size_t begin, std::size_t end, std::uint64_t first) {
        for (std::size_t f = begin; f < end; ++f) {
          (*face_begin)[f] = static_cast<Index>(first);
          first += ArityAt(arities, f);
        }
      },
      &total));
  if (total != corners) {
    return MakeError(absl::StrCat("the faces' arities sum to ", total,
                                  ", but the header's corner_count is ", corners),
                     {.reason = Reason::kMalformedEncoding,
                      .field = "mesh.corner_count",
                      .remedy = "Set corner_count to the sum of the arities"});
  }
  face_begin->back() = static_cast<Index>(corners);
  return absl::OkStatus();
}

}  // namespace

std::uint64_t PackedBytes(const MeshCounts& counts) {
  return sizeof(Vec3) * counts.vertices + sizeof(Index) * (counts.faces + counts.corners);
}

absl::StatusOr<std::string> EncodePacked(const Context& context, const PolygonMesh& mesh) {
  std::string bytes;
  bytes.resize(PackedBytes({mesh.vertex_count(), mesh.face_count(), mesh.corner_count()}));
  char* const arities = bytes.data() + sizeof(Vec3) * mesh.vertex_count();
  char* const corners = arities + sizeof(Index) * mesh.face_count();
  LIMN_RETURN_IF_ERROR(
      Copy(context, mesh.positions.data(), sizeof(Vec3) * mesh.vertex_count(), bytes.data()));
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.face_count(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          const Index arity = static_cast<Index>(mesh.arity(f));
          std::memcpy(arities + f * sizeof(Index), &arity, sizeof(Index));
        }
      }));
  LIMN_RETURN_IF_ERROR(
      Copy(context, mesh.corner_vertex.data(), sizeof(Index) * mesh.corner_count(), corners));
  return bytes;
}

absl::StatusOr<PolygonMesh> DecodePacked(const Context& context, const MeshCounts& counts,
                                         std::string_view bytes) {
  if (bytes.size() != PackedBytes(counts)) {
    return MakeError(absl::StrCat("the packed mesh has ", bytes.size(),
                                  " bytes, but its header's counts need ", PackedBytes(counts)),
                     {.reason = Reason::kMalformedEncoding,
                      .field = "mesh.byte_count",
                      .remedy = "Send 24 bytes per vertex and 4 per face and per corner"});
  }
  const char* const arities = bytes.data() + sizeof(Vec3) * counts.vertices;
  const char* const corners = arities + sizeof(Index) * counts.faces;
  PolygonMesh mesh;
  mesh.face_begin.resize(counts.faces + 1);
  LIMN_RETURN_IF_ERROR(ReadArities(context, arities, counts.corners, &mesh.face_begin));
  mesh.positions.resize(counts.vertices);
  mesh.corner_vertex.resize(counts.corners);
  LIMN_RETURN_IF_ERROR(
      Copy(context, bytes.data(), sizeof(Vec3) * counts.vertices, mesh.positions.data()));
  LIMN_RETURN_IF_ERROR(
      Copy(context, corners, sizeof(Index) * counts.corners, mesh.corner_vertex.data()));
  return mesh;
}

}  // namespace limn::wire
