// SPDX-License-Identifier: MIT
// See half_calls.h. Frames after RFC 7540, section 6; headers as literals, RFC 7541, section 6.2.2.
#include "tests/robustness/half_calls.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "tests/robustness/harness.h"

namespace limn::robustness {
namespace {

constexpr std::uint8_t kData = 0;
constexpr std::uint8_t kHeaders = 1;
constexpr std::uint8_t kReset = 3;
constexpr std::uint8_t kSettings = 4;
constexpr std::uint8_t kPing = 6;
constexpr std::uint8_t kWindowUpdate = 8;
constexpr std::uint8_t kAcknowledge = 1;
constexpr std::uint8_t kEndStream = 1;
constexpr std::uint8_t kEndHeaders = 4;
constexpr std::int64_t kDefaultWindow = 65535;
constexpr std::int64_t kMostInFrame = 16384;
constexpr std::size_t kFrameHeader = 9;

std::string BigEndian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i));
  return text;
}

std::uint32_t Number(const std::string& bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8 | static_cast<std::uint8_t>(bytes.at(at + i));
  }
  return value;
}

std::string Frame(std::uint8_t type, std::uint8_t flags, std::uint32_t stream,
                  const std::string& body) {
  return BigEndian(static_cast<std::uint32_t>(body.size()), 3) + static_cast<char>(type) +
         static_cast<char>(flags) + BigEndian(stream, 4) + body;
}

std::string Headers(const std::string& method) {
  std::string block;
  for (const auto& [name, value] : std::initializer_list<std::pair<std::string, std::string>>{
           {":method", "POST"},
           {":scheme", "http"},
           {":path", method},
           {":authority", "limn"},
           {"te", "trailers"},
           {"content-type", "application/grpc"}}) {
    block += '\0';
    block += static_cast<char>(name.size()) + name;
    block += static_cast<char>(value.size()) + value;
  }
  return block;
}

}  // namespace

HalfCalls::HalfCalls(int port, const std::string& method, int calls, std::uint32_t message_bytes)
    : fd_(Dial(port)),
      message_bytes_(message_bytes),
      prefix_('\0' + BigEndian(message_bytes, 4)),
      window_(kDefaultWindow),
      first_window_(kDefaultWindow) {
  waiting_ = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Frame(kSettings, 0, 0, "");
  for (int i = 0; i < calls; ++i) {
    const auto stream = static_cast<std::uint32_t>(2 * i + 1);
    waiting_ += Frame(kHeaders, kEndHeaders, stream, Headers(method));
    calls_[stream].window = kDefaultWindow;
  }
  open_ = calls;
  thread_ = std::thread([this] { Run(); });
}

HalfCalls::~HalfCalls() {
  stop_ = true;
  thread_.join();
  if (fd_ >= 0) close(fd_);
}

void HalfCalls::Run() {
  while (!stop_ && fd_ >= 0) {
    pollfd waiting{.fd = fd_, .events = POLLIN, .revents = 0};
    if (!waiting_.empty()) waiting.events |= POLLOUT;
    (void)poll(&waiting, 1, 50);
    if ((waiting.revents & (POLLIN | POLLHUP | POLLERR)) != 0 && !Receive()) break;
    Offer();
    const ssize_t sent = send(fd_, waiting_.data(), waiting_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) waiting_.erase(0, static_cast<std::size_t>(sent));
  }
  open_ = 0;
}

bool HalfCalls::Receive() {
  char buffer[65536];
  const ssize_t got = recv(fd_, buffer, sizeof buffer, MSG_DONTWAIT);
  if (got == 0) return false;
  if (got > 0) received_.append(buffer, static_cast<std::size_t>(got));
  while (received_.size() >= kFrameHeader) {
    const std::size_t size = Number(received_, 0, 3);
    if (received_.size() < kFrameHeader + size) break;
    Take(static_cast<std::uint8_t>(received_[3]), static_cast<std::uint8_t>(received_[4]),
         Number(received_, 5, 4), received_.substr(kFrameHeader, size));
    received_.erase(0, kFrameHeader + size);
  }
  return true;
}

void HalfCalls::Take(std::uint8_t type, std::uint8_t flags, std::uint32_t stream,
                     const std::string& body) {
  if (type == kSettings && (flags & kAcknowledge) == 0) {
    for (std::size_t at = 0; at + 6 <= body.size(); at += 6) {
      constexpr std::uint32_t kInitialWindow = 4;
      if (Number(body, at, 2) != kInitialWindow) continue;
      const std::int64_t first = Number(body, at + 2, 4);
      for (auto& [id, call] : calls_) call.window += first - first_window_;
      first_window_ = first;
    }
    waiting_ += Frame(kSettings, kAcknowledge, 0, "");
  } else if (type == kPing && (flags & kAcknowledge) == 0) {
    waiting_ += Frame(kPing, kAcknowledge, 0, body);
  } else if (type == kWindowUpdate) {
    if (stream == 0) window_ += Number(body, 0, 4);
    if (const auto at = calls_.find(stream); at != calls_.end()) {
      at->second.window += Number(body, 0, 4);
    }
  } else if (type == kReset || (type == kHeaders && (flags & kEndStream) != 0)) {
    calls_.erase(stream);
    open_ = static_cast<int>(calls_.size());
  }
}

// What the windows allow, up to what is sent at a time.
void HalfCalls::Offer() {
  constexpr std::size_t kMostWaiting = 100'000;
  for (auto& [stream, call] : calls_) {
    while (waiting_.size() < kMostWaiting) {
      const auto left = static_cast<std::int64_t>(prefix_.size() + message_bytes_ - 1 - call.sent);
      const std::int64_t size = std::min({left, call.window, window_, kMostInFrame});
      if (size <= 0) break;
      std::string body(static_cast<std::size_t>(size), '\0');
      if (call.sent == 0) body.replace(0, prefix_.size(), prefix_);
      waiting_ += Frame(kData, 0, stream, body);
      call.sent += body.size();
      call.window -= size;
      window_ -= size;
      sent_ += body.size();
    }
  }
}

}  // namespace limn::robustness
