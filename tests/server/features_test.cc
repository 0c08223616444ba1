// SPDX-License-Identifier: MIT
// Feature values through the whole service: the engine's surface in tiles, its certificate, points
// anywhere on it, a level for a tolerance.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "client/client.h"
#include "engine/interpolate.h"
#include "engine/limit/evaluate.h"
#include "proto/wire/samples.h"
#include "server/constraints_from_proto.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/test_meshes.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

struct Model {
  PolygonMesh mesh;
  v1::Constraints constraints;
};

// Values of all kinds; planes: the faces that are plane ones. Vertices 0 and 9 are met.
Model MakeModel(PolygonMesh mesh, const std::vector<Index>& planes) {
  Model model = {.mesh = std::move(mesh), .constraints = {}};
  v1::FeatureValues* const features = model.constraints.mutable_features();
  features->set_default_edge(0.4);
  features->set_default_vertex(0.9);
  for (const Index f : planes) {
    v1::FeatureValues::Face* const face = features->add_faces();
    face->set_face(f);
    face->set_kind(v1::FeatureValues::FACE_KIND_PLANE);
  }
  for (Index f = 0; f < model.mesh.face_count(); f += 3) {
    const absl::Span<const Index> corners = model.mesh.face(f);
    v1::FeatureValues::Edge* const edge = features->add_edges();
    edge->set_from(corners[1]);
    edge->set_to(corners[0]);
    edge->set_face(f);
    edge->set_value(0.1 * (f % 11));
    v1::FeatureValues::Vertex* const vertex = features->add_vertices();
    vertex->set_vertex(corners[2]);
    vertex->set_face(f);
    vertex->set_value(0.05);
  }
  model.constraints.mutable_interpolate()->add_vertices(0);
  model.constraints.mutable_interpolate()->add_vertices(9);
  return model;
}

Model MakeModel(const std::string& name) {
  if (name == "closed") return MakeModel(oracle::TorusOfQuads(12, 8), {});
  if (name == "closed_with_planes") return MakeModel(oracle::Dodecahedron(), {0, 3, 7});
  PolygonMesh open = oracle::QuadPatch(5, 4);
  for (Vec3& p : open.positions) p.z = 0.1 * p.x - 0.2 * p.y;
  return MakeModel(std::move(open), {0, 7});
}

InterpolateOptions OptionsOf(const Model& model) {
  auto constraints = ConstraintsFromProto(model.constraints, model.mesh.vertex_count());
  EXPECT_TRUE(constraints.ok()) << constraints.status();
  return {.constraints = *std::move(constraints), .keep_patches = true};
}

