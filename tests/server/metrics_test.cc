// SPDX-License-Identifier: MIT
// What an operator sees.
#include "server/metrics.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

// The value of a series, written as in the text format; -1 when it is not there.
double ValueOf(const std::string& text, const std::string& series) {
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    double value = 0;
    if (line.substr(0, series.size()) == series && line.size() > series.size() &&
        line[series.size()] == ' ' && absl::SimpleAtod(line.substr(series.size() + 1), &value)) {
      return value;
    }
  }
  return -1;
}

// Until it has the value, for what happens a moment after an answer.
double Await(const Server& server, const std::string& series, double expected) {
  double value = -1;
  for (int attempt = 0; attempt < 200; ++attempt) {
    value = ValueOf(server.MetricsText(), series);
    if (value == expected) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  return value;
}

std::string HttpGet(int port, const std::string& path) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
    const std::string request = "GET " + path + " HTTP/1.0\r\n\r\n";
    EXPECT_EQ(write(fd, request.data(), request.size()), static_cast<ssize_t>(request.size()));
    char buffer[4096];
    for (ssize_t got = 0; (got = read(fd, buffer, sizeof buffer)) > 0;) {
      answer.append(buffer, static_cast<std::size_t>(got));
    }
  }
  close(fd);
  return answer;
}

TEST(MetricsTest, EveryNameOfTheDesignIsThere) {
  ServerOptions options{.threads = 1};
  options.limits.max_vertices = 1000;
  const std::unique_ptr<Server> server = StartServer(options);
  const Client client(server->InProcessChannel());
  ASSERT_TRUE(client.Run(MakeHeader(1), MakeSphere(100)).ok());
  EXPECT_FALSE(client.Run(MakeHeader(1), MakeSphere(2000)).ok());
  std::vector<v1::InterpolateRequest> broken = MakeUpload(MakeHeader(1), MakeSphere(100));
  {
    // Arities that do not fit the corners.
    v1::MeshHeader& mesh = *broken[0].mutable_header()->mutable_mesh();
    mesh.set_face_count(mesh.face_count() + 1);
    mesh.set_corner_count(mesh.corner_count() - 1);
    RawCall call(server->InProcessChannel());
    call.Write(broken);
    EXPECT_FALSE(call.Finish().ok());
  }
  Await(*server, "limn_open_streams", 0);
  const std::string text = server->MetricsText();
  for (const char* series :
       {"limn_requests_total{code=\"OK\",method=\"Interpolate\",reason=\"\"} 1\n",
        "limn_requests_total{code=\"RESOURCE_EXHAUSTED\",method=\"Interpolate\",reason=\"LIMIT_"
        "EXCEEDED\"} 1\n",
        "limn_admission_rejects_total{limit=\"max-vertices\"} 1\n",
        "limn_decode_rejects_total{reason=\"MALFORMED_ENCODING\"} 1\n",
        "limn_queue_depth{lane=\"interactive\"} 0\n",
        "limn_queue_depth{lane=\"batch\"} 0\n",
        "limn_queue_wait_seconds_count{lane=\"interactive\"}",
        "limn_stage_duration_seconds_count{stage=\"solve\"} 1\n",
        "limn_stage_duration_seconds_count{stage=\"encode\"} 1\n",
        "limn_first_tile_seconds_count 1\n",
        "limn_inflight_bytes 0\n",
        "limn_stream_stall_seconds_total",
        "limn_cancel_to_stop_seconds_count 0\n",
        "limn_draining 0\n",
        "limn_live 1\n",
        "limn_running_jobs{lane=\"batch\"} 0\n",
        "limn_stuck_jobs{lane=\"batch\"} 0\n",
        "limn_reserved_bytes 0\n",
        "process_resident_memory_bytes",
        "process_open_fds"}) {
    EXPECT_NE(text.find(series), std::string::npos) << series << "\n" << text;
  }
  server->Drain();
  EXPECT_EQ(ValueOf(server->MetricsText(), "limn_draining"), 1);
}

