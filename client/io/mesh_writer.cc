// SPDX-License-Identifier: MIT
// Picks the format, checks the indices and writes through an OutputFile.
#include "client/io/mesh_writer.h"

#include <array>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <stdexcept>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/io/output_file.h"
#include "client/io/surface_view.h"
#include "engine/base/error.h"

namespace limn {
namespace {

using WriteFunction = absl::Status (*)(const io::SurfaceView& view, io::OutputFile* file);

struct Format {
  std::string_view extension;
  WriteFunction write;
  bool surfaces_only;
};

constexpr std::array kFormats = {
    Format{".obj", io::WriteObj, false}, Format{".off", io::WriteOff, false},
    Format{".ply", io::WritePly, false}, Format{".stl", io::WriteStl, false},
    Format{".glb", io::WriteGlb, true},
};

std::string KnownExtensions(OutputKind kind) {
  std::string known;
  for (const Format& format : kFormats) {
    if (format.surfaces_only && kind != OutputKind::kSurface) continue;
    absl::StrAppend(&known, known.empty() ? "" : ", ", std::string(format.extension));
  }
  return known;
}

absl::StatusOr<WriteFunction> FindFormat(const std::string& path, OutputKind kind) {
  const std::string extension =
      absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
  for (const Format& format : kFormats) {
    const bool fits = !format.surfaces_only || kind == OutputKind::kSurface;
    if (fits && format.extension == extension) return format.write;
  }
  return MakeError(
      absl::StrCat(kind == OutputKind::kSurface ? "a surface" : "a mesh",
                   " cannot be written to a file of extension \"", extension, "\": ", path),
      {.reason = Reason::kInvalidOption,
       .field = "output",
       .remedy = absl::StrCat("Known extensions are ", KnownExtensions(kind))});
}

// The writers look up vertices unchecked.
absl::Status CheckIndices(const io::SurfaceView& view) {
  Index before = 0;
  for (const Index begin : view.face_begin) {
    if (begin < before || begin > view.vertices.size()) {
      return MakeError("face_begin decreases or passes the last corner",
                       {.reason = Reason::kMalformedRequest,
                        .field = "face_begin",
                        .remedy = "See PolygonMesh for what it holds"});
    }
    before = begin;
  }
  if (!view.normals.empty() && view.normals.size() != view.positions.size()) {
    return MakeError(
        absl::StrCat(view.normals.size(), " normals for ", view.positions.size(), " vertices"),
        {.reason = Reason::kMalformedRequest,
         .field = "normals",
         .remedy = "Give one normal per vertex, or none"});
  }
  for (std::size_t c = 0; c < view.vertices.size(); ++c) {
    if (view.vertices[c] < view.positions.size()) continue;
    return MakeError(absl::StrCat("corner ", c, " names vertex ", view.vertices[c], " of ",
                                  view.positions.size()),
                     {.reason = Reason::kIndexOutOfRange,
                      .field = "corners",
                      .index = c,
                      .remedy = "Every vertex of a face must exist"});
  }
  return absl::OkStatus();
}

absl::Status Write(const std::string& path, const io::SurfaceView& view, OutputKind kind,
                   io::OutputFile* file) {
  LIMN_ASSIGN_OR_RETURN(const WriteFunction write, FindFormat(path, kind));
  LIMN_RETURN_IF_ERROR(CheckIndices(view));
  return write(view, file);
}

absl::Status WriteAndCommit(const std::string& path, const io::SurfaceView& view, OutputKind kind) {
  LIMN_RETURN_IF_ERROR(FindFormat(path, kind).status());
  LIMN_RETURN_IF_ERROR(CheckIndices(view));
  LIMN_ASSIGN_OR_RETURN(const std::unique_ptr<io::OutputFile> file, io::OutputFile::Create(path));
  LIMN_RETURN_IF_ERROR(Write(path, view, kind, file.get()));
  return file->Commit();
}

absl::Status OutOfMemory(const std::string& path) {
  return MakeError(absl::StrCat("no memory to write ", path),
                   {.reason = Reason::kOutOfMemory,
                    .field = "output",
                    .remedy = "Write .ply, which needs none"});
}

// write(): what may throw.
template <class F>
absl::Status Explained(const std::string& path, const F& write) {
  try {
    return write();
  } catch (const std::bad_alloc&) {
    return OutOfMemory(path);
  } catch (const std::length_error&) {
    return OutOfMemory(path);
  } catch (const std::exception& error) {  // tinygltf's JSON library throws
    return MakeError(absl::StrCat("cannot write ", path, ": ", error.what()),
                     {.reason = Reason::kInternal, .field = "output"});
  }
}

}  // namespace

absl::Status CheckWritable(const std::string& path, OutputKind kind) {
  LIMN_RETURN_IF_ERROR(FindFormat(path, kind).status());
  return io::OutputFile::Create(path).status();
}

absl::Status WriteMeshFile(const std::string& path, const PolygonMesh& mesh) {
  return Explained(path,
                   [&] { return WriteAndCommit(path, io::SurfaceView(mesh), OutputKind::kMesh); });
}

absl::Status WriteSurfaceFile(const std::string& path, const Tessellation& surface) {
  return Explained(
      path, [&] { return WriteAndCommit(path, io::SurfaceView(surface), OutputKind::kSurface); });
}

absl::Status WriteMeshTo(const std::string& path, const PolygonMesh& mesh, io::OutputFile* file) {
  return Explained(path,
                   [&] { return Write(path, io::SurfaceView(mesh), OutputKind::kMesh, file); });
}

absl::Status WriteSurfaceTo(const std::string& path, const Tessellation& surface,
                            io::OutputFile* file) {
  return Explained(
      path, [&] { return Write(path, io::SurfaceView(surface), OutputKind::kSurface, file); });
}

}  // namespace limn
