// SPDX-License-Identifier: MIT
// Parses the header of a PLY file line by line.
#include "client/io/ply_header.h"

#include <utility>

namespace limn::io::ply {
namespace {

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

}  // namespace

absl::Status Header::Read() {
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

absl::Status Header::ReadFormat() {
  const std::string_view name = scanner_.TokenOnLine();
  if (name == "ascii") {
    encoding_ = Encoding::kText;
  } else if (name == "binary_little_endian") {
    encoding_ = Encoding::kLittleEndian;
  } else if (name == "binary_big_endian") {
    encoding_ = Encoding::kBigEndian;
  } else {
    return Malformed("the format should be ascii, binary_little_endian or binary_big_endian, not " +
                     Quoted(name));
  }
  return absl::OkStatus();
}

absl::Status Header::ReadElement() {
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

absl::Status Header::ReadScalar(Scalar* scalar) {
  const std::string_view token = scanner_.TokenOnLine();
  for (const ScalarName& entry : kScalarNames) {
    if (entry.name != token) continue;
    *scalar = entry.scalar;
    return absl::OkStatus();
  }
  // "list" is taken for the type by the caller.
  return Malformed(Quoted(token) + " is not a type of PLY");
}

absl::Status Header::ReadProperty() {
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

absl::Status Header::SetRole(const Element& element, std::string_view name,
                             Property* property) const {
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

}  // namespace limn::io::ply
