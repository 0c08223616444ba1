// SPDX-License-Identifier: MIT
// What `limn evaluate` reads and writes: parameters, and samples of the surface there.
#include "client/cli/samples_file.h"

#include <array>
#include <charconv>
#include <filesystem>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/cli/message_file.h"
#include "client/io/text_scanner.h"
#include "engine/base/error.h"
#include "limn/v1/evaluate.pb.h"
#include "proto/wire/samples.h"

namespace limn::cli {
namespace {

absl::Status Malformed(const std::string& place, const std::string& what) {
  return MakeError(absl::StrCat(place, ": ", what),
                   {.reason = Reason::kMalformedFile,
                    .field = "parameters",
                    .remedy = "A line is: face corner u v, such as: 0 2 0.5 0.25"});
}

bool ParseIndex(std::string_view token, Index* value) {
  std::int64_t number = 0;
  if (!io::ParseInteger(token, &number) || number < 0 || number > kNoIndex) return false;
  *value = static_cast<Index>(number);
  return true;
}

absl::StatusOr<ParametersFile> ParseLines(std::string_view text, const std::string& name) {
  ParametersFile file = {.name = name};
  io::TextScanner scanner(text, '#', false);
  do {
    const std::string_view face = scanner.TokenOnLine();
    if (face.empty()) continue;
    const std::array<std::string_view, 3> rest = {scanner.TokenOnLine(), scanner.TokenOnLine(),
                                                  scanner.TokenOnLine()};
    const std::string_view more = scanner.TokenOnLine();
    const std::string place = absl::StrCat(name, ":", scanner.line());
    SurfaceParameter p;
    const auto bad = [&](const char* what, std::string_view token) {
      return Malformed(place, absl::StrCat(what, " is ", io::Quoted(token)));
    };
    if (!ParseIndex(face, &p.face)) return bad("the face", face);
    if (!ParseIndex(rest[0], &p.corner)) return bad("the corner", rest[0]);
    if (!io::ParseDouble(rest[1], &p.u)) return bad("u", rest[1]);
    if (!io::ParseDouble(rest[2], &p.v)) return bad("v", rest[2]);
    if (!more.empty()) return bad("after the four numbers there", more);
    file.parameters.push_back(p);
    file.lines.push_back(scanner.line());
  } while (scanner.NextLine());
  return file;
}

absl::StatusOr<ParametersFile> ParseJson(const std::string& text, const std::string& name) {
  v1::ParameterBlock block;
  LIMN_RETURN_IF_ERROR(ParseMessage(text, {.path = name, .field = "parameters"}, &block));
  const absl::Status status = wire::CheckParameterArrays(block);
  if (!status.ok()) return Surrounded(absl::StrCat(name, ": "), status);
  return ParametersFile{
      .name = name,
      .parameters = wire::ReadParameters(block, 0, static_cast<std::size_t>(block.faces_size()))};
}

// Text that goes out when there is enough of it.
class TextSink {
 public:
  explicit TextSink(const WriteText& write) : write_(write) {}

  TextSink& Add(std::string_view text) {
    text_ += text;
    return *this;
  }
  template <class Number>
  TextSink& AddNumber(Number number) {
    std::array<char, 32> digits;
    const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    return Add({digits.data(), static_cast<std::size_t>(end - digits.data())});
  }
  TextSink& AddVector(const Vec3& a, std::string_view between) {
    return AddNumber(a.x).Add(between).AddNumber(a.y).Add(between).AddNumber(a.z);
  }
  // False: nobody wants more.
  bool Flush(std::size_t least = 0) {
    if (text_.size() < least) return true;
    const bool more = write_(text_);
    text_.clear();
    return more;
  }

