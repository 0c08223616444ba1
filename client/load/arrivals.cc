// SPDX-License-Identifier: MIT
#include "client/load/arrivals.h"

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn::load {
namespace {

constexpr std::array kNames = {
    std::pair("constant", ArrivalKind::kConstant), std::pair("poisson", ArrivalKind::kPoisson),
    std::pair("burst", ArrivalKind::kBurst), std::pair("ramp", ArrivalKind::kRamp)};

absl::Status Invalid(std::string field, std::string_view message, std::string remedy) {
  return MakeError(
      message,
      {.reason = Reason::kInvalidOption, .field = std::move(field), .remedy = std::move(remedy)});
}

std::vector<double> Poisson(const ArrivalOptions& options) {
  std::mt19937_64 random(options.seed);
  std::vector<double> times;
  // By hand, since a library's distribution may differ from another's.
  const auto gap = [&] {
    const double uniform = (static_cast<double>(random() >> 11U) + 0.5) * 0x1p-53;
    return -std::log(uniform) / options.rate;
  };
  for (double t = gap(); t < options.seconds && times.size() <= kMostArrivals; t += gap()) {
    times.push_back(t);
  }
  return times;
}

}  // namespace

absl::StatusOr<ArrivalKind> ParseArrivalKind(std::string_view name) {
  for (const auto& [known, kind] : kNames) {
    if (name == known) return kind;
  }
  return Invalid("arrivals", absl::StrCat("there are no arrivals '", std::string(name), "'"),
                 "Use constant, poisson, burst or ramp");
}

std::vector<std::string> ArrivalKindNames() {
  std::vector<std::string> names;
  for (const auto& entry : kNames) names.emplace_back(entry.first);
  return names;
}

absl::StatusOr<std::vector<double>> MakeArrivals(const ArrivalOptions& options) {
  if (!(options.rate > 0 && std::isfinite(options.rate))) {
    return Invalid("rate", "the rate is not above 0", "Give jobs per second");
  }
  if (!(options.seconds > 0 && std::isfinite(options.seconds))) {
    return Invalid("duration", "the duration is not above 0", "Give seconds");
  }
  if (options.burst == 0) return Invalid("burst", "a burst has no jobs", "Give 1 or more");
  const double expected = options.rate * options.seconds;
  if (!(expected <= static_cast<double>(kMostArrivals) * 0.9)) {
    return Invalid("rate", absl::StrCat("these are ", expected, " jobs, more than 9,000,000"),
                   "Lower the rate or the duration");
  }
  if (options.kind == ArrivalKind::kPoisson) return Poisson(options);
  std::vector<double> times;
  const auto add = [&](double t) {
    if (t < options.seconds) times.push_back(t);
    return t < options.seconds;
  };
  switch (options.kind) {
    case ArrivalKind::kConstant:
      for (std::uint64_t i = 0; add(static_cast<double>(i) / options.rate); ++i) {
      }
      break;
    case ArrivalKind::kBurst:
      for (std::uint64_t i = 0; add(static_cast<double>(i - i % options.burst) / options.rate);
           ++i) {
      }
      break;
    case ArrivalKind::kRamp:
      // The i-th comes when the integral of the rate, rate t^2 / (2 seconds), is i.
      for (std::uint64_t i = 0;
           add(std::sqrt(2 * static_cast<double>(i) * options.seconds / options.rate)); ++i) {
      }
      break;
    case ArrivalKind::kPoisson:
      break;
  }
  return times;
}

absl::StatusOr<std::vector<double>> ReadArrivals(const std::string& path) {
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  std::vector<double> times;
  std::size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const absl::string_view text = absl::StripAsciiWhitespace(line);
    if (text.empty() || text[0] == '#') continue;
    double time = 0;
    const bool fine = absl::SimpleAtod(text, &time) && std::isfinite(time) && time >= 0 &&
                      (times.empty() || time >= times.back()) && times.size() < kMostArrivals;
    if (!fine) {
      return MakeError(
          absl::StrCat(path, ", line ", number, ": '", std::string(text.substr(0, 40)),
                       "' is no time in seconds from 0 on that is not below the one before"),
          {.reason = Reason::kMalformedFile, .field = "replay", .index = number});
    }
    times.push_back(time);
  }
  return times;
}

}  // namespace limn::load
