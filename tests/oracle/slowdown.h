// SPDX-License-Identifier: MIT
// How much longer things take under a sanitizer, for tests that would take minutes there or that
// hold something against the clock. For what a test proves it makes no difference.
#pragma once

namespace limn::oracle {

// Divides sizes, multiplies limits of time.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSlowdown = 5;
#else
inline constexpr int kSlowdown = 1;
#endif

}  // namespace limn::oracle
