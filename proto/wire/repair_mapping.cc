// SPDX-License-Identifier: MIT
// See repair_mapping.h.
#include "proto/wire/repair_mapping.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <utility>

namespace limn::wire {
namespace {

// Arrays travel as they lie in memory.
static_assert(std::endian::native == std::endian::little);

// The bytes of the first elements, which are taken away.
std::string Take(std::size_t most, absl::Span<const Index>* elements) {
  const absl::Span<const Index> taken = elements->first(std::min(most, elements->size()));
  elements->remove_prefix(taken.size());
  std::string bytes(taken.size() * sizeof(Index), '\0');
  std::memcpy(bytes.data(), taken.data(), bytes.size());
  return bytes;
}

}  // namespace

MappingReader::MappingReader(absl::Span<const Index> original_vertex,
                             absl::Span<const Index> original_face, std::size_t piece_bytes)
    : vertices_(original_vertex),
      faces_(original_face),
      piece_elements_(std::max<std::size_t>(1, piece_bytes / sizeof(Index))) {}

void MappingReader::Next(v1::RepairReport* piece) {
  if (!vertices_.empty()) {
    piece->set_original_vertex(Take(piece_elements_, &vertices_));
  } else {
    piece->set_original_face(Take(piece_elements_, &faces_));
  }
}

void MappingCollector::Add(const v1::RepairReport& piece) {
  whole_.mutable_original_vertex()->append(piece.original_vertex());
  whole_.mutable_original_face()->append(piece.original_face());
}

void MappingCollector::MoveTo(v1::Summary* summary) {
  if (!summary->has_repair()) return;
  v1::RepairReport* const repair = summary->mutable_repair();
  repair->set_original_vertex(std::move(*whole_.mutable_original_vertex()));
  repair->set_original_face(std::move(*whole_.mutable_original_face()));
}

Buffer<Index> MappingElements(std::string_view bytes) {
  Buffer<Index> elements(bytes.size() / sizeof(Index));
  if (!elements.empty())
    std::memcpy(elements.data(), bytes.data(), elements.size() * sizeof(Index));
  return elements;
}

}  // namespace limn::wire
