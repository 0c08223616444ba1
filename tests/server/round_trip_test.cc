// SPDX-License-Identifier: MIT
// The whole job through the service gives what the engine gives.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "engine/constraints/certificate.h"
#include "engine/interpolate.h"
#include "server/options_from_proto.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

InterpolateResult Alone(const PolygonMesh& mesh, std::uint32_t level) {
  InterpolateOptions options;
  options.level = level;
  absl::StatusOr<InterpolateResult> result = Interpolate(Context{}, mesh, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

// Through memory: at -O3, GCC 12 drops a vectorised conversion to float and back.
double AsFloat(double x) {
  const volatile float narrow = static_cast<float>(x);
  return narrow;
}
Vec3 AsFloat(const Vec3& v) { return {AsFloat(v.x), AsFloat(v.y), AsFloat(v.z)}; }

void ExpectSame(const JobResult& received, const InterpolateResult& computed,
                const PolygonMesh& mesh) {
  EXPECT_EQ(received.control_mesh.positions, computed.control_positions);
  EXPECT_EQ(received.control_mesh.face_begin, mesh.face_begin);
  EXPECT_EQ(received.control_mesh.corner_vertex, mesh.corner_vertex);
  EXPECT_EQ(received.surface.positions, computed.surface.positions);
  EXPECT_EQ(received.surface.arity, computed.surface.arity);
  EXPECT_EQ(received.surface.face_begin, computed.surface.face_begin);
  EXPECT_EQ(received.surface.face_vertices, computed.surface.face_vertices);
  ASSERT_EQ(received.surface.normals.size(), computed.surface.normals.size());
  for (std::size_t i = 0; i < computed.surface.normals.size(); ++i) {
    ASSERT_EQ(received.surface.normals[i], AsFloat(computed.surface.normals[i])) << i;
  }
}

// Every polygon cut into triangles from its first corner.
PolygonMesh Fans(const PolygonMesh& mesh) {
  PolygonMesh fans;
  fans.positions = mesh.positions;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Index first = mesh.face_begin[f];
    for (Index i = first + 1; i + 1 < mesh.face_begin[f + 1]; ++i) {
      fans.AddFace({mesh.corner_vertex[first], mesh.corner_vertex[i], mesh.corner_vertex[i + 1]});
    }
  }
  return fans;
}

class RoundTripTest : public testing::TestWithParam<std::tuple<v1::MeshEncoding, std::uint32_t>> {};

TEST_P(RoundTripTest, GivesTheEnginesResultBitForBit) {
  const auto [encoding, level] = GetParam();
  const PolygonMesh mesh = MakeSphere(500);
  v1::InterpolateHeader header = MakeHeader(level);
  header.mutable_mesh()->set_encoding(encoding);
  header.mutable_output()->set_encoding(encoding);
  const std::unique_ptr<Server> server = StartServer();
  const absl::StatusOr<JobResult> result = Client(server->InProcessChannel()).Run(header, mesh);
  ASSERT_TRUE(result.ok()) << result.status();
  ExpectSame(*result, Alone(mesh, level), mesh);
  EXPECT_EQ(result->surface.level, level);
}

INSTANTIATE_TEST_SUITE_P(Encodings, RoundTripTest,
                         testing::Combine(testing::Values(v1::MESH_ENCODING_PACKED,
                                                          v1::MESH_ENCODING_DRACO),
                                          testing::Values(0, 1, 2, 3)));

// The other schemes, with creases and a hole, in every encoding that keeps order.
TEST(ServiceTest, OtherSchemesGiveTheEnginesResultBitForBit) {
  const PolygonMesh polygons = MakeSphere(300);
  const PolygonMesh triangles = Fans(polygons);
  const std::unique_ptr<Server> server = StartServer();
  for (const Scheme scheme : {Scheme::kCatmullClark, Scheme::kLoop}) {
    const PolygonMesh& mesh = scheme == Scheme::kLoop ? triangles : polygons;
    for (const v1::MeshEncoding encoding : {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO}) {
      // Faces of one arity arrive as such: triangles at level 0 would.
      for (const std::uint32_t level : {scheme == Scheme::kLoop ? 3U : 0U, 1U, 2U}) {
        InterpolateOptions options = {.scheme = scheme, .level = level};
        options.constraints.creases = {
            {.vertices = {mesh.corner_vertex[0], mesh.corner_vertex[1]}, .sharpness = {2.5F}}};
        // The last one too, whose middle has the last number.
        const auto last = static_cast<Index>(mesh.face_count() - 1);
        if (encoding == v1::MESH_ENCODING_PACKED) options.constraints.holes = {7, last};
        v1::InterpolateHeader header = MakeHeader(level);
        header.set_scheme(SchemeToProto(scheme));
        v1::Crease* crease = header.mutable_constraints()->add_creases();
        crease->add_vertices(mesh.corner_vertex[0]);
        crease->add_vertices(mesh.corner_vertex[1]);
        crease->add_sharpness(2.5);
        for (const Index hole : options.constraints.holes) {
          header.mutable_constraints()->add_holes(hole);
        }
        header.mutable_mesh()->set_encoding(encoding);
        header.mutable_output()->set_encoding(encoding);
        const absl::StatusOr<JobResult> result =
            Client(server->InProcessChannel()).Run(header, mesh);
        ASSERT_TRUE(result.ok()) << result.status();
        const absl::StatusOr<InterpolateResult> alone = Interpolate(Context{}, mesh, options);
        ASSERT_TRUE(alone.ok()) << alone.status();
        ExpectSame(*result, *alone, mesh);
        const v1::Summary& summary = result->summary;
        EXPECT_EQ(summary.scheme(), SchemeToProto(scheme));
        EXPECT_EQ(summary.solve().method(), v1::SolveOptions::METHOD_CONJUGATE_GRADIENT);
        EXPECT_EQ(summary.solve().rule(), RuleToProto(alone->rule));
        EXPECT_EQ(summary.surface_faces(), alone->surface.face_count());
        EXPECT_LE(summary.certificate().max_error(),
                  4e-12 * summary.certificate().bounding_box_diagonal());
      }
    }
  }
}

TEST(ServiceTest, GivesTheSameOverASocketInSmallTiles) {
  const PolygonMesh mesh = MakeSphere(3000);
  v1::InterpolateHeader header = MakeHeader(2);
  header.mutable_output()->set_tile_bytes(4 << 10);
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 2});
  const Client client =
      Client::Connect("127.0.0.1:" + std::to_string(server->port()), {.chunk_bytes = 1000});
  const absl::StatusOr<JobResult> result = client.Run(header, mesh);
  ASSERT_TRUE(result.ok()) << result.status();
  ExpectSame(*result, Alone(mesh, 2), mesh);
}

