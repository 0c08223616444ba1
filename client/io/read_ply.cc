// SPDX-License-Identifier: MIT
// PLY 1.0, text and binary of both byte orders: x, y, z of the element "vertex" and the list
// "vertex_indices" (or "vertex_index") of the element "face", in any of the scalar types; all other
// properties and elements are skipped.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "client/io/mesh_collector.h"
#include "client/io/text_scanner.h"

namespace limn::io {
namespace {

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct ScalarName {
  std::string_view name;
  Scalar scalar;
};

constexpr std::array kScalarNames = {
    ScalarName{"char", Scalar::kInt8},      ScalarName{"int8", Scalar::kInt8},
    ScalarName{"uchar", Scalar::kUint8},    ScalarName{"uint8", Scalar::kUint8},
    ScalarName{"short", Scalar::kInt16},    ScalarName{"int16", Scalar::kInt16},
    ScalarName{"ushort", Scalar::kUint16},  ScalarName{"uint16", Scalar::kUint16},
    ScalarName{"int", Scalar::kInt32},      ScalarName{"int32", Scalar::kInt32},
    ScalarName{"uint", Scalar::kUint32},    ScalarName{"uint32", Scalar::kUint32},
    ScalarName{"float", Scalar::kFloat32},  ScalarName{"float32", Scalar::kFloat32},
    ScalarName{"double", Scalar::kFloat64}, ScalarName{"float64", Scalar::kFloat64},
};

bool IsInteger(Scalar scalar) { return scalar < Scalar::kFloat32; }

std::size_t SizeOf(Scalar scalar) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(scalar)];
}

enum class Encoding { kText, kLittleEndian, kBigEndian };

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

// Values of the body, one after the other. Functions return false at the end of the file or where
// the text is no such number.
class Body {
 public:
  Body(std::string_view bytes, Encoding encoding)
      : bytes_(bytes), text_(bytes, '\0', /*continued=*/false), encoding_(encoding) {}

  bool ReadDouble(Scalar scalar, double* value) {
    if (encoding_ == Encoding::kText) return ParseDouble(text_.Token(), value);
    switch (scalar) {
      case Scalar::kFloat32:
        return ReadAs<float>(value);
      case Scalar::kFloat64:
        return ReadAs<double>(value);
      default:
        std::int64_t integer = 0;
        if (!ReadInteger(scalar, &integer)) return false;
        *value = static_cast<double>(integer);
        return true;
    }
  }

  bool ReadInteger(Scalar scalar, std::int64_t* value) {
    if (encoding_ == Encoding::kText) return ParseInteger(text_.Token(), value);
    switch (scalar) {
      case Scalar::kInt8:
        return ReadAs<std::int8_t>(value);
      case Scalar::kUint8:
        return ReadAs<std::uint8_t>(value);
      case Scalar::kInt16:
        return ReadAs<std::int16_t>(value);
      case Scalar::kUint16:
        return ReadAs<std::uint16_t>(value);
      case Scalar::kInt32:
        return ReadAs<std::int32_t>(value);
      case Scalar::kUint32:
        return ReadAs<std::uint32_t>(value);
      default:
        return false;
    }
  }

  // Skips `count` values; false if there are fewer.
  bool Skip(Scalar scalar, std::uint64_t count) {
    if (encoding_ != Encoding::kText) {
      if (count > left() / SizeOf(scalar)) return false;
      at_ += count * SizeOf(scalar);
      return true;
    }
    for (; count > 0; --count) {
      if (text_.Token().empty()) return false;
    }
    return true;
  }

  // Fewest bytes that a value can take.
  std::size_t MinSize(Scalar scalar) const {
    return encoding_ == Encoding::kText ? 1 : SizeOf(scalar);
  }
  std::size_t left() const {
    return encoding_ == Encoding::kText ? text_.left() : bytes_.size() - at_;
  }
  // Lines of the body so far; 0 where there are none.
  std::uint64_t lines() const { return encoding_ == Encoding::kText ? text_.line() : 0; }

 private:
  template <class T, class Value>
  bool ReadAs(Value* value) {
    std::array<char, sizeof(T)> raw;
    if (bytes_.size() - at_ < raw.size()) return false;
    std::memcpy(raw.data(), bytes_.data() + at_, raw.size());
    at_ += raw.size();
    const bool swap =
        (encoding_ == Encoding::kBigEndian) != (std::endian::native == std::endian::big);
    if (swap) std::reverse(raw.begin(), raw.end());
    *value = static_cast<Value>(std::bit_cast<T>(raw));
    return true;
  }

