// SPDX-License-Identifier: MIT
// Constraints through the whole service: the engine's result, a certificate of what was sent, and
// refusals by the path of their field.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "client/vertex_set.h"
#include "engine/constraints/certificate.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "server/constraints_from_proto.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

// Within 1e-7: unit normals in float32.
constexpr double kFloatAngle = 1e-7;

PolygonMesh MakeMesh(MeshKind kind) {
  absl::StatusOr<PolygonMesh> mesh = GenerateMesh({.kind = kind, .vertices = 600, .seed = 11});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

// Through two of three vertices, some of them with a normal; handles anywhere.
v1::Constraints MakeConstraints(const PolygonMesh& mesh) {
  v1::Constraints constraints;
  *constraints.mutable_interpolate() =
      VerticesWhere(mesh, [](Index v, const Vec3&) { return v % 3 != 1; });
  for (Index v = 0; v < mesh.vertex_count(); v += 30) {
    v1::NormalConstraint* normal = constraints.add_normals();
    normal->set_vertex(v);
    normal->mutable_normal()->set_x(0.1 * (v % 7) - 0.3);
    normal->mutable_normal()->set_y(0.2);
    normal->mutable_normal()->set_z(-3);
  }
  for (Index v = 1; v < mesh.vertex_count(); v += 20) {
    v1::ShapeHandle* handle = constraints.add_shape_handles();
    handle->set_vertex(v);
    handle->set_value(v % 40 == 1 ? 0.4 : 2.5);
  }
  return constraints;
}

v1::InterpolateHeader MakeConstrainedHeader(const PolygonMesh& mesh, std::uint32_t level) {
  v1::InterpolateHeader header = MakeHeader(level);
  *header.mutable_constraints() = MakeConstraints(mesh);
  return header;
}

Constraints EngineConstraints(const PolygonMesh& mesh) {
  const auto constraints = ConstraintsFromProto(MakeConstraints(mesh), mesh.vertex_count());
  EXPECT_TRUE(constraints.ok()) << constraints.status();
  return *constraints;
}

JobResult RunJob(const v1::InterpolateHeader& header, const PolygonMesh& mesh) {
  const std::unique_ptr<Server> server = StartServer();
  absl::StatusOr<JobResult> result = Client(server->InProcessChannel()).Run(header, mesh);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result) : JobResult{};
}

// What the client itself finds.
Certificate Certify(const PolygonMesh& mesh, const Tessellation& surface) {
  CertificateBuilder builder(mesh.positions, EngineConstraints(mesh));
  builder.AddRun(0, surface.positions);
  builder.AddNormalRun(0, surface.normals);
  return builder.Finish();
}

void ExpectTells(const v1::Certificate& told, const Certificate& found) {
  EXPECT_EQ(told.points_checked(), found.points_checked);
  EXPECT_EQ(told.max_error(), found.max_error);
  EXPECT_EQ(told.mean_error(), found.mean_error);
  EXPECT_EQ(told.max_error_vertex(), found.max_error_vertex);
  EXPECT_EQ(told.bounding_box_diagonal(), found.bounding_box_diagonal);
  EXPECT_EQ(told.normals_checked(), found.normals_checked);
  EXPECT_EQ(told.max_normal_deviation(), found.max_normal_deviation);
  EXPECT_EQ(told.max_normal_deviation_vertex(), found.max_normal_deviation_vertex);
}

using Case = std::tuple<MeshKind, v1::MeshEncoding, v1::SolveOptions::Rule>;

class ConstrainedRoundTripTest : public testing::TestWithParam<Case> {};

