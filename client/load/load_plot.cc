// SPDX-License-Identifier: MIT
#include "client/load/load_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "engine/base/error.h"

namespace limn::load {
namespace {

// Few enough for a picture, and dense where the tail is.
constexpr int kPoints = 200;

// "x y" in lines, x = 1 / (1 - quantile).
std::string Curve(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  std::string text;
  const double most = std::min(static_cast<double>(values.size()), 1e4);
  for (int i = 0; i <= kPoints; ++i) {
    const double x = std::pow(most, static_cast<double>(i) / kPoints);
    const double rank = std::ceil((1 - 1 / x) * static_cast<double>(values.size()));
    const auto at = std::min(static_cast<std::size_t>(std::max(rank, 1.0)), values.size()) - 1;
    absl::StrAppendFormat(&text, "%.9g %.9g\n", x, values[at]);
  }
  return text + "e\n";
}

}  // namespace

absl::Status PlotLatencies(const LoadResult& result, const std::string& path) {
  std::map<std::string, std::vector<double>> kinds;
  for (const Sample& sample : result.samples) {
    if (!sample.good) continue;
    kinds[std::string(JobKindName(sample.kind))].push_back(1e3 * (sample.ended - sample.intended));
  }
  std::string script = absl::StrCat(
      "set terminal svg size 900,500 background 'white'\nset output '",
      absl::StrReplaceAll(path, {{"'", "''"}}),
      "'\nset logscale xy\nset grid\nset key top left\nset xlabel 'percentile'\n"
      "set ylabel 'latency from the intended time, ms'\n"
      "set xtics ('0' 1, '50' 2, '90' 10, '99' 100, '99.9' 1000, '99.99' 10000)\nplot ");
  std::string data;
  for (const auto& [kind, values] : kinds) {
    absl::StrAppend(&script, data.empty() ? "" : ", ", "'-' with lines lw 2 title '", kind, "'");
    data += Curve(values);
  }
  const absl::Status failed = MakeError(absl::StrCat("gnuplot could not draw ", path),
                                        {.reason = Reason::kInvalidOption,
                                         .field = "plot",
                                         .remedy = "Install gnuplot, or leave the picture out"});
  if (kinds.empty()) return failed;
  // Its own words would only repeat the script.
  std::FILE* const gnuplot = popen("gnuplot 2>/dev/null", "w");
  if (gnuplot == nullptr) return failed;
  std::fputs((script + "\n" + data).c_str(), gnuplot);
  return pclose(gnuplot) == 0 ? absl::OkStatus() : failed;
}

}  // namespace limn::load
