// SPDX-License-Identifier: MIT
// STL, text and binary. Corners with equal coordinates become one vertex; names, normals and
// attributes are skipped.
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "client/io/mesh_collector.h"
#include "client/io/text_scanner.h"

namespace limn::io {
namespace {

constexpr std::size_t kBinaryHeader = 84;
constexpr std::size_t kBinaryTriangle = 50;

// Numbers points by first occurrence: a hash table with linear probing, at most half full.
class PointNumbers {
 public:
  explicit PointNumbers(MeshCollector* collector)
      : collector_(collector), slots_(std::size_t{1} << 10, kNoIndex) {}

  Index Number(Vec3 point) {
    point += Vec3{0, 0, 0};  // -0 becomes 0
    if (2 * (points_.size() + 1) > slots_.size()) Grow();
    Index& slot = slots_[FindSlot(point)];
    if (slot == kNoIndex) {
      slot = static_cast<Index>(points_.size());
      points_.push_back(point);
      collector_->AddVertex(point);
    }
    return slot;
  }

 private:
  static std::uint64_t Hash(const Vec3& point) {
    std::uint64_t hash = 0;
    for (const double coordinate : {point.x, point.y, point.z}) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate)) * 0x9e3779b97f4a7c15U;
      hash ^= hash >> 29;
    }
    return hash;
  }
  static bool SameBits(const Vec3& a, const Vec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

  std::size_t FindSlot(const Vec3& point) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = Hash(point) & mask;
    while (slots_[at] != kNoIndex && !SameBits(points_[slots_[at]], point)) at = (at + 1) & mask;
    return at;
  }

  void Grow() {
    slots_.assign(2 * slots_.size(), kNoIndex);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      slots_[FindSlot(points_[i])] = static_cast<Index>(i);
    }
  }

  MeshCollector* collector_;
  Buffer<Index> slots_;
  Buffer<Vec3> points_;
};

std::uint32_t LittleEndian32(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

absl::Status ReadBinary(std::string_view bytes, MeshCollector* collector) {
  const std::uint32_t triangles = LittleEndian32(bytes.data() + kBinaryHeader - 4);
  if (triangles > (bytes.size() - kBinaryHeader) / kBinaryTriangle) {
    return collector->Malformed(
        0, absl::StrCat("as binary STL it promises ", triangles, " triangles, more than its ",
                        bytes.size(), " bytes can hold"));
  }
  PointNumbers numbers(collector);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    // 12 bytes of normal come first.
    const char* at = bytes.data() + kBinaryHeader + std::size_t{t} * kBinaryTriangle + 12;
    for (int corner = 0; corner < 3; ++corner, at += 12) {
      const Vec3 point = {std::bit_cast<float>(LittleEndian32(at)),
                          std::bit_cast<float>(LittleEndian32(at + 4)),
                          std::bit_cast<float>(LittleEndian32(at + 8))};
      LIMN_RETURN_IF_ERROR(collector->AddCorner(numbers.Number(point), 0));
    }
    LIMN_RETURN_IF_ERROR(collector->EndFace(0));
  }
  return absl::OkStatus();
}

class TextReader {
 public:
  TextReader(std::string_view bytes, MeshCollector* collector)
      : scanner_(bytes, '\0', /*continued=*/false), collector_(collector), numbers_(collector) {}

  absl::Status Read() {
    for (std::string_view token = scanner_.Token(); !token.empty(); token = scanner_.Token()) {
      if (token == "solid" || token == "endsolid") {
        scanner_.NextLine();  // a name, which may hold anything
      } else if (token == "facet") {
        LIMN_RETURN_IF_ERROR(ReadFacet());
      } else {
        return Malformed("facet or endsolid", token);
      }
    }
    return absl::OkStatus();
  }

 private:
  absl::Status Malformed(const std::string& wanted, std::string_view token) const {
    return collector_->Malformed(
        scanner_.line(), absl::StrCat("there should be ", wanted, ", not ",
                                      token.empty() ? "the end of the file" : Quoted(token)));
  }

  absl::Status Expect(std::string_view word) {
    const std::string_view token = scanner_.Token();
    return token == word ? absl::OkStatus() : Malformed(std::string(word), token);
  }

  // facet normal x y z, outer loop, vertex x y z three or more times, endloop, endfacet
  absl::Status ReadFacet() {
    const std::uint64_t line = scanner_.line();
    Vec3 point = {};
    LIMN_RETURN_IF_ERROR(Expect("normal"));
    LIMN_RETURN_IF_ERROR(ReadVector(&point));
    LIMN_RETURN_IF_ERROR(Expect("outer"));
    LIMN_RETURN_IF_ERROR(Expect("loop"));
    std::string_view token = scanner_.Token();
    for (; token == "vertex"; token = scanner_.Token()) {
      LIMN_RETURN_IF_ERROR(ReadVector(&point));
      LIMN_RETURN_IF_ERROR(collector_->AddCorner(numbers_.Number(point), line));
    }
    if (token != "endloop") return Malformed("vertex or endloop", token);
    LIMN_RETURN_IF_ERROR(Expect("endfacet"));
    return collector_->EndFace(line);
  }

  absl::Status ReadVector(Vec3* vector) {
    for (double* coordinate : {&vector->x, &vector->y, &vector->z}) {
      const std::string_view token = scanner_.Token();
      if (!ParseDouble(token, coordinate)) return Malformed("a number", token);
    }
    return absl::OkStatus();
  }

  TextScanner scanner_;
  MeshCollector* collector_;
  PointNumbers numbers_;
};

// Binary files may begin with "solid" too, so the size decides where it fits exactly.
bool IsBinary(std::string_view bytes) {
  if (bytes.size() < kBinaryHeader) return false;
  const std::uint64_t triangles = LittleEndian32(bytes.data() + kBinaryHeader - 4);
  if (bytes.size() == kBinaryHeader + triangles * kBinaryTriangle) return true;
  TextScanner scanner(bytes, '\0', /*continued=*/false);
  return scanner.Token() != "solid";
}

}  // namespace

absl::Status ReadStl(std::string_view bytes, MeshCollector* collector) {
  return IsBinary(bytes) ? ReadBinary(bytes, collector) : TextReader(bytes, collector).Read();
}

}  // namespace limn::io