TEST(ServiceTest, SummaryTellsStagesSizesAndCertificate) {
  const PolygonMesh mesh = MakeSphere(700);
  v1::InterpolateHeader header = MakeHeader(1);
  header.set_request_id("my-job.1");
  const std::unique_ptr<Server> server = StartServer();
  const absl::StatusOr<JobResult> result = Client(server->InProcessChannel()).Run(header, mesh);
  ASSERT_TRUE(result.ok()) << result.status();
  const v1::Summary& summary = result->summary;
  EXPECT_EQ(summary.request_id(), "my-job.1");
  EXPECT_EQ(summary.scheme(), v1::SCHEME_DOO_SABIN);
  EXPECT_EQ(summary.input_vertices(), mesh.vertex_count());
  EXPECT_EQ(summary.input_faces(), mesh.face_count());
  EXPECT_EQ(summary.level(), 1U);
  EXPECT_EQ(summary.surface_vertices(), result->surface.vertex_count());
  EXPECT_EQ(summary.surface_faces(), result->surface.face_count());
  EXPECT_EQ(summary.bytes_received(),
            24 * mesh.vertex_count() + 4 * (mesh.face_count() + mesh.corner_count()));
  EXPECT_EQ(summary.bytes_sent(), summary.bytes_received() + 36 * result->surface.vertex_count() +
                                      4 * result->surface.face_vertices.size());
  EXPECT_TRUE(summary.solve().converged());
  EXPECT_LE(summary.solve().sweeps(), 18U);
  EXPECT_EQ(summary.certificate().points_checked(), mesh.vertex_count());
  EXPECT_TRUE(summary.certificate().after_encoding());
  EXPECT_GT(summary.certificate().bounding_box_diagonal(), 0);
  EXPECT_LE(summary.certificate().max_error(),
            1e-12 * summary.certificate().bounding_box_diagonal());

  std::vector<std::string> stages;
  for (const v1::StageTime& stage : summary.stages()) {
    stages.push_back(stage.stage());
    EXPECT_GE(stage.milliseconds(), 0);
  }
  EXPECT_EQ(stages,
            (std::vector<std::string>{"receive", "queue", "decode", "build", "solve",
                                      "first_refinement", "perturb", "refine", "limit", "encode"}));
}

