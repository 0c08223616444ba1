// SPDX-License-Identifier: MIT
// The header of a PLY file: its encoding, and the properties of its elements.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "client/io/mesh_collector.h"
#include "client/io/text_scanner.h"

namespace limn::io::ply {

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

inline std::size_t SizeOf(Scalar scalar) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(scalar)];
}

enum class Encoding { kText, kLittleEndian, kBigEndian };

// What a property is to Limn: a coordinate of "vertex", the corners of "face", or nothing.
enum class Role { kSkipped, kX, kY, kZ, kCorners };

struct Property {
  Role role = Role::kSkipped;
  bool list = false;
  Scalar count = Scalar::kUint8;  // of lists
  Scalar value = Scalar::kFloat32;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

class Header {
 public:
  Header(std::string_view bytes, const MeshCollector& collector)
      : scanner_(bytes, '\0', /*continued=*/false), collector_(collector) {}

  // Parses it. Errors: MALFORMED_FILE. Counts are as the file claims.
  absl::Status Read();

  Encoding encoding() const { return encoding_; }
  const std::vector<Element>& elements() const { return elements_; }
  // Where the body begins.
  std::size_t size() const { return scanner_.offset(); }
  std::uint64_t lines() const { return scanner_.line(); }

 private:
  absl::Status Malformed(const std::string& what) const {
    return collector_.Malformed(scanner_.line(), what);
  }
  absl::Status ReadFormat();
  absl::Status ReadElement();
  absl::Status ReadScalar(Scalar* scalar);
  absl::Status ReadProperty();
  absl::Status SetRole(const Element& element, std::string_view name, Property* property) const;

  TextScanner scanner_;
  const MeshCollector& collector_;
  Encoding encoding_ = Encoding::kText;
  std::vector<Element> elements_;
};

}  // namespace limn::io::ply
