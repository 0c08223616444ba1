// SPDX-License-Identifier: MIT
// OFF of Geomview as text: [ST][C][N]OFF, counts, one vertex a line, one face a line; what follows
// on a vertex's or face's line (normals, colours) is skipped.
#include <cstdint>
#include <string>
#include <string_view>

#include "client/io/mesh_collector.h"
#include "client/io/text_scanner.h"

namespace limn::io {
namespace {

class OffReader {
 public:
  OffReader(std::string_view bytes, MeshCollector* collector)
      : scanner_(bytes, '#', /*continued=*/false), collector_(collector) {}

  absl::Status Read() {
    LIMN_RETURN_IF_ERROR(ReadHeader());
    for (std::int64_t v = 0; v < vertices_; ++v) LIMN_RETURN_IF_ERROR(ReadVertex(v));
    for (std::int64_t f = 0; f < faces_; ++f) LIMN_RETURN_IF_ERROR(ReadFace(f));
    const std::string_view more = scanner_.Token();
    if (more.empty()) return absl::OkStatus();
    return Malformed(
        absl::StrCat(Quoted(more), " after the ", faces_, " faces that the header promises"));
  }

 private:
  absl::Status Malformed(const std::string& what) const {
    return collector_->Malformed(scanner_.line(), what);
  }

  absl::Status ReadHeader() {
    std::string_view token = scanner_.Token();
    std::string_view magic = token;
    for (const std::string_view prefix : {"ST", "C", "N"}) {
      if (magic.substr(0, prefix.size()) == prefix) magic.remove_prefix(prefix.size());
    }
    if (magic == "OFF") {
      token = scanner_.Token();
    } else if (!ParseInteger(token, &vertices_)) {  // Geomview allows to leave out the magic.
      return Malformed("an OFF file of dimension 3 should begin with OFF, not with " +
                       Quoted(token));
    }
    if (token == "BINARY") return Malformed("binary OFF is not supported");
    LIMN_RETURN_IF_ERROR(ParseCount(token, "the number of vertices", &vertices_));
    LIMN_RETURN_IF_ERROR(ParseCount(scanner_.Token(), "the number of faces", &faces_));
    scanner_.NextLine();  // The number of edges, which many programs get wrong or leave out.
    // The shortest vertex is "0 0 0" and an end of line, the shortest face "0".
    if (vertices_ > static_cast<std::int64_t>(scanner_.left() / 6 + 1) ||
        faces_ > static_cast<std::int64_t>(scanner_.left() / 2 + 1)) {
      return Malformed(absl::StrCat("the header promises ", vertices_, " vertices and ", faces_,
                                    " faces, more than the ", scanner_.left(),
                                    " bytes after it can hold"));
    }
    return absl::OkStatus();
  }

  absl::Status ParseCount(std::string_view token, const std::string& what, std::int64_t* count) {
    if (ParseInteger(token, count) && *count >= 0) return absl::OkStatus();
    return Malformed(what + " should be a whole number, not " + Quoted(token));
  }

  // Each vertex and each face is on a line of its own: what is missing there is not taken from the
  // next line.
  absl::Status ReadVertex(std::int64_t v) {
    Vec3 point = {};
    std::string_view token = scanner_.Token();
    for (double* coordinate : {&point.x, &point.y, &point.z}) {
      if (!ParseDouble(token, coordinate)) {
        return Malformed(absl::StrCat("vertex ", v, " (counted from 0) of ", vertices_,
                                      " should have three numbers, not ", OrEnd(token)));
      }
      if (coordinate != &point.z) token = scanner_.TokenOnLine();
    }
    collector_->AddVertex(point);
    scanner_.NextLine();
    return absl::OkStatus();
  }

  absl::Status ReadFace(std::int64_t f) {
    const std::string_view token = scanner_.Token();
    const std::uint64_t line = scanner_.line();
    std::int64_t arity = 0;
    if (!ParseInteger(token, &arity) || arity < 0) {
      return Malformed(absl::StrCat("face ", f, " (counted from 0) of ", faces_,
                                    " should begin with its number of corners, not ",
                                    OrEnd(token)));
    }
    for (std::int64_t i = 0; i < arity; ++i) {
      const std::string_view corner = scanner_.TokenOnLine();
      std::int64_t vertex = 0;
      if (!ParseInteger(corner, &vertex)) {
        return Malformed(absl::StrCat("face ", f, " (counted from 0) should name ", arity,
                                      " vertices, not ", OrEnd(corner)));
      }
      LIMN_RETURN_IF_ERROR(collector_->AddCorner(vertex, line));
    }
    LIMN_RETURN_IF_ERROR(collector_->EndFace(line));
    scanner_.NextLine();
    return absl::OkStatus();
  }

  std::string OrEnd(std::string_view token) const {
    return token.empty() && scanner_.left() == 0 ? "the end of the file" : Quoted(token);
  }

  TextScanner scanner_;
  MeshCollector* collector_;
  std::int64_t vertices_ = 0;
  std::int64_t faces_ = 0;
};

}  // namespace

absl::Status ReadOff(std::string_view bytes, MeshCollector* collector) {
  return OffReader(bytes, collector).Read();
}

}  // namespace limn::io