TEST(ServiceTest, CertificateIsThatOfTheQuantisedPositions) {
  const PolygonMesh mesh = MakeSphere(900);
  v1::InterpolateHeader header = MakeHeader(1);
  header.mutable_output()->set_encoding(v1::MESH_ENCODING_DRACO_QUANTIZED);
  header.mutable_output()->set_quantization_bits(10);
  header.mutable_output()->set_tile_bytes(16 << 10);
  const std::unique_ptr<Server> server = StartServer();
  const absl::StatusOr<JobResult> result = Client(server->InProcessChannel()).Run(header, mesh);
  ASSERT_TRUE(result.ok()) << result.status();
  CertificateBuilder received(mesh.positions);
  received.AddRun(0, result->surface.positions);
  const Certificate expected = received.Finish();
  const v1::Certificate& told = result->summary.certificate();
  EXPECT_TRUE(told.after_encoding());
  EXPECT_EQ(told.points_checked(), mesh.vertex_count());
  EXPECT_EQ(told.max_error(), expected.max_error);
  EXPECT_EQ(told.mean_error(), expected.mean_error);
  EXPECT_EQ(told.max_error_vertex(), expected.max_error_vertex);
  EXPECT_GT(told.max_error(), 1e-6 * told.bounding_box_diagonal());
  EXPECT_LT(told.max_error(), 1e-2 * told.bounding_box_diagonal());
}

TEST(ServiceTest, WithoutASurfaceTheCertificateIsOfTheComputedOne) {
  const PolygonMesh mesh = MakeSphere(600);
  v1::InterpolateHeader header = MakeHeader(3);
  header.mutable_output()->set_surface(false);
  const std::unique_ptr<Server> server = StartServer();
  const absl::StatusOr<JobResult> result = Client(server->InProcessChannel()).Run(header, mesh);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->control_mesh.positions, Alone(mesh, 0).control_positions);
  EXPECT_EQ(result->surface.vertex_count(), 0U);
  EXPECT_EQ(result->summary.surface_vertices(), 0U);
  EXPECT_FALSE(result->summary.certificate().after_encoding());
  EXPECT_EQ(result->summary.certificate().points_checked(), mesh.vertex_count());
  EXPECT_LE(result->summary.certificate().max_error(),
            1e-12 * result->summary.certificate().bounding_box_diagonal());
}

TEST(ServiceTest, ConnectivityAndNormalsCanBeLeftOut) {
  const PolygonMesh mesh = MakeSphere(800);
  v1::InterpolateHeader header = MakeHeader(2);
  header.mutable_output()->set_omit_connectivity(true);
  header.mutable_output()->set_normals(false);
  header.mutable_output()->set_control_mesh(false);
  const std::unique_ptr<Server> server = StartServer();
  const absl::StatusOr<JobResult> result = Client(server->InProcessChannel()).Run(header, mesh);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->surface.positions, Alone(mesh, 2).surface.positions);
  EXPECT_TRUE(result->surface.face_vertices.empty());
  EXPECT_TRUE(result->surface.normals.empty());
  EXPECT_EQ(result->control_mesh.vertex_count(), 0U);
}

