// SPDX-License-Identifier: MIT
// The mapping from a repaired mesh to the input <-> pieces of limn.v1.RepairReport.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/interpolate.pb.h"

namespace limn::wire {

// Cuts a mapping into pieces: all vertices, then all faces. The arrays must outlive it.
class MappingReader {
 public:
  // piece_bytes: of a piece's arrays at the most; at least one element goes into each.
  MappingReader(absl::Span<const Index> original_vertex, absl::Span<const Index> original_face,
                std::size_t piece_bytes);

  bool has_next() const { return !vertices_.empty() || !faces_.empty(); }

  // Fills the next piece, which there must be.
  void Next(v1::RepairReport* piece);

 private:
  absl::Span<const Index> vertices_;
  absl::Span<const Index> faces_;
  std::size_t piece_elements_;
};

// Puts pieces together again, in the summary.
class MappingCollector {
 public:
  void Add(const v1::RepairReport& piece);

  // Moves what has come into summary->repair(), if the summary has that.
  void MoveTo(v1::Summary* summary);

 private:
  v1::RepairReport whole_;
};

// The elements of original_vertex or original_face; bytes after the last whole one are left out.
[[nodiscard]] Buffer<Index> MappingElements(std::string_view bytes);

}  // namespace limn::wire
