// SPDX-License-Identifier: MIT
// Start, health, reflection, what the server says of itself, drain and stop.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "server/limits.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

std::shared_ptr<grpc::Channel> Connect(const Server& server) {
  return grpc::CreateChannel("127.0.0.1:" + std::to_string(server.port()),
                             grpc::InsecureChannelCredentials());
}

Reason StartError(const ServerOptions& options) {
  const absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  EXPECT_FALSE(server.ok());
  return ReasonOf(server.status());
}

TEST(ServerTest, ListensOnAFreePort) {
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0"});
  EXPECT_GT(server->port(), 0);
  EXPECT_GE(server->threads(), 1);
  EXPECT_TRUE(Client(Connect(*server)).GetServerInfo().ok());
}

TEST(ServerTest, NeedsNoPort) {
  const std::unique_ptr<Server> server = StartServer();
  EXPECT_EQ(server->port(), 0);
  EXPECT_TRUE(Client(server->InProcessChannel()).GetServerInfo().ok());
}

TEST(ServerTest, RefusesAnAddressThatOthersReachUnlessTold) {
  EXPECT_EQ(StartError({.listen = "0.0.0.0:0"}), Reason::kInvalidOption);
  EXPECT_EQ(StartError({.listen = "[::]:0"}), Reason::kInvalidOption);
  EXPECT_EQ(StartError({.listen = "example.org:80"}), Reason::kInvalidOption);
}

TEST(ServerTest, RefusesAPortThatIsTaken) {
  const std::unique_ptr<Server> first = StartServer({.listen = "127.0.0.1:0"});
  const std::string address = "127.0.0.1:" + std::to_string(first->port());
  EXPECT_EQ(StartError({.listen = address}), Reason::kUnreachable);
}

TEST(ServerTest, RefusesOptionsOutOfRange) {
  EXPECT_EQ(StartError({.threads = -1}), Reason::kInvalidOption);
  for (const LimitEntry& entry : LimitTable()) {
    ServerOptions options;
    options.limits.*entry.value = entry.most + 1;
    EXPECT_EQ(StartError(options), Reason::kInvalidOption) << entry.name;
    if (entry.least == 0) continue;
    options.limits.*entry.value = entry.least - 1;
    EXPECT_EQ(StartError(options), Reason::kInvalidOption) << entry.name;
  }
}

TEST(ServerTest, InfoTellsTheTableOfLimits) {
  ServerOptions options{.threads = 3};
  options.limits.max_level = 5;
  const std::unique_ptr<Server> server = StartServer(options);
  const absl::StatusOr<v1::GetServerInfoResponse> info =
      Client(server->InProcessChannel()).GetServerInfo();
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->version(), LIMN_VERSION);
  EXPECT_EQ(info->threads(), 3U);
  EXPECT_EQ(info->schemes_size(), 3);
  ASSERT_EQ(static_cast<std::size_t>(info->limits_size()), LimitTable().size());
  for (int i = 0; i < info->limits_size(); ++i) {
    const LimitEntry& entry = LimitTable()[static_cast<std::size_t>(i)];
    EXPECT_EQ(info->limits(i).name(), entry.name);
    EXPECT_EQ(info->limits(i).value(), options.limits.*entry.value);
    EXPECT_EQ(info->limits(i).unit(), entry.unit);
    EXPECT_EQ(info->limits(i).description(), entry.description);
  }
}

TEST(ServerTest, HealthAndReflectionAnswer) {
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 1});
  const auto channel = Connect(*server);
  EXPECT_EQ(Health(channel), "SERVING");
  EXPECT_EQ(Health(channel, "limn.v1.LimnService"), "SERVING");
  // ServerReflectionRequest{list_services = 7: ""}.
  const RawAnswer list =
      CallRaw(channel, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
              std::string("\x3a\x00", 2));
  EXPECT_TRUE(list.status.ok()) << list.status.error_message();
  EXPECT_NE(list.bytes.find("limn.v1.LimnService"), std::string::npos);
  // ServerReflectionRequest{file_containing_symbol = 4: "limn.v1.LimnService"}.
  const RawAnswer file =
      CallRaw(channel, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
              std::string("\x22\x13") + "limn.v1.LimnService");
  EXPECT_NE(file.bytes.find("GetServerInfo"), std::string::npos);
}

