// SPDX-License-Identifier: MIT
#include "client/cli/batch_manifest.h"

#include <google/protobuf/struct.pb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/cli/job_checks.h"
#include "client/cli/message_file.h"
#include "client/cli/usage.h"
#include "engine/base/context.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

namespace fs = std::filesystem;
using google::protobuf::Value;

constexpr std::array<std::string_view, 4> kEndings = {".obj", ".off", ".ply", ".stl"};

absl::Status Malformed(const std::string& place, std::string_view what, std::string_view remedy) {
  return MakeError(
      absl::StrCat(place, ": ", std::string(what)),
      {.reason = Reason::kMalformedFile, .field = "manifest", .remedy = std::string(remedy)});
}

absl::Status Invalid(const std::string& place, std::string_view what, std::string_view remedy) {
  return MakeError(
      absl::StrCat(place, ": ", std::string(what)),
      {.reason = Reason::kInvalidOption, .field = "manifest", .remedy = std::string(remedy)});
}

// One member of a line into the entry; false: it is of another type, or out of range.
using Setter = bool (*)(const Value&, BatchEntry*);

bool SetText(const Value& value, std::string* text) {
  *text = value.string_value();
  return value.kind_case() == Value::kStringValue && !text->empty();
}

bool SetLevel(const Value& value, BatchEntry* entry) {
  const double level = value.number_value();
  if (value.kind_case() != Value::kNumberValue || !(level >= 0 && level <= kMaxLevel)) return false;
  entry->options.level = static_cast<std::uint32_t>(level);
  entry->options.chord_tolerance.reset();
  return level == std::floor(level);
}

bool SetChordTolerance(const Value& value, BatchEntry* entry) {
  const double tolerance = value.number_value();
  entry->options.chord_tolerance = tolerance;
  return value.kind_case() == Value::kNumberValue && tolerance > 0 && std::isfinite(tolerance);
}

bool SetScheme(const Value& value, BatchEntry* entry) {
  return SetText(value, &entry->options.scheme) &&
         MakeJobHeader(entry->options, {}).scheme() != v1::SCHEME_UNSPECIFIED;
}

bool SetRepair(const Value& value, BatchEntry* entry) {
  entry->options.repair = value.bool_value();
  return value.kind_case() == Value::kBoolValue;
}

struct Member {
  std::string_view name;
  std::string_view wanted;
  Setter set;
};

constexpr std::array<Member, 8> kMembers = {{
    {"input", "a file's name", [](const Value& v, BatchEntry* e) { return SetText(v, &e->input); }},
    {"id", "a name", [](const Value& v, BatchEntry* e) { return SetText(v, &e->id); }},
    {"output", "a name", [](const Value& v, BatchEntry* e) { return SetText(v, &e->output); }},
    {"constraints", "a file's name",
     [](const Value& v, BatchEntry* e) { return SetText(v, &e->constraints); }},
    {"scheme", "doo-sabin, catmull-clark or loop", SetScheme},
    {"level", "a whole number from 0 to 10", SetLevel},
    {"chordTolerance", "a number above 0", SetChordTolerance},
    {"repair", "true or false", SetRepair},
}};
static_assert(kMaxLevel == 10);

absl::Status SetMember(const std::string& place, const std::string& name, const Value& value,
                       BatchEntry* entry) {
  std::vector<std::string> known;
  for (const Member& member : kMembers) {
    if (member.name == name) {
      if (member.set(value, entry)) return absl::OkStatus();
      return Malformed(place, absl::StrCat(name, " is not ", std::string(member.wanted)),
                       "Correct it");
    }
    known.emplace_back(member.name);
  }
  const auto near = NearestWord(name, known);
  return Malformed(place,
                   absl::StrCat("there is no member '", name, "'",
                                near.has_value() ? "; did you mean " + *near + "?" : ""),
                   "See 'limn batch --help' for those there are");
}

std::string StemOf(const std::string& path) { return fs::path(path).stem().string(); }

// Made absolute by the manifest's folder.
void Resolve(const fs::path& folder, std::string* path) {
  if (!path->empty()) *path = (folder / *path).lexically_normal().string();
}

absl::StatusOr<BatchEntry> ParseLine(const std::string& line, const std::string& place,
                                     const BatchEntry& defaults) {
  google::protobuf::Struct object;
  LIMN_RETURN_IF_ERROR(ParseMessage(
      line, {.path = place, .field = "manifest", .remedy = "Write a JSON object in each line"},
      &object));
  BatchEntry entry = defaults;
  entry.constraints.clear();
  for (const auto& [name, value] : object.fields()) {
    LIMN_RETURN_IF_ERROR(SetMember(place, name, value, &entry));
  }
  if (entry.input.empty()) return Malformed(place, "it has no input", "Name a mesh file");
  if (object.fields().contains("level") && object.fields().contains("chordTolerance")) {
    return Invalid(place, "it has both a level and a chord tolerance", "Leave one of them out");
  }
  if (absl::Status status = CheckTogether(entry.options); !status.ok()) {
    return Surrounded(place + ": ", status);
  }
  const fs::path folder = fs::path(place.substr(0, place.rfind(':'))).parent_path();
  Resolve(folder, &entry.input);
  Resolve(folder, &entry.constraints);
  if (entry.constraints.empty()) entry.constraints = defaults.constraints;
  if (entry.id.empty()) entry.id = StemOf(entry.input);
  if (entry.output.empty()) entry.output = entry.id;
  return entry;
}

