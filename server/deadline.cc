// SPDX-License-Identifier: MIT
#include "server/deadline.h"

#include <algorithm>
#include <cstdint>

namespace limn {
namespace {

constexpr std::int64_t kCentury = std::int64_t{100} * 366 * 86'400;

}  // namespace

std::optional<std::chrono::steady_clock::time_point> DeadlineOf(gpr_timespec deadline) {
  const auto now = std::chrono::steady_clock::now();
  const gpr_timespec left = gpr_time_sub(gpr_convert_clock_type(deadline, GPR_CLOCK_REALTIME),
                                         gpr_now(GPR_CLOCK_REALTIME));
  if (left.tv_sec >= kCentury) return std::nullopt;
  return now + std::chrono::seconds(std::max(left.tv_sec, -kCentury)) +
         std::chrono::nanoseconds(left.tv_nsec);
}

}  // namespace limn