TEST(MetricsTest, AreServedOnAPortOfTheirOwn) {
  ServerOptions options{.listen = "127.0.0.1:0", .metrics_listen = "127.0.0.1:0", .threads = 1};
  const std::unique_ptr<Server> server = StartServer(options);
  ASSERT_NE(server->metrics_port(), 0);
  ASSERT_NE(server->metrics_port(), server->port());
  const std::string answer = HttpGet(server->metrics_port(), "/metrics");
  EXPECT_NE(answer.find("200 OK"), std::string::npos) << answer;
  EXPECT_NE(answer.find("limn_draining 0"), std::string::npos) << answer;
  EXPECT_EQ(HttpGet(server->metrics_port(), "/etc/passwd").find("200 OK"), std::string::npos);
}

TEST(MetricsTest, AreNotServedToOtherMachinesUnlessTold) {
  ServerOptions options{.metrics_listen = "0.0.0.0:0", .threads = 1};
  const absl::Status status = Server::Start(options).status();
  EXPECT_EQ(ReasonOf(status), Reason::kInvalidOption);
  EXPECT_EQ(GetErrorDetail(status)->field, "metrics-listen");
  options.insecure = true;
  EXPECT_TRUE(Server::Start(options).ok());
}

TEST(MetricsTest, ATakenPortIsNamed) {
  const std::unique_ptr<Server> server =
      StartServer({.metrics_listen = "127.0.0.1:0", .threads = 1});
  const ServerOptions again{.metrics_listen = "127.0.0.1:" + std::to_string(server->metrics_port()),
                            .threads = 1};
  EXPECT_EQ(ReasonOf(Server::Start(again).status()), Reason::kUnreachable);
}

TEST(MetricsTest, WhatWaitsAndRunsIsCountedByLane) {
  ServerOptions options{.threads = 1};
  options.limits.workers = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  const std::vector<v1::InterpolateRequest> upload =
      MakeUpload(MakeEndlessHeader(), MakeSphere(20'000));
  std::vector<std::unique_ptr<RawCall>> calls;
  for (int i = 0; i < 3; ++i) {
    calls.push_back(std::make_unique<RawCall>(server->InProcessChannel()));
    ASSERT_TRUE(calls.back()->Write(upload));
    // The first one runs, whichever upload is complete first.
    ASSERT_EQ(Await(*server, "limn_running_jobs{lane=\"batch\"}", 1), 1);
  }
  EXPECT_EQ(Await(*server, "limn_queue_depth{lane=\"batch\"}", 2), 2);
  EXPECT_GT(ValueOf(server->MetricsText(), "limn_queue_cost_seconds{lane=\"batch\"}"), 1);
  EXPECT_GT(ValueOf(server->MetricsText(), "limn_reserved_bytes"), 1e6);
  // Those that wait first: else one of them might start before its own cancel comes.
  for (const std::size_t i : {2, 1}) calls[i]->Cancel();
  EXPECT_EQ(Await(*server, "limn_queue_depth{lane=\"batch\"}", 0), 0);
  calls[0]->Cancel();
  EXPECT_EQ(Await(*server, "limn_running_jobs{lane=\"batch\"}", 0), 0);
  EXPECT_EQ(Await(*server, "limn_queue_depth{lane=\"batch\"}", 0), 0);
  EXPECT_EQ(Await(*server, "limn_cancel_to_stop_seconds_count", 1), 1);
  calls.clear();
  EXPECT_EQ(Await(*server, "limn_reserved_bytes", 0), 0);
}

TEST(MetricsTest, AReaderThatStandsStillShows) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall slow(server->InProcessChannel());
  ASSERT_TRUE(slow.Write(MakeUpload(MakeHeader(4), MakeSphere(2000))));
  for (int attempt = 0; attempt < 1000; ++attempt) {
    if (ValueOf(server->MetricsText(), "limn_inflight_bytes") > 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  const double inflight = ValueOf(server->MetricsText(), "limn_inflight_bytes");
  EXPECT_GT(inflight, 0);
  // Three messages of half a MiB and a little more.
  EXPECT_LT(inflight, 3 << 20);
  EXPECT_TRUE(slow.Finish().ok());
  EXPECT_EQ(Await(*server, "limn_inflight_bytes", 0), 0);
  EXPECT_GT(ValueOf(server->MetricsText(), "limn_stream_stall_seconds_total"), 0.5);
}

}  // namespace
}  // namespace limn
