// SPDX-License-Identifier: MIT
#include "tests/robustness/harness.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "absl/strings/numbers.h"

namespace limn::robustness {
namespace {

bool Send(int fd, const std::string& bytes) {
  return send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

int PortBehind(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key);
  return at == std::string::npos ? 0 : std::atoi(text.c_str() + at + key.size());
}

}  // namespace

int Dial(int port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  close(fd);
  return -1;
}

Subject::Subject(const std::vector<std::string>& flags, const std::vector<std::string>& prefix,
                 const std::string& preload) {
  // A port that is free now, as the server's log may be what is broken.
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(probe, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("no port");
  }
  metrics_port_ = ntohs(address.sin_port);
  close(probe);
  std::vector<std::string> all = {"--metrics-listen", "127.0.0.1:" + std::to_string(metrics_port_)};
  all.insert(all.end(), flags.begin(), flags.end());
  server_ = std::make_unique<e2e::ServerProcess>(space_, all, e2e::Process::Errors::kFile, preload,
                                                 prefix);
}

int Subject::port() const { return PortBehind(address(), ":"); }

std::shared_ptr<grpc::Channel> Subject::Connect() const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(address(), grpc::InsecureChannelCredentials(), arguments);
}

absl::Status Subject::SmallJob() const {
  return Client(Connect(), {.deadline_seconds = 20}).Run(MakeHeader(1), MakeSphere(100)).status();
}

std::string Subject::Metrics() const {
  const int fd = Dial(metrics_port_);
  std::string text;
  if (fd < 0) return text;
  if (Send(fd, "GET /metrics HTTP/1.0\r\n\r\n")) {
    char buffer[16384];
    for (ssize_t got = 0; (got = read(fd, buffer, sizeof buffer)) > 0;) {
      text.append(buffer, static_cast<std::size_t>(got));
    }
  }
  close(fd);
  return text;
}

double Subject::Metric(const std::string& series) const {
  const std::string text = Metrics();
  const std::size_t at = text.find("\n" + series + " ");
  if (at == std::string::npos) return -1;
  const std::size_t begin = at + series.size() + 2;
  double value = -1;
  return absl::SimpleAtod(text.substr(begin, text.find('\n', begin) - begin), &value) ? value : -1;
}

bool Subject::WaitForMetric(const std::string& series, double value, double seconds) const {
  return e2e::WaitUntil(seconds, [&] { return Metric(series) == value; });
}

bool Subject::WaitUntilIdle(double seconds) const {
  return WaitForMetric("limn_open_streams", 0, seconds) &&
         WaitForMetric("limn_running_jobs{lane=\"batch\"}", 0, seconds) &&
         WaitForMetric("limn_running_jobs{lane=\"interactive\"}", 0, seconds) &&
         WaitForMetric("limn_reserved_bytes", 0, seconds) &&
         WaitForMetric("limn_inflight_bytes", 0, seconds);
}

BareConnection::BareConnection(int port, const std::string& bytes) : fd_(Dial(port)) {
  connected_ = fd_ >= 0 && (bytes.empty() || Send(fd_, bytes));
}

BareConnection::~BareConnection() {
  if (fd_ >= 0) close(fd_);
}

bool BareConnection::Closed(double seconds) const {
  if (fd_ < 0) return true;
  return e2e::WaitUntil(seconds, [&] {
    pollfd waiting{.fd = fd_, .events = POLLIN, .revents = 0};
    char buffer[4096];
    while (poll(&waiting, 1, 0) > 0) {
      if (recv(fd_, buffer, sizeof buffer, 0) <= 0) return true;
    }
    return false;
  });
}

bool Full() {
  const char* form = std::getenv("LIMN_ROBUSTNESS");
  return form != nullptr && std::string(form) == "full";
}

double Quantile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(
      std::min(last, part * static_cast<double>(values.size())))];
}

}  // namespace limn::robustness
