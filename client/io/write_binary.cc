// SPDX-License-Identifier: MIT
// PLY (binary, little-endian) and STL (binary).
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/surface_view.h"
#include "engine/base/error.h"

namespace limn::io {
namespace {

static_assert(std::endian::native == std::endian::little, "values are written as in memory");

std::size_t LargestArity(const SurfaceView& view) {
  std::size_t largest = 0;
  for (std::size_t f = 0; f < view.face_count(); ++f) {
    largest = std::max(largest, view.face(f).size());
  }
  return largest;
}

std::array<float, 3> ToFloat32(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

std::string PlyHeader(const SurfaceView& view, bool wide_lists, bool wide_indices) {
  std::string header =
      absl::StrCat("ply\nformat binary_little_endian 1.0\nelement vertex ", view.positions.size(),
                   "\nproperty double x\nproperty double y\nproperty double z\n");
  if (!view.normals.empty()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  absl::StrAppend(&header, "element face ", view.face_count(), "\nproperty list ",
                  wide_lists ? "uint" : "uchar", wide_indices ? " uint" : " int",
                  " vertex_indices\nend_header\n");
  return header;
}

}  // namespace

absl::Status CheckFloat32(const SurfaceView& view, const Vec3& origin, std::string_view format) {
  for (std::size_t v = 0; v < view.positions.size(); ++v) {
    ErrorDetail detail = {.field = "vertices", .index = v};
    if (!IsFinite(view.positions[v])) {
      detail.reason = Reason::kNonFiniteCoordinate;
      detail.remedy = "Write .obj, .off or .ply, which keep it";
      return MakeError(
          absl::StrCat("vertex ", v, " is not finite, which ", std::string(format), " cannot hold"),
          detail);
    }
    if (MaxAbs(view.positions[v] - origin) > std::numeric_limits<float>::max()) {
      detail.reason = Reason::kCoordinateTooLarge;
      detail.remedy = "Write .obj, .off or .ply, or scale the mesh down";
      return MakeError(
          absl::StrCat("vertex ", v, " is too large for the float32 of ", std::string(format)),
          detail);
    }
  }
  return absl::OkStatus();
}

absl::Status WritePly(const SurfaceView& view, OutputFile* file) {
  // The narrow types are those that every reader knows.
  const bool wide_lists = LargestArity(view) > std::numeric_limits<std::uint8_t>::max();
  const bool wide_indices = view.positions.size() > std::numeric_limits<std::int32_t>::max();
  file->Append(PlyHeader(view, wide_lists, wide_indices));
  for (std::size_t v = 0; v < view.positions.size() && file->ok(); ++v) {
    file->AppendRaw(view.positions[v]);
    if (!view.normals.empty()) file->AppendRaw(ToFloat32(view.normals[v]));
  }
  for (std::size_t f = 0; f < view.face_count() && file->ok(); ++f) {
    const absl::Span<const Index> face = view.face(f);
    if (wide_lists) {
      file->AppendRaw(static_cast<std::uint32_t>(face.size()));
    } else {
      file->AppendRaw(static_cast<std::uint8_t>(face.size()));
    }
    file->Append({reinterpret_cast<const char*>(face.data()), face.size() * sizeof(Index)});
  }
  return absl::OkStatus();
}

absl::Status WriteStl(const SurfaceView& view, OutputFile* file) {
  LIMN_RETURN_IF_ERROR(CheckFloat32(view, {0, 0, 0}, "STL"));
  const std::size_t triangles = view.triangle_count();
  if (triangles > std::numeric_limits<std::uint32_t>::max()) {
    return MakeError(
        absl::StrCat(triangles, " triangles are more than STL can count"),
        {.reason = Reason::kLimitExceeded, .field = "faces", .remedy = "Write .ply or .obj"});
  }
  // Not "solid": that is how text files begin.
  std::string header = "binary STL by Limn";
  header.resize(80, ' ');
  file->Append(header);
  file->AppendRaw(static_cast<std::uint32_t>(triangles));
  view.ForEachTriangle([&](Index a, Index b, Index c) {
    if (!file->ok()) return;
    const Vec3& p = view.positions[a];
    const Vec3& q = view.positions[b];
    const Vec3& r = view.positions[c];
    file->AppendRaw(ToFloat32(NormalizedOrZero(Cross(q - p, r - p))));
    file->AppendRaw(ToFloat32(p));
    file->AppendRaw(ToFloat32(q));
    file->AppendRaw(ToFloat32(r));
    file->AppendRaw(std::uint16_t{0});
  });
  return absl::OkStatus();
}

}  // namespace limn::io
