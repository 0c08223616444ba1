// SPDX-License-Identifier: MIT
// A picture of a load test's latencies.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "client/load/generator.h"

namespace limn::load {

// Latency over percentile, up to 99.99, of every kind of job that ended well: an SVG by gnuplot,
// which must be installed. Errors: INVALID_OPTION when it is not, or cannot write the file.
[[nodiscard]] absl::Status PlotLatencies(const LoadResult& result, const std::string& path);

}  // namespace limn::load