// As RFC 3629 has it, which JSON demands.
bool IsUtf8(std::string_view text) {
  std::size_t at = 0;
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  while (at < text.size()) {
    const unsigned lead = byte(at);
    const std::size_t length = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
    if ((lead >= 0x80 && lead < 0xc2) || lead > 0xf4) return false;
    const unsigned second = byte(at + 1);
    if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f)) return false;
    if ((lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second > 0x8f)) return false;
    for (std::size_t i = 1; i < length; ++i) {
      if ((byte(at + i) & 0xc0U) != 0x80) return false;
    }
    at += length;
  }
  return true;
}

// Whether the id or output is one that no entry before had.
class Names {
 public:
  absl::Status Check(const std::string& place, const BatchEntry& entry) {
    if (!IsUtf8(entry.id) || !IsUtf8(entry.output)) {
      return Invalid(place, "its name is not in UTF-8", "Give it an id in a manifest");
    }
    const bool plain = entry.output.find('/') == std::string::npos && entry.output[0] != '.' &&
                       entry.output.find('\0') == std::string::npos;
    if (!plain) {
      return Invalid(place, absl::StrCat("the output '", entry.output, "' is no plain name"),
                     "Give it an output without a folder");
    }
    LIMN_RETURN_IF_ERROR(CheckOne(place, "id", entry.id, &ids_));
    return CheckOne(place, "output", entry.output, &outputs_);
  }

 private:
  static absl::Status CheckOne(const std::string& place, std::string_view what,
                               const std::string& name, std::map<std::string, std::string>* seen) {
    const auto [at, fresh] = seen->emplace(name, place);
    if (fresh) return absl::OkStatus();
    return Invalid(place,
                   absl::StrCat("the ", std::string(what), " '", name, "' is that of ", at->second),
                   "Give every job its own, in a manifest");
  }

  std::map<std::string, std::string> ids_;
  std::map<std::string, std::string> outputs_;
};

absl::StatusOr<std::vector<BatchEntry>> ReadManifest(const std::string& path,
                                                     const BatchEntry& defaults) {
  LIMN_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path));
  std::vector<BatchEntry> entries;
  Names names;
  std::size_t number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    const std::string place = absl::StrCat(path, ":", ++number);
    if (absl::StripAsciiWhitespace(line).empty()) continue;
    LIMN_ASSIGN_OR_RETURN(BatchEntry entry, ParseLine(std::string(line), place, defaults));
    LIMN_RETURN_IF_ERROR(names.Check(place, entry));
    entries.push_back(std::move(entry));
  }
  return entries;
}

bool IsMeshName(const fs::path& path) {
  const std::string ending = absl::AsciiStrToLower(path.extension().string());
  const std::string name = path.filename().string();
  return name[0] != '.' && std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

absl::StatusOr<std::vector<BatchEntry>> ReadFolder(const std::string& path,
                                                   const BatchEntry& defaults) {
  std::error_code error;
  std::vector<std::string> files;
  for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error)) {
    if (IsMeshName(at->path()) && at->is_regular_file()) files.push_back(at->path().string());
  }
  if (error) return absl::ErrnoToStatus(error.value(), absl::StrCat("cannot read ", path));
  std::sort(files.begin(), files.end());
  std::vector<BatchEntry> entries;
  Names names;
  for (const std::string& file : files) {
    BatchEntry entry = defaults;
    entry.input = file;
    entry.id = entry.output = StemOf(file);
    LIMN_RETURN_IF_ERROR(names.Check(file, entry));
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace

absl::StatusOr<std::vector<BatchEntry>> ReadBatchEntries(const std::string& path,
                                                         const BatchEntry& defaults) {
  std::error_code error;
  const bool folder = fs::is_directory(path, error);
  absl::StatusOr<std::vector<BatchEntry>> entries =
      folder ? ReadFolder(path, defaults) : ReadManifest(path, defaults);
  if (!entries.ok() || !entries->empty()) return entries;
  return MakeError(absl::StrCat(path, ": there are no jobs in it"),
                   {.reason = Reason::kEmptyMesh,
                    .field = "manifest",
                    .remedy = folder ? "Name a folder with .obj, .off, .ply or .stl files"
                                     : "Write a line for each job"});
}

}  // namespace limn::cli