TEST(ServerTest, RpcsThatAreNotBuiltNameThemselves) {
  const std::unique_ptr<Server> server = StartServer();
  for (const std::string rpc : {"Edit"}) {
    const RawAnswer answer = CallRaw(server->InProcessChannel(), "/limn.v1.LimnService/" + rpc, "");
    EXPECT_EQ(answer.status.error_code(), grpc::StatusCode::UNIMPLEMENTED);
    EXPECT_NE(answer.status.error_message().find(rpc), std::string::npos);
    v1::RichStatus rich;
    ASSERT_TRUE(rich.ParseFromString(answer.status.error_details()));
    EXPECT_EQ(ErrorInfoOf(rich).reason(), "UNIMPLEMENTED");
  }
}

TEST(DrainTest, NewJobsAreRefusedAndTheRunningOneFinishes) {
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 2});
  const auto channel = Connect(*server);
  RawCall running(channel);
  ASSERT_TRUE(running.Write(MakeUpload(MakeHeader(1), MakeSphere(100)).front()));
  ASSERT_TRUE(running.Read()->has_accepted());

  server->Drain();
  EXPECT_EQ(Health(channel), "NOT_SERVING");
  EXPECT_EQ(Health(channel, "limn.v1.LimnService"), "NOT_SERVING");
  RawCall late(channel);
  late.Write(MakeUpload(MakeHeader(1), MakeSphere(100)).front());
  EXPECT_EQ(ReasonOf(late.Finish()), Reason::kShuttingDown);
  EXPECT_EQ(late.Finish().code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(HasRetryInfo(late.rich_status()));

  std::thread stopper([&] { server->Shutdown(std::chrono::seconds(30)); });
  std::vector<v1::InterpolateRequest> upload = MakeUpload(MakeHeader(1), MakeSphere(100));
  upload.erase(upload.begin());
  EXPECT_TRUE(running.Write(upload));
  EXPECT_TRUE(running.Finish().ok()) << running.Finish();
  stopper.join();
}

TEST(DrainTest, JobsThatTakeTooLongAreEndedInTime) {
  // Over a socket: an in-process channel is cut at once when its server stops, and what the server
  // said last may go unheard.
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 2});
  const auto channel = Connect(*server);
  RawCall running(channel);
  ASSERT_TRUE(running.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(50'000))));
  RawCall uploading(channel);
  ASSERT_TRUE(uploading.Write(MakeUpload(MakeHeader(1), MakeSphere(100)).front()));
  ASSERT_TRUE(uploading.Read().has_value());
  std::thread reader([&] { (void)running.Finish(); });
  std::thread other_reader([&] { (void)uploading.Finish(); });
  const auto start = steady_clock::now();
  server->Shutdown(milliseconds(300));
  const auto took = steady_clock::now() - start;
  reader.join();
  other_reader.join();
  EXPECT_GE(took, milliseconds(300));
  EXPECT_LT(took, std::chrono::milliseconds(2000));
  EXPECT_EQ(ReasonOf(running.Finish()), Reason::kShuttingDown);
  EXPECT_EQ(ReasonOf(uploading.Finish()), Reason::kShuttingDown);
}

TEST(DrainTest, AReaderThatStandsStillDoesNotHoldTheServer) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall slow(server->InProcessChannel());
  ASSERT_TRUE(slow.Write(MakeUpload(MakeHeader(3), MakeSphere(5'000))));
  std::this_thread::sleep_for(milliseconds(500));
  const auto start = steady_clock::now();
  server->Shutdown(milliseconds(100));
  EXPECT_LT(steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_FALSE(slow.Finish().ok());
}

TEST(DrainTest, DestroyingAServerEndsItsJobs) {
  std::unique_ptr<Server> server = StartServer();
  RawCall running(server->InProcessChannel());
  ASSERT_TRUE(running.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(20'000))));
  server.reset();
  EXPECT_FALSE(running.Finish().ok());
}

}  // namespace
}  // namespace limn
