// SPDX-License-Identifier: MIT
// Deadlines as any client may say them, the longest ones of HTTP/2 included.
#include "server/deadline.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using std::chrono::steady_clock;

std::string BigEndian(std::size_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 0xff);
  return text;
}

// HTTP/2's types of frames and their flags.
enum FrameType { kData = 0, kHeaders = 1, kSettings = 4 };
constexpr int kEndStream = 1;
constexpr int kEndHeaders = 4;

std::string Frame(FrameType type, int flags, int stream, const std::string& payload) {
  return BigEndian(payload.size(), 3) + static_cast<char>(type) + static_cast<char>(flags) +
         BigEndian(static_cast<std::size_t>(stream), 4) + payload;
}

// HPACK, literal and not indexed.
std::string HeaderField(const std::string& name, const std::string& value) {
  return std::string(1, '\0') + static_cast<char>(name.size()) + name +
         static_cast<char>(value.size()) + value;
}

// One Interpolate call by bare HTTP/2, because gRPC's own clients cannot say every timeout. It
// stays open after a header without chunks.
class BareCall {
 public:
  BareCall(int port, const std::string& timeout, const std::vector<v1::InterpolateRequest>& upload)
      : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    std::string bytes = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Frame(kSettings, 0, 0, "");
    bytes += Frame(kHeaders, kEndHeaders, 1,
                   HeaderField(":method", "POST") + HeaderField(":scheme", "http") +
                       HeaderField(":path", "/limn.v1.LimnService/Interpolate") +
                       HeaderField(":authority", "test") + HeaderField("te", "trailers") +
                       HeaderField("content-type", "application/grpc") +
                       HeaderField("grpc-timeout", timeout));
    for (const v1::InterpolateRequest& request : upload) {
      const std::string message = request.SerializeAsString();
      bytes += Frame(kData, 0, 1, std::string(1, '\0') + BigEndian(message.size(), 4) + message);
    }
    if (upload.size() > 1) bytes += Frame(kData, kEndStream, 1, "");
    EXPECT_EQ(send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  ~BareCall() { close(socket_); }
  BareCall(const BareCall&) = delete;
  BareCall& operator=(const BareCall&) = delete;

 private:
  int socket_;
};

TEST(DeadlineTest, TheLongestTimeoutOfHttp2IsNotOver) {
  const EventLog events;
  const std::unique_ptr<Server> server =
      StartServer({.listen = "127.0.0.1:0", .threads = 1, .log = events.log()});
  // Eight digits are what gRPC over HTTP/2 allows.
  for (const std::string timeout : {"99999999H", "2562048H", "27000H", "10000S"}) {
    v1::InterpolateHeader header = MakeHeader(0);
    header.set_request_id("timeout-" + timeout);
    const BareCall call(server->port(), timeout, MakeUpload(header, MakeSphere(32)));
    const std::string line = events.WaitFor("request_id=timeout-" + timeout);
    EXPECT_NE(line.find(" code=OK "), std::string::npos) << line;
  }
}

TEST(DeadlineTest, AShortTimeoutIsHeld) {
  const EventLog events;
  const std::unique_ptr<Server> server =
      StartServer({.listen = "127.0.0.1:0", .threads = 1, .log = events.log()});
  v1::InterpolateHeader header = MakeHeader(0);
  header.set_request_id("short");
  std::vector<v1::InterpolateRequest> upload = MakeUpload(header, MakeSphere(32));
  upload.resize(1);
  const BareCall call(server->port(), "400m", upload);
  const std::string line = events.WaitFor("request_id=short");
  EXPECT_NE(line.find("reason=DEADLINE_EXCEEDED"), std::string::npos) << line;
}

gpr_timespec FromNow(std::int64_t seconds) {
  return gpr_time_add(gpr_now(GPR_CLOCK_REALTIME), gpr_time_from_seconds(seconds, GPR_TIMESPAN));
}

TEST(DeadlineTest, ACenturyAndMoreIsNone) {
  constexpr std::int64_t kYear = 366 * 86'400;
  EXPECT_EQ(DeadlineOf(gpr_inf_future(GPR_CLOCK_REALTIME)), std::nullopt);
  EXPECT_EQ(DeadlineOf(gpr_inf_future(GPR_CLOCK_MONOTONIC)), std::nullopt);
  for (const std::int64_t years : {101, 300, 10'000, 1'000'000'000}) {
    EXPECT_EQ(DeadlineOf(FromNow(years * kYear)), std::nullopt) << years;
  }
}

TEST(DeadlineTest, OtherDeadlinesAreMovedToTheSteadyClock) {
  constexpr std::int64_t kYear = 366 * 86'400;
  for (const std::int64_t seconds : {-10 * kYear, std::int64_t{-5}, std::int64_t{0},
                                     std::int64_t{60}, std::int64_t{99} * kYear}) {
    const auto before = steady_clock::now();
    const auto deadline = DeadlineOf(FromNow(seconds));
    ASSERT_TRUE(deadline.has_value()) << seconds;
    EXPECT_GE(*deadline, before + std::chrono::seconds(seconds - 1));
    EXPECT_LE(*deadline, steady_clock::now() + std::chrono::seconds(seconds + 1));
  }
  EXPECT_LT(DeadlineOf(gpr_inf_past(GPR_CLOCK_REALTIME)), steady_clock::now());
}

}  // namespace
}  // namespace limn
