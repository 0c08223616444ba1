// SPDX-License-Identifier: MIT
// Constraints of the contract become the engine's, entry by entry; what has no sensible structure
// is refused by the path of its field before anything is copied.
#include "server/constraints_from_proto.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/base/error.h"

namespace limn {
namespace {

void AddNormal(v1::Constraints* constraints, Index vertex, const Vec3& normal) {
  v1::NormalConstraint* entry = constraints->add_normals();
  entry->set_vertex(vertex);
  entry->mutable_normal()->set_x(normal.x);
  entry->mutable_normal()->set_y(normal.y);
  entry->mutable_normal()->set_z(normal.z);
}

void AddHandle(v1::Constraints* constraints, Index vertex, double value) {
  v1::ShapeHandle* entry = constraints->add_shape_handles();
  entry->set_vertex(vertex);
  entry->set_value(value);
}

TEST(ConstraintsFromProtoTest, EveryEntryArrivesInItsOrder) {
  v1::Constraints constraints;
  for (const Index v : {7U, 0U, 3U}) constraints.mutable_interpolate()->add_vertices(v);
  AddNormal(&constraints, 3, {1, -2, 0.1});
  AddNormal(&constraints, 7, {0, 0, -1});
  AddHandle(&constraints, 6, 0.4);
  AddHandle(&constraints, 1, 2.5);
  const absl::StatusOr<Constraints> got = ConstraintsFromProto(constraints, 8);
  ASSERT_TRUE(got.ok()) << got.status();
  EXPECT_EQ(got->interpolate, (std::vector<Index>{7, 0, 3}));
  ASSERT_EQ(got->normals.size(), 2U);
  EXPECT_EQ(got->normals[0].vertex, 3U);
  EXPECT_EQ(got->normals[0].normal, (Vec3{1, -2, 0.1}));
  EXPECT_EQ(got->normals[1].vertex, 7U);
  EXPECT_EQ(got->normals[1].normal, (Vec3{0, 0, -1}));
  ASSERT_EQ(got->shape_handles.size(), 2U);
  EXPECT_EQ(got->shape_handles[0].vertex, 6U);
  EXPECT_EQ(got->shape_handles[0].value, 0.4);
  EXPECT_EQ(got->shape_handles[1].vertex, 1U);
  EXPECT_EQ(got->shape_handles[1].value, 2.5);
  EXPECT_EQ(ConstraintBytes(*got), 3 * 4 + 2 * sizeof(NormalConstraint) + 2 * sizeof(ShapeHandle));
}

TEST(ConstraintsFromProtoTest, ConstraintsOnTheSurfaceArriveWithWhatTheyAskFor) {
  v1::Constraints constraints;
  v1::SurfaceConstraint* at_vertex = constraints.add_surface_points();
  at_vertex->set_vertex(3);
  at_vertex->mutable_point()->set_y(2);
  at_vertex->mutable_normal()->set_z(-1);
  for (const Index f : {8U, 2U, 5U}) at_vertex->add_region(f);
  v1::SurfaceConstraint* at_parameter = constraints.add_surface_points();
  at_parameter->mutable_parameter()->set_face(4);
  at_parameter->mutable_parameter()->set_corner(1);
  at_parameter->mutable_parameter()->set_u(0.25);
  at_parameter->mutable_parameter()->set_v(0.75);
  at_parameter->mutable_derivative_u()->set_x(3);
  at_parameter->mutable_derivative_v()->set_y(-4);
  constraints.add_surface_points();
  const absl::StatusOr<Constraints> got = ConstraintsFromProto(constraints, 8);
  ASSERT_TRUE(got.ok()) << got.status();
  ASSERT_EQ(got->surface_points.size(), 3U);
  const SurfaceConstraint& first = got->surface_points[0];
  EXPECT_EQ(first.vertex, 3U);
  EXPECT_FALSE(first.parameter.has_value());
  EXPECT_EQ(first.point, (Vec3{0, 2, 0}));
  EXPECT_EQ(first.normal, (Vec3{0, 0, -1}));
  EXPECT_FALSE(first.derivative_u || first.derivative_v);
  EXPECT_EQ(first.region, (std::vector<Index>{8, 2, 5}));
  const SurfaceConstraint& second = got->surface_points[1];
  EXPECT_FALSE(second.vertex || second.point || second.normal);
  ASSERT_TRUE(second.parameter.has_value());
  EXPECT_EQ(second.parameter->face, 4U);
  EXPECT_EQ(second.parameter->corner, 1U);
  EXPECT_EQ(second.parameter->u, 0.25);
  EXPECT_EQ(second.parameter->v, 0.75);
  EXPECT_EQ(second.derivative_u, (Vec3{3, 0, 0}));
  EXPECT_EQ(second.derivative_v, (Vec3{0, -4, 0}));
  EXPECT_EQ(ConstraintBytes(*got), 3 * sizeof(SurfaceConstraint) + 3 * 4);
}

TEST(ConstraintsFromProtoTest, WhatIsSharpArrivesInItsOrder) {
  v1::Constraints constraints;
  v1::Crease* crease = constraints.add_creases();
  for (const Index v : {3U, 1U, 2U}) crease->add_vertices(v);
  crease->add_sharpness(10);
  crease->add_sharpness(0.5);
  constraints.add_creases()->add_vertices(4);
  v1::SharpVertex* corner = constraints.add_corners();
  corner->set_vertex(6);
  corner->set_sharpness(2.25);
  constraints.add_holes(5);
  constraints.add_holes(0);
  const absl::StatusOr<Constraints> got = ConstraintsFromProto(constraints, 8);
  ASSERT_TRUE(got.ok()) << got.status();
  ASSERT_EQ(got->creases.size(), 2U);
  EXPECT_EQ(got->creases[0].vertices, (std::vector<Index>{3, 1, 2}));
  EXPECT_EQ(got->creases[0].sharpness, (std::vector<float>{10, 0.5F}));
  EXPECT_EQ(got->creases[1].vertices, (std::vector<Index>{4}));
  ASSERT_EQ(got->corners.size(), 1U);
  EXPECT_EQ(got->corners[0].vertex, 6U);
  EXPECT_EQ(got->corners[0].sharpness, 2.25F);
  EXPECT_EQ(got->holes, (std::vector<Index>{5, 0}));
  EXPECT_EQ(ConstraintBytes(*got),
            2 * sizeof(CreaseConstraint) + 4 * 4 + 2 * 4 + sizeof(CornerConstraint) + 2 * 4);
}

TEST(ConstraintsFromProtoTest, AnAbsentSubsetIsAllVerticesAndAnEmptyOneIsNone) {
  const absl::StatusOr<Constraints> absent = ConstraintsFromProto({}, 8);
  ASSERT_TRUE(absent.ok());
  EXPECT_FALSE(absent->interpolate.has_value());
  EXPECT_EQ(ConstraintBytes(*absent), 0U);
  v1::Constraints constraints;
  constraints.mutable_interpolate();
  const absl::StatusOr<Constraints> none = ConstraintsFromProto(constraints, 8);
  ASSERT_TRUE(none.ok());
  ASSERT_TRUE(none->interpolate.has_value());
  EXPECT_TRUE(none->interpolate->empty());
}

// Ranges are for ValidateConstraints, which knows the mesh.
TEST(ConstraintsFromProtoTest, ValuesAreHandedOnUnchecked) {
  v1::Constraints constraints;
  constraints.mutable_interpolate()->add_vertices(kNoIndex);
  AddNormal(&constraints, 99, {0, 0, 0});
  AddHandle(&constraints, 99, -std::numeric_limits<double>::infinity());
  const absl::StatusOr<Constraints> got = ConstraintsFromProto(constraints, 8);
  ASSERT_TRUE(got.ok()) << got.status();
  EXPECT_EQ(got->interpolate->front(), kNoIndex);
  EXPECT_EQ(got->shape_handles[0].value, -std::numeric_limits<double>::infinity());
}

struct BadCase {
  std::string name;
  std::function<void(v1::Constraints*)> add;
  Reason reason;
  std::string field;
};

void PrintTo(const BadCase& c, std::ostream* out) { *out << c.name; }

class BadConstraintsFromProtoTest : public testing::TestWithParam<BadCase> {};

TEST_P(BadConstraintsFromProtoTest, AreRefusedByField) {
  v1::Constraints constraints;
  GetParam().add(&constraints);
  const absl::Status status = ConstraintsFromProto(constraints, 2).status();
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, GetParam().reason) << status;
  EXPECT_EQ(detail->field, GetParam().field);
  EXPECT_FALSE(detail->remedy.empty());
  EXPECT_TRUE(std::string(status.message()).starts_with(GetParam().field + ": ")) << status;
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, BadConstraintsFromProtoTest,
    testing::Values(BadCase{"TooManyVertices",
                            [](auto* c) {
                              for (Index v = 0; v < 3; ++v)
                                c->mutable_interpolate()->add_vertices(v);
                            },
                            Reason::kInvalidOption, "constraints.interpolate.vertices"},
                    BadCase{"TooManyNormals",
                            [](auto* c) {
                              for (Index v = 0; v < 3; ++v) AddNormal(c, v, {0, 0, 1});
                            },
                            Reason::kInvalidOption, "constraints.normals"},
                    BadCase{"TooManyHandles",
                            [](auto* c) {
                              for (Index v = 0; v < 3; ++v) AddHandle(c, v, 1);
                            },
                            Reason::kInvalidOption, "constraints.shape_handles"},
                    BadCase{"NormalMissing",
                            [](auto* c) {
                              AddNormal(c, 0, {0, 0, 1});
                              c->add_normals()->set_vertex(1);
                            },
                            Reason::kInvalidOption, "constraints.normals[1].normal"},
                    BadCase{"FeatureDefault",
                            [](auto* c) {
                              c->mutable_features()->set_default_face(
                                  static_cast<v1::FeatureValues::FaceKind>(7));
                            },
                            Reason::kInvalidOption, "constraints.features.default_face"},
                    BadCase{"FeatureKind",
                            [](auto* c) {
                              c->mutable_features()->add_faces();
                              c->mutable_features()->add_faces()->set_kind(
                                  static_cast<v1::FeatureValues::FaceKind>(3));
                            },
                            Reason::kInvalidOption, "constraints.features.faces[1].kind"},
                    BadCase{"FeatureEdgeWithoutValue",
                            [](auto* c) {
                              c->mutable_features()->add_edges()->set_value(0);
                              c->mutable_features()->add_edges()->set_to(1);
                            },
                            Reason::kInvalidOption, "constraints.features.edges[1].value"},
                    BadCase{"FeatureVertexWithoutValue",
                            [](auto* c) { c->mutable_features()->add_vertices()->set_vertex(3); },
                            Reason::kInvalidOption, "constraints.features.vertices[0].value"}),
    [](const auto& test) { return test.param.name; });

TEST(ConstraintsFromProtoTest, FeatureValuesArriveInTheirOrder) {
  v1::Constraints constraints;
  v1::FeatureValues* features = constraints.mutable_features();
  features->set_default_face(v1::FeatureValues::FACE_KIND_PLANE);
  features->set_default_edge(0.25);
  features->set_default_vertex(0);
  v1::FeatureValues::Face* face = features->add_faces();
  face->set_face(3);
  face->set_kind(v1::FeatureValues::FACE_KIND_SURFACE);
  features->add_faces()->set_kind(v1::FeatureValues::FACE_KIND_PLANE);
  v1::FeatureValues::Edge* edge = features->add_edges();
  edge->set_from(7);
  edge->set_to(2);
  edge->set_value(0.75);
  edge = features->add_edges();
  edge->set_face(0);
  edge->set_value(0);
  v1::FeatureValues::Vertex* vertex = features->add_vertices();
  vertex->set_vertex(5);
  vertex->set_face(4);
  vertex->set_value(0.5);
  features->add_vertices()->set_value(0.25);
  const absl::StatusOr<Constraints> got = ConstraintsFromProto(constraints, 8);
  ASSERT_TRUE(got.ok()) << got.status();
  ASSERT_TRUE(got->features.has_value());
  const FeatureValues& values = *got->features;
  EXPECT_EQ(values.default_face, FaceKind::kPlane);
  EXPECT_EQ(values.default_edge, 0.25);
  EXPECT_EQ(values.default_vertex, 0);
  ASSERT_EQ(values.faces.size(), 2U);
  EXPECT_EQ(values.faces[0].face, 3U);
  EXPECT_EQ(values.faces[0].kind, FaceKind::kSurface);
  EXPECT_EQ(values.faces[1].kind, FaceKind::kPlane);
  ASSERT_EQ(values.edges.size(), 2U);
  EXPECT_EQ(values.edges[0].from, 7U);
  EXPECT_EQ(values.edges[0].to, 2U);
  EXPECT_FALSE(values.edges[0].face.has_value());
  EXPECT_EQ(values.edges[0].value, 0.75);
  EXPECT_EQ(values.edges[1].face, 0U);
  EXPECT_EQ(values.edges[1].value, 0);
  ASSERT_EQ(values.vertices.size(), 2U);
  EXPECT_EQ(values.vertices[0].vertex, 5U);
  EXPECT_EQ(values.vertices[0].face, 4U);
  EXPECT_EQ(values.vertices[0].value, 0.5);
  EXPECT_FALSE(values.vertices[1].face.has_value());
  EXPECT_EQ(ConstraintBytes(*got),
            2 * sizeof(FaceFeature) + 2 * sizeof(EdgeFeature) + 2 * sizeof(VertexFeature));
}

// The contract's defaults are the engine's.
TEST(ConstraintsFromProtoTest, AbsentFeatureValuesTakeTheDefaults) {
  v1::Constraints constraints;
  EXPECT_FALSE(ConstraintsFromProto(constraints, 8)->features.has_value());
  constraints.mutable_features();
  const absl::StatusOr<Constraints> got = ConstraintsFromProto(constraints, 8);
  ASSERT_TRUE(got.ok()) << got.status();
  EXPECT_EQ(got->features->default_face, FaceKind::kSurface);
  EXPECT_EQ(got->features->default_edge, 0.5);
  EXPECT_EQ(got->features->default_vertex, 1);
}

TEST(ConstraintsFromProtoTest, WithoutAClaimOnlyTheMessageBoundsTheLists) {
  v1::Constraints constraints;
  for (Index v = 0; v < 1000; ++v) constraints.mutable_interpolate()->add_vertices(v);
  EXPECT_TRUE(ConstraintsFromProto(constraints, 0).ok());
}

}  // namespace
}  // namespace limn
