// SPDX-License-Identifier: MIT
// A job's summary for a program.
#include <google/protobuf/util/json_util.h>

#include <string>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/report.h"
#include "engine/base/buffer.h"
#include "proto/wire/repair_mapping.h"

namespace limn::cli {
namespace {

// "[0, 2, 3]" for a mapping's bytes.
std::string ListJson(std::string_view bytes) {
  const Buffer<Index> elements = wire::MappingElements(bytes);
  return absl::StrCat("[", absl::StrJoin(elements, ", "), "]");
}

// Puts a list in the place of an empty member.
void FillMember(const std::string& name, const std::string& list, std::string* json) {
  const std::string member = absl::StrCat("\"", name, "\": ");
  const std::size_t at = json->find(member + "\"\"");
  if (at != std::string::npos) json->replace(at + member.size(), 2, list);
}

}  // namespace

absl::StatusOr<std::string> SummaryJson(const v1::Summary& summary) {
  v1::Summary shown = summary;
  if (shown.has_repair()) {
    shown.mutable_repair()->clear_original_vertex();
    shown.mutable_repair()->clear_original_face();
  }
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto status = google::protobuf::util::MessageToJsonString(shown, &json, options);
  if (!status.ok()) return absl::InternalError("the report cannot be put into JSON");
  FillMember("originalVertex", ListJson(summary.repair().original_vertex()), &json);
  FillMember("originalFace", ListJson(summary.repair().original_face()), &json);
  return json;
}

}  // namespace limn::cli
