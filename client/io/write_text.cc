// SPDX-License-Identifier: MIT
// OBJ and OFF.
#include "absl/status/status.h"
#include "client/io/surface_view.h"

namespace limn::io {
namespace {

template <class Number>
void AppendTriple(const Vec3& v, OutputFile* file) {
  file->AppendNumber(static_cast<Number>(v.x));
  file->Append(" ");
  file->AppendNumber(static_cast<Number>(v.y));
  file->Append(" ");
  file->AppendNumber(static_cast<Number>(v.z));
  file->Append("\n");
}

}  // namespace

absl::Status WriteObj(const SurfaceView& view, OutputFile* file) {
  for (const Vec3& point : view.positions) {
    if (!file->ok()) break;
    file->Append("v ");
    AppendTriple<double>(point, file);
  }
  for (const Vec3& normal : view.normals) {
    file->Append("vn ");
    AppendTriple<float>(normal, file);
  }
  for (std::size_t f = 0; f < view.face_count() && file->ok(); ++f) {
    file->Append("f");
    for (const Index v : view.face(f)) {
      file->Append(" ");
      file->AppendNumber(std::uint64_t{v} + 1);
      if (view.normals.empty()) continue;
      file->Append("//");
      file->AppendNumber(std::uint64_t{v} + 1);
    }
    file->Append("\n");
  }
  return absl::OkStatus();
}

absl::Status WriteOff(const SurfaceView& view, OutputFile* file) {
  file->Append("OFF\n");
  file->AppendNumber(view.positions.size());
  file->Append(" ");
  file->AppendNumber(view.face_count());
  file->Append(" 0\n");
  for (const Vec3& point : view.positions) {
    if (!file->ok()) break;
    AppendTriple<double>(point, file);
  }
  for (std::size_t f = 0; f < view.face_count() && file->ok(); ++f) {
    file->AppendNumber(view.face(f).size());
    for (const Index v : view.face(f)) {
      file->Append(" ");
      file->AppendNumber(v);
    }
    file->Append("\n");
  }
  return absl::OkStatus();
}

}  // namespace limn::io
