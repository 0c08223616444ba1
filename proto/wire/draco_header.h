// SPDX-License-Identifier: MIT
// What a Draco mesh claims to hold, read before Draco's decoder sees it: 66 bytes that claim 1e8
// triangles would cost gigabytes and seconds there.
//
// Layout (bitstream 2.2, the only one taken; Draco writes it since 2018):
//   "DRACO", major u8, minor u8, geometry u8 (1 mesh), method u8 (0 sequential, 1 edgebreaker),
//   flags u16 (bit 15: metadata follow), metadata,
//   sequential:  triangles, points (varint), index coding u8, ...
//   edgebreaker: traversal u8 (0 standard, 2 valence), vertices, triangles (varint),
//                attributes beside the position u8, symbols, split symbols (varint), ...
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace limn::wire {

// Names under which Limn's data stand in a Draco mesh; see mesh.proto.
inline constexpr char kAritiesEntry[] = "limn.arities";
inline constexpr char kOriginalIdName[] = "original_id";
inline constexpr char kAddedEdgesName[] = "added_edges";

// What may be decoded at the most.
struct DracoBounds {
  std::uint64_t max_vertices = 0;
  std::uint64_t max_triangles = 0;
  // Whether the sender itself claimed max_triangles: more is then MALFORMED_ENCODING.
  bool triangles_claimed = false;
  // Bytes that Draco may need for it, by the estimate of DracoDecodeBytes.
  std::uint64_t max_bytes = 0;
  // Whether normals are wanted. Only of servers: their decoder is fenced less.
  bool want_normals = false;
};

// Attributes, position included, that a Draco mesh may have; more are refused.
inline constexpr int kMaxDracoAttributes = 8;
// Components of an attribute at the most.
inline constexpr int kMaxDracoComponents = 4;
// Bytes of a value of all attributes together, each component counted with the 4 bytes of the
// integer that may stand for it: positions of doubles, normals, texture coordinates and colours
// fit.
inline constexpr int kMaxDracoValueBytes = 128;

struct DracoHeader {
  bool edgebreaker = false;
  std::uint64_t triangles = 0;
  // Points (sequential) or vertices with those that splits make (edgebreaker).
  std::uint64_t vertices = 0;
  // Attributes with their own connectivity (edgebreaker).
  std::uint32_t attribute_connectivities = 0;
};

// Reads the header and the claims behind the metadata, and holds them against the number of bytes
// that are there: a triangle takes 3 bytes in the sequential coding; a bit in the standard
// edgebreaker; half a bit, on average over the whole file, is asked of the valence edgebreaker.
// Metadata are walked with bounds on depth and number. Errors: MALFORMED_ENCODING. Cost: linear in
// the metadata; no memory.
[[nodiscard]] absl::StatusOr<DracoHeader> ReadDracoHeader(std::string_view bytes);

// Bytes that Draco's decoder and what is made from its mesh need at their peak, roughly.
[[nodiscard]] std::uint64_t DracoDecodeBytes(const DracoHeader& header);

// Holds the claims against the bounds. Errors: LIMIT_EXCEEDED; MALFORMED_ENCODING as said above.
[[nodiscard]] absl::Status CheckDracoHeader(const DracoHeader& header, const DracoBounds& bounds);

}  // namespace limn::wire
