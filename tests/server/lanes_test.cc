// SPDX-License-Identifier: MIT
// Two lanes: what goes where, what each takes, who gets how much of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/job_cost.h"
#include "server/lane.h"
#include "tests/oracle/slowdown.h"
#include "tests/server/certificates.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

JobSpec SpecOf(std::uint32_t level, std::uint64_t vertices) {
  JobSpec spec;
  spec.mesh.set_vertex_count(vertices);
  spec.mesh.set_face_count(vertices);
  spec.mesh.set_corner_count(4 * vertices);
  spec.engine.level = level;
  spec.send_surface = true;
  return spec;
}

TEST(JobCostTest, GrowsWithSizeLevelSweepsConstraintsAndEncoding) {
  JobSpec spec = SpecOf(2, 100'000);
  const std::uint64_t base = EstimateMilliseconds(spec);
  EXPECT_GT(EstimateMilliseconds(SpecOf(2, 200'000)), base * 3 / 2);
  EXPECT_GT(EstimateMilliseconds(SpecOf(4, 100'000)), base * 5);
  spec.tiles.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED;
  EXPECT_GT(EstimateMilliseconds(spec), base * 3);
  spec = SpecOf(2, 100'000);
  spec.engine.solve.tolerance = 0;
  spec.engine.solve.max_sweeps = 10'000;
  EXPECT_GT(EstimateMilliseconds(spec), base * 20);
  spec = SpecOf(2, 100'000);
  spec.engine.constraints.normals.resize(100'000);
  EXPECT_GT(EstimateMilliseconds(spec), base + 100);
  spec = SpecOf(2, 100'000);
  spec.repair = true;
  EXPECT_GT(EstimateMilliseconds(spec), base + 50);
}

TEST(JobCostTest, IsWithinAnOrderOfMagnitudeOfTheTruth) {
  const std::unique_ptr<Server> server = StartServer({.threads = 1});
  const PolygonMesh mesh = MakeSphere(20'000);
  for (const std::uint32_t level : {0U, 2U, 3U}) {
    RawCall call(server->InProcessChannel());
    ASSERT_TRUE(call.Write(MakeUpload(MakeHeader(level), mesh)));
    double estimate = 0;
    double took = 0;
    while (const std::optional<v1::InterpolateResponse> message = call.Read()) {
      if (message->has_accepted()) {
        estimate = static_cast<double>(message->accepted().estimated_milliseconds());
      }
      for (const v1::StageTime& stage : message->summary().stages()) {
        if (stage.stage() != "receive" && stage.stage() != "queue") took += stage.milliseconds();
      }
    }
    // On processors that do other things too.
    EXPECT_LT(took, 20 * oracle::kSlowdown * oracle::kSlowdown * estimate) << level;
    EXPECT_GT(took, estimate / 10) << level;
  }
}

TEST(JobCostTest, AMeshOfUnknownSizeCountsByItsBytes) {
  JobSpec spec = SpecOf(2, 0);
  spec.mesh.set_byte_count(10 << 20);
  EXPECT_GT(EstimateMilliseconds(spec), 1000U);
}

v1::Accepted AcceptedOf(RawCall& call) {
  const std::optional<v1::InterpolateResponse> message = call.Read();
  EXPECT_TRUE(message.has_value()) << call.Finish();
  return message.has_value() ? message->accepted() : v1::Accepted();
}

TEST(LanesTest, SmallJobsAreInteractiveAndLargeOnesBatch) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall small(server->InProcessChannel());
  ASSERT_TRUE(small.Write(MakeUpload(MakeHeader(1), MakeSphere(500))));
  EXPECT_EQ(AcceptedOf(small).lane(), "interactive");
  RawCall large(server->InProcessChannel());
  ASSERT_TRUE(large.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(5000))));
  const v1::Accepted accepted = AcceptedOf(large);
  EXPECT_EQ(accepted.lane(), "batch");
  EXPECT_GT(accepted.estimated_milliseconds(), 100U);
}

TEST(LanesTest, AFullBatchLaneTakesNothingFromTheInteractiveOne) {
  ServerOptions options{.threads = 1};
  options.limits.workers = 1;
  options.limits.queue_length = 0;
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = server->InProcessChannel();
  const auto endless = MakeUpload(MakeEndlessHeader(), MakeSphere(20'000));
  RawCall running(channel);
  ASSERT_TRUE(running.Write(endless));
  for (std::string stage; stage != "solve";) {
    const std::optional<v1::InterpolateResponse> message = running.Read();
    ASSERT_TRUE(message.has_value());
    stage = message->progress().stage();
  }
  RawCall refused(channel);
  refused.Write(endless);
  EXPECT_EQ(ReasonOf(refused.Finish()), Reason::kLimitExceeded);
  for (int i = 0; i < 5; ++i) {
    RawCall small(channel);
    ASSERT_TRUE(small.Write(MakeUpload(MakeHeader(1), MakeSphere(200))));
    EXPECT_TRUE(small.Finish().ok()) << small.Finish();
  }
}

TEST(LanesTest, WhatWaitsIsBoundedByBytesAndByTime) {
  Lane lane({.name = "test",
             .workers = 1,
             .queue_length = 100,
             .queue_bytes = 1000,
             .queue_milliseconds = 50});
  const auto limit_of = [&](const LaneRequest& request) {
    const absl::Status status = lane.Reserve(request).status();
    EXPECT_EQ(ReasonOf(status), Reason::kLimitExceeded);
    EXPECT_TRUE(GetErrorDetail(status)->retryable);
    EXPECT_EQ(lane.NextPosition(request).status(), status);
    return GetErrorDetail(status)->limit;
  };
  // One that does not have to wait may be of any size.
  std::promise<void> go;
  std::promise<void> running;
  absl::StatusOr<Lane::Place> first = lane.Reserve({.bytes = 5000, .milliseconds = 500});
  ASSERT_TRUE(first.ok());
  first->Post([&] {
    running.set_value();
    go.get_future().wait();
  });
  running.get_future().wait();
  absl::StatusOr<Lane::Place> second = lane.Reserve({.bytes = 600, .milliseconds = 10});
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(limit_of({.bytes = 401, .milliseconds = 1}), "queue-bytes");
  EXPECT_EQ(limit_of({.bytes = 1, .milliseconds = 41}), "queue-milliseconds");
  absl::StatusOr<Lane::Place> third = lane.Reserve({.bytes = 400, .milliseconds = 40});
  EXPECT_TRUE(third.ok());
  EXPECT_EQ(limit_of({.bytes = 1, .milliseconds = 1}), "queue-bytes");
  EXPECT_EQ(lane.load().waiting, 2U);
  EXPECT_EQ(lane.load().waiting_bytes, 1000U);
  third->Release();
  second->Release();
  EXPECT_EQ(lane.load().waiting_bytes, 0U);
  EXPECT_EQ(lane.load().waiting_milliseconds, 0U);
  go.set_value();
  first->Release();
  lane.Stop();
}

TEST(LanesTest, JobsThatAreToldToStopAndDoNotAreCounted) {
  Lane lane({.name = "test", .workers = 2, .queue_length = 1});
  std::promise<void> go;
  std::promise<void> running;
  absl::StatusOr<Lane::Place> place = lane.Reserve();
  place->Post([&] {
    running.set_value();
    go.get_future().wait();
  });
  running.get_future().wait();
  const Clock::time_point now = Clock::now();
  EXPECT_EQ(lane.StuckJobs(now + std::chrono::hours(1)), 0U);
  place->StopRequested(now);
  EXPECT_EQ(lane.StuckJobs(now), 0U);
  EXPECT_EQ(lane.StuckJobs(now + milliseconds(1)), 1U);
  go.set_value();
  place->Release();
  EXPECT_EQ(lane.StuckJobs(now + std::chrono::hours(1)), 0U);
  lane.Stop();
}

TEST(LanesTest, AJobThatWaitsTooLongIsRefusedWithItsLimit) {
  ServerOptions options{.threads = 1};
  options.limits.workers = 1;
  options.limits.queue_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  const auto endless = MakeUpload(MakeEndlessHeader(), MakeSphere(20'000));
  RawCall running(server->InProcessChannel());
  ASSERT_TRUE(running.Write(endless));
  RawCall waiting(server->InProcessChannel());
  ASSERT_TRUE(waiting.Write(endless));
  const Clock::time_point start = Clock::now();
  EXPECT_EQ(waiting.Finish().code(), absl::StatusCode::kResourceExhausted) << waiting.Finish();
  EXPECT_GE(Clock::now() - start, milliseconds(900));
  EXPECT_EQ(ErrorInfoOf(waiting.rich_status()).metadata().at("limit"), "queue-seconds");
  EXPECT_TRUE(HasRetryInfo(waiting.rich_status()));
  EXPECT_NE(server->MetricsText().find("limn_admission_rejects_total{limit=\"queue-seconds\"} 1\n"),
            std::string::npos);
}

TEST(LanesTest, ACallThatTakesTooLongInAllIsEnded) {
  ServerOptions options{.threads = 1};
  options.limits.stream_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawCall call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(20'000))));
  EXPECT_EQ(ReasonOf(call.Finish()), Reason::kLimitExceeded);
  EXPECT_EQ(ErrorInfoOf(call.rich_status()).metadata().at("limit"), "stream-seconds");
}

// Clients are told apart by their tokens.
TEST(LanesTest, EveryClientGetsItsShareOfTheServer) {
  const TestDirectory files;
  const std::string token_a = "aaaaaaaaaaaaaaaaaaaaaaaa";
  const std::string token_b = "bbbbbbbbbbbbbbbbbbbbbbbb";
  ServerOptions options{.listen = "127.0.0.1:0", .threads = 1};
  options.token_file = files.Write("tokens", "a " + token_a + "\nb " + token_b + "\n");
  options.limits.workers = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  const std::string address = "127.0.0.1:" + std::to_string(server->port());
  const auto client_of = [&](const std::string& token) {
    return *Client::ConnectSecurely(address, {.token_file = files.Write(token, token)}, {});
  };
  const Client a = client_of(token_a);
  const Client b = client_of(token_b);
  // Some 20 to 50 milliseconds each.
  const PolygonMesh mesh = MakeSphere(10'000);
  v1::InterpolateHeader header = MakeHeader(0);
  header.mutable_output()->clear_surface();
  header.mutable_output()->clear_control_mesh();
  std::mutex mutex;
  std::string order;
  const auto run = [&](const Client& client, char name) {
    const absl::StatusOr<JobResult> result = client.Run(header, mesh);
    EXPECT_TRUE(result.ok()) << result.status();
    const std::lock_guard lock(mutex);
    order += name;
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 24; ++i) threads.emplace_back(run, std::cref(a), 'a');
  // When b comes, a's jobs all wait.
  while (server->MetricsText().find("limn_queue_depth{lane=\"interactive\"} 2") ==
         std::string::npos) {
    const std::lock_guard lock(mutex);
    if (order.size() > 2) break;
  }
  for (int i = 0; i < 4; ++i) threads.emplace_back(run, std::cref(b), 'b');
  for (std::thread& thread : threads) thread.join();
  // b's four jobs do not wait for a's twenty-four.
  EXPECT_LT(order.rfind('b'), 24U) << order;
}

TEST(LanesTest, SixtyFourDifferentJobsAtOnceGiveWhatTheyGiveAlone) {
  ServerOptions options{.threads = 2};
  options.limits.workers = 4;
  options.limits.queue_length = 64;
  // So that both lanes have jobs.
  options.limits.interactive_milliseconds = 2;
  const std::unique_ptr<Server> server = StartServer(options);
  const Client client(server->InProcessChannel());
  constexpr int kJobs = 64;
  const auto run = [&](int job) {
    v1::InterpolateHeader header = MakeHeader(static_cast<std::uint32_t>(job % 4));
    header.set_scheme(job % 3 == 0 ? v1::SCHEME_CATMULL_CLARK : v1::SCHEME_DOO_SABIN);
    const absl::StatusOr<JobResult> result =
        client.Run(header, MakeSphere(100 + 37 * static_cast<std::uint64_t>(job),
                                      1 + static_cast<std::uint64_t>(job)));
    EXPECT_TRUE(result.ok()) << result.status();
    return *result;
  };
  std::vector<JobResult> alone;
  for (int job = 0; job < kJobs; ++job) alone.push_back(run(job));
  std::vector<std::future<JobResult>> together;
  for (int job = 0; job < kJobs; ++job) {
    together.push_back(std::async(std::launch::async, run, job));
  }
  for (int job = 0; job < kJobs; ++job) {
    SCOPED_TRACE(job);
    const JobResult result = together[static_cast<std::size_t>(job)].get();
    const JobResult& expected = alone[static_cast<std::size_t>(job)];
    const auto same_bits = [](const auto& x, const auto& y) {
      return x.size() == y.size() && std::equal(x.begin(), x.end(), y.begin());
    };
    EXPECT_TRUE(same_bits(result.surface.positions, expected.surface.positions));
    EXPECT_TRUE(same_bits(result.surface.normals, expected.surface.normals));
    EXPECT_TRUE(same_bits(result.surface.face_vertices, expected.surface.face_vertices));
    EXPECT_TRUE(same_bits(result.control_mesh.positions, expected.control_mesh.positions));
  }
}

}  // namespace
}  // namespace limn
