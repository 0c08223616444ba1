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

#include "client/io/mesh_collector.h"
#include "client/io/ply_header.h"
#include "client/io/text_scanner.h"

namespace limn::io {
namespace {

using ply::Element;
using ply::Encoding;
using ply::Header;
using ply::Property;
using ply::Role;
using ply::Scalar;
using ply::SizeOf;

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
