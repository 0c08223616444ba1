// SPDX-License-Identifier: MIT
// What the format readers put vertices and faces into, and their common errors.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::io {

class MeshCollector {
 public:
  // file: the name for messages, without folders.
  explicit MeshCollector(std::string file) : file_(std::move(file)) {
    mesh_.face_begin.push_back(0);
  }

  const std::string& file() const { return file_; }
  std::size_t vertex_count() const { return mesh_.vertex_count(); }
  std::size_t face_count() const { return mesh_.face_begin.size() - 1; }

  void AddVertex(const Vec3& point) { mesh_.positions.push_back(point); }

  // Adds a corner to the present face, which began at that line (0 in binary files). `vertex`
  // counts from 0 and may come later in the file.
  absl::Status AddCorner(std::int64_t vertex, std::uint64_t line) {
    if (vertex < 0 || vertex >= kNoIndex) return NoSuchVertex(face_count(), vertex, line);
    mesh_.corner_vertex.push_back(static_cast<Index>(vertex));
    return absl::OkStatus();
  }

  // Ends the present face.
  absl::Status EndFace(std::uint64_t line) {
    if (mesh_.corner_count() >= kNoIndex || mesh_.vertex_count() >= kNoIndex) {
      return MakeError(absl::StrCat(file_, " has more than 2^32 - 1 vertices or corners"),
                       {.reason = Reason::kLimitExceeded,
                        .field = "file",
                        .remedy = "Split the mesh into several files"});
    }
    mesh_.face_begin.push_back(static_cast<Index>(mesh_.corner_count()));
    face_line_.push_back(line);
    return absl::OkStatus();
  }

  // The mesh, if it has faces and their vertices exist.
  absl::StatusOr<PolygonMesh> Take() {
    if (mesh_.vertex_count() == 0 || face_count() == 0) {
      return MakeError(absl::StrCat(file_, " has ", mesh_.vertex_count(), " vertices and ",
                                    face_count(), " faces"),
                       {.reason = Reason::kEmptyMesh,
                        .field = "file",
                        .remedy = "A mesh needs vertices and faces"});
    }
    for (std::size_t f = 0; f < face_count(); ++f) {
      for (const Index v : mesh_.face(f)) {
        if (v >= mesh_.vertex_count()) return NoSuchVertex(f, v, face_line_[f]);
      }
    }
    return std::move(mesh_);
  }

  // MALFORMED_FILE at a line, or at no line in particular for line 0.
  absl::Status Malformed(std::uint64_t line, const std::string& what) const {
    ErrorDetail detail = {.reason = Reason::kMalformedFile,
                          .field = "file",
                          .remedy = "Export the file again or convert it with another program"};
    if (line != 0) detail.index = line;
    return MakeError(absl::StrCat(file_, Place(line), ": ", what), detail);
  }

  // INDEX_OUT_OF_RANGE; `vertex` counts from 0 and may be negative.
  absl::Status NoSuchVertex(std::size_t face, std::int64_t vertex, std::uint64_t line) const {
    return MakeError(absl::StrCat(file_, Place(line), ": face ", face, " names vertex ", vertex,
                                  " (faces and vertices counted from 0), but the file has ",
                                  mesh_.vertex_count(), " vertices"),
                     {.reason = Reason::kIndexOutOfRange,
                      .field = "faces",
                      .index = face,
                      .remedy = "Every vertex of a face must be in the file"});
  }

 private:
  static std::string Place(std::uint64_t line) {
    return line == 0 ? "" : absl::StrCat(", line ", line);
  }

  std::string file_;
  PolygonMesh mesh_;
  Buffer<std::uint64_t> face_line_;
};

// The readers: `bytes` is the whole file.
absl::Status ReadObj(std::string_view bytes, MeshCollector* collector);
absl::Status ReadOff(std::string_view bytes, MeshCollector* collector);
absl::Status ReadPly(std::string_view bytes, MeshCollector* collector);
absl::Status ReadStl(std::string_view bytes, MeshCollector* collector);

}  // namespace limn::io
