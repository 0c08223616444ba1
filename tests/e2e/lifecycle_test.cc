// SPDX-License-Identifier: MIT
// From readiness to the end: probes, a second signal, the watchdog.
#include <grpcpp/grpcpp.h>

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include "tests/e2e/health.h"
#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

class LifecycleE2e : public testing::Test {
 protected:
  std::string Generate(const std::string& kind, const std::string& vertices) const {
    const RunResult run =
        space_.Limn({"generate", kind, "--vertices", vertices, "-o", space_.path("given.obj")});
    EXPECT_EQ(run.status, 0) << run.errors;
    return space_.path("given.obj");
  }
  // A client whose job takes minutes, in the stage "solve".
  Process* StartLongJob(const ServerProcess& server) {
    Process* client =
        space_.StartLimn({"interpolate", Generate("irregular_sphere", "50000"), "--solver",
                          "gauss-seidel", "--tolerance", "0", "--max-sweeps", "10000", "-o",
                          space_.path("s.obj"), "--server", server.address()});
    EXPECT_TRUE(
        WaitUntil(30, [&] { return client->ErrorText().find("solve") != std::string::npos; }));
    return client;
  }
  Workspace space_;
};

TEST_F(LifecycleE2e, IsReadyWhenItsPortIsKnown) {
  ServerProcess server(space_);
  EXPECT_EQ(Health(server.address(), ""), "SERVING");
  EXPECT_EQ(Health(server.address(), "limn.v1.LimnService"), "SERVING");
  EXPECT_EQ(Health(server.address(), "liveness"), "SERVING");
}

TEST_F(LifecycleE2e, WhileItDrainsItIsAliveButNotReady) {
  ServerProcess server(space_, {"--drain-seconds", "20"});
  Process* client = StartLongJob(server);
  server.process().Signal(SIGTERM);
  EXPECT_TRUE(WaitUntil(5, [&] { return Health(server.address(), "") == "NOT_SERVING"; }));
  EXPECT_EQ(Health(server.address(), "liveness"), "SERVING");
  // New work is refused at once, with a word on when to come back.
  const RunResult late = space_.Limn({"interpolate", space_.path("given.obj"), "-o",
                                      space_.path("t.obj"), "--server", server.address()});
  EXPECT_EQ(late.status, 3);
  EXPECT_NE(late.errors.find("stopping"), std::string::npos) << late.errors;
  EXPECT_TRUE(client->Running());
  client->Signal(SIGINT);
  EXPECT_EQ(server.process().Wait(10), 0) << server.Log();
}

TEST_F(LifecycleE2e, ASecondSignalEndsItAtOnce) {
  ServerProcess server(space_, {"--drain-seconds", "600"});
  Process* client = StartLongJob(server);
  server.process().Signal(SIGTERM);
  EXPECT_TRUE(server.WaitForLog("event=stopping"));
  const auto start = std::chrono::steady_clock::now();
  server.process().Signal(SIGTERM);
  EXPECT_EQ(server.process().Wait(10), 128 + SIGTERM);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
  EXPECT_EQ(client->Wait(10), 3) << client->ErrorText();
}

TEST_F(LifecycleE2e, AStuckLaneIsLoggedAndFailsLivenessWhileTheOtherWorks) {
  ServerProcess server(space_,
                       {"--stuck-seconds", "1", "--workers", "1", "--drain-seconds", "1",
                        "--interactive-milliseconds", "10"},
                       Process::Errors::kFile, ENDLESS_DRACO);
  // Large enough for the batch lane; its control mesh is never encoded.
  const std::string given = Generate("torus", "20000");
  Process* client =
      space_.StartLimn({"interpolate", given, "--control-mesh", space_.path("c.obj"), "--encoding",
                        "draco-quantized", "--deadline", "3", "--server", server.address()});
  EXPECT_EQ(client->Wait(20), 3) << client->ErrorText();
  EXPECT_TRUE(server.WaitForLog("event=lane_stuck", 10)) << server.Log();
  EXPECT_NE(server.Log().find("lane=batch stuck_jobs=1 workers=1"), std::string::npos)
      << server.Log();
  EXPECT_EQ(Health(server.address(), "liveness"), "NOT_SERVING");
  EXPECT_EQ(Health(server.address(), ""), "NOT_SERVING");
  const RunResult small = space_.Limn({"interpolate", Generate("cube", "8"), "-o",
                                       space_.path("s.obj"), "--server", server.address()});
  EXPECT_EQ(small.status, 0) << small.errors;
  server.process().Signal(SIGTERM);
  EXPECT_EQ(server.process().Wait(20), 0) << server.Log();
}

TEST_F(LifecycleE2e, MetricsAreServedWhereTheLogSays) {
  ServerProcess server(space_, {"--metrics-listen", "127.0.0.1:0"});
  EXPECT_TRUE(server.WaitForLog("metrics_port="));
  EXPECT_EQ(server.Log().find("metrics_port=0"), std::string::npos) << server.Log();
}

}  // namespace
}  // namespace limn::e2e
