// SPDX-License-Identifier: MIT
#include "engine/base/context.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "tests/oracle/expect.h"

namespace limn {
namespace {

TEST(Context, RunsUntilToldToStop) {
  const Context context;
  EXPECT_FALSE(context.stop_requested());
  EXPECT_TRUE(context.Check().ok());
}

TEST(Context, CancelReachesAllCopies) {
  const Context context;
  const Context copy = context;  // NOLINT: copies are the point
  copy.Cancel();
  EXPECT_TRUE(context.stop_requested());
  oracle::ExpectError(context.Check(), {Reason::kCancelled});
  EXPECT_FALSE(Context().stop_requested());
}

TEST(Context, CancelFromAnotherThreadIsSeen) {
  const Context context;
  std::thread other([&] { context.Cancel(); });
  while (!context.stop_requested()) std::this_thread::yield();
  other.join();
  oracle::ExpectError(context.Check(), {Reason::kCancelled});
}

TEST(Context, StopsAtItsDeadlineAndNotBefore) {
  Context context;
  const auto deadline = Context::Clock::now() + std::chrono::milliseconds(30);
  context.set_deadline(deadline);
  absl::Status status;
  while ((status = context.Check()).ok()) {
  }
  EXPECT_GE(Context::Clock::now(), deadline);
  EXPECT_TRUE(context.stop_requested());
  oracle::ExpectError(status, {Reason::kDeadlineExceeded});
  Context far;
  far.set_deadline(Context::Clock::now() + std::chrono::hours(1));
  EXPECT_FALSE(far.stop_requested());
}

TEST(Context, CancelWinsOverDeadline) {
  Context context;
  context.set_deadline(Context::Clock::now());
  context.Cancel();
  oracle::ExpectError(context.Check(), {Reason::kCancelled});
}

TEST(Context, ReportsToWhoeverListens) {
  Context context;
  context.Report({.stage = "nobody"});
  std::vector<ProgressEvent> events;
  context.set_progress([&](const ProgressEvent& event) { events.push_back(event); });
  context.Report({.stage = "solve", .fraction = 0.5, .sweep = 7, .update = 0.25});
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].stage, "solve");
  EXPECT_EQ(events[0].fraction, 0.5);
  EXPECT_EQ(events[0].sweep, 7U);
  EXPECT_EQ(events[0].update, 0.25);
}

TEST(Context, KeepsItsLimits) {
  Limits limits;
  limits.max_vertices = 5;
  limits.max_level = 3;
  const Context context(limits);
  EXPECT_EQ(context.limits().max_vertices, 5U);
  EXPECT_EQ(context.limits().max_level, 3U);
  EXPECT_EQ(Context().limits().max_level, 10U);
}

}  // namespace
}  // namespace limn
