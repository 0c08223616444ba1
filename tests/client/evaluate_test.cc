// SPDX-License-Identifier: MIT
// Evaluation by the client library: what comes back, errors that a caller can tell apart, cancel.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "client/client.h"
#include "engine/base/error.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "server/server.h"

namespace limn {
namespace {

class ClientEvaluateTest : public testing::Test {
 protected:
  ClientEvaluateTest() : mesh_(Sphere(300)) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> coordinate(0, 1);
    for (int i = 0; i < 100'000; ++i) {
      const auto face = static_cast<Index>(random() % mesh_.face_count());
      const auto corner = static_cast<Index>(random() % mesh_.face(face).size());
      const double u = coordinate(random);
      parameters_.push_back({face, corner, u, coordinate(random)});
    }
  }

  static PolygonMesh Sphere(std::uint64_t vertices) {
    absl::StatusOr<PolygonMesh> mesh =
        GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices, .seed = 5});
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    return *std::move(mesh);
  }
  static std::unique_ptr<Server> Start(const ServerOptions& options = {.threads = 2}) {
    absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
    EXPECT_TRUE(server.ok()) << server.status();
    return *std::move(server);
  }
  // Runs for minutes if nobody stops it.
  static v1::InterpolateHeader Endless() {
    v1::InterpolateHeader header;
    header.mutable_solve()->set_tolerance(0);
    header.mutable_solve()->set_max_sweeps(10'000);
    header.mutable_solve()->set_method(v1::SolveOptions::METHOD_GAUSS_SEIDEL);
    return header;
  }
  static Reason ReasonOf(const absl::Status& status) {
    const std::optional<ErrorDetail> detail = GetErrorDetail(status);
    EXPECT_TRUE(detail.has_value()) << "there is no error";
    return detail.has_value() ? detail->reason : Reason::kInternal;
  }

  const PolygonMesh mesh_;
  std::vector<SurfaceParameter> parameters_;
};

TEST_F(ClientEvaluateTest, GivesTheEnginesSamplesToTheBit) {
  const std::unique_ptr<Server> server = Start();
  const absl::StatusOr<EvaluateResult> result =
      Client(server->InProcessChannel()).Evaluate({}, mesh_, parameters_);
  ASSERT_TRUE(result.ok()) << result.status();
  const auto surface =
      Interpolate(Context(), mesh_, {.surface = false, .keep_patches = true})->patches;
  const std::size_t n = parameters_.size();
  std::vector<Vec3> points(n);
  std::vector<Vec3> du(n);
  std::vector<Vec3> dv(n);
  std::vector<Vec3> normals(n);
  ASSERT_TRUE(EvaluateSurface(Context(), *surface, parameters_,
                              {.points = absl::MakeSpan(points),
                               .du = absl::MakeSpan(du),
                               .dv = absl::MakeSpan(dv),
                               .normals = absl::MakeSpan(normals)})
                  .ok());
  EXPECT_EQ(result->points, points);
  EXPECT_EQ(result->du, du);
  EXPECT_EQ(result->dv, dv);
  EXPECT_EQ(result->normals, normals);
  EXPECT_EQ(result->summary.input_vertices(), 300U);
  EXPECT_TRUE(result->summary.solve().converged());
}