  std::string_view bytes_;
  TextScanner text_;
  Encoding encoding_;
  std::size_t at_ = 0;
};

// Parses the header line by line.
class Header {
 public:
  Header(std::string_view bytes, const MeshCollector& collector)
      : scanner_(bytes, '\0', /*continued=*/false), collector_(collector) {}

  absl::Status Read() {
    if (scanner_.TokenOnLine() != "ply") return Malformed("a PLY file should begin with ply");
    bool has_format = false;
    while (scanner_.NextLine()) {
      const std::string_view keyword = scanner_.TokenOnLine();
      if (keyword == "format") {
        has_format = true;
        LIMN_RETURN_IF_ERROR(ReadFormat());
      } else if (keyword == "element") {
        LIMN_RETURN_IF_ERROR(ReadElement());
      } else if (keyword == "property") {
        LIMN_RETURN_IF_ERROR(ReadProperty());
      } else if (keyword == "end_header") {
        if (!has_format) return Malformed("the header has no format");
        scanner_.NextLine();
        return absl::OkStatus();
      } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
        return Malformed(Quoted(keyword) + " is not part of a PLY header");
      }
    }
    return Malformed("the header has no end_header");
  }

  Encoding encoding() const { return encoding_; }
  const std::vector<Element>& elements() const { return elements_; }
  std::size_t size() const { return scanner_.offset(); }
  std::uint64_t lines() const { return scanner_.line(); }

 private:
  absl::Status Malformed(const std::string& what) const {
    return collector_.Malformed(scanner_.line(), what);
  }

  absl::Status ReadFormat() {
    const std::string_view name = scanner_.TokenOnLine();
    if (name == "ascii") {
      encoding_ = Encoding::kText;
    } else if (name == "binary_little_endian") {
      encoding_ = Encoding::kLittleEndian;
    } else if (name == "binary_big_endian") {
      encoding_ = Encoding::kBigEndian;
    } else {
      return Malformed(
          "the format should be ascii, binary_little_endian or binary_big_endian, not " +
          Quoted(name));
    }
    return absl::OkStatus();
  }

  absl::Status ReadElement() {
    Element element;
    element.name = std::string(scanner_.TokenOnLine());
    const std::string_view token = scanner_.TokenOnLine();
    std::int64_t count = 0;
    if (element.name.empty() || !ParseInteger(token, &count) || count < 0) {
      return Malformed("an element should have a name and a count, not " + Quoted(token));
    }
    element.count = static_cast<std::uint64_t>(count);
    elements_.push_back(std::move(element));
    return absl::OkStatus();
  }

  absl::Status ReadScalar(Scalar* scalar) {
    const std::string_view token = scanner_.TokenOnLine();
    for (const ScalarName& entry : kScalarNames) {
      if (entry.name != token) continue;
      *scalar = entry.scalar;
      return absl::OkStatus();
    }
    // "list" is taken for the type by the caller.
    return Malformed(Quoted(token) + " is not a type of PLY");
  }

  absl::Status ReadProperty() {
    if (elements_.empty()) return Malformed("a property should follow an element");
    Element& element = elements_.back();
    Property property;
    TextScanner ahead = scanner_;
    property.list = ahead.TokenOnLine() == "list";
    if (property.list) {
      scanner_ = ahead;
      LIMN_RETURN_IF_ERROR(ReadScalar(&property.count));
      if (!IsInteger(property.count)) return Malformed("a list's length should be an integer");
    }
    LIMN_RETURN_IF_ERROR(ReadScalar(&property.value));
    const std::string_view name = scanner_.TokenOnLine();
    if (name.empty()) return Malformed("a property should have a name");
    LIMN_RETURN_IF_ERROR(SetRole(element, name, &property));
    element.properties.push_back(property);
    return absl::OkStatus();
  }

  absl::Status SetRole(const Element& element, std::string_view name, Property* property) const {
    if (element.name == "tristrips") return Malformed("triangle strips are not supported");
    const bool corners = name == "vertex_indices" || name == "vertex_index";
    if (element.name == "vertex" && !property->list) {
      if (name == "x") property->role = Role::kX;
      if (name == "y") property->role = Role::kY;
      if (name == "z") property->role = Role::kZ;
    } else if (element.name == "face" && corners) {
      if (!property->list || !IsInteger(property->value)) {
        return Malformed("a face's vertices should be a list of integers");
      }
      property->role = Role::kCorners;
    }
    for (const Property& other : element.properties) {
      if (other.role == Role::kSkipped || other.role != property->role) continue;
      return Malformed("the property " + Quoted(name) + " is there twice");
    }
    return absl::OkStatus();
  }

  TextScanner scanner_;
  const MeshCollector& collector_;
  Encoding encoding_ = Encoding::kText;
  std::vector<Element> elements_;
};

