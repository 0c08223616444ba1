// SPDX-License-Identifier: MIT
// TLS and tokens between the real binaries.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/e2e/process.h"
#include "tests/server/certificates.h"

namespace limn::e2e {
namespace {

constexpr char kToken[] = "a-token-of-twenty-four-c";

class SecurityE2e : public testing::Test {
 protected:
  SecurityE2e() {
    const TestIdentity server = authority_.Issue("limnd");
    server_flags_ = {"--tls-cert",      files_.Write("server.pem", server.certificate),
                     "--tls-key",       files_.Write("server.key", server.key),
                     "--tls-client-ca", files_.Write("ca.pem", authority_.certificate()),
                     "--token-file",    files_.Write("tokens", std::string("me ") + kToken + "\n")};
    const RunResult run =
        space_.Limn({"generate", "cube", "--vertices", "8", "-o", space_.path("c.obj")});
    EXPECT_EQ(run.status, 0) << run.errors;
  }
  // Exit status and errors of a job sent to the server.
  RunResult Job(const ServerProcess& server, const std::vector<std::string>& flags) const {
    std::vector<std::string> command = {"interpolate", space_.path("c.obj"),
                                        "-o",          space_.path("s.obj"),
                                        "--server",    server.address()};
    command.insert(command.end(), flags.begin(), flags.end());
    return space_.Limn(command);
  }
  std::vector<std::string> Identity(const TestAuthority& authority) const {
    const TestIdentity client = authority.Issue("client");
    return {"--tls-ca",   files_.path("ca.pem"),
            "--tls-cert", files_.Write("client.pem", client.certificate),
            "--tls-key",  files_.Write("client.key", client.key)};
  }

  Workspace space_;
  TestDirectory files_;
  TestAuthority authority_{"authority"};
  std::vector<std::string> server_flags_;
};

TEST_F(SecurityE2e, WhoHasEverythingIsServedAndWhoLacksAnythingIsNot) {
  ServerProcess server(space_, server_flags_);
  std::vector<std::string> flags = Identity(authority_);
  const std::vector<std::string> token = {"--token-file", files_.path("tokens")};
  flags.insert(flags.end(), token.begin(), token.end());
  EXPECT_EQ(Job(server, flags).status, 0) << server.Log();
  EXPECT_TRUE(server.WaitForLog("client=me")) << server.Log();

  const auto refused = [&](const std::vector<std::string>& some) {
    const RunResult run = Job(server, some);
    EXPECT_EQ(run.status, 3) << run.errors;
    EXPECT_TRUE(run.errors.starts_with("limn: ")) << run.errors;
    return run.errors;
  };
  EXPECT_NE(refused(Identity(authority_)).find("token"), std::string::npos) << "no token";
  std::vector<std::string> wrong = Identity(authority_);
  wrong.insert(wrong.end(), {"--token-file", files_.Write("wrong", "another-token-of-24-char")});
  EXPECT_NE(refused(wrong).find("token"), std::string::npos) << "wrong token";
  refused({"--tls-ca", files_.path("ca.pem"), "--token-file", files_.path("tokens")});
  std::vector<std::string> stranger = Identity(TestAuthority("stranger"));
  stranger.insert(stranger.end(), token.begin(), token.end());
  refused(stranger);
  refused({});
  // What strangers do fills nobody's log: one line for each job that got that far, and those of the
  // start.
  EXPECT_EQ(server.Log().find("andshake"), std::string::npos) << server.Log();
}

TEST_F(SecurityE2e, FlagsThatMakeNoSenseEndTheServerAtOnce) {
  const auto status = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> command = {LIMND_BINARY};
    command.insert(command.end(), flags.begin(), flags.end());
    Process server(command, space_.log("bad"));
    return server.Wait(20);
  };
  EXPECT_EQ(status({"--listen", "0.0.0.0:0"}), 2);
  EXPECT_EQ(status({"--listen", "127.0.0.1:0", "--metrics-listen", "0.0.0.0:0"}), 2);
  EXPECT_EQ(status({"--listen", "127.0.0.1:0", "--tls-cert", files_.path("server.pem")}), 2);
  EXPECT_EQ(status({"--listen", "127.0.0.1:0", "--token-file", files_.path("nowhere")}), 2);
}

TEST_F(SecurityE2e, TheClientsFlagsNeedAServer) {
  const RunResult run = space_.Limn(
      {"interpolate", space_.path("c.obj"), "-o", space_.path("s.obj"), "--tls-ca", "x"});
  EXPECT_EQ(run.status, 2) << run.errors;
}

}  // namespace
}  // namespace limn::e2e