TEST_P(ConstrainedRoundTripTest, GivesTheEnginesResultAndCertifiesWhatWasSent) {
  const auto [kind, encoding, rule] = GetParam();
  const PolygonMesh mesh = MakeMesh(kind);
  v1::InterpolateHeader header = MakeConstrainedHeader(mesh, 2);
  header.mutable_mesh()->set_encoding(encoding);
  header.mutable_output()->set_encoding(encoding);
  header.mutable_output()->set_tile_bytes(16 << 10);
  header.mutable_solve()->set_rule(rule);
  const JobResult got = RunJob(header, mesh);

  InterpolateOptions options;
  options.constraints = EngineConstraints(mesh);
  options.rule =
      rule == v1::SolveOptions::RULE_STANDARD ? FirstRule::kStandard : FirstRule::kModified;
  const absl::StatusOr<InterpolateResult> expected = Interpolate(Context{}, mesh, options);
  ASSERT_TRUE(expected.ok()) << expected.status();
  EXPECT_EQ(got.control_mesh.positions, expected->control_positions);
  EXPECT_EQ(got.surface.positions, expected->surface.positions);
  ASSERT_EQ(got.surface.normals.size(), expected->surface.normals.size());

  EXPECT_EQ(got.summary.solve().rule(), rule);
  EXPECT_TRUE(got.summary.solve().converged());
  EXPECT_LT(got.summary.solve().residual(), 1e-11);
  const v1::Certificate& told = got.summary.certificate();
  ExpectTells(told, Certify(mesh, got.surface));
  EXPECT_TRUE(told.after_encoding());
  EXPECT_EQ(told.points_checked(), options.constraints.interpolate->size());
  EXPECT_LE(told.max_error(), 1e-12 * told.bounding_box_diagonal());
  EXPECT_EQ(told.normals_checked(), options.constraints.normals.size());
  EXPECT_LE(told.max_normal_deviation(), kFloatAngle);
}

INSTANTIATE_TEST_SUITE_P(
    Jobs, ConstrainedRoundTripTest,
    testing::Combine(testing::Values(MeshKind::kIrregularSphere, MeshKind::kDisk),
                     testing::Values(v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO),
                     testing::Values(v1::SolveOptions::RULE_MODIFIED,
                                     v1::SolveOptions::RULE_STANDARD)),
    [](const auto& test) {
      return std::string(MeshKindName(std::get<0>(test.param))) + "_" +
             v1::MeshEncoding_Name(std::get<1>(test.param)) + "_" +
             v1::SolveOptions::Rule_Name(std::get<2>(test.param));
    });

TEST(ConstrainedJobTest, QuantisedNormalsAndPointsAreCertifiedAsTheyArrive) {
  const PolygonMesh mesh = MakeMesh(MeshKind::kIrregularSphere);
  v1::InterpolateHeader header = MakeConstrainedHeader(mesh, 1);
  header.mutable_output()->set_encoding(v1::MESH_ENCODING_DRACO_QUANTIZED);
  header.mutable_output()->set_quantization_bits(12);
  header.mutable_output()->set_tile_bytes(16 << 10);
  const JobResult got = RunJob(header, mesh);
  ExpectTells(got.summary.certificate(), Certify(mesh, got.surface));
  EXPECT_GT(got.summary.certificate().max_error(), 0);
  EXPECT_GT(got.summary.certificate().max_normal_deviation(), kFloatAngle);
  EXPECT_LT(got.summary.certificate().max_normal_deviation(), 1e-3);
}

