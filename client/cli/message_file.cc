// SPDX-License-Identifier: MIT
// Text files, and messages in their JSON mapping.
#include "client/cli/message_file.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string_view>

#include "absl/strings/cord.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

constexpr std::size_t kMostBytes = std::size_t{256} << 20;
// What is quoted of a file at the most.
constexpr std::size_t kMostQuoted = 60;

std::string Shortened(std::string_view text) {
  return absl::StrCat(std::string(text.substr(0, kMostQuoted)),
                      text.size() > kMostQuoted ? "..." : "");
}

// " is none of A, B" for an enumeration's full name.
std::string ExplainEnum(const google::protobuf::EnumDescriptor& kind) {
  std::string text = " is none of ";
  for (int i = 0; i < kind.value_count(); ++i) {
    absl::StrAppend(&text, i == 0 ? "" : ", ", kind.value(i)->name());
  }
  return text;
}

// A value that protobuf calls `invalid value "x" for type TYPE_DOUBLE`, or, for messages and
// enumerations, `... for type type.googleapis.com/NAME`.
std::string ExplainValue(std::string_view what, const google::protobuf::DescriptorPool& pool) {
  constexpr std::string_view kBegin = "invalid value ";
  constexpr std::string_view kEnd = " for type ";
  const std::size_t end = what.rfind(kEnd);
  const std::string value = Shortened(what.substr(kBegin.size(), end - kBegin.size()));
  const std::string_view type = what.substr(end + kEnd.size());
  if (type == "TYPE_UINT32") return value + " is not a whole number from 0 to 4294967295";
  if (type == "TYPE_DOUBLE") return value + " is not a number";
  const std::size_t slash = type.rfind('/');
  if (slash == std::string_view::npos) return value + " is no value of this field";
  const auto* kind = pool.FindEnumTypeByName(std::string(type.substr(slash + 1)));
  return value + (kind != nullptr ? ExplainEnum(*kind) : " is not an object, {...}");
}

std::string Explain(std::string_view what, const google::protobuf::DescriptorPool& pool) {
  if (what.starts_with("invalid value ") && what.rfind(" for type ") != std::string_view::npos) {
    return ExplainValue(what, pool);
  }
  if (what == "Cannot find field.") return "there is no such field";
  if (what == "Root element must be a message.") return "there is no object, {...}";
  if (what.starts_with("Proto field is not repeating")) return "a list does not belong here";
  return std::string(what);
}

// protobuf's "(normals[1]) vertx: Cannot find field." or "(normals[1].vertex): invalid value ...".
std::string ExplainField(std::string_view error, const std::string& prefix,
                         const google::protobuf::DescriptorPool& pool) {
  std::string path;
  if (error.starts_with('(')) {
    const std::size_t end = std::min(error.find(')'), error.size() - 1);
    path = absl::StrCat(prefix, std::string(error.substr(1, end - 1)));
    error.remove_prefix(end + 1);
    if (error.starts_with(' ')) error.remove_prefix(1);
  }
  const std::size_t colon = error.find(": ");
  if (colon == std::string_view::npos) return absl::StrCat(path, Shortened(error));
  if (colon > 0) {
    absl::StrAppend(&path, path.empty() ? prefix : ".", Shortened(error.substr(0, colon)));
  }
  return absl::StrCat(path, path.empty() ? "" : ": ", Explain(error.substr(colon + 2), pool));
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

// Of a file that somebody else opened.
absl::StatusOr<std::string> ReadAll(std::FILE* file, const std::string& name) {
  std::string text;
  std::array<char, 64 << 10> block;
  while (const std::size_t got = std::fread(block.data(), 1, block.size(), file)) {
    text.append(block.data(), got);
    if (text.size() > kMostBytes) {
      return MakeError(
          absl::StrCat(name, ": it is larger than ", kMostBytes, " bytes"),
          {.reason = Reason::kMalformedFile, .field = "file", .remedy = "Use a smaller one"});
    }
  }
  if (std::ferror(file) != 0) return SystemError(name);
  return text;
}

}  // namespace

absl::StatusOr<std::string> ReadTextFile(const std::string& path) {
  const auto close = [](std::FILE* file) { std::fclose(file); };
  const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rbe"), close);
  if (file == nullptr) return SystemError(path);
  return ReadAll(file.get(), path);
}

absl::StatusOr<std::string> ReadStandardInput() { return ReadAll(stdin, "standard input"); }

absl::Status WithMessage(const absl::Status& status, const std::string& message) {
  absl::Status other(status.code(), message);
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { other.SetPayload(url, payload); });
  return other;
}

absl::Status Surrounded(const std::string& before, const absl::Status& status,
                        const std::string& after) {
  return WithMessage(status, absl::StrCat(before, status.message(), after));
}

absl::Status ParseMessage(const std::string& json, const MessageFile& file,
                          google::protobuf::Message* message) {
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = false;
  const auto status = google::protobuf::util::JsonStringToMessage(json, message, options);
  if (status.ok()) return absl::OkStatus();
  const std::string error(status.message());
  const google::protobuf::DescriptorPool& pool = *message->GetDescriptor()->file()->pool();
  const std::string what =
      error.ends_with('^') ? ExplainSyntax(error, json) : ExplainField(error, file.prefix, pool);
  return MakeError(
      absl::StrCat(file.path, ": ", what),
      {.reason = Reason::kMalformedFile,
       .field = file.field,
       .remedy = file.remedy.empty() ? absl::StrCat("It has to be the JSON of ",
                                                    message->GetDescriptor()->full_name())
                                     : file.remedy});
}

}  // namespace limn::cli
