// SPDX-License-Identifier: MIT
// Several servers without a proxy: calls take turns, and go around servers that drain or are gone.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "client/client.h"
#include "engine/base/error.h"
#include "engine/mesh/generate.h"
#include "server/log.h"
#include "server/server.h"
#include "tests/server/certificates.h"

namespace limn {
namespace {

// A server on a loopback port, with a count of the jobs that it was asked for and that went well.
class CountedServer {
 public:
  explicit CountedServer(ServerOptions options = {}, int port = 0) {
    options.listen = "127.0.0.1:" + std::to_string(port);
    options.threads = 1;
    options.log = Log::ToFunction([this](std::string_view line) {
      if (line.find("event=job ") == std::string_view::npos) return;
      if (line.find(" code=OK ") != std::string_view::npos) ++done_;
    });
    absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
    EXPECT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  ~CountedServer() { server_->Shutdown(std::chrono::milliseconds(0)); }

  std::string address() const { return "127.0.0.1:" + std::to_string(server_->port()); }
  int done() const { return done_.load(); }
  Server& server() { return *server_; }

 private:
  std::atomic<int> done_ = 0;
  std::unique_ptr<Server> server_;
};

class BalancingTest : public testing::Test {
 protected:
  void StartServers(int count, const ServerOptions& options = {}) {
    for (int i = 0; i < count; ++i) servers_.push_back(std::make_unique<CountedServer>(options));
  }
  std::string Addresses() const {
    std::string list;
    for (const auto& server : servers_) list += (list.empty() ? "" : ",") + server->address();
    return list;
  }
  // So many jobs, each of which has to go well.
  void RunJobs(const Client& client, int count) {
    for (int i = 0; i < count; ++i) {
      const absl::StatusOr<JobResult> result = client.Run(header_, mesh_);
      ASSERT_TRUE(result.ok()) << result.status();
      ++run_;
    }
  }
  // Until the client has found all of them.
  void RunUntilAllHaveWorked(const Client& client) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    for (const auto& server : servers_) {
      while (server->done() == 0) {
        ASSERT_LT(std::chrono::steady_clock::now(), until) << server->address();
        RunJobs(client, 1);
      }
    }
  }
  // Jobs by server. A server counts a job a moment after the client has its answer.
  std::vector<int> Counts() const {
    std::vector<int> counts;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    do {
      counts.clear();
      for (const auto& server : servers_) counts.push_back(server->done());
    } while (std::accumulate(counts.begin(), counts.end(), 0) < run_ &&
             std::chrono::steady_clock::now() < until);
    return counts;
  }

  v1::InterpolateHeader header_ = [] {
    v1::InterpolateHeader header;
    header.mutable_output()->set_control_mesh(true);
    return header;
  }();
  int run_ = 0;
  PolygonMesh mesh_ = *GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 200});
  std::vector<std::unique_ptr<CountedServer>> servers_;
};

TEST_F(BalancingTest, ServersTakeTurns) {
  StartServers(3);
  const Client client = Client::Connect(Addresses());
  RunUntilAllHaveWorked(client);
  const std::vector<int> before = Counts();
  RunJobs(client, 30);
  const std::vector<int> after = Counts();
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i] - before[i], 10) << i;
}

TEST_F(BalancingTest, ADrainingServerGetsNoMoreJobsAndNoneIsLost) {
  StartServers(3);
  const Client client = Client::Connect(Addresses());
  RunUntilAllHaveWorked(client);
  servers_[1]->server().Drain();
  // What it refuses before its health has arrived is tried again elsewhere.
  const std::vector<int> before = Counts();
  RunJobs(client, 30);
  const std::vector<int> after = Counts();
  EXPECT_EQ(after[1], before[1]);
  EXPECT_EQ(after[0] + after[2] - before[0] - before[2], 30);
}

TEST_F(BalancingTest, AServerThatIsGoneIsGoneAroundAndFoundAgain) {
  StartServers(2);
  const Client client = Client::Connect(Addresses());
  RunUntilAllHaveWorked(client);
  const int port = servers_[1]->server().port();
  servers_.pop_back();
  RunJobs(client, 20);
  servers_.push_back(std::make_unique<CountedServer>(ServerOptions{}, port));
  RunUntilAllHaveWorked(client);
}