 private:
  const WriteText& write_;
  std::string text_;
};

struct Sample {
  const SurfaceParameter& at;
  const Vec3& point;
  const Vec3& normal;
  const Vec3& du;
  const Vec3& dv;
};

void AddNumbers(const Sample& sample, std::string_view between, TextSink* sink) {
  sink->AddVector(sample.point, between).Add(between).AddVector(sample.normal, between);
  sink->Add(between).AddVector(sample.du, between).Add(between).AddVector(sample.dv, between);
}

void AddJson(const Sample& sample, TextSink* sink) {
  sink->Add("{\"face\": ").AddNumber(sample.at.face);
  sink->Add(", \"corner\": ").AddNumber(sample.at.corner);
  sink->Add(", \"u\": ").AddNumber(sample.at.u).Add(", \"v\": ").AddNumber(sample.at.v);
  const std::pair<std::string_view, const Vec3&> vectors[] = {
      {"point", sample.point}, {"normal", sample.normal}, {"du", sample.du}, {"dv", sample.dv}};
  for (const auto& [name, vector] : vectors) {
    sink->Add(", \"").Add(name).Add("\": [").AddVector(vector, ", ").Add("]");
  }
  sink->Add("}");
}

}  // namespace

absl::StatusOr<ParametersFile> ParseParameters(const std::string& text, const std::string& name) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{') return ParseJson(text, name);
  return ParseLines(text, name);
}

absl::StatusOr<ParametersFile> ReadParametersFile(const std::string& path) {
  const bool standard_input = path == "-";
  LIMN_ASSIGN_OR_RETURN(const std::string text,
                        standard_input ? ReadStandardInput() : ReadTextFile(path));
  return ParseParameters(text, standard_input ? "standard input" : path);
}

absl::Status NameParametersFile(const absl::Status& status, const ParametersFile& file) {
  const auto detail = GetErrorDetail(status);
  if (!detail.has_value() || !detail->index.has_value() ||
      !absl::StartsWith(detail->field, "parameters[")) {
    return status;
  }
  if (*detail->index >= file.lines.size()) return Surrounded(file.name + ": ", status);
  return Surrounded(absl::StrCat(file.name, ":", file.lines[*detail->index], ": "), status);
}

absl::StatusOr<SampleFormat> SampleFormatOf(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension == ".txt") return SampleFormat::kText;
  if (extension == ".csv") return SampleFormat::kCsv;
  if (extension == ".json") return SampleFormat::kJson;
  return MakeError(absl::StrCat("'", path, "' has no extension of a known format"),
                   {.reason = Reason::kInvalidOption,
                    .field = "output",
                    .remedy = "Name it .txt, .csv or .json, or say --format"});
}

void WriteSamples(SampleFormat format, const std::vector<SurfaceParameter>& parameters,
                  const EvaluateResult& result, const WriteText& write) {
  constexpr std::size_t kPiece = std::size_t{64} << 10;
  TextSink sink(write);
  if (format == SampleFormat::kCsv) {
    sink.Add("face,corner,u,v,x,y,z,nx,ny,nz,dux,duy,duz,dvx,dvy,dvz\n");
  } else if (format == SampleFormat::kJson) {
    sink.Add("{\"samples\": [");
  }
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Sample sample = {parameters[i], result.points[i], result.normals[i], result.du[i],
                           result.dv[i]};
    if (format == SampleFormat::kJson) {
      sink.Add(i == 0 ? "\n  " : ",\n  ");
      AddJson(sample, &sink);
    } else if (format == SampleFormat::kCsv) {
      sink.AddNumber(sample.at.face).Add(",").AddNumber(sample.at.corner).Add(",");
      sink.AddNumber(sample.at.u).Add(",").AddNumber(sample.at.v).Add(",");
      AddNumbers(sample, ",", &sink);
      sink.Add("\n");
    } else {
      AddNumbers(sample, " ", &sink);
      sink.Add("\n");
    }
    if (!sink.Flush(kPiece)) return;
  }
  if (format == SampleFormat::kJson) sink.Add(parameters.empty() ? "]}\n" : "\n]}\n");
  sink.Flush();
}

}  // namespace limn::cli
