// SPDX-License-Identifier: MIT
// Faults around the real server, each with what has to hold; the table of them is in faults.md.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/robustness/half_calls.h"
#include "tests/robustness/harness.h"

namespace limn::robustness {
namespace {

using e2e::Process;
using e2e::WaitUntil;
using std::chrono::milliseconds;

// HTTP/2's preface, without the settings that have to follow it.
constexpr char kPreface[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

// Where a client's job is, by what its progress bar shows.
struct Stage {
  std::string name;
  // Shown then.
  std::string text;
  std::string level;
};

void PrintTo(const Stage& stage, std::ostream* out) { *out << stage.name; }

class StageTest : public testing::TestWithParam<Stage> {
 protected:
  // A client whose job has come to the stage.
  Process* StartClient(Subject& subject) {
    const std::string given = subject.space().path("given.obj");
    EXPECT_EQ(subject.space()
                  .Limn({"generate", "irregular_sphere", "--vertices", "60000", "-o", given})
                  .status,
              0);
    std::vector<std::string> command = {"interpolate", given,
                                        "-o",          subject.space().path("s.obj"),
                                        "--server",    subject.address(),
                                        "--level",     GetParam().level};
    if (GetParam().name == "Solve" || GetParam().name == "Queue") {
      command.insert(command.end(),
                     {"--solver", "gauss-seidel", "--tolerance", "0", "--max-sweeps", "10000"});
    }
    Process* const client = subject.space().StartLimn(command);
    EXPECT_TRUE(WaitUntil(60, [&] {
      return client->ErrorText().find(GetParam().text) != std::string::npos || !client->Running();
    }));
    EXPECT_TRUE(client->Running()) << client->ErrorText();
    return client;
  }
  static std::vector<std::string> Flags() {
    return {"--workers", "1", "--interactive-milliseconds", "0"};
  }
  // Holds the only worker where jobs are to wait.
  std::unique_ptr<RawCall> Occupy(const Subject& subject) const {
    if (GetParam().name != "Queue") return nullptr;
    auto call = std::make_unique<RawCall>(subject.Connect(), std::chrono::minutes(5));
    EXPECT_TRUE(call->Write(MakeUpload(MakeEndlessHeader(), MakeSphere(20'000))));
    EXPECT_TRUE(subject.WaitForMetric("limn_running_jobs{lane=\"batch\"}", 1));
    return call;
  }
};

TEST_P(StageTest, AKilledClientFreesItsWork) {
  Subject subject(Flags());
  std::unique_ptr<RawCall> other = Occupy(subject);
  Process* const client = StartClient(subject);
  if (other != nullptr) {
    EXPECT_TRUE(subject.WaitForMetric("limn_queue_depth{lane=\"batch\"}", 1));
  }
  client->Signal(SIGKILL);
  EXPECT_EQ(client->Wait(10), 128 + SIGKILL);
  const auto killed = std::chrono::steady_clock::now();
  EXPECT_TRUE(subject.WaitForMetric("limn_open_streams", other != nullptr ? 1 : 0));
  EXPECT_LT(std::chrono::steady_clock::now() - killed, std::chrono::seconds(5));
  other.reset();
  EXPECT_TRUE(subject.WaitUntilIdle()) << subject.Metrics();
  EXPECT_TRUE(subject.SmallJob().ok());
}

TEST_P(StageTest, AKilledServerEndsItsClientWithoutOutput) {
  Subject subject(Flags());
  std::unique_ptr<RawCall> other = Occupy(subject);
  Process* const client = StartClient(subject);
  subject.server().process().Signal(SIGKILL);
  EXPECT_EQ(client->Wait(20), 3) << client->ErrorText();
  EXPECT_EQ(subject.space().Files(), std::vector<std::string>{"given.obj"});
}

INSTANTIATE_TEST_SUITE_P(Stages, StageTest,
                         testing::Values(Stage{"Upload", "send", "2"}, Stage{"Queue", "send", "2"},
                                         Stage{"Solve", "solve", "2"},
                                         Stage{"Compute", "limit", "4"},
                                         Stage{"Answer", "collect", "4"}),
                         [](const auto& test) { return test.param.name; });

TEST(FaultsTest, AStoppedReaderCostsLittleMemoryAndIsEnded) {
  Subject subject({"--stall-seconds", "2"});
  // Their answers are 25 MB each.
  const std::vector<v1::InterpolateRequest> upload = MakeUpload(MakeHeader(4), MakeSphere(2000));
  std::vector<std::unique_ptr<RawCall>> calls;
  for (int i = 0; i < 4; ++i) {
    calls.push_back(std::make_unique<RawCall>(subject.Connect(), std::chrono::minutes(5)));
    ASSERT_TRUE(calls.back()->Write(upload));
  }
  ASSERT_TRUE(WaitUntil(30, [&] { return subject.Metric("limn_inflight_bytes") > 1e6; }));
  EXPECT_LT(subject.Metric("limn_inflight_bytes"), 4.0 * 4 * (1 << 20));
  // Nobody reads: all are ended, and what they held comes back.
  EXPECT_TRUE(subject.WaitUntilIdle(40)) << subject.Metrics();
  for (const auto& call : calls) EXPECT_FALSE(call->Finish().ok());
  EXPECT_GT(subject.Metric("limn_stream_stall_seconds_total"), 2);
  EXPECT_TRUE(subject.SmallJob().ok());
}

TEST(FaultsTest, AStalledUploaderIsEnded) {
  Subject subject({"--stall-seconds", "2"});
  const std::vector<v1::InterpolateRequest> upload =
      MakeUpload(MakeHeader(1), MakeSphere(20'000), 64 << 10);
  RawCall call(subject.Connect(), std::chrono::minutes(5));
  ASSERT_TRUE(call.Write({upload.begin(), upload.begin() + 4}));
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kResourceExhausted) << call.Finish();
  EXPECT_TRUE(subject.WaitUntilIdle());
}

TEST(FaultsTest, HalfOpenConnectionsHoldNobodyUp) {
  Subject subject({"--max-connections", "200", "--stall-seconds", "2"});
  std::vector<std::unique_ptr<BareConnection>> silent;
  for (int i = 0; i < 100; ++i) {
    silent.push_back(std::make_unique<BareConnection>(subject.port(), i % 2 == 0 ? "" : kPreface));
    ASSERT_TRUE(silent.back()->connected());
  }
  EXPECT_TRUE(subject.SmallJob().ok());
  // They never finish their handshakes.
  for (const auto& connection : silent) EXPECT_TRUE(connection->Closed(40));
  EXPECT_TRUE(subject.WaitForMetric("limn_connections", 0)) << subject.Metrics();
}

TEST(FaultsTest, GarbageOnTheWireEndsItsConnectionOnly) {
  Subject subject({"--stall-seconds", "2"});
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\n\r\n"), std::string(100'000, '\xff'),
        std::string("\x16\x03\x01\x02\x00\x01", 6) + std::string(512, 'x'),
        std::string(kPreface) + std::string(5000, '\0')}) {
    EXPECT_TRUE(BareConnection(subject.port(), bytes).Closed(40));
  }
  EXPECT_TRUE(subject.SmallJob().ok());
}

TEST(FaultsTest, MessagesThatNeverArriveWholeAreBoundedTogether) {
  constexpr double kMiB = 1 << 20;
  Subject subject({"--max-network-bytes", std::to_string(64 << 20)});
  ASSERT_TRUE(subject.SmallJob().ok());
  const double before = subject.Metric("process_resident_memory_bytes");
  // Calls of what has no token asked of it yet, or never: 512 MiB if they were let.
  const std::string methods[] = {"/limn.v1.LimnService/GetServerInfo",
                                 "/grpc.health.v1.Health/Check"};
  std::vector<std::unique_ptr<HalfCalls>> connections;
  for (int i = 0; i < 4; ++i) {
    connections.push_back(
        std::make_unique<HalfCalls>(subject.port(), methods[i % 2], 64, (2 << 20) - 100));
  }
  const auto sum = [&](auto value) {
    double total = 0;
    for (const auto& connection : connections) total += value(*connection);
    return total;
  };
  // The server begins to end them.
  EXPECT_TRUE(WaitUntil(30, [&] { return sum([](const auto& c) { return c.open(); }) < 200; }));
  EXPECT_GT(sum([](const auto& c) { return static_cast<double>(c.sent()); }), 32 * kMiB);
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_LT(subject.Metric("process_resident_memory_bytes"), before + 160 * kMiB);
  connections.clear();
  EXPECT_TRUE(WaitUntil(20, [&] { return subject.SmallJob().ok(); })) << subject.server().Log();
}

TEST(FaultsTest, CallsOfReflectionThatSayNothingTakeFewThreads) {
  Subject subject;
  const auto threads = [&] {
    return std::distance(std::filesystem::directory_iterator(
                             "/proc/" + std::to_string(subject.server().process().pid()) + "/task"),
                         {});
  };
  const auto before = threads();
  std::vector<std::unique_ptr<HalfCalls>> connections;
  for (int i = 0; i < 4; ++i) {
    connections.push_back(std::make_unique<HalfCalls>(
        subject.port(), "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", 64, 100));
  }
  EXPECT_TRUE(WaitUntil(20, [&] { return connections.back()->open() < 64; }));
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_LT(threads(), before + 40);
  EXPECT_TRUE(subject.SmallJob().ok()) << subject.server().Log();
}

TEST(FaultsTest, DescriptorsRunOutAndTheServerRecovers) {
  Subject subject({"--max-connections", "100000"}, {"/usr/bin/prlimit", "--nofile=80:80"});
  ASSERT_TRUE(subject.SmallJob().ok());
  {
    std::vector<std::unique_ptr<BareConnection>> many;
    for (int i = 0; i < 300; ++i) {
      many.push_back(std::make_unique<BareConnection>(subject.port()));
    }
    std::this_thread::sleep_for(milliseconds(500));
    EXPECT_TRUE(subject.server().process().Running());
  }
  EXPECT_TRUE(WaitUntil(30, [&] { return subject.SmallJob().ok(); })) << subject.server().Log();
}

TEST(FaultsTest, AFullDiskUnderTheLogChangesNothing) {
  Subject subject({}, {"/bin/sh", "-c", "exec \"$@\" 2>/dev/full", "sh"});
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(subject.SmallJob().ok());
  subject.server().process().Signal(SIGTERM);
  EXPECT_EQ(subject.server().process().Wait(20), 0);
}

TEST(FaultsTest, MemoryThatIsNotThereRefusesTheJobAndTheServerLives) {
  // The server believes that it has more than there is.
  Subject subject({"--max-total-bytes", "17179869184"}, {"/usr/bin/prlimit", "--as=1600000000"});
  ASSERT_TRUE(subject.SmallJob().ok()) << subject.server().Log();
  RawCall large(subject.Connect(), std::chrono::minutes(2));
  large.Write(MakeUpload(MakeHeader(5), MakeSphere(50'000)));
  const absl::Status status = large.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(ReasonOf(status), Reason::kOutOfMemory) << status;
  EXPECT_TRUE(subject.server().process().Running());
  EXPECT_TRUE(subject.WaitUntilIdle());
  EXPECT_TRUE(subject.SmallJob().ok()) << subject.server().Log();
}

class ClockTest : public testing::TestWithParam<const char*> {};

TEST_P(ClockTest, AWallClockThatJumpsByADayEndsNothing) {
  const e2e::Workspace files;
  const std::string jump = files.path("jump");
  Subject subject({"--stall-seconds", "10"}, {"/usr/bin/env", "LIMN_CLOCK_JUMP=" + jump},
                  CLOCK_JUMP);
  RawCall running(subject.Connect(), std::chrono::minutes(2));
  ASSERT_TRUE(running.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(20'000))));
  ASSERT_TRUE(subject.WaitForMetric("limn_running_jobs{lane=\"batch\"}", 1));
  RawCall uploading(subject.Connect(), std::chrono::minutes(2));
  const std::vector<v1::InterpolateRequest> upload = MakeUpload(MakeHeader(1), MakeSphere(100));
  ASSERT_TRUE(uploading.Write(upload[0]));
  ASSERT_TRUE(uploading.Read().has_value());
  e2e::WriteAll(jump, GetParam());
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_EQ(subject.Metric("limn_running_jobs{lane=\"batch\"}"), 1);
  ASSERT_TRUE(uploading.Write({upload.begin() + 1, upload.end()}));
  EXPECT_TRUE(uploading.Finish().ok()) << uploading.Finish();
  EXPECT_TRUE(subject.SmallJob().ok());
  running.Cancel();
  (void)running.Finish();
  EXPECT_TRUE(subject.WaitUntilIdle());
}

INSTANTIATE_TEST_SUITE_P(Ways, ClockTest, testing::Values("+", "-"), [](const auto& test) {
  return test.param[0] == '+' ? "Forwards" : "Backwards";
});

}  // namespace
}  // namespace limn::robustness
