// SPDX-License-Identifier: MIT
// See chunks.h.
#include "proto/wire/chunks.h"

#include <xxhash.h>

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"

namespace limn::wire {
namespace {

absl::Status BadChunk(const char* field, const std::string& message, const std::string& remedy) {
  return MakeError(message, {.reason = Reason::kMalformedRequest,
                             .field = absl::StrCat("chunk.", field),
                             .remedy = remedy});
}

}  // namespace

std::uint64_t Checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

ChunkReader::ChunkReader(std::string_view bytes, std::size_t chunk_bytes)
    : bytes_(bytes), chunk_bytes_(std::clamp<std::size_t>(chunk_bytes, 1, kMaxChunkBytes)) {}

bool ChunkReader::Next(v1::MeshChunk* chunk) {
  if (offset_ >= bytes_.size()) return false;
  const std::string_view data = bytes_.substr(offset_, chunk_bytes_);
  chunk->Clear();
  chunk->set_offset(offset_);
  chunk->set_data(data.data(), data.size());
  offset_ += data.size();
  if (offset_ == bytes_.size()) {
    chunk->set_last(true);
    chunk->set_xxh3(Checksum(bytes_));
  }
  return true;
}

ChunkAssembler::ChunkAssembler(std::uint64_t expected_bytes) : expected_bytes_(expected_bytes) {}

absl::Status ChunkAssembler::Add(const v1::MeshChunk& chunk) {
  const std::string& data = chunk.data();
  if (complete_) {
    return BadChunk("last", "a chunk came after the last one", "Send nothing after `last`");
  }
  if (data.empty() || data.size() > kMaxChunkBytes) {
    return BadChunk("data",
                    absl::StrCat("a chunk holds ", data.size(), " bytes; 1 to ", kMaxChunkBytes,
                                 " are allowed"),
                    "Send chunks of 512 KiB");
  }
  if (chunk.offset() != bytes_.size()) {
    return BadChunk("offset",
                    absl::StrCat("a chunk begins at byte ", chunk.offset(), ", but ", bytes_.size(),
                                 " bytes have come"),
                    "Send chunks in order, without gaps or overlaps");
  }
  const std::uint64_t received = bytes_.size() + data.size();
  if (received > expected_bytes_) {
    return BadChunk("data",
                    absl::StrCat("the chunks hold more than the ", expected_bytes_,
                                 " bytes that the header's byte_count announced"),
                    "Set byte_count to the sum of the chunks' sizes");
  }
  if (chunk.last() != (received == expected_bytes_)) {
    return BadChunk("last",
                    absl::StrCat(received, " of ", expected_bytes_, " announced bytes have come ",
                                 chunk.last() ? "with the last chunk" : "without a last chunk"),
                    "Set `last` on the chunk that completes byte_count, and on no other");
  }
  LIMN_RETURN_IF_ERROR(Guarded("receiving the mesh", Reason::kInternal, [&] {
    // At the end there is no more room than bytes were announced.
    if (received > bytes_.capacity()) {
      bytes_.reserve(
          std::min(expected_bytes_, std::max<std::uint64_t>(received, 2 * bytes_.size())));
    }
    bytes_.append(data);
    return absl::OkStatus();
  }));
  if (!chunk.last()) return absl::OkStatus();
  if (const std::uint64_t checksum = Checksum(bytes_); checksum != chunk.xxh3()) {
    return MakeError(
        absl::StrCat("the mesh's XXH3 is ", absl::Hex(checksum, absl::kZeroPad16),
                     ", but the last chunk says ", absl::Hex(chunk.xxh3(), absl::kZeroPad16)),
        {.reason = Reason::kChecksumMismatch,
         .field = "chunk.xxh3",
         .remedy = "Send the mesh again"});
  }
  complete_ = true;
  return absl::OkStatus();
}

}  // namespace limn::wire
