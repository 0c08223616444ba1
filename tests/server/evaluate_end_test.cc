// SPDX-License-Identifier: MIT
// Evaluate calls that end early: cancel, deadline, clients that vanish or stand still, drain.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

#include "proto/wire/samples.h"
#include "tests/oracle/slowdown.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

ServerOptions OnePlace() {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_length = 0;
  return options;
}

v1::InterpolateHeader MakeEndlessEvaluation() {
  v1::InterpolateHeader header = MakeEndlessHeader();
  header.clear_output();
  return header;
}

// n parameters of face 0.
v1::EvaluateRequest MakeBlock(std::size_t n) {
  v1::EvaluateRequest request;
  wire::WriteParameters(std::vector<SurfaceParameter>(n, {0, 0, 0.25, 0.5}),
                        request.mutable_parameters());
  return request;
}

void WaitForSolve(RawEvaluation& call) {
  for (;;) {
    const std::optional<v1::EvaluateResponse> message = call.Read();
    ASSERT_TRUE(message.has_value()) << call.Finish();
    if (message->has_progress() && message->progress().stage() == "solve") return;
  }
}

void WaitForSamples(RawEvaluation& call) {
  for (;;) {
    const std::optional<v1::EvaluateResponse> message = call.Read();
    ASSERT_TRUE(message.has_value()) << call.Finish();
    if (!message->positions().empty()) return;
  }
}

