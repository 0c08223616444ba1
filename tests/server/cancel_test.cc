// SPDX-License-Identifier: MIT
// Cancel, deadline, and clients that vanish or stand still: work ends and places come back.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/oracle/slowdown.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// One job at a time and no queue: a place that is not given back is noticed at once.
ServerOptions OnePlace() {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_length = 0;
  return options;
}

// Reads until the job runs.
void WaitForProgress(RawCall& call) {
  for (;;) {
    const std::optional<v1::InterpolateResponse> message = call.Read();
    ASSERT_TRUE(message.has_value()) << call.Finish();
    if (message->has_progress() && message->progress().stage() == "solve") return;
  }
}

TEST(CancelTest, ARunningJobStopsAndItsPlaceComesBack) {
  const std::unique_ptr<Server> server = StartServer(OnePlace());
  const auto channel = server->InProcessChannel();
  RawCall call(channel);
  ASSERT_TRUE(call.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(50'000))));
  WaitForProgress(call);
  const auto start = steady_clock::now();
  call.Cancel();
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(PlaceBecomesFree(channel));
  EXPECT_LT(steady_clock::now() - start, std::chrono::seconds(4));
}

TEST(CancelTest, ADeadlineStopsARunningJob) {
  const std::unique_ptr<Server> server = StartServer(OnePlace());
  const auto channel = server->InProcessChannel();
  const auto upload = MakeUpload(MakeEndlessHeader(), MakeSphere(20'000));
  {
    RawCall call(channel, milliseconds(700) * oracle::kSlowdown);
    ASSERT_TRUE(call.Write(upload));
    EXPECT_EQ(ReasonOf(call.Finish()), Reason::kDeadlineExceeded);
  }
  EXPECT_TRUE(PlaceBecomesFree(channel));
}

TEST(CancelTest, AClientThatVanishesFreesItsPlaceAtEveryStage) {
  const std::vector<v1::InterpolateRequest> upload =
      MakeUpload(MakeEndlessHeader(), MakeSphere(5'000));
  ServerOptions options = OnePlace();
  options.listen = "127.0.0.1:0";
  const std::unique_ptr<Server> server = StartServer(options);
  const std::string address = "127.0.0.1:" + std::to_string(server->port());
  const auto probe = server->InProcessChannel();
  for (const std::size_t sent :
       {std::size_t{0}, std::size_t{1}, upload.size() / 2, upload.size()}) {
    {
      // A connection of its own, which closes at the end of the block.
      grpc::ChannelArguments arguments;
      arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
      const auto channel =
          grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
      RawCall call(channel);
      ASSERT_TRUE(call.Write({upload.begin(), upload.begin() + static_cast<long>(sent)}));
      if (sent == upload.size()) WaitForProgress(call);
    }
    EXPECT_TRUE(PlaceBecomesFree(probe)) << "after " << sent << " messages";
  }
}

TEST(CancelTest, AWaitingJobThatIsCancelledGivesItsPlaceBackAtOnce) {
  ServerOptions options = OnePlace();
  options.limits.queue_length = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = server->InProcessChannel();
  RawCall running(channel);
  ASSERT_TRUE(running.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(20'000))));
  WaitForProgress(running);
  const std::vector<v1::InterpolateRequest> upload = MakeUpload(MakeHeader(0), MakeSphere(64));
  for (int round = 0; round < 20; ++round) {
    RawCall waiting(channel);
    ASSERT_TRUE(waiting.Write(upload)) << waiting.Finish();
    const std::optional<v1::InterpolateResponse> accepted = waiting.Read();
    ASSERT_TRUE(accepted.has_value()) << waiting.Finish();
    EXPECT_EQ(accepted->accepted().queue_position(), 1U);
    waiting.Cancel();
    EXPECT_EQ(waiting.Finish().code(), absl::StatusCode::kCancelled);
    // The server hears of it a moment later.
    std::this_thread::sleep_for(milliseconds(20));
  }
}

TEST(CancelTest, AHundredCancelledJobsLeaveAServerThatWorks) {
  const std::unique_ptr<Server> server = StartServer();
  const auto channel = server->InProcessChannel();
  const std::vector<v1::InterpolateRequest> upload = MakeUpload(MakeHeader(3), MakeSphere(500));
  for (int job = 0; job < 100; ++job) {
    RawCall call(channel);
    call.Write(upload);
    for (int message = 0; message < job % 7; ++message) call.Read();
    call.Cancel();
    // What was quick enough ends well.
    const absl::Status status = call.Finish();
    EXPECT_TRUE(status.ok() || status.code() == absl::StatusCode::kCancelled) << status;
  }
  EXPECT_TRUE(PlaceBecomesFree(channel));
}

TEST(StallTest, AnUploadThatStandsStillIsEnded) {
  ServerOptions options = OnePlace();
  options.limits.stall_seconds = 1;
  options.limits.min_bytes_per_second = 0;
  const std::unique_ptr<Server> server = StartServer(options);
  RawCall call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(MakeUpload(MakeHeader(1), MakeSphere(64)).front()));
  const absl::Status status = call.Finish();
  EXPECT_EQ(ReasonOf(status), Reason::kLimitExceeded) << status;
  EXPECT_EQ(GetErrorDetail(status)->limit, "stall-seconds");
}

TEST(StallTest, AnUploadThatTricklesIsEnded) {
  ServerOptions options = OnePlace();
  options.limits.stall_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawCall call(server->InProcessChannel(), std::chrono::seconds(15));
  const std::vector<v1::InterpolateRequest> upload =
      MakeUpload(MakeHeader(1), MakeSphere(5000), 100);
  ASSERT_TRUE(call.Write(upload[0]));
  ASSERT_TRUE(call.Read().has_value());
  // A message every fifth of a second, so that there is always a sign of life.
  bool ok = true;
  for (std::size_t i = 1; ok && i < 50; ++i) {
    ok = call.Write(upload[i]);
    std::this_thread::sleep_for(milliseconds(200));
  }
  EXPECT_FALSE(ok);
  const absl::Status status = call.Finish();
  EXPECT_EQ(ReasonOf(status), Reason::kLimitExceeded) << status;
  EXPECT_EQ(GetErrorDetail(status)->limit, "min-bytes-per-second");
}

TEST(StallTest, AReaderThatCrawlsIsEnded) {
  const EventLog events;
  ServerOptions options = OnePlace();
  options.limits.stall_seconds = 1;
  options.log = events.log();
  const std::unique_ptr<Server> server = StartServer(options);
  RawCall call(server->InProcessChannel(), std::chrono::seconds(30));
  v1::InterpolateHeader header = MakeHeader(3);
  header.mutable_output()->set_tile_bytes(4096);
  ASSERT_TRUE(call.Write(MakeUpload(header, MakeSphere(5'000))));
  bool ok = true;
  for (int i = 0; ok && i < 100; ++i) {
    ok = call.Read().has_value();
    std::this_thread::sleep_for(milliseconds(250));
  }
  EXPECT_FALSE(ok);
  EXPECT_FALSE(call.Finish().ok());
  EXPECT_NE(events.WaitFor("event=job").find("limit=min-bytes-per-second"), std::string::npos)
      << events.WaitFor("event=job");
}

TEST(StallTest, AReaderThatStandsStillIsEndedAndAWorkingOneIsNot) {
  const EventLog events;
  ServerOptions options = OnePlace();
  options.limits.stall_seconds = 1;
  options.log = events.log();
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = server->InProcessChannel();
  RawCall slow(channel);
  ASSERT_TRUE(slow.Write(MakeUpload(MakeHeader(3), MakeSphere(5'000))));
  std::this_thread::sleep_for(milliseconds(2500));
  // The stream is cut, which is all that such a client can hear; the log knows why.
  EXPECT_EQ(slow.Finish().code(), absl::StatusCode::kCancelled);
  const std::string line = events.WaitFor("event=job");
  EXPECT_NE(line.find("reason=LIMIT_EXCEEDED limit=stall-seconds"), std::string::npos) << line;
  EXPECT_TRUE(PlaceBecomesFree(channel));

  // A job that takes longer than the limit is not a stall.
  const auto upload = MakeUpload(MakeEndlessHeader(), MakeSphere(50'000));
  RawCall working(channel);
  ASSERT_TRUE(working.Write(upload));
  const auto start = steady_clock::now();
  while (steady_clock::now() - start < milliseconds(2000)) {
    ASSERT_TRUE(working.Read().has_value()) << working.Finish();
  }
}

}  // namespace
}  // namespace limn
