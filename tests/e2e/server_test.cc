// SPDX-License-Identifier: MIT
// The server as a process: start, stop, cancel, and what the client says when it is not there.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <vector>

#include "limn/v1/limn.grpc.pb.h"
#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

class ServerE2e : public testing::Test {
 protected:
  std::string At(const std::string& name) const { return space_.path(name); }
  std::string Generate(const std::string& vertices) const {
    const RunResult run = space_.Limn(
        {"generate", "irregular_sphere", "--vertices", vertices, "-o", At("given.obj")});
    EXPECT_EQ(run.status, 0) << run.errors;
    return At("given.obj");
  }
  // Waits until the progress bar shows the solve: then the server computes.
  static bool WaitForSolve(Process* client) {
    return WaitUntil(30, [&] { return client->ErrorText().find("solve") != std::string::npos; });
  }
  // A job of minutes: ten thousand serial sweeps over a large mesh.
  std::vector<std::string> LongJob() const {
    return {"interpolate", Generate("100000"), "--solver", "gauss-seidel", "--tolerance",
            "0",           "--max-sweeps",     "10000",    "-o",           At("s.obj")};
  }

  Workspace space_;
};

// One table: what --help says is what GetServerInfo answers; server_tests has the README's.
TEST_F(ServerE2e, HelpAndServerInfoTellTheSameLimits) {
  Process help({LIMND_BINARY, "--help"}, space_.log("help"));
  ASSERT_EQ(help.Wait(20), 0);
  const std::string text = help.Output();
  ServerProcess server(space_);
  const auto stub = v1::LimnService::NewStub(
      grpc::CreateChannel(server.address(), grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  ASSERT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  std::size_t at = text.find("Limits:");
  ASSERT_NE(at, std::string::npos);
  for (const v1::Limit& limit : info.limits()) {
    SCOPED_TRACE(limit.name());
    at = text.find("\n  --" + limit.name() + " ", at);
    ASSERT_NE(at, std::string::npos) << text;
    const std::string entry = text.substr(at + 1, text.find("\n  --", at + 1) - at);
    EXPECT_NE(entry.find("]=" + std::to_string(limit.value()) + "\n"), std::string::npos) << entry;
    EXPECT_NE(entry.find(limit.description() + " (" + limit.unit() + ")\n"), std::string::npos)
        << entry;
  }
  // And no other flags of that group.
  EXPECT_EQ(text.find("\n  --", at + 1), std::string::npos) << text.substr(at);
}

TEST_F(ServerE2e, SigtermEndsAnIdleServerWithZero) {
  ServerProcess server(space_);
  server.process().Signal(SIGTERM);
  EXPECT_EQ(server.process().Wait(20), 0) << server.Log();
}

TEST_F(ServerE2e, SigtermEndsTheServerWithZeroAfterJobs) {
  ServerProcess server(space_);
  const std::string given = Generate("500");
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(
        space_.Limn({"interpolate", given, "-o", At("s.obj"), "--server", server.address()}).status,
        0)
        << server.Log();
  }
  server.process().Signal(SIGTERM);
  EXPECT_EQ(server.process().Wait(20), 0) << server.Log();
}

TEST_F(ServerE2e, CtrlCOfTheClientCancelsOnTheServer) {
  ServerProcess server(space_);
  std::vector<std::string> arguments = LongJob();
  arguments.insert(arguments.end(), {"--server", server.address()});
  Process* client = space_.StartLimn(arguments);
  ASSERT_TRUE(WaitForSolve(client)) << server.Log() << client->ErrorText();
  EXPECT_TRUE(client->Running()) << client->ErrorText();
  client->Signal(SIGINT);
  EXPECT_EQ(client->Wait(10), 130) << client->ErrorText();
  EXPECT_NE(client->ErrorText().find("limn: interrupted"), std::string::npos)
      << client->ErrorText();
  EXPECT_TRUE(server.WaitForLog("CANCELLED", 10)) << server.Log();
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"given.obj"});

  // The next job runs at once.
  const RunResult next = space_.Limn(
      {"interpolate", Generate("500"), "-o", At("t.obj"), "--server", server.address()});
  EXPECT_EQ(next.status, 0) << next.errors << server.Log();
}

TEST_F(ServerE2e, CtrlCEndsAnEmbeddedJobToo) {
  Process* client = space_.StartLimn(LongJob());
  ASSERT_TRUE(WaitForSolve(client)) << client->ErrorText();
  EXPECT_TRUE(client->Running()) << client->ErrorText();
  client->Signal(SIGINT);
  EXPECT_EQ(client->Wait(10), 130) << client->ErrorText();
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"given.obj"});
}

TEST_F(ServerE2e, DeadlineEndsAJobWithThree) {
  ServerProcess server(space_);
  std::vector<std::string> arguments = LongJob();
  arguments.insert(arguments.end(), {"--server", server.address(), "--deadline", "1"});
  const RunResult run = space_.Limn(arguments);
  EXPECT_EQ(run.status, 3) << run.errors;
  EXPECT_TRUE(run.errors.starts_with("limn: ")) << run.errors;
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"given.obj"});
}

TEST_F(ServerE2e, SigtermStopsTheServerWhileAJobRuns) {
  ServerProcess server(space_, {"--drain-seconds", "1"});
  std::vector<std::string> arguments = LongJob();
  arguments.insert(arguments.end(), {"--server", server.address()});
  Process* client = space_.StartLimn(arguments);
  ASSERT_TRUE(WaitForSolve(client)) << server.Log() << client->ErrorText();
  server.process().Signal(SIGTERM);
  EXPECT_EQ(server.process().Wait(50), 0) << server.Log();
  EXPECT_EQ(client->Wait(20), 3) << client->ErrorText();
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"given.obj"});
}

TEST_F(ServerE2e, NoServerIsExitStatusThreeAndNamesTheAddress) {
  const std::string given = Generate("100");
  // Port 1 of the loopback address: nobody listens there.
  const RunResult run =
      space_.Limn({"interpolate", given, "-o", At("s.obj"), "--server", "127.0.0.1:1"});
  EXPECT_EQ(run.status, 3) << run.errors;
  EXPECT_NE(run.errors.find("127.0.0.1:1"), std::string::npos) << run.errors;
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"given.obj"});
}

TEST_F(ServerE2e, LoopAsksForTriangles) {
  const std::string given = Generate("100");
  const RunResult run = space_.Limn({"interpolate", given, "-o", At("s.obj"), "--scheme", "loop"});
  EXPECT_EQ(run.status, 1) << run.errors;
  EXPECT_NE(run.errors.find("triangle"), std::string::npos) << run.errors;
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"given.obj"});
}

TEST_F(ServerE2e, AServerThatCannotListenSaysSoAndFails) {
  ServerProcess first(space_);
  Process second({LIMND_BINARY, "--listen", first.address()}, space_.log("second"));
  const int status = second.Wait(20);
  EXPECT_NE(status, 0);
  EXPECT_NE(status, Process::kTimedOut);
}

}  // namespace
}  // namespace limn::e2e
