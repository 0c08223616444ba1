// SPDX-License-Identifier: MIT
#include "server/listener.h"

#include <dirent.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/address.h"

namespace limn {
namespace {

constexpr int kBacklog = 512;
constexpr int kPollMilliseconds = 100;
// After a failure that time may cure, such as having no descriptors left.
constexpr std::chrono::milliseconds kPause(50);

void SetOption(int fd, int level, int name, int value) {
  (void)setsockopt(fd, level, name, &value, sizeof value);
}

// The port of a socket's own address; nothing for what is no internet socket.
std::optional<int> PortOf(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return std::nullopt;
  if (address.ss_family == AF_INET) return ntohs(reinterpret_cast<sockaddr_in&>(address).sin_port);
  if (address.ss_family == AF_INET6) {
    return ntohs(reinterpret_cast<sockaddr_in6&>(address).sin6_port);
  }
  return std::nullopt;
}

int BindTo(const addrinfo& address) {
  const int fd = socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  // So that a restart need not wait for connections that linger; two servers on one port are still
  // refused.
  SetOption(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  if (bind(fd, address.ai_addr, address.ai_addrlen) == 0 && listen(fd, kBacklog) == 0) return fd;
  close(fd);
  return -1;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Listener>> Listener::Bind(const std::string& address,
                                                         std::uint64_t max_connections) {
  const std::optional<wire::HostPort> parsed = wire::ParseHostPort(address);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  int fd = -1;
  if (parsed.has_value() &&
      getaddrinfo(parsed->host.c_str(), absl::StrCat(parsed->port).c_str(), &hints, &found) == 0) {
    for (const addrinfo* at = found; at != nullptr && fd < 0; at = at->ai_next) fd = BindTo(*at);
    freeaddrinfo(found);
  }
  if (fd < 0) {
    return MakeError(absl::StrCat("cannot listen on ", address),
                     {.reason = Reason::kUnreachable,
                      .field = "listen",
                      .remedy = "Is the port taken? Port 0 picks a free one"});
  }
  return std::unique_ptr<Listener>(new Listener(fd, PortOf(fd).value_or(0), max_connections));
}

Listener::~Listener() {
  Stop();
  close(fd_);
}

void Listener::Start(std::function<void(int listener, int fd)> take) {
  take_ = std::move(take);
  thread_ = std::thread([this] { Run(); });
}

void Listener::Stop() {
  stopping_.store(true);
  if (thread_.joinable()) thread_.join();
}

void Listener::Run() {
  while (!stopping_.load()) {
    pollfd waiting{.fd = fd_, .events = POLLIN, .revents = 0};
    if (poll(&waiting, 1, kPollMilliseconds) <= 0) continue;
    const int fd = accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) {
      if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) {
        std::this_thread::sleep_for(kPause);
      }
      continue;
    }
    if (!HasRoom()) {
      ++refused_;
      close(fd);
      continue;
    }
    ++at_most_;
    SetOption(fd, IPPROTO_TCP, TCP_NODELAY, 1);
    take_(fd_, fd);
  }
}

// gRPC does not say when a connection ends, so they are counted, but only when there may be too
// many.
bool Listener::HasRoom() {
  if (at_most_ < max_connections_) return true;
  // Without the one that asks.
  const std::uint64_t open = Connections();
  at_most_ = open > 0 ? open - 1 : 0;
  return at_most_ < max_connections_;
}

std::uint64_t Listener::Connections() const {
  DIR* const directory = opendir("/proc/self/fd");
  if (directory == nullptr) return 0;
  std::uint64_t count = 0;
  while (const dirent* entry = readdir(directory)) {
    const int fd = std::atoi(entry->d_name);
    if (fd <= 2 || fd == fd_) continue;
    if (PortOf(fd) == port_) ++count;
  }
  closedir(directory);
  return count;
}

}  // namespace limn
