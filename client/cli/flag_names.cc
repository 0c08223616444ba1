// SPDX-License-Identifier: MIT
// The contract's names in the words of the command line.
#include "client/cli/flag_names.h"

#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

using Pair = std::pair<std::string_view, std::string_view>;

constexpr std::array kFlags = {
    Pair{"scheme", "--scheme"},
    Pair{"solve.method", "--solver"},
    Pair{"solve.rule", "--rule"},
    Pair{"solve.strict", "--strict"},
    Pair{"solve.fair", "--fair"},
    Pair{"solve.tolerance", "--tolerance"},
    Pair{"solve.max_sweeps", "--max-sweeps"},
    Pair{"surface.level", "--level"},
    Pair{"surface.chord_tolerance", "--chord-tolerance"},
    Pair{"surface.boundary", "--boundary"},
    Pair{"output.encoding", "--encoding"},
    Pair{"output.quantization_bits", "--quantization-bits"},
    Pair{"output.repair", "--repair"},
};

}  // namespace

std::string_view FlagOf(std::string_view field) {
  for (const auto& [name, flag] : kFlags) {
    if (name == field) return flag;
  }
  return {};
}

std::string MessageInFlags(const absl::Status& status) {
  std::string message = absl::StrReplaceAll(
      status.message(), {{"MESH_ENCODING_PACKED", "--encoding packed"},
                         {"MESH_ENCODING_DRACO_QUANTIZED", "--encoding draco-quantized"},
                         {"MESH_ENCODING_DRACO", "--encoding draco"}});
  const auto detail = GetErrorDetail(status);
  if (!detail.has_value()) return message;
  const std::string flag(FlagOf(detail->field));
  if (flag.empty() || message.starts_with(flag)) return message;
  if (message.starts_with(detail->field)) return message.replace(0, detail->field.size(), flag);
  return absl::StrCat(flag, ": ", message);
}

}  // namespace limn::cli
