// SPDX-License-Identifier: MIT
// The client library: errors that a caller can tell apart, cancel, and what it leaves behind.
#include "client/client.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "engine/base/error.h"
#include "engine/mesh/generate.h"
#include "server/server.h"

namespace limn {
namespace {

PolygonMesh MakeSphere(std::uint64_t vertices) {
  absl::StatusOr<PolygonMesh> mesh =
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices, .seed = 5});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

v1::InterpolateHeader MakeHeader() {
  v1::InterpolateHeader header;
  header.mutable_surface()->set_level(1);
  header.mutable_output()->set_surface(true);
  return header;
}

// Runs for minutes if nobody stops it.
v1::InterpolateHeader MakeEndlessHeader() {
  v1::InterpolateHeader header = MakeHeader();
  header.mutable_solve()->set_tolerance(0);
  header.mutable_solve()->set_max_sweeps(10'000);
  header.mutable_solve()->set_method(v1::SolveOptions::METHOD_GAUSS_SEIDEL);
  return header;
}

std::unique_ptr<Server> StartServer(const ServerOptions& options = {.threads = 2}) {
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  EXPECT_TRUE(server.ok()) << server.status();
  return *std::move(server);
}

Reason ReasonOf(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  EXPECT_TRUE(detail.has_value()) << "there is no error";
  return detail.has_value() ? detail->reason : Reason::kInternal;
}

TEST(ClientTest, AServerThatIsNotThereIsUnreachable) {
  std::string address;
  {
    const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 1});
    address = "127.0.0.1:" + std::to_string(server->port());
  }
  const Client client = Client::Connect(address);
  EXPECT_EQ(ReasonOf(client.GetServerInfo().status()), Reason::kUnreachable);
  EXPECT_EQ(ReasonOf(client.Run(MakeHeader(), MakeSphere(100)).status()), Reason::kUnreachable);
}

TEST(ClientTest, OptionsOutOfRangeAreRefused) {
  const std::unique_ptr<Server> server = StartServer();
  for (const ClientOptions& options :
       {ClientOptions{.chunk_bytes = 0}, ClientOptions{.chunk_bytes = (1 << 20) + 1},
        ClientOptions{.deadline_seconds = -1}}) {
    const Client client(server->InProcessChannel(), options);
    EXPECT_EQ(ReasonOf(client.Run(MakeHeader(), MakeSphere(100)).status()), Reason::kInvalidOption);
  }
}

TEST(ClientTest, AnErrorOfTheServerKeepsItsDetail) {
  const std::unique_ptr<Server> server = StartServer();
  v1::InterpolateHeader header = MakeHeader();
  header.mutable_surface()->set_chord_tolerance(0.1);
  header.set_scheme(v1::SCHEME_LOOP);
  // Large, so that the upload is still going on when the refusal comes.
  const absl::StatusOr<JobResult> result =
      Client(server->InProcessChannel()).Run(header, MakeSphere(100'000));
  const std::optional<ErrorDetail> detail = GetErrorDetail(result.status());
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, Reason::kUnimplemented);
  EXPECT_EQ(detail->field, "surface.chord_tolerance");
}

TEST(ClientTest, ProgressThatReturnsFalseCancels) {
  const std::unique_ptr<Server> server = StartServer();
  const auto start = std::chrono::steady_clock::now();
  const absl::StatusOr<JobResult> result =
      Client(server->InProcessChannel())
          .Run(MakeEndlessHeader(), MakeSphere(20'000), [](const v1::Progress&) { return false; });
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled) << result.status();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(ClientTest, CancelWorksFromAnotherThread) {
  const std::unique_ptr<Server> server = StartServer();
  absl::StatusOr<ClientJob> job =
      Client(server->InProcessChannel()).Submit(MakeEndlessHeader(), MakeSphere(20'000));
  ASSERT_TRUE(job.ok()) << job.status();
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    job->Cancel();
  });
  EXPECT_EQ(job->Finish().code(), absl::StatusCode::kCancelled);
  canceller.join();
  EXPECT_FALSE(job->Next().has_value());
  EXPECT_EQ(job->Finish().code(), absl::StatusCode::kCancelled);
}

TEST(ClientTest, ADeadlineEndsTheJob) {
  const std::unique_ptr<Server> server = StartServer();
  const Client client(server->InProcessChannel(), {.deadline_seconds = 0.5});
  EXPECT_EQ(ReasonOf(client.Run(MakeEndlessHeader(), MakeSphere(20'000)).status()),
            Reason::kDeadlineExceeded);
}

TEST(ClientTest, ADestroyedJobIsCancelledOnTheServer) {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_length = 0;
  const std::unique_ptr<Server> server = StartServer(options);
  const Client client(server->InProcessChannel());
  {
    absl::StatusOr<ClientJob> job = client.Submit(MakeEndlessHeader(), MakeSphere(20'000));
    ASSERT_TRUE(job.ok()) << job.status();
    ASSERT_TRUE(job->Next().has_value());
  }
  // The only place is free again.
  absl::StatusOr<JobResult> next = absl::UnknownError("not tried");
  for (int attempt = 0; attempt < 100 && !next.ok(); ++attempt) {
    next = client.Run(MakeHeader(), MakeSphere(100));
    if (!next.ok()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(next.ok()) << next.status();
}

TEST(ClientTest, JobsCanBeMoved) {
  const std::unique_ptr<Server> server = StartServer();
  const Client client(server->InProcessChannel());
  absl::StatusOr<ClientJob> first = client.Submit(MakeHeader(), MakeSphere(100));
  ASSERT_TRUE(first.ok());
  ClientJob moved = *std::move(first);
  absl::StatusOr<ClientJob> second = client.Submit(MakeHeader(), MakeSphere(200));
  ASSERT_TRUE(second.ok());
  moved = *std::move(second);
  bool summary = false;
  while (const std::optional<v1::InterpolateResponse> message = moved.Next()) {
    if (message->has_summary()) {
      summary = true;
      EXPECT_EQ(message->summary().input_vertices(), 200U);
    }
  }
  EXPECT_TRUE(summary);
  EXPECT_TRUE(moved.Finish().ok());
}

}  // namespace
}  // namespace limn
