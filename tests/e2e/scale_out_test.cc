// SPDX-License-Identifier: MIT
// `limn` with several servers: one that dies in the middle of a job, and what `limn health` says.
#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <vector>

#include "tests/e2e/process.h"
#include "tests/server/certificates.h"

namespace limn::e2e {
namespace {

class ScaleOutE2e : public testing::Test {
 protected:
  std::string At(const std::string& name) const { return space_.path(name); }
  void Generate(const std::string& vertices) const {
    const RunResult run = space_.Limn(
        {"generate", "irregular_sphere", "--vertices", vertices, "-o", At("given.obj")});
    EXPECT_EQ(run.status, 0) << run.errors;
  }
  // Seconds long.
  std::vector<std::string> Job(const std::string& servers, const std::string& out) const {
    return {"interpolate", At("given.obj"), "--solver", "gauss-seidel", "--tolerance",
            "0",           "--max-sweeps",  "1000",     "--level",      "1",
            "-o",          At(out),         "--server", servers};
  }
  RunResult Health(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "health");
    return space_.Limn(arguments);
  }

  Workspace space_;
};

TEST_F(ScaleOutE2e, AJobWhoseServerIsKilledIsDoneByAnother) {
  Generate("20000");
  // The only one there is when the job begins, so that it has the job.
  ServerProcess first(space_);
  std::string second_address;
  {
    ServerProcess reserved(space_);
    second_address = reserved.address();
    reserved.process().Signal(SIGTERM);
    ASSERT_EQ(reserved.process().Wait(20), 0);
  }
  Process* client = space_.StartLimn(Job(first.address() + "," + second_address, "lists.obj"));
  ASSERT_TRUE(WaitUntil(30, [&] { return client->ErrorText().find("solve") != std::string::npos; }))
      << client->ErrorText();
  Process second({LIMND_BINARY, "--listen", second_address}, space_.log("second"));
  ASSERT_TRUE(WaitUntil(20, [&] { return Health({"--server", second_address}).status == 0; }));
  ASSERT_TRUE(client->Running()) << client->ErrorText();
  first.process().Signal(SIGKILL);
  EXPECT_EQ(client->Wait(120), 0) << client->ErrorText();
  EXPECT_NE(second.ErrorText().find("code=OK"), std::string::npos) << second.ErrorText();

  ASSERT_EQ(space_.Limn(Job(second_address, "alone.obj")).status, 0);
  EXPECT_EQ(ReadAll(At("lists.obj")), ReadAll(At("alone.obj")));
}

TEST_F(ScaleOutE2e, WithoutAnyServerTheJobFailsSoon) {
  Generate("100");
  const RunResult run = space_.Limn(Job("127.0.0.1:1,127.0.0.2:1", "s.obj"));
  EXPECT_EQ(run.status, 3);
  EXPECT_NE(run.errors.find("no answer from 127.0.0.1:1,127.0.0.2:1"), std::string::npos)
      << run.errors;
}

TEST_F(ScaleOutE2e, HealthIsAnExitStatus) {
  ServerProcess server(space_);
  EXPECT_EQ(Health({"--server", server.address()}).output, "SERVING\n");
  EXPECT_EQ(Health({"--server", server.address(), "--service", "liveness"}).status, 0);
  EXPECT_EQ(Health({"--server", server.address(), "--service", "another"}).status, 3);
  server.process().Signal(SIGTERM);
  ASSERT_EQ(server.process().Wait(20), 0);
  const RunResult gone = Health({"--server", server.address()});
  EXPECT_EQ(gone.status, 3);
  EXPECT_TRUE(gone.errors.starts_with("limn: no answer from " + server.address())) << gone.errors;
  EXPECT_EQ(Health({"--server", "nowhere"}).status, 2);
}

TEST_F(ScaleOutE2e, ADrainingServerIsNotHealthyButAlive) {
  Generate("20000");
  ServerProcess server(space_);
  Process* client = space_.StartLimn(Job(server.address(), "s.obj"));
  ASSERT_TRUE(WaitUntil(30, [&] { return client->ErrorText().find("solve") != std::string::npos; }))
      << client->ErrorText();
  server.process().Signal(SIGTERM);
  ASSERT_TRUE(server.WaitForLog("event=stopping")) << server.Log();
  const RunResult health = Health({"--server", server.address()});
  EXPECT_EQ(health.output, "NOT_SERVING\n");
  EXPECT_EQ(health.status, 3);
  EXPECT_EQ(Health({"--server", server.address(), "--service", "liveness"}).status, 0);
  EXPECT_EQ(client->Wait(60), 0) << client->ErrorText();
}

// As the probe of a container asks, whose address is not what the certificate is for.
TEST_F(ScaleOutE2e, HealthSpeaksTlsAndTakesItsFlagsFromTheEnvironment) {
  const TestDirectory files;
  const TestAuthority authority("authority");
  const TestIdentity identity = authority.Issue("limnd");
  ServerProcess server(space_, {"--tls-cert", files.Write("server.pem", identity.certificate),
                                "--tls-key", files.Write("server.key", identity.key)});
  const std::string ca = files.Write("ca.pem", authority.certificate());
  EXPECT_EQ(Health({"--server", server.address(), "--tls-ca", ca}).status, 0);
  EXPECT_EQ(
      Health({"--server", server.address(), "--tls-ca", ca, "--tls-name", "localhost"}).status, 0);
  EXPECT_EQ(Health({"--server", server.address(), "--tls-ca", ca, "--tls-name", "other"}).status,
            3);
  EXPECT_EQ(Health({"--server", server.address()}).status, 3);

  Process from_environment(
      {"/usr/bin/env", "LIMN_HEALTH_SERVER=" + server.address(), "LIMN_HEALTH_TLS_CA=" + ca,
       "LIMN_HEALTH_TLS_NAME=localhost", LIMN_BINARY, "health"},
      space_.log("health"));
  EXPECT_EQ(from_environment.Wait(20), 0) << from_environment.ErrorText();
  EXPECT_EQ(from_environment.Output(), "SERVING\n");
}

}  // namespace
}  // namespace limn::e2e
