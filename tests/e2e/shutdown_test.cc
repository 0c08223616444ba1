// SPDX-License-Identifier: MIT
// limnd ends with status 0, in time, whenever the signal comes and whatever stands still around it.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>

#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

using Clock = std::chrono::steady_clock;

class ShutdownE2e : public testing::Test {
 protected:
  Workspace space_;
};

TEST_F(ShutdownE2e, SigtermTheMomentThePortIsKnownEndsWithZero) {
  const std::filesystem::path port = space_.log("port");
  for (int round = 0; round < 50; ++round) {
    std::filesystem::remove(port);
    Process server({LIMND_BINARY, "--listen", "127.0.0.1:0", "--port-file", port},
                   space_.log("limnd"));
    // Without a pause: the moments after the file's appearance are the ones in question.
    const Clock::time_point start = Clock::now();
    while (!std::filesystem::exists(port) && Clock::now() - start < std::chrono::seconds(20)) {
    }
    server.Signal(SIGTERM);
    ASSERT_EQ(server.Wait(20), 0) << "round " << round << ": " << server.ErrorText();
  }
}

TEST_F(ShutdownE2e, AReaderOfTheLogThatStandsStillChangesNothing) {
  ServerProcess server(space_, {"--drain-seconds", "1"}, Process::Errors::kFullPipe);
  ASSERT_EQ(space_.Limn({"generate", "cube", "--vertices", "8", "-o", space_.path("c.obj")}).status,
            0);
  EXPECT_EQ(space_
                .Limn({"interpolate", space_.path("c.obj"), "-o", space_.path("s.obj"), "--server",
                       server.address()})
                .status,
            0);
  const Clock::time_point start = Clock::now();
  server.process().Signal(SIGTERM);
  EXPECT_EQ(server.process().Wait(30), 0);
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(8));
}

TEST_F(ShutdownE2e, WorkThatSeesNoCancelDoesNotHoldTheProcess) {
  ServerProcess server(space_, {"--drain-seconds", "1"}, Process::Errors::kFile, ENDLESS_DRACO);
  ASSERT_EQ(
      space_.Limn({"generate", "torus", "--vertices", "100", "-o", space_.path("t.obj")}).status,
      0);
  Process* client = space_.StartLimn(
      {"interpolate", space_.path("t.obj"), "-o", space_.path("s.obj"), "--control-mesh",
       space_.path("c.obj"), "--encoding", "draco-quantized", "--server", server.address()});
  ASSERT_TRUE(WaitUntil(20, [&] {
    return client->ErrorText().find("encode") != std::string::npos || !client->Running();
  }));
  EXPECT_TRUE(client->Running()) << client->ErrorText();
  const Clock::time_point start = Clock::now();
  server.process().Signal(SIGTERM);
  EXPECT_EQ(server.process().Wait(30), 0) << server.Log();
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(8));
  EXPECT_NE(server.Log().find("work_left=yes"), std::string::npos) << server.Log();
  EXPECT_EQ(client->Wait(20), 3) << client->ErrorText();
}

}  // namespace
}  // namespace limn::e2e
