// SPDX-License-Identifier: MIT
// Calls whose one message never arrives whole, which no client library makes: HTTP/2 by hand.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <string>
#include <thread>

namespace limn::robustness {

// A connection of its own with so many calls of a method, each of which sends a message but for its
// last byte, as fast as the server's windows let it, and then waits. Not thread-safe.
class HalfCalls {
 public:
  // method: such as "/limn.v1.LimnService/GetServerInfo". message_bytes: what the message claims.
  HalfCalls(int port, const std::string& method, int calls, std::uint32_t message_bytes);
  ~HalfCalls();
  HalfCalls(const HalfCalls&) = delete;
  HalfCalls& operator=(const HalfCalls&) = delete;

  // Bytes of messages that were sent, of all calls.
  std::uint64_t sent() const { return sent_; }
  // Calls that have not been ended by the server.
  int open() const { return open_; }

 private:
  struct Call {
    std::int64_t window = 0;
    std::uint64_t sent = 0;
  };
  void Run();
  bool Receive();
  void Take(std::uint8_t type, std::uint8_t flags, std::uint32_t stream, const std::string& body);
  void Offer();

  const int fd_;
  const std::uint64_t message_bytes_;
  std::string prefix_;
  std::map<std::uint32_t, Call> calls_;
  std::int64_t window_;
  std::int64_t first_window_;
  std::string received_;
  std::string waiting_;
  std::atomic<std::uint64_t> sent_ = 0;
  std::atomic<int> open_ = 0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace limn::robustness
