// SPDX-License-Identifier: MIT
// When a job is done again, and how often.
#include "client/retry.h"

#include <gtest/gtest.h>

#include <chrono>

#include "engine/base/error.h"

namespace limn {
namespace {

double SecondsOf(const std::function<void()>& what) {
  const auto begin = std::chrono::steady_clock::now();
  what();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

TEST(RetryTest, AServerThatIsUnreachableOrStopsWentAway) {
  EXPECT_TRUE(ServerWentAway(absl::UnavailableError("connection refused")));
  EXPECT_TRUE(ServerWentAway(MakeError("stopping", {.reason = Reason::kShuttingDown})));
}

TEST(RetryTest, ACallThatBrokeOffWithoutAWordOfTheServerWentAway) {
  EXPECT_TRUE(ServerWentAway(absl::UnknownError("stream removed")));
  EXPECT_TRUE(ServerWentAway(absl::InternalError("RST_STREAM with error code 2")));
  EXPECT_TRUE(ServerWentAway(absl::CancelledError("RST_STREAM with error code 8")));
}

TEST(RetryTest, AnAnswerThatBrokeOffIsAskedForAgain) {
  EXPECT_TRUE(ServerWentAway(AnswerBrokeOff()));
}

TEST(RetryTest, WhatTheServerSaidIsNotAskedAgain) {
  for (const Reason reason : {Reason::kInternal, Reason::kCancelled, Reason::kInvalidOption,
                              Reason::kLimitExceeded, Reason::kDeadlineExceeded}) {
    EXPECT_FALSE(ServerWentAway(MakeError("no", {.reason = reason}))) << ReasonName(reason);
  }
  EXPECT_FALSE(ServerWentAway(absl::OkStatus()));
  EXPECT_FALSE(ServerWentAway(absl::InvalidArgumentError("no")));
  EXPECT_FALSE(ServerWentAway(absl::DeadlineExceededError("late")));
}

TEST(RetryTest, AttemptsAreCountedAndTakeLongerEachTime) {
  Attempts attempts({.attempts = 3});
  const absl::Status gone = absl::UnavailableError("gone");
  EXPECT_FALSE(attempts.last());
  const double first = SecondsOf([&] { EXPECT_TRUE(attempts.Again(gone)); });
  EXPECT_GE(first, 0.08);
  const double second = SecondsOf([&] { EXPECT_TRUE(attempts.Again(gone)); });
  EXPECT_GE(second, 0.24);
  EXPECT_TRUE(attempts.last());
  EXPECT_LT(SecondsOf([&] { EXPECT_FALSE(attempts.Again(gone)); }), 0.05);
}

TEST(RetryTest, AnErrorThatStaysIsNotTriedAgain) {
  Attempts attempts({});
  EXPECT_FALSE(attempts.Again(absl::InvalidArgumentError("no")));
}

TEST(RetryTest, TheDeadlineIsForAllAttemptsTogether) {
  Attempts attempts({.deadline_seconds = 0.3});
  EXPECT_EQ(attempts.NextOptions().deadline_seconds, 0.3);
  const absl::Status gone = absl::UnavailableError("gone");
  ASSERT_TRUE(attempts.Again(gone));
  EXPECT_LT(attempts.NextOptions().deadline_seconds, 0.25);
  EXPECT_GT(attempts.NextOptions().deadline_seconds, 0);
  // Less is left than the next pause takes.
  EXPECT_FALSE(attempts.Again(gone));
}

TEST(RetryTest, WithoutADeadlineNoneIsMade) {
  Attempts attempts({});
  ASSERT_TRUE(attempts.Again(absl::UnavailableError("gone")));
  EXPECT_EQ(attempts.NextOptions().deadline_seconds, 0);
}

TEST(RetryTest, WhoStopsIsNotKeptWaiting) {
  Attempts attempts({}, [] { return true; });
  EXPECT_LT(SecondsOf([&] { EXPECT_FALSE(attempts.Again(absl::UnavailableError("gone"))); }), 0.05);
}

}  // namespace
}  // namespace limn