TEST_F(BalancingTest, ManyThreadsLoseNothingWhenAServerStops) {
  StartServers(3);
  const Client client = Client::Connect(Addresses());
  RunUntilAllHaveWorked(client);
  std::vector<std::thread> threads;
  std::atomic<int> lost = 0;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int job = 0; job < 25; ++job) lost += client.Run(header_, mesh_).ok() ? 0 : 1;
    });
  }
  servers_[0]->server().Shutdown(std::chrono::milliseconds(0));
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(lost.load(), 0);
}

TEST_F(BalancingTest, OneAttemptIsOneAttempt) {
  StartServers(1);
  const Client once = Client::Connect(Addresses(), {.attempts = 1});
  RunJobs(once, 1);
  servers_[0]->server().Drain();
  EXPECT_EQ(once.Run(header_, mesh_).status().code(), absl::StatusCode::kUnavailable);
}

TEST_F(BalancingTest, EvaluationsTakeTurnsToo) {
  StartServers(2);
  const Client client = Client::Connect(Addresses());
  RunUntilAllHaveWorked(client);
  servers_[0]->server().Drain();
  for (int i = 0; i < 10; ++i) {
    const absl::StatusOr<EvaluateResult> result =
        client.Evaluate({}, mesh_, {{.face = 0, .corner = 0, .u = 0.5, .v = 0.5}});
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->points.size(), 1U);
  }
}

// All certificates are for the first host.
TEST_F(BalancingTest, AListSpeaksTlsToo) {
  const TestDirectory files;
  const TestAuthority authority("authority");
  const TestIdentity identity = authority.Issue("limnd");
  StartServers(2, {.tls = {.certificate = files.Write("server.pem", identity.certificate),
                           .key = files.Write("server.key", identity.key)}});
  const ClientSecurity security = {.ca_file = files.Write("ca.pem", authority.certificate())};
  const absl::StatusOr<Client> client = Client::ConnectSecurely(Addresses(), security);
  ASSERT_TRUE(client.ok()) << client.status();
  RunUntilAllHaveWorked(*client);
}

TEST_F(BalancingTest, TheCertificatesNameMayBeGiven) {
  const TestDirectory files;
  const TestAuthority authority("authority");
  const TestIdentity identity = authority.Issue("limnd");
  StartServers(1, {.tls = {.certificate = files.Write("server.pem", identity.certificate),
                           .key = files.Write("server.key", identity.key)}});
  ClientSecurity security = {.ca_file = files.Write("ca.pem", authority.certificate())};
  security.server_name = "localhost";
  EXPECT_TRUE(*Client::ConnectSecurely(Addresses(), security)->Serves(""));
  security.server_name = "elsewhere.example";
  EXPECT_EQ(Client::ConnectSecurely(Addresses(), security)->Serves("").status().code(),
            absl::StatusCode::kUnavailable);
}

TEST_F(BalancingTest, ATokenIsForALocalListOnly) {
  const TestDirectory files;
  const ClientSecurity security = {.token_file = files.Write("token", "twenty-four-characters-x")};
  EXPECT_TRUE(Client::ConnectSecurely("127.0.0.1:1,127.0.0.2:2", security).ok());
  EXPECT_FALSE(Client::ConnectSecurely("127.0.0.1:1,10.0.0.2:2", security).ok());
}

TEST_F(BalancingTest, HealthIsTold) {
  StartServers(1);
  const Client client = Client::Connect(Addresses());
  EXPECT_TRUE(*client.Serves(""));
  EXPECT_TRUE(*client.Serves("limn.v1.LimnService"));
  EXPECT_TRUE(*client.Serves("liveness"));
  EXPECT_EQ(client.Serves("another").status().code(), absl::StatusCode::kNotFound);
  EXPECT_FALSE(client.Serves(std::string(128, 'x')).ok());
  servers_[0]->server().Drain();
  EXPECT_FALSE(*client.Serves(""));
  EXPECT_TRUE(*client.Serves("liveness"));
}

}  // namespace
}  // namespace limn
