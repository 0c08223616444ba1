// SPDX-License-Identifier: MIT
// Constraints in a file: the JSON mapping of limn.v1.Constraints.
#include "client/cli/constraints_file.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string_view>

#include "absl/strings/cord.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

constexpr std::size_t kMostBytes = std::size_t{256} << 20;
// What is quoted of a file at the most.
constexpr std::size_t kMostQuoted = 60;

absl::Status Malformed(const std::string& path, const std::string& what) {
  return MakeError(absl::StrCat(path, ": ", what),
                   {.reason = Reason::kMalformedFile,
                    .field = "constraints",
                    .remedy = "It has to be the JSON of limn.v1.Constraints"});
}

std::string Shortened(std::string_view text) {
  return absl::StrCat(std::string(text.substr(0, kMostQuoted)),
                      text.size() > kMostQuoted ? "..." : "");
}

// A value that protobuf calls `invalid value "x" for type TYPE_DOUBLE`.
std::string ExplainValue(std::string_view what) {
  constexpr std::string_view kBegin = "invalid value ";
  constexpr std::string_view kEnd = " for type ";
  const std::size_t end = what.rfind(kEnd);
  const std::string value = Shortened(what.substr(kBegin.size(), end - kBegin.size()));
  const std::string_view type = what.substr(end + kEnd.size());
  if (type == "TYPE_UINT32") return value + " is not a whole number from 0 to 4294967295";
  if (type == "TYPE_DOUBLE") return value + " is not a number";
  const bool object = type.find('/') != std::string_view::npos;
  return value + (object ? " is not an object, {...}" : " is no value of this field");
}

std::string Explain(std::string_view what) {
  if (what.starts_with("invalid value ") && what.rfind(" for type ") != std::string_view::npos) {
    return ExplainValue(what);
  }
  if (what == "Cannot find field.") return "there is no such field";
  if (what == "Root element must be a message.") return "there is no object, {...}";
  if (what.starts_with("Proto field is not repeating")) return "a list does not belong here";
  return std::string(what);
}

// protobuf's "(normals[1]) vertx: Cannot find field." or "(normals[1].vertex): invalid value ...".
std::string ExplainField(std::string_view error) {
  std::string path;
  if (error.starts_with('(')) {
    const std::size_t end = std::min(error.find(')'), error.size() - 1);
    path = std::string(error.substr(1, end - 1));
    error.remove_prefix(end + 1);
    if (error.starts_with(' ')) error.remove_prefix(1);
  }
  const std::size_t colon = error.find(": ");
  if (colon == std::string_view::npos) return absl::StrCat(path, Shortened(error));
  if (colon > 0) {
    absl::StrAppend(&path, path.empty() ? "" : ".", Shortened(error.substr(0, colon)));
  }
  return absl::StrCat(path, path.empty() ? "" : ": ", Explain(error.substr(colon + 2)));
}

// " in line N" if the piece stands at one place of the text only.
std::string LineOf(std::string_view json, std::string_view piece, std::size_t offset) {
  const std::size_t at = json.find(piece);
  if (at == std::string_view::npos || json.find(piece, at + 1) != std::string_view::npos) return "";
  const auto line = std::count(json.begin(), json.begin() + static_cast<long>(at + offset), '\n');
  return absl::StrCat(" in line ", line + 1);
}

// protobuf's three parts of an error of syntax: what, the text around, a caret below the place.
std::string ExplainSyntax(std::string_view error, std::string_view json) {
  const std::size_t first = error.find('\n');
  const std::size_t last = error.rfind('\n');
  std::string_view what = error.substr(0, first);
  if (what.ends_with('.')) what.remove_suffix(1);
  const std::string_view piece =
      first < last ? error.substr(first + 1, last - first - 1) : std::string_view();
  const std::size_t caret = std::min(error.size() - last - 2, piece.size());
  std::string_view here = piece.substr(caret);
  here = here.substr(0, here.find('\n'));
  const std::string place =
      here.empty() ? " at its end"
                   : absl::StrCat(LineOf(json, piece, caret), " at '", std::string(here), "'");
  return absl::StrCat("no JSON", place, ": ", std::string(what));
}

absl::Status SystemError(const std::string& path) {
  return absl::ErrnoToStatus(errno, absl::StrCat("cannot read ", path));
}

absl::StatusOr<std::string> ReadText(const std::string& path) {
  const auto close = [](std::FILE* file) { std::fclose(file); };
  const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rbe"), close);
  if (file == nullptr) return SystemError(path);
  std::string text;
  std::array<char, 64 << 10> block;
  while (const std::size_t got = std::fread(block.data(), 1, block.size(), file.get())) {
    text.append(block.data(), got);
    if (text.size() > kMostBytes) {
      return Malformed(path, absl::StrCat("it is larger than ", kMostBytes, " bytes"));
    }
  }
  if (std::ferror(file.get()) != 0) return SystemError(path);
  return text;
}

}  // namespace

void AddConstraintsFlag(CLI::App& app, std::string* path) {
  app.add_option("--constraints", *path,
                 "What the surface meets, as JSON of limn.v1.Constraints: which vertices to "
                 "interpolate, normals, shape handles [all vertices]")
      ->type_name("FILE.json");
}

absl::StatusOr<v1::Constraints> ParseConstraints(const std::string& json, const std::string& path) {
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = false;
  v1::Constraints constraints;
  const auto status = google::protobuf::util::JsonStringToMessage(json, &constraints, options);
  if (status.ok()) return constraints;
  const std::string error(status.message());
  return Malformed(path, error.ends_with('^') ? ExplainSyntax(error, json) : ExplainField(error));
}

absl::StatusOr<v1::Constraints> ReadConstraintsFile(const std::string& path) {
  LIMN_ASSIGN_OR_RETURN(const std::string text, ReadText(path));
  return ParseConstraints(text, path);
}

absl::Status NameConstraintsFile(const absl::Status& status, const std::string& path) {
  const auto detail = GetErrorDetail(status);
  if (path.empty() || !detail.has_value()) return status;
  const bool too_large = status.code() == absl::StatusCode::kResourceExhausted &&
                         absl::StrContains(status.message(), "message larger than max");
  if (!too_large && !detail->field.starts_with("constraints")) return status;
  absl::Status named(
      status.code(),
      absl::StrCat(
          path, ": ", status.message(),
          too_large ? ". Use fewer constraints, or raise the server's --max-message-bytes" : ""));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { named.SetPayload(url, payload); });
  return named;
}

}  // namespace limn::cli
