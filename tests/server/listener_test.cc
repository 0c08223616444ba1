// SPDX-License-Identifier: MIT
// Connections have a number that they do not exceed.
#include "server/listener.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "tests/server/service_fixture.h"

namespace limn {
namespace {

// A connection that says nothing.
class Silent {
 public:
  explicit Silent(int port) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~Silent() { close(fd_); }
  Silent(const Silent&) = delete;
  Silent& operator=(const Silent&) = delete;

  // Whether the server has closed it, within some time. A server of HTTP/2 speaks first.
  bool Closed() const {
    pollfd waiting{.fd = fd_, .events = POLLIN, .revents = 0};
    char byte = 0;
    if (!connected_) return true;
    while (poll(&waiting, 1, 1000) > 0) {
      if (recv(fd_, &byte, 1, 0) <= 0) return true;
    }
    return false;
  }

 private:
  const int fd_;
  bool connected_ = false;
};

absl::Status Ask(int port) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const Client client(grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(port),
                                                grpc::InsecureChannelCredentials(), arguments),
                      {.deadline_seconds = 5});
  return client.GetServerInfo().status();
}

TEST(ListenerTest, TheConnectionAfterTheLastIsClosedAndRoomComesBack) {
  ServerOptions options{.listen = "127.0.0.1:0", .threads = 1};
  options.limits.max_connections = 4;
  const std::unique_ptr<Server> server = StartServer(options);
  std::vector<std::unique_ptr<Silent>> silent;
  for (int i = 0; i < 4; ++i) {
    silent.push_back(std::make_unique<Silent>(server->port()));
    EXPECT_FALSE(silent.back()->Closed()) << i;
  }
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(Silent(server->port()).Closed());
  EXPECT_FALSE(Ask(server->port()).ok());
  EXPECT_NE(server->MetricsText().find("limn_connections 4\n"), std::string::npos);
  silent.clear();
  absl::Status status;
  for (int attempt = 0; attempt < 50; ++attempt) {
    status = Ask(server->port());
    if (status.ok()) break;
    usleep(50'000);
  }
  EXPECT_TRUE(status.ok()) << status;
}

TEST(ListenerTest, RunningOutOfDescriptorsPasses) {
  ServerOptions options{.listen = "127.0.0.1:0", .threads = 1};
  const std::unique_ptr<Server> server = StartServer(options);
  ASSERT_TRUE(Ask(server->port()).ok());
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  {
    // Clients first: they need descriptors of this process too. The listener finds none.
    std::vector<std::unique_ptr<Silent>> silent;
    for (int i = 0; i < 20; ++i) silent.push_back(std::make_unique<Silent>(server->port()));
    usleep(300'000);
    const int next = dup(0);
    close(next);
    rlimit none = before;
    none.rlim_cur = static_cast<rlim_t>(next) + 1;
    const Silent last(server->port());
    none.rlim_cur = static_cast<rlim_t>(next) + 1;
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
    std::vector<int> rest;
    for (int fd = dup(0); fd >= 0; fd = dup(0)) rest.push_back(fd);
    usleep(300'000);
    for (const int fd : rest) close(fd);
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  }
  absl::Status status;
  for (int attempt = 0; attempt < 50; ++attempt) {
    status = Ask(server->port());
    if (status.ok()) break;
    usleep(50'000);
  }
  EXPECT_TRUE(status.ok()) << status;
}

TEST(ListenerTest, ATakenPortIsNamed) {
  const auto first = Listener::Bind("127.0.0.1:0", 1);
  ASSERT_TRUE(first.ok());
  const auto second = Listener::Bind("127.0.0.1:" + std::to_string((*first)->port()), 1);
  EXPECT_EQ(ReasonOf(second.status()), Reason::kUnreachable);
  EXPECT_EQ(GetErrorDetail(second.status())->field, "listen");
}

TEST(ListenerTest, ListensOnNamesAndOnIpv6) {
  for (const char* address : {"localhost:0", "[::1]:0"}) {
    const auto listener = Listener::Bind(address, 1);
    ASSERT_TRUE(listener.ok()) << address;
    EXPECT_GT((*listener)->port(), 0);
  }
}

}  // namespace
}  // namespace limn