TEST(ConstrainedJobTest, WithoutNormalsSentTheComputedOnesAreCertified) {
  const PolygonMesh mesh = MakeMesh(MeshKind::kDisk);
  for (const v1::MeshEncoding encoding :
       {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    v1::InterpolateHeader header = MakeConstrainedHeader(mesh, 1);
    header.mutable_output()->set_normals(false);
    header.mutable_output()->set_encoding(encoding);
    const JobResult got = RunJob(header, mesh);
    EXPECT_TRUE(got.surface.normals.empty());
    EXPECT_GT(got.summary.certificate().normals_checked(), 10U);
    EXPECT_LE(got.summary.certificate().max_normal_deviation(), 1e-10);
  }
}

TEST(ConstrainedJobTest, WithoutASurfaceTheComputedOneIsCertified) {
  const PolygonMesh mesh = MakeMesh(MeshKind::kIrregularSphere);
  v1::InterpolateHeader header = MakeConstrainedHeader(mesh, 3);
  header.mutable_output()->set_surface(false);
  const JobResult got = RunJob(header, mesh);
  const v1::Certificate& told = got.summary.certificate();
  EXPECT_FALSE(told.after_encoding());
  EXPECT_EQ(got.surface.vertex_count(), 0U);
  EXPECT_EQ(told.points_checked(), EngineConstraints(mesh).interpolate->size());
  EXPECT_LE(told.max_error(), 1e-12 * told.bounding_box_diagonal());
  EXPECT_EQ(told.normals_checked(), EngineConstraints(mesh).normals.size());
  EXPECT_LE(told.max_normal_deviation(), 1e-10);
}

TEST(ConstrainedJobTest, AnEmptySubsetChecksNothing) {
  v1::InterpolateHeader header = MakeHeader(1);
  header.mutable_constraints()->mutable_interpolate();
  const JobResult got = RunJob(header, MakeMesh(MeshKind::kIrregularSphere));
  EXPECT_EQ(got.summary.certificate().points_checked(), 0U);
  EXPECT_EQ(got.summary.certificate().max_error(), 0);
}

TEST(ConstrainedJobTest, CountsThatWereNotClaimedAreToldInTheSummary) {
  const PolygonMesh mesh = MakeMesh(MeshKind::kIrregularSphere);
  v1::InterpolateHeader header = MakeConstrainedHeader(mesh, 0);
  header.mutable_mesh()->set_encoding(v1::MESH_ENCODING_DRACO);
  std::vector<v1::InterpolateRequest> upload = MakeUpload(header, mesh);
  v1::MeshHeader* claims = upload[0].mutable_header()->mutable_mesh();
  claims->clear_vertex_count();
  claims->clear_face_count();
  claims->clear_corner_count();
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  call.Write(upload);
  call.WritesDone();
  std::optional<v1::Summary> summary;
  while (const auto message = call.Read()) {
    if (message->has_summary()) summary = message->summary();
  }
  ASSERT_TRUE(summary.has_value()) << call.Finish();
  EXPECT_EQ(summary->input_vertices(), mesh.vertex_count());
  EXPECT_EQ(summary->input_faces(), mesh.face_count());
  EXPECT_EQ(summary->certificate().normals_checked(), EngineConstraints(mesh).normals.size());
}

struct Refused {
  std::string name;
  std::function<void(v1::Constraints*)> spoil;
  // "INVALID_OPTION" or "INDEX_OUT_OF_RANGE".
  std::string reason;
  std::string path;
};

void PrintTo(const Refused& c, std::ostream* out) { *out << c.name; }

class RefusedConstraintsTest : public testing::TestWithParam<Refused> {};

TEST_P(RefusedConstraintsTest, ReachTheClientAsInvalidArgumentWithTheirPath) {
  const PolygonMesh mesh = MakeMesh(MeshKind::kIrregularSphere);
  v1::InterpolateHeader header = MakeConstrainedHeader(mesh, 1);
  GetParam().spoil(header.mutable_constraints());
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  call.Write(MakeUpload(header, mesh));
  call.WritesDone();
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kInvalidArgument) << call.Finish();
  EXPECT_EQ(ErrorInfoOf(call.rich_status()).reason(), GetParam().reason);
  v1::BadRequestDetails bad;
  const v1::RichStatus rich = call.rich_status();
  for (const auto& any : rich.details()) {
    if (any.type_url() == "type.googleapis.com/google.rpc.BadRequest") {
      ASSERT_TRUE(bad.ParseFromString(any.value()));
    }
  }
  ASSERT_EQ(bad.field_violations_size(), 1);
  EXPECT_EQ(bad.field_violations(0).field(), GetParam().path);
  EXPECT_TRUE(bad.field_violations(0).description().starts_with(GetParam().path + ": "));
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, RefusedConstraintsTest,
    testing::Values(
        Refused{"VertexOutOfRange", [](auto* c) { c->mutable_interpolate()->set_vertices(2, 600); },
                "INDEX_OUT_OF_RANGE", "constraints.interpolate.vertices[2]"},
        Refused{"VertexRepeated", [](auto* c) { c->mutable_interpolate()->set_vertices(2, 0); },
                "INVALID_OPTION", "constraints.interpolate.vertices[2]"},
        Refused{"TooManyVertices",
                [](auto* c) {
                  for (int i = 0; i < 300; ++i) c->mutable_interpolate()->add_vertices(0);
                },
                "INVALID_OPTION", "constraints.interpolate.vertices"},
        Refused{"NormalOutOfRange", [](auto* c) { c->mutable_normals(3)->set_vertex(12345); },
                "INDEX_OUT_OF_RANGE", "constraints.normals[3].vertex"},
        Refused{"NormalRepeated", [](auto* c) { c->mutable_normals(3)->set_vertex(30); },
                "INVALID_OPTION", "constraints.normals[3].vertex"},
        Refused{"NormalElsewhere", [](auto* c) { c->mutable_normals(3)->set_vertex(1); },
                "INVALID_OPTION", "constraints.normals[3].vertex"},
        Refused{"NormalMissing", [](auto* c) { c->mutable_normals(3)->clear_normal(); },
                "INVALID_OPTION", "constraints.normals[3].normal"},
        Refused{"NormalZero", [](auto* c) { c->mutable_normals(3)->mutable_normal()->Clear(); },
                "INVALID_OPTION", "constraints.normals[3].normal"},
        Refused{"NormalNan",
                [](auto* c) { c->mutable_normals(3)->mutable_normal()->set_y(std::nan("")); },
                "INVALID_OPTION", "constraints.normals[3].normal"},
        Refused{"HandleOutOfRange", [](auto* c) { c->mutable_shape_handles(1)->set_vertex(600); },
                "INDEX_OUT_OF_RANGE", "constraints.shape_handles[1].vertex"},
        Refused{"HandleRepeated", [](auto* c) { c->mutable_shape_handles(1)->set_vertex(1); },
                "INVALID_OPTION", "constraints.shape_handles[1].vertex"},
        Refused{"HandleZero", [](auto* c) { c->mutable_shape_handles(1)->clear_value(); },
                "INVALID_OPTION", "constraints.shape_handles[1].value"},
        Refused{"HandleInfinite",
                [](auto* c) {
                  c->mutable_shape_handles(1)->set_value(std::numeric_limits<double>::infinity());
                },
                "INVALID_OPTION", "constraints.shape_handles[1].value"},
        Refused{"FeatureValueMissing",
                [](auto* c) {
                  c->mutable_features()->add_edges()->set_value(0);
                  c->mutable_features()->add_edges()->set_to(1);
                },
                "INVALID_OPTION", "constraints.features.edges[1].value"},
        Refused{"FeatureValueTooLarge",
                [](auto* c) { c->mutable_features()->set_default_vertex(1.5); }, "INVALID_OPTION",
                "constraints.features.default_vertex"},
        Refused{"FeatureFaceOutOfRange",
                [](auto* c) { c->mutable_features()->add_faces()->set_face(1 << 20); },
                "INDEX_OUT_OF_RANGE", "constraints.features.faces[0].face"},
        // The faces of the sphere are not planar, and its normals are at their vertices.
        Refused{"FeaturePlanes",
                [](auto* c) {
                  c->clear_normals();
                  c->clear_shape_handles();
                  c->mutable_features()->set_default_face(v1::FeatureValues::FACE_KIND_PLANE);
                },
                "INVALID_OPTION", "constraints.features.default_face"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace limn
