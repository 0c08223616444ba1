// SPDX-License-Identifier: MIT
// Wavefront OBJ: the statements v and f; all others are skipped.
#include <cstdint>
#include <string>
#include <string_view>

#include "client/io/mesh_collector.h"
#include "client/io/text_scanner.h"

namespace limn::io {
namespace {

// The vertex number of a corner "v", "v/vt", "v//vn" or "v/vt/vn".
bool ParseCorner(std::string_view token, std::int64_t* number) {
  const std::size_t slash = token.find('/');
  if (slash != std::string_view::npos) {
    if (token.find_first_not_of("0123456789+-/", slash) != std::string_view::npos) return false;
    token = token.substr(0, slash);
  }
  return ParseInteger(token, number);
}

absl::Status ReadVertex(TextScanner* scanner, MeshCollector* collector) {
  Vec3 point = {};
  const std::uint64_t line = scanner->line();
  for (double* coordinate : {&point.x, &point.y, &point.z}) {
    const std::string_view token = scanner->TokenOnLine();
    if (!ParseDouble(token, coordinate)) {
      return collector->Malformed(line, "a coordinate should be a number, not " + Quoted(token));
    }
  }
  collector->AddVertex(point);
  return absl::OkStatus();
}

absl::Status ReadFace(TextScanner* scanner, MeshCollector* collector) {
  const std::uint64_t line = scanner->line();
  for (std::string_view token = scanner->TokenOnLine(); !token.empty();
       token = scanner->TokenOnLine()) {
    std::int64_t number = 0;
    if (!ParseCorner(token, &number)) {
      return collector->Malformed(line, "a face should name vertices, not " + Quoted(token));
    }
    // Numbers count from 1; negative ones back from the vertex read last.
    const auto count = static_cast<std::int64_t>(collector->vertex_count());
    const bool valid = number > 0 || (number < 0 && number >= -count);
    if (!valid) {
      return MakeError(
          absl::StrCat(collector->file(), ", line ", line, ": face ", collector->face_count(),
                       " (counted from 0) names vertex ", number, " after ", count, " vertices"),
          {.reason = Reason::kIndexOutOfRange,
           .field = "faces",
           .index = collector->face_count(),
           .remedy = "OBJ counts vertices from 1, or from -1 backwards"});
    }
    LIMN_RETURN_IF_ERROR(collector->AddCorner(number > 0 ? number - 1 : count + number, line));
  }
  return collector->EndFace(line);
}

}  // namespace

absl::Status ReadObj(std::string_view bytes, MeshCollector* collector) {
  TextScanner scanner(bytes, '#', /*continued=*/true);
  do {
    const std::string_view keyword = scanner.TokenOnLine();
    if (keyword == "v") {
      LIMN_RETURN_IF_ERROR(ReadVertex(&scanner, collector));
    } else if (keyword == "f" || keyword == "fo") {
      LIMN_RETURN_IF_ERROR(ReadFace(&scanner, collector));
    } else if (keyword.find('\0') != std::string_view::npos) {
      return collector->Malformed(scanner.line(), "this is not text but " + Quoted(keyword));
    }
  } while (scanner.NextLine());
  return absl::OkStatus();
}

}  // namespace limn::io