InterpolateResult Expected(const Model& model, InterpolateOptions options) {
  auto result = Interpolate(Context{}, model.mesh, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

using Case = std::tuple<std::string, v1::MeshEncoding>;

class FeatureJobs : public testing::TestWithParam<Case> {
 protected:
  FeatureJobs() : model_(MakeModel(std::get<0>(GetParam()))), header_(MakeHeader(3)) {
    *header_.mutable_constraints() = model_.constraints;
    header_.mutable_mesh()->set_encoding(std::get<1>(GetParam()));
    header_.mutable_output()->set_encoding(std::get<1>(GetParam()));
    // Several of them.
    header_.mutable_output()->set_tile_bytes(16 << 10);
  }

  const Model model_;
  v1::InterpolateHeader header_;
};

TEST_P(FeatureJobs, AreTheEnginesSurfaceInTilesAndCertified) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  call.Write(MakeUpload(header_, model_.mesh));
  std::size_t tiles = 0;
  while (const std::optional<v1::InterpolateResponse> message = call.Read()) {
    if (message->has_tile()) ++tiles;
  }
  EXPECT_TRUE(call.Finish().ok()) << call.Finish();
  EXPECT_GT(tiles, 1U);

  const absl::StatusOr<JobResult> got =
      Client(server->InProcessChannel()).Run(header_, model_.mesh);
  ASSERT_TRUE(got.ok()) << got.status();
  InterpolateOptions options = OptionsOf(model_);
  options.level = 3;
  const InterpolateResult expected = Expected(model_, options);
  EXPECT_EQ(got->surface.positions, expected.surface.positions);
  EXPECT_EQ(got->surface.face_vertices, expected.surface.face_vertices);
  ASSERT_EQ(got->surface.normals.size(), expected.surface.normals.size());
  for (std::size_t v = 0; v < expected.surface.normals.size(); ++v) {
    // In float32.
    ASSERT_LE(MaxAbs(got->surface.normals[v] - expected.surface.normals[v]), 1e-7) << v;
  }
  EXPECT_EQ(got->control_mesh.positions, model_.mesh.positions);
  EXPECT_EQ(got->summary.solve().rule(), v1::SolveOptions::RULE_FEATURE_VALUES);
  const v1::Certificate& told = got->summary.certificate();
  EXPECT_TRUE(told.after_encoding());
  EXPECT_EQ(told.points_checked(), 2U);
  EXPECT_LE(told.max_error(), 1e-12 * told.bounding_box_diagonal());
}

TEST_P(FeatureJobs, HaveALevelForATolerance) {
  header_.mutable_surface()->clear_level();
  header_.mutable_surface()->set_chord_tolerance(0.02);
  const std::unique_ptr<Server> server = StartServer();
  const absl::StatusOr<JobResult> got =
      Client(server->InProcessChannel()).Run(header_, model_.mesh);
  ASSERT_TRUE(got.ok()) << got.status();
  InterpolateOptions options = OptionsOf(model_);
  options.chord_tolerance = 0.02;
  const InterpolateResult expected = Expected(model_, options);
  EXPECT_EQ(got->summary.level(), expected.surface.level);
  EXPECT_GT(got->summary.chord_bound(), 0);
  EXPECT_LE(got->summary.chord_bound(), 0.02);
  EXPECT_EQ(got->surface.positions, expected.surface.positions);
}

TEST_P(FeatureJobs, HavePointsAnywhere) {
  std::vector<SurfaceParameter> parameters;
  for (Index f = 0; f < model_.mesh.face_count(); ++f) {
    parameters.push_back({f, 1, 0, 0});
    parameters.push_back({f, 0, 0.3, 0.8});
    parameters.push_back({f, 2, 1, 0.5});
  }
  v1::InterpolateHeader header = MakeEvaluateHeader();
  *header.mutable_constraints() = model_.constraints;
  const std::unique_ptr<Server> server = StartServer();
  RawEvaluation call(server->InProcessChannel());
  std::vector<v1::EvaluateRequest> requests = MakeEvaluateUpload(header, model_.mesh);
  wire::WriteParameters(parameters, requests.emplace_back().mutable_parameters());
  call.Write(requests);
  call.WritesDone();
  wire::SampleArrays got;
  while (const std::optional<v1::EvaluateResponse> message = call.Read()) {
    if (message->has_accepted() || message->has_summary() || message->has_progress()) continue;
    ASSERT_TRUE(wire::DecodeSamples(*message, &got).ok());
  }
  EXPECT_TRUE(call.Finish().ok()) << call.Finish();
  const InterpolateResult result = Expected(model_, OptionsOf(model_));
  wire::SampleArrays expected;
  expected.Resize(parameters.size());
  ASSERT_TRUE(EvaluateSurface(Context{}, *result.patches, parameters, expected.Spans()).ok());
  EXPECT_EQ(got.points, expected.points);
  EXPECT_EQ(got.normals, expected.normals);
}

INSTANTIATE_TEST_SUITE_P(Models, FeatureJobs,
                         testing::Combine(testing::Values("closed", "closed_with_planes", "open"),
                                          testing::Values(v1::MESH_ENCODING_PACKED,
                                                          v1::MESH_ENCODING_DRACO)),
                         [](const auto& test) {
                           return std::get<0>(test.param) + "_" +
                                  v1::MeshEncoding_Name(std::get<1>(test.param));
                         });

}  // namespace
}  // namespace limn