class BodyReader {
 public:
  BodyReader(const Header& header, std::string_view bytes, MeshCollector* collector)
      : header_(header),
        body_(bytes.substr(header.size()), header.encoding()),
        collector_(collector) {}

  absl::Status Read() {
    for (const Element& element : header_.elements()) {
      LIMN_RETURN_IF_ERROR(CheckElement(element));
      if (element.properties.empty()) continue;
      for (std::uint64_t i = 0; i < element.count; ++i) {
        LIMN_RETURN_IF_ERROR(ReadOne(element, i));
      }
    }
    return absl::OkStatus();
  }

 private:
  std::uint64_t Line() const {
    return body_.lines() == 0 ? 0 : header_.lines() - 1 + body_.lines();
  }

  // Whether the element has what its kind needs, and can fit into what is left of the file.
  absl::Status CheckElement(const Element& element) const {
    std::uint64_t roles = 0;
    std::size_t size = 0;
    for (const Property& property : element.properties) {
      roles += property.role != Role::kSkipped ? 1 : 0;
      size += body_.MinSize(property.list ? property.count : property.value);
    }
    if (element.name == "vertex" && roles != 3) {
      return collector_->Malformed(0, "the element vertex should have the properties x, y and z");
    }
    if (element.name == "face" && roles != 1 && element.count > 0) {
      return collector_->Malformed(0, "the element face should have the list vertex_indices");
    }
    if (size == 0 || element.count <= body_.left() / size) return absl::OkStatus();
    return collector_->Malformed(
        0, absl::StrCat("the header promises ", element.count, " of the element ",
                        Quoted(element.name), ", more than the ", body_.left(),
                        " bytes left can hold"));
  }

  absl::Status ReadOne(const Element& element, std::uint64_t number) {
    Vec3 point = {};
    for (const Property& property : element.properties) {
      bool ok = true;
      double* coordinate = property.role == Role::kX   ? &point.x
                           : property.role == Role::kY ? &point.y
                                                       : &point.z;
      switch (property.role) {
        case Role::kX:
        case Role::kY:
        case Role::kZ:
          ok = body_.ReadDouble(property.value, coordinate);
          break;
        case Role::kCorners:
          LIMN_RETURN_IF_ERROR(ReadFace(property, &ok));
          break;
        case Role::kSkipped:
          ok = SkipProperty(property);
          break;
      }
      if (ok) continue;
      return collector_->Malformed(
          Line(), absl::StrCat(element.name, " ", number, " (counted from 0) of ", element.count,
                               " is cut off or not a number"));
    }
    if (element.name == "vertex") collector_->AddVertex(point);
    return absl::OkStatus();
  }

  absl::Status ReadFace(const Property& property, bool* ok) {
    std::int64_t arity = 0;
    *ok = body_.ReadInteger(property.count, &arity) && arity >= 0;
    const std::uint64_t line = Line();
    for (std::int64_t i = 0; *ok && i < arity; ++i) {
      std::int64_t vertex = 0;
      *ok = body_.ReadInteger(property.value, &vertex);
      if (*ok) LIMN_RETURN_IF_ERROR(collector_->AddCorner(vertex, line));
    }
    return *ok ? collector_->EndFace(line) : absl::OkStatus();
  }

  bool SkipProperty(const Property& property) {
    std::int64_t count = 1;
    if (property.list && !body_.ReadInteger(property.count, &count)) return false;
    return count >= 0 && body_.Skip(property.value, static_cast<std::uint64_t>(count));
  }

  const Header& header_;
  Body body_;
  MeshCollector* collector_;
};

}  // namespace

absl::Status ReadPly(std::string_view bytes, MeshCollector* collector) {
  Header header(bytes, *collector);
  LIMN_RETURN_IF_ERROR(header.Read());
  return BodyReader(header, bytes, collector).Read();
}

}  // namespace limn::io
