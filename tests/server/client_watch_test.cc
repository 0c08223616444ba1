// SPDX-License-Identifier: MIT
// Who keeps the server waiting, by a clock of the test's own.
#include "server/client_watch.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"

namespace limn {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using TimePoint = ClientWatch::Clock::time_point;

constexpr TimePoint kStart{seconds(1000)};

ServerLimits Limits(std::uint64_t bytes_per_second) {
  ServerLimits limits;
  limits.stall_seconds = 10;
  limits.min_bytes_per_second = bytes_per_second;
  return limits;
}

std::string LimitOf(const absl::Status& status) {
  return status.ok() ? "" : GetErrorDetail(status)->limit;
}

TEST(PaceTest, OnlyTheClientsTurnsCount) {
  Pace pace(seconds(10), 100);
  TimePoint now = kStart;
  for (int turn = 0; turn < 9; ++turn) {
    pace.Resume(now);
    pace.Pause(now += seconds(1));
    // Other people's time.
    now += seconds(3600);
    EXPECT_TRUE(pace.KeepsUp(now)) << turn;
  }
  pace.Resume(now);
  EXPECT_TRUE(pace.KeepsUp(now + milliseconds(900)));
  EXPECT_FALSE(pace.KeepsUp(now + milliseconds(1000)));
}

TEST(PaceTest, EachWindowIsHeldToTheRate) {
  Pace pace(seconds(10), 100);
  pace.Resume(kStart);
  // What was too much in one window does not help in the next.
  pace.Add(1'000'000);
  EXPECT_TRUE(pace.KeepsUp(kStart + seconds(10)));
  pace.Add(1000);
  EXPECT_TRUE(pace.KeepsUp(kStart + seconds(20)));
  pace.Add(999);
  EXPECT_FALSE(pace.KeepsUp(kStart + seconds(30)));
}

TEST(PaceTest, ZeroDemandsNothing) {
  Pace pace(seconds(1), 0);
  pace.Resume(kStart);
  EXPECT_TRUE(pace.KeepsUp(kStart + seconds(100'000)));
}

TEST(ClientWatchTest, SilenceIsAStallOnlyWhereAMessageIsWaitedFor) {
  ClientWatch watch(Limits(0), kStart);
  watch.Touch(kStart + seconds(5));
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(14), {.for_message = true})), "");
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(15), {})), "");
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(15), {.for_message = true})), "stall-seconds");
}

TEST(ClientWatchTest, AMessageThatIsNotTakenIsAStallWhateverComesMeanwhile) {
  ClientWatch watch(Limits(0), kStart);
  watch.BeginWrite(kStart, false);
  watch.Touch(kStart + seconds(9));
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(9), {.for_reader = true})), "");
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(10), {.for_reader = true})), "stall-seconds");
}

TEST(ClientWatchTest, ReadingMayBeginAfterTheUpload) {
  ClientWatch watch(Limits(0), kStart);
  watch.BeginUpload(kStart);
  watch.BeginWrite(kStart, false);
  watch.Touch(kStart + seconds(100));
  watch.EndUpload(kStart + seconds(100));
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(109), {.for_reader = true})), "");
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(110), {.for_reader = true})), "stall-seconds");
}

TEST(ClientWatchTest, ATrickleOfAnUploadIsTooSlow) {
  ClientWatch watch(Limits(100), kStart);
  watch.BeginUpload(kStart);
  for (int second = 1; second < 10; ++second) {
    watch.Touch(kStart + seconds(second));
    watch.Uploaded(99);
    EXPECT_EQ(
        LimitOf(watch.Check(kStart + seconds(second), {.for_message = true, .for_upload = true})),
        "");
  }
  watch.Uploaded(99);
  EXPECT_EQ(LimitOf(watch.Check(kStart + seconds(10), {.for_upload = true})),
            "min-bytes-per-second");
}

TEST(ClientWatchTest, WhatIsNoPartOfTheAnswerDoesNotCount) {
  ClientWatch watch(Limits(100), kStart);
  TimePoint now = kStart;
  for (int message = 0; message < 100; ++message) {
    watch.BeginWrite(now, false);
    watch.EndWrite(now += seconds(1), 10);
    EXPECT_EQ(LimitOf(watch.Check(now, {.for_reader = true})), "");
  }
  for (int message = 0; message < 9; ++message) {
    watch.BeginWrite(now, true);
    watch.EndWrite(now += seconds(1), 10);
  }
  watch.BeginWrite(now, true);
  EXPECT_EQ(LimitOf(watch.Check(now + seconds(1), {.for_reader = true})), "min-bytes-per-second");
}

}  // namespace
}  // namespace limn