TEST(EvaluateCancelTest, ARunningJobStopsAndItsPlaceComesBack) {
  const std::unique_ptr<Server> server = StartServer(OnePlace());
  RawEvaluation call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(MakeEvaluateUpload(MakeEndlessEvaluation(), MakeSphere(50'000))));
  // Parameters may wait for the surface.
  ASSERT_TRUE(call.Write(MakeBlock(100)));
  WaitForSolve(call);
  const auto start = steady_clock::now();
  call.Cancel();
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
  EXPECT_LT(steady_clock::now() - start, std::chrono::seconds(4));
}

TEST(EvaluateCancelTest, ADeadlineStopsARunningJob) {
  const std::unique_ptr<Server> server = StartServer(OnePlace());
  const auto upload = MakeEvaluateUpload(MakeEndlessEvaluation(), MakeSphere(20'000));
  {
    RawEvaluation call(server->InProcessChannel(), milliseconds(700) * oracle::kSlowdown);
    ASSERT_TRUE(call.Write(upload));
    EXPECT_EQ(ReasonOf(call.Finish()), Reason::kDeadlineExceeded);
  }
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
}

TEST(EvaluateCancelTest, ADeadlineEndsACallThatWaitsForParameters) {
  const std::unique_ptr<Server> server = StartServer();
  RawEvaluation call(server->InProcessChannel(), milliseconds(500) * oracle::kSlowdown);
  ASSERT_TRUE(call.Write(MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100))));
  EXPECT_EQ(ReasonOf(call.Finish()), Reason::kDeadlineExceeded);
}

// The only memory and the only place are free again after each.
TEST(EvaluateCancelTest, AClientThatVanishesFreesItsPlaceAtEveryStage) {
  std::vector<v1::EvaluateRequest> requests =
      MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(5'000));
  const std::size_t upload = requests.size();
  // As many as the server holds without being read.
  requests.insert(requests.end(), 2, MakeBlock(60'000));
  const std::unique_ptr<Server> server = StartServer(OnePlace());
  const auto channel = server->InProcessChannel();
  for (const std::size_t sent : {std::size_t{0}, std::size_t{1}, upload, upload + 1, upload + 2}) {
    {
      RawEvaluation call(channel);
      ASSERT_TRUE(call.Write({requests.begin(), requests.begin() + static_cast<long>(sent)}));
      if (sent > upload) WaitForSamples(call);
    }
    EXPECT_TRUE(PlaceBecomesFree(channel)) << "after " << sent << " messages";
  }
}

TEST(EvaluateCancelTest, AHundredCancelledCallsLeaveAServerThatWorks) {
  const std::unique_ptr<Server> server = StartServer();
  const auto channel = server->InProcessChannel();
  const std::vector<v1::EvaluateRequest> upload =
      MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(500));
  for (int job = 0; job < 100; ++job) {
    RawEvaluation call(channel);
    call.Write(upload);
    if (job % 3 != 0) call.Write(MakeBlock(20'000));
    if (job % 4 == 0) call.WritesDone();
    for (int message = 0; message < job % 5 && job % 3 != 0; ++message) call.Read();
    call.Cancel();
    const absl::Status status = call.Finish();
    EXPECT_TRUE(status.ok() || status.code() == absl::StatusCode::kCancelled) << status;
  }
  EXPECT_TRUE(PlaceBecomesFree(channel));
}

TEST(EvaluateStallTest, ACallWithoutParametersIsEnded) {
  ServerOptions options = OnePlace();
  options.limits.stall_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  for (const std::size_t blocks : {0, 1}) {
    RawEvaluation call(server->InProcessChannel());
    ASSERT_TRUE(call.Write(MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100))));
    ASSERT_TRUE(blocks == 0 || call.Write(MakeBlock(10)));
    const absl::Status status = call.Finish();
    EXPECT_EQ(ReasonOf(status), Reason::kLimitExceeded) << status;
    EXPECT_EQ(GetErrorDetail(status)->limit, "stall-seconds");
  }
}

// Not only the answers wait then: the server takes no more than it can hold.
TEST(EvaluateStallTest, AClientThatOnlySendsIsHeldBackAndEnded) {
  ServerOptions options = OnePlace();
  options.limits.stall_seconds = 1;
  options.listen = "127.0.0.1:0";
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = grpc::CreateChannel("127.0.0.1:" + std::to_string(server->port()),
                                           grpc::InsecureChannelCredentials());
  RawEvaluation call(channel);
  ASSERT_TRUE(call.Write(MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100))));
  const v1::EvaluateRequest block = MakeBlock(60'000);
  int taken = 0;
  // 1.3 MB each; what the sockets hold comes on top of what the server does.
  while (taken < 400 && call.Write(block)) ++taken;
  EXPECT_LT(taken, 100);
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
}

TEST(EvaluateStallTest, ALongJobIsNoStall) {
  ServerOptions options = OnePlace();
  options.limits.stall_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  const auto upload = MakeEvaluateUpload(MakeEndlessEvaluation(), MakeSphere(50'000));
  RawEvaluation call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(upload));
  const auto start = steady_clock::now();
  while (steady_clock::now() - start < milliseconds(2000)) {
    ASSERT_TRUE(call.Read().has_value()) << call.Finish();
  }
}

TEST(EvaluateDrainTest, NewCallsAreRefusedAndTheRunningOneFinishes) {
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 2});
  const auto channel = grpc::CreateChannel("127.0.0.1:" + std::to_string(server->port()),
                                           grpc::InsecureChannelCredentials());
  RawEvaluation running(channel);
  ASSERT_TRUE(running.Write(MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100))));
  ASSERT_TRUE(running.Read().has_value());
  server->Drain();
  RawEvaluation late(channel);
  late.Write(MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100)).front());
  EXPECT_EQ(ReasonOf(late.Finish()), Reason::kShuttingDown);
  std::thread stopper([&] { server->Shutdown(std::chrono::seconds(30)); });
  EXPECT_TRUE(running.Write(MakeBlock(100)));
  running.WritesDone();
  EXPECT_TRUE(running.Finish().ok()) << running.Finish();
  stopper.join();
}

TEST(EvaluateDrainTest, ACallThatWaitsForParametersIsEndedInTime) {
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 2});
  const auto channel = grpc::CreateChannel("127.0.0.1:" + std::to_string(server->port()),
                                           grpc::InsecureChannelCredentials());
  RawEvaluation waiting(channel);
  ASSERT_TRUE(waiting.Write(MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100))));
  ASSERT_TRUE(waiting.Write(MakeBlock(10)));
  WaitForSamples(waiting);
  std::thread reader([&] { (void)waiting.Finish(); });
  const auto start = steady_clock::now();
  server->Shutdown(milliseconds(300));
  EXPECT_LT(steady_clock::now() - start, milliseconds(2000));
  reader.join();
  EXPECT_EQ(ReasonOf(waiting.Finish()), Reason::kShuttingDown);
}

}  // namespace
}  // namespace limn
