// SPDX-License-Identifier: MIT
// Jobs to a chord tolerance, whose level is not known when they come.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "tests/server/service_fixture.h"

namespace limn {
namespace {

// What is set aside for a level that is not known yet is no more than there can be.
TEST(ChordTolerance, IsTakenWhereAllTogetherMayHoldLessThanOneJob) {
  ServerOptions options{.threads = 1};
  options.limits.max_job_bytes = std::uint64_t{64} << 20;
  options.limits.max_total_bytes = std::uint64_t{16} << 20;
  const std::unique_ptr<Server> server = StartServer(options);
  v1::InterpolateHeader header = MakeHeader(0);
  header.mutable_surface()->set_chord_tolerance(0.5);
  RawCall call(server->InProcessChannel());
  call.Write(MakeUpload(header, MakeSphere(200)));
  std::uint64_t estimated = 0;
  v1::Summary summary;
  while (const std::optional<v1::InterpolateResponse> message = call.Read()) {
    if (message->has_accepted()) estimated = message->accepted().estimated_bytes();
    if (message->has_summary()) summary = message->summary();
  }
  EXPECT_TRUE(call.Finish().ok()) << call.Finish();
  EXPECT_GT(estimated, 0U);
  EXPECT_LE(estimated, options.limits.max_total_bytes);
  EXPECT_GT(summary.chord_bound(), 0);
  EXPECT_LE(summary.chord_bound(), 0.5);
}

TEST(ChordTolerance, TheLevelThatWasChosenIsLogged) {
  const EventLog events;
  const std::unique_ptr<Server> server = StartServer({.threads = 1, .log = events.log()});
  v1::InterpolateHeader header = MakeHeader(0);
  header.mutable_surface()->set_chord_tolerance(0.02);
  RawCall call(server->InProcessChannel());
  call.Write(MakeUpload(header, MakeSphere(200)));
  std::uint32_t level = 0;
  while (const std::optional<v1::InterpolateResponse> message = call.Read()) {
    if (message->has_summary()) level = message->summary().level();
  }
  EXPECT_TRUE(call.Finish().ok()) << call.Finish();
  ASSERT_GT(level, 0U);
  EXPECT_NE(events.WaitFor("method=Interpolate").find(" level=" + std::to_string(level) + " "),
            std::string::npos);
}

TEST(ChordTolerance, ThatNeedsMoreThanAJobMayIsRefusedWithOneThatDoesNot) {
  ServerOptions options{.threads = 1};
  options.limits.max_job_bytes = std::uint64_t{12} << 20;
  const std::unique_ptr<Server> server = StartServer(options);
  v1::InterpolateHeader header = MakeHeader(0);
  header.mutable_surface()->set_chord_tolerance(1e-6);
  RawCall refused(server->InProcessChannel());
  refused.Write(MakeUpload(header, MakeSphere(200)));
  const absl::Status status = refused.Finish();
  EXPECT_EQ(ReasonOf(status), Reason::kLimitExceeded) << status;
  const v1::ErrorDetails info = ErrorInfoOf(refused.rich_status());
  EXPECT_EQ(info.metadata().at("field"), "surface.chord_tolerance");
  // The remedy, at the message's end, names a tolerance that can be met.
  const std::string message(status.message());
  header.mutable_surface()->set_chord_tolerance(std::stod(message.substr(message.rfind(' '))));
  RawCall taken(server->InProcessChannel());
  taken.Write(MakeUpload(header, MakeSphere(200)));
  EXPECT_TRUE(taken.Finish().ok()) << taken.Finish();
}

TEST(ChordTolerance, IsNotToldToTakeALowerLevelWhereLevel0DoesNotFit) {
  ServerOptions options{.threads = 1};
  options.limits.max_job_bytes = 100'000;
  const std::unique_ptr<Server> server = StartServer(options);
  v1::InterpolateHeader header = MakeHeader(0);
  header.mutable_surface()->set_chord_tolerance(0.5);
  RawCall call(server->InProcessChannel());
  call.Write(MakeUpload(header, MakeSphere(200)));
  const absl::Status status = call.Finish();
  EXPECT_EQ(ReasonOf(status), Reason::kLimitExceeded) << status;
  const v1::ErrorDetails info = ErrorInfoOf(call.rich_status());
  EXPECT_EQ(info.metadata().at("field"), "surface.chord_tolerance");
  EXPECT_EQ(info.metadata().at("limit"), "max-job-bytes");
  EXPECT_NE(status.message().find("use a smaller mesh"), std::string::npos) << status;
}

}  // namespace
}  // namespace limn
