// SPDX-License-Identifier: MIT
// See draco_header.h.
#include "proto/wire/draco_header.h"

#include <cstring>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn::wire {
namespace {

constexpr int kMetadataFlag = 0x8000;
constexpr int kMaxMetadataDepth = 8;
constexpr int kMaxMetadataItems = 1024;
// Triangles per byte that are believed at the most.
constexpr std::uint64_t kStandardTrianglesPerByte = 8;
constexpr std::uint64_t kValenceTrianglesPerByte = 16;

absl::Status Malformed(const std::string& message, const std::string& remedy = "") {
  return MakeError(absl::StrCat("the Draco mesh ", message),
                   {.reason = Reason::kMalformedEncoding, .field = "mesh", .remedy = remedy});
}

// Reads forward; once something is missing, everything reads as 0 and ok() is false.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  bool ok() const { return ok_; }
  std::size_t remaining() const { return rest_.size(); }

  std::string_view Take(std::size_t n) {
    if (n > rest_.size()) {
      ok_ = false;
      n = rest_.size();
    }
    const std::string_view taken = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return taken;
  }

  std::uint8_t Byte() {
    const std::string_view byte = Take(1);
    return ok_ ? static_cast<std::uint8_t>(byte[0]) : 0;
  }

  // 7 bits a byte, the lowest first; 5 bytes at the most.
  std::uint32_t Varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const std::uint8_t byte = Byte();
      value |= std::uint64_t{byte & 0x7fU} << shift;
      if ((byte & 0x80) != 0) continue;
      if (value > 0xffffffffU) ok_ = false;
      return ok_ ? static_cast<std::uint32_t>(value) : 0;
    }
    ok_ = false;
    return 0;
  }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

// Steps over nested name-value lists; false when they are cut off, too many or too deep.
class MetadataWalk {
 public:
  explicit MetadataWalk(Reader* reader) : reader_(reader) {}

  bool Run() {
    const std::uint32_t attributes = reader_->Varint();
    for (std::uint32_t i = 0; i < attributes; ++i) {
      reader_->Varint();
      if (!List(0)) return false;
    }
    return List(0);
  }

 private:
  bool Count() { return reader_->ok() && ++items_ <= kMaxMetadataItems; }

  bool List(int depth) {
    if (!Count() || depth > kMaxMetadataDepth) return false;
    const std::uint32_t entries = reader_->Varint();
    for (std::uint32_t i = 0; i < entries; ++i) {
      if (!Count()) return false;
      reader_->Take(reader_->Byte());
      const std::uint32_t size = reader_->Varint();
      if (size == 0 || size > reader_->remaining()) return false;
      reader_->Take(size);
    }
    const std::uint32_t children = reader_->Varint();
    for (std::uint32_t i = 0; i < children; ++i) {
      reader_->Take(reader_->Byte());
      if (!List(depth + 1)) return false;
    }
    return reader_->ok();
  }

  Reader* reader_;
  int items_ = 0;
};

absl::Status TooFewBytes(std::uint64_t triangles, std::size_t remaining) {
  return Malformed(absl::StrCat("claims ", triangles, " triangles in ", remaining, " bytes"),
                   "Use MESH_ENCODING_PACKED if the mesh is really so regular");
}

absl::StatusOr<DracoHeader> ReadSequential(Reader* reader) {
  DracoHeader header;
  header.triangles = reader->Varint();
  header.vertices = reader->Varint();
  reader->Byte();
  if (!reader->ok()) return Malformed("ends in its header");
  if (3 * header.triangles > reader->remaining()) {
    return TooFewBytes(header.triangles, reader->remaining());
  }
  if (header.vertices > 3 * header.triangles) {
    return Malformed(
        absl::StrCat("claims ", header.vertices, " points for ", header.triangles, " triangles"));
  }
  return header;
}