TEST_F(ClientEvaluateTest, EveryLosslessEncodingGivesTheSame) {
  const std::unique_ptr<Server> server = Start();
  const Client client(server->InProcessChannel());
  parameters_.resize(1'000);
  v1::InterpolateHeader header;
  header.mutable_mesh()->set_encoding(v1::MESH_ENCODING_DRACO);
  const absl::StatusOr<EvaluateResult> packed = client.Evaluate({}, mesh_, parameters_);
  const absl::StatusOr<EvaluateResult> draco = client.Evaluate(header, mesh_, parameters_);
  ASSERT_TRUE(packed.ok() && draco.ok()) << packed.status() << draco.status();
  EXPECT_EQ(packed->points, draco->points);
  EXPECT_EQ(packed->normals, draco->normals);
}

TEST_F(ClientEvaluateTest, NoParametersGiveTheSummary) {
  const std::unique_ptr<Server> server = Start();
  const absl::StatusOr<EvaluateResult> result =
      Client(server->InProcessChannel()).Evaluate({}, mesh_, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->points.empty());
  EXPECT_EQ(result->summary.input_vertices(), 300U);
}

TEST_F(ClientEvaluateTest, AWrongParameterIsNamedByItsNumber) {
  const std::unique_ptr<Server> server = Start();
  parameters_[77'777].u = -1;
  const absl::Status status =
      Client(server->InProcessChannel()).Evaluate({}, mesh_, parameters_).status();
  EXPECT_EQ(ReasonOf(status), Reason::kInvalidOption);
  EXPECT_EQ(GetErrorDetail(status)->field, "parameters[77777].u");
  EXPECT_EQ(GetErrorDetail(status)->index, 77'777U);
}

TEST_F(ClientEvaluateTest, ErrorsOfTheJobKeepTheirDetail) {
  const std::unique_ptr<Server> server = Start();
  const Client client(server->InProcessChannel());
  v1::InterpolateHeader header;
  header.set_scheme(v1::SCHEME_LOOP);
  const absl::Status loop = client.Evaluate(header, mesh_, parameters_).status();
  EXPECT_EQ(GetErrorDetail(loop)->field, "mesh.faces") << loop;
  header.Clear();
  header.mutable_output()->set_surface(true);
  EXPECT_EQ(ReasonOf(client.Evaluate(header, mesh_, parameters_).status()), Reason::kInvalidOption);
}

TEST_F(ClientEvaluateTest, AServerThatIsNotThereIsUnreachable) {
  std::string address;
  {
    const std::unique_ptr<Server> server = Start({.listen = "127.0.0.1:0", .threads = 1});
    address = "127.0.0.1:" + std::to_string(server->port());
  }
  EXPECT_EQ(ReasonOf(Client::Connect(address).Evaluate({}, mesh_, parameters_).status()),
            Reason::kUnreachable);
}

TEST_F(ClientEvaluateTest, OptionsOutOfRangeAreRefused) {
  const std::unique_ptr<Server> server = Start();
  const Client client(server->InProcessChannel(), {.chunk_bytes = 0});
  EXPECT_EQ(ReasonOf(client.Evaluate({}, mesh_, {}).status()), Reason::kInvalidOption);
}

TEST_F(ClientEvaluateTest, FalseFromTheProgressCallbackCancels) {
  const std::unique_ptr<Server> server = Start();
  const auto start = std::chrono::steady_clock::now();
  const absl::StatusOr<EvaluateResult> result =
      Client(server->InProcessChannel())
          .Evaluate(Endless(), Sphere(20'000), parameters_,
                    [](const v1::Progress& progress) { return progress.stage() != "solve"; });
  EXPECT_EQ(ReasonOf(result.status()), Reason::kCancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST_F(ClientEvaluateTest, CancelFromAnotherThreadEndsTheCall) {
  const std::unique_ptr<Server> server = Start();
  const Client client(server->InProcessChannel());
  absl::StatusOr<ClientEvaluation> call =
      client.SubmitEvaluation(Endless(), Sphere(20'000), parameters_);
  ASSERT_TRUE(call.ok()) << call.status();
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    call->Cancel();
  });
  EXPECT_EQ(ReasonOf(CollectEvaluation(&*call, parameters_.size(), {}).status()),
            Reason::kCancelled);
  canceller.join();
}

TEST_F(ClientEvaluateTest, DestroyingACallInMidstreamFreesItsPlace) {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_length = 0;
  const std::unique_ptr<Server> server = Start(options);
  const Client client(server->InProcessChannel());
  {
    // The rest of its parameters waits in the uploader.
    absl::StatusOr<ClientEvaluation> call = client.SubmitEvaluation({}, mesh_, parameters_);
    ASSERT_TRUE(call.ok()) << call.status();
    ASSERT_TRUE(call->Next().has_value());
  }
  absl::StatusOr<EvaluateResult> next = absl::UnknownError("not tried");
  for (int attempt = 0; attempt < 100 && !next.ok(); ++attempt) {
    next = client.Evaluate({}, mesh_, {});
    if (!next.ok()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(next.ok()) << next.status();
}

TEST_F(ClientEvaluateTest, DeadlinesEndIt) {
  const std::unique_ptr<Server> server = Start();
  const Client client(server->InProcessChannel(), {.deadline_seconds = 0.5});
  EXPECT_EQ(ReasonOf(client.Evaluate(Endless(), Sphere(20'000), parameters_).status()),
            Reason::kDeadlineExceeded);
}

}  // namespace
}  // namespace limn