TEST(ServiceTest, MessagesComeInTheOrderOfTheContract) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  v1::InterpolateHeader header = MakeHeader(2);
  header.mutable_output()->set_tile_bytes(8 << 10);
  ASSERT_TRUE(call.Write(MakeUpload(header, MakeSphere(1000))));
  call.WritesDone();
  std::string order;
  std::uint32_t tiles = 0;
  while (const std::optional<v1::InterpolateResponse> message = call.Read()) {
    char kind = '?';
    if (message->has_accepted()) kind = 'A';
    if (message->has_progress()) kind = 'P';
    if (message->has_control_mesh()) kind = message->control_mesh().has_header() ? 'H' : 'C';
    if (message->has_tile()) {
      kind = 'T';
      EXPECT_EQ(message->tile().index(), tiles++);
    }
    if (message->has_summary()) kind = 'S';
    if (kind != 'P' && (order.empty() || order.back() != kind)) order += kind;
  }
  EXPECT_TRUE(call.Finish().ok()) << call.Finish();
  EXPECT_EQ(order, "AHCTS");
  EXPECT_GT(tiles, 3U);
}

TEST(ServiceTest, AnEmptyRequestIdIsReplacedByOneOfTheServer) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(MakeUpload(MakeHeader(0), MakeSphere(32))));
  const std::optional<v1::InterpolateResponse> accepted = call.Read();
  ASSERT_TRUE(accepted.has_value());
  EXPECT_EQ(accepted->accepted().request_id().size(), 16U);
  EXPECT_EQ(accepted->accepted().server_version(), LIMN_VERSION);
  EXPECT_GT(accepted->accepted().estimated_bytes(), 0U);
  EXPECT_TRUE(call.Finish().ok());
}

TEST(ServiceTest, ProgressComesWhileTheJobRunsButNotTooOften) {
  const std::unique_ptr<Server> server = StartServer();
  v1::InterpolateHeader header = MakeHeader(1);
  header.mutable_solve()->set_tolerance(0);
  header.mutable_solve()->set_max_sweeps(2000);
  int messages = 0;
  bool solve_seen = false;
  const auto start = std::chrono::steady_clock::now();
  const absl::StatusOr<JobResult> result =
      Client(server->InProcessChannel())
          .Run(header, MakeSphere(20'000), [&](const v1::Progress& progress) {
            ++messages;
            solve_seen = solve_seen || (progress.stage() == "solve" && progress.sweep() > 0);
            EXPECT_GE(progress.fraction(), 0);
            EXPECT_LE(progress.fraction(), 1);
            return true;
          });
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(solve_seen);
  EXPECT_LE(messages, 10 * seconds + 2);
}

TEST(ServiceTest, ConcurrentJobsAreNotMixedUp) {
  constexpr int kJobs = 12;
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 2});
  const Client client = Client::Connect("127.0.0.1:" + std::to_string(server->port()));
  std::vector<std::thread> threads;
  for (int job = 0; job < kJobs; ++job) {
    threads.emplace_back([&client, job] {
      const PolygonMesh mesh = MakeSphere(300 + 50 * job, 100 + job);
      v1::InterpolateHeader header = MakeHeader(job % 3);
      header.set_request_id("job-" + std::to_string(job));
      header.mutable_output()->set_tile_bytes(4 << 10);
      const absl::StatusOr<JobResult> result = client.Run(header, mesh);
      ASSERT_TRUE(result.ok()) << result.status();
      EXPECT_EQ(result->summary.request_id(), header.request_id());
      ExpectSame(*result, Alone(mesh, job % 3), mesh);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(ServiceTest, ABadMeshIsRefusedWithWhatIsWrong) {
  const std::unique_ptr<Server> server = StartServer();
  PolygonMesh mesh = MakeSphere(64);
  mesh.positions[7].y = std::nan("");
  const absl::StatusOr<JobResult> result =
      Client(server->InProcessChannel()).Run(MakeHeader(1), mesh);
  ASSERT_FALSE(result.ok());
  const std::optional<ErrorDetail> detail = GetErrorDetail(result.status());
  EXPECT_EQ(detail->reason, Reason::kNonFiniteCoordinate);
  EXPECT_EQ(detail->index, 7U);
}

}  // namespace
}  // namespace limn