absl::StatusOr<DracoHeader> ReadEdgebreaker(Reader* reader) {
  DracoHeader header;
  header.edgebreaker = true;
  const std::uint8_t traversal = reader->Byte();
  const std::uint64_t vertices = reader->Varint();
  header.triangles = reader->Varint();
  header.attribute_connectivities = reader->Byte();
  const std::uint64_t symbols = reader->Varint();
  const std::uint64_t splits = reader->Varint();
  header.vertices = vertices + splits;
  if (!reader->ok()) return Malformed("ends in its header");
  if (traversal != 0 && traversal != 2) {
    return Malformed(absl::StrCat("uses edgebreaker traversal ", traversal),
                     "Encode it with Draco 1.3 or later");
  }
  const std::uint64_t per_byte =
      traversal == 0 ? kStandardTrianglesPerByte : kValenceTrianglesPerByte;
  if (symbols > per_byte * reader->remaining()) {
    return TooFewBytes(header.triangles, reader->remaining());
  }
  // Draco's own rules, applied before it allocates: a component of n triangles takes n or n - 1
  // symbols, and n is 4 or more in the latter case; splits are symbols.
  if (symbols > header.triangles || header.triangles > symbols + symbols / 3 || splits > symbols ||
      vertices > 3 * header.triangles) {
    return Malformed(absl::StrCat("claims ", header.triangles, " triangles, ", vertices,
                                  " vertices, ", symbols, " symbols and ", splits,
                                  " splits, which do not fit together"));
  }
  if (header.attribute_connectivities >= kMaxDracoAttributes) {
    return Malformed(absl::StrCat("has more than ", kMaxDracoAttributes, " attributes"),
                     "Send positions only");
  }
  return header;
}

}  // namespace

absl::StatusOr<DracoHeader> ReadDracoHeader(std::string_view bytes) {
  Reader reader(bytes);
  const bool magic = reader.Take(5) == "DRACO";
  const int major = reader.Byte();
  const int minor = reader.Byte();
  const int geometry = reader.Byte();
  const int method = reader.Byte();
  const int flags_low = reader.Byte();
  const int flags = reader.Byte() << 8 | flags_low;
  if (!magic || !reader.ok()) return Malformed("does not begin with a Draco header");
  if (major != 2 || minor != 2) {
    return Malformed(absl::StrCat("has bitstream version ", major, ".", minor, "; 2.2 is taken"),
                     "Encode it with Draco 1.3 or later");
  }
  if (geometry != 1 || method > 1) {
    return Malformed("is not a triangle mesh in Draco's sequential or edgebreaker coding",
                     "Encode a mesh, not a point cloud");
  }
  if ((flags & kMetadataFlag) != 0 && !MetadataWalk(&reader).Run()) {
    return Malformed("has metadata that are cut off, too many or too deep");
  }
  absl::StatusOr<DracoHeader> header =
      method == 0 ? ReadSequential(&reader) : ReadEdgebreaker(&reader);
  if (header.ok() && header->triangles == 0) return Malformed("has no triangles");
  return header;
}

// Triangles, corners' values and polygons: about 70 bytes per triangle; with edgebreaker's tables
// 100, and an attribute's connectivity another 40. A vertex's values and those made of them.
std::uint64_t DracoDecodeBytes(const DracoHeader& header) {
  const std::uint64_t per_triangle =
      header.edgebreaker ? 100 + 40 * std::uint64_t{header.attribute_connectivities} : 70;
  return header.triangles * per_triangle + header.vertices * (kMaxDracoValueBytes + 32);
}

absl::Status CheckDracoHeader(const DracoHeader& header, const DracoBounds& bounds) {
  const auto too_large = [](const char* field, std::uint64_t value, std::uint64_t limit,
                            const char* limit_name) {
    return MakeError(
        absl::StrCat("the Draco mesh needs ", value, " ", field, "; ", limit, " are allowed"),
        {.reason = Reason::kLimitExceeded,
         .field = absl::StrCat("mesh.", field),
         .remedy = "Send a smaller mesh, or check the counts of the header",
         .limit = limit_name});
  };
  if (header.triangles > bounds.max_triangles) {
    if (bounds.triangles_claimed) {
      return Malformed(absl::StrCat("has ", header.triangles,
                                    " triangles; its header's counts make ", bounds.max_triangles),
                       "Set the header's counts to those of the mesh");
    }
    return too_large("triangles", header.triangles, bounds.max_triangles, "max-corners");
  }
  if (const std::uint64_t bytes = DracoDecodeBytes(header); bytes > bounds.max_bytes) {
    return too_large("bytes", bytes, bounds.max_bytes, "max-job-bytes");
  }
  return absl::OkStatus();
}

}  // namespace limn::wire
