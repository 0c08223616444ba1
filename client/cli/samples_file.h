// SPDX-License-Identifier: MIT
// What `limn evaluate` reads and writes: parameters, and samples of the surface there.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/client.h"
#include "engine/limit/evaluate.h"

namespace limn::cli {

struct ParametersFile {
  // As errors call it.
  std::string name;
  std::vector<SurfaceParameter> parameters;
  // Line of each parameter; empty for JSON.
  std::vector<std::uint64_t> lines;
};

// Parameters in a text: lines "face corner u v", with comments from # to the end of the line; or,
// if its first character is {, the JSON mapping of limn.v1.ParameterBlock. Whether they make sense
// for a mesh is for the server to say. Errors: MALFORMED_FILE, naming file and line.
[[nodiscard]] absl::StatusOr<ParametersFile> ParseParameters(const std::string& text,
                                                             const std::string& name);

// Those of a file, "-" for standard input. Errors: as ParseParameters and ReadTextFile.
[[nodiscard]] absl::StatusOr<ParametersFile> ReadParametersFile(const std::string& path);

// A job's error, with file and line before it where it speaks of one of the parameters.
[[nodiscard]] absl::Status NameParametersFile(const absl::Status& status,
                                              const ParametersFile& file);

// Of what is written; numbers are the shortest that read back to the same bits.
enum class SampleFormat {
  // A line "x y z nx ny nz dux duy duz dvx dvy dvz" per parameter: point, normal, derivatives.
  kText,
  // The same after "face,corner,u,v", under a line of names.
  kCsv,
  // {"samples": [{"face": 0, "corner": 0, "u": 0, "v": 0, "point": [x, y, z], "normal": [...],
  // "du": [...], "dv": [...]}, ...]}
  kJson
};

// By a file's extension: .txt, .csv, .json. Errors: INVALID_OPTION, naming them.
[[nodiscard]] absl::StatusOr<SampleFormat> SampleFormatOf(const std::string& path);

// Calls write(text) for pieces of the whole text, in order, until it is false.
using WriteText = std::function<bool(std::string_view)>;
void WriteSamples(SampleFormat format, const std::vector<SurfaceParameter>& parameters,
                  const EvaluateResult& result, const WriteText& write);

}  // namespace limn::cli
