// SPDX-License-Identifier: MIT
// When the jobs of a load test are to be sent: an open loop's schedule, made before it begins, so
// that a slow server cannot slow its own load down (Schroeder, Wierman, Harchol-Balter, "Open
// versus closed: a cautionary tale", NSDI 2006).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace limn::load {

enum class ArrivalKind {
  // One every 1 / rate seconds.
  kConstant,
  // Gaps of exponential distribution, as of many clients that know nothing of each other.
  kPoisson,
  // `burst` at once, so often that the mean is the rate.
  kBurst,
  // From 0 to the rate, rising evenly.
  kRamp,
};

struct ArrivalOptions {
  ArrivalKind kind = ArrivalKind::kPoisson;
  // Jobs per second, above 0.
  double rate = 10;
  // Above 0.
  double seconds = 10;
  // Jobs of a burst, 1 or more.
  std::uint64_t burst = 10;
  // Of the random gaps: the same seed gives the same schedule.
  std::uint64_t seed = 1;
};

// "constant", "poisson", "burst", "ramp".
[[nodiscard]] absl::StatusOr<ArrivalKind> ParseArrivalKind(std::string_view name);
std::vector<std::string> ArrivalKindNames();

// Sends at the most: a schedule is held as a whole.
inline constexpr std::uint64_t kMostArrivals = 10'000'000;

// Times in seconds after the start, ascending. Errors: INVALID_OPTION for values out of range, and
// for more than kMostArrivals.
[[nodiscard]] absl::StatusOr<std::vector<double>> MakeArrivals(const ArrivalOptions& options);

// The times of a file, one in a line: a recorded load, to be replayed. Lines that are empty or
// begin with '#' count for nothing. Errors: NotFound; MALFORMED_FILE with the line, also for times
// that do not ascend.
[[nodiscard]] absl::StatusOr<std::vector<double>> ReadArrivals(const std::string& path);

}  // namespace limn::load
