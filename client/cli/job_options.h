// SPDX-License-Identifier: MIT
// The flags that say what a job is, and the header they make.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "limn/v1/interpolate.pb.h"

namespace limn::cli {

// Absent values are the server's to choose; the names are those of the flags' help.
struct JobOptions {
  std::string scheme = "doo-sabin";
  std::optional<std::string> solver;
  std::string encoding = "packed";
  std::uint32_t level = 2;
  // Instead of the level.
  std::optional<double> chord_tolerance;
  std::optional<std::string> rule;
  std::optional<std::string> boundary;
  std::optional<double> tolerance;
  std::optional<std::uint32_t> max_sweeps;
  std::optional<std::uint32_t> quantization_bits;
  bool repair = false;
  bool fair = false;
  bool strict = false;
  // Gains of a filter; none: interpolate. With them `rest`.
  std::vector<double> gains;
  double rest = 0;
};

// Add the flags of how the surface is found, and of its tessellation, how it travels and what is
// done to the mesh before, which is not for evaluations. Values out of range, and flags that do not
// go together, end the parse with a CLI::ValidationError. *options must live as long as app.
void AddSolveFlags(CLI::App& app, JobOptions* options);
void AddTessellationFlags(CLI::App& app, JobOptions* options);
// The scheme and the boundary alone, and the filter's gains.
void AddFilterFlags(CLI::App& app, JobOptions* options);

// What to ask the server to send back.
struct WantedOutputs {
  bool surface = true;
  bool control_mesh = false;
};

// The header of such a job. options: as checked by the flags.
[[nodiscard]] v1::InterpolateHeader MakeJobHeader(const JobOptions& options,
                                                  const WantedOutputs& wanted);

}  // namespace limn::cli
