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
    std::int64_t vertices = 0;
    std::int64_t faces = 0;
    LIMN_RETURN_IF_ERROR(ReadHeader(&vertices, &faces));
    for (std::int64_t v = 0; v < vertices; ++v) LIMN_RETURN_IF_ERROR(ReadVertex(v));
    for (std::int64_t f = 0; f < faces; ++f) LIMN_RETURN_IF_ERROR(ReadFace(f));
    const std::string_view more = scanner_.Token();
    if (more.empty()) return absl::OkStatus();
    return Malformed(
        absl::StrCat(Quoted(more), " after the ", faces, " faces that the header promises"));
  }

 private:
  absl::Status Malformed(const std::string& what) const {
    return collector_->Malformed(scanner_.line(), what);
  }

  absl::Status ReadHeader(std::int64_t* vertices, std::int64_t* faces) {
    std::string_view token = scanner_.Token();
    std::string_view magic = token;
    for (const std::string_view prefix : {"ST", "C", "N"}) {
      if (magic.substr(0, prefix.size()) == prefix) magic.remove_prefix(prefix.size());
    }
    if (magic == "OFF") {
      token = scanner_.Token();
    } else if (!ParseInteger(token, vertices)) {  // Geomview allows to leave out the magic.
      return Malformed("an OFF file of dimension 3 should begin with OFF, not with " +
                       Quoted(token));
    }
    if (token == "BINARY") return Malformed("binary OFF is not supported");
    LIMN_RETURN_IF_ERROR(ParseCount(token, "the number of vertices", vertices));
    LIMN_RETURN_IF_ERROR(ParseCount(scanner_.Token(), "the number of faces", faces));
    scanner_.NextLine();  // The number of edges, which many programs get wrong or leave out.
    // The shortest vertex is "0 0 0" and an end of line, the shortest face "0".
    if (*vertices > static_cast<std::int64_t>(scanner_.left() / 6 + 1) ||
        *faces > static_cast<std::int64_t>(scanner_.left() / 2 + 1)) {
      return Malformed(absl::StrCat("the header promises ", *vertices, " vertices and ", *faces,
                                    " faces, more than the ", scanner_.left(),
                                    " bytes after it can hold"));
    }
    return absl::OkStatus();
  }

  absl::Status ParseCount(std::string_view token, const std::string& what, std::int64_t* count) {
    if (ParseInteger(token, count) && *count >= 0) return absl::OkStatus();
    return Malformed(what + " should be a whole number, not " + Quoted(token));
  }

  absl::Status ReadVertex(std::int64_t v) {
    Vec3 point = {};
    for (double* coordinate : {&point.x, &point.y, &point.z}) {
      const std::string_view token = scanner_.Token();
      if (ParseDouble(token, coordinate)) continue;
      return Malformed(absl::StrCat(
          "vertex ", v, " (counted from 0) should have three numbers, not ", OrEnd(token)));
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
      return Malformed(absl::StrCat("face ", f,
                                    " (counted from 0) should begin with its number of ",
                                    "corners, not ", OrEnd(token)));
    }
    for (std::int64_t i = 0; i < arity; ++i) {
      const std::string_view corner = scanner_.Token();
      std::int64_t vertex = 0;
      if (!ParseInteger(corner, &vertex)) {
        return Malformed(absl::StrCat("face ", f, " (counted from 0) should name ", arity,
                                      " vertices, but there is ", OrEnd(corner)));
      }
      LIMN_RETURN_IF_ERROR(collector_->AddCorner(vertex, line));
    }
    LIMN_RETURN_IF_ERROR(collector_->EndFace(line));
    scanner_.NextLine();
    return absl::OkStatus();
  }

  static std::string OrEnd(std::string_view token) {
    return token.empty() ? "the end of the file" : Quoted(token);
  }

  TextScanner scanner_;
  MeshCollector* collector_;
};

}  // namespace

absl::Status ReadOff(std::string_view bytes, MeshCollector* collector) {
  return OffReader(bytes, collector).Read();
}

}  // namespace limn::io
