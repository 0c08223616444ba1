// SPDX-License-Identifier: MIT
// Every field of a job's header: what is out of range is refused, what is not built says so.
#include "server/options_from_proto.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using Header = v1::InterpolateHeader;

Header ValidHeader() {
  Header header = MakeHeader(2);
  header.mutable_mesh()->set_vertex_count(8);
  header.mutable_mesh()->set_face_count(6);
  header.mutable_mesh()->set_corner_count(24);
  return header;
}

struct FieldCase {
  std::string name;
  std::function<void(Header&)> spoil;
  Reason reason;
  std::string field;
};

void PrintTo(const FieldCase& c, std::ostream* out) { *out << c.name; }

class HeaderFieldTest : public testing::TestWithParam<FieldCase> {};

TEST_P(HeaderFieldTest, IsRefusedByName) {
  Header header = ValidHeader();
  GetParam().spoil(header);
  const absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  ASSERT_FALSE(spec.ok());
  const std::optional<ErrorDetail> detail = GetErrorDetail(spec.status());
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, GetParam().reason) << spec.status();
  EXPECT_EQ(detail->field, GetParam().field);
  EXPECT_FALSE(detail->remedy.empty());
}

template <class Enum>
Enum NoValue() {
  return static_cast<Enum>(99);
}

std::vector<FieldCase> InvalidCases() {
  constexpr Reason kInvalid = Reason::kInvalidOption;
  return {
      {"RequestIdTooLong", [](Header& h) { h.set_request_id(std::string(129, 'a')); }, kInvalid,
       "request_id"},
      {"RequestIdWithSpace", [](Header& h) { h.set_request_id("a b"); }, kInvalid, "request_id"},
      {"RequestIdWithNewline", [](Header& h) { h.set_request_id("a\n"); }, kInvalid, "request_id"},
      {"UnknownScheme", [](Header& h) { h.set_scheme(NoValue<v1::Scheme>()); }, kInvalid, "scheme"},
      {"NoMesh", [](Header& h) { h.clear_mesh(); }, kInvalid, "mesh"},
      {"UnknownMeshEncoding",
       [](Header& h) { h.mutable_mesh()->set_encoding(NoValue<v1::MeshEncoding>()); }, kInvalid,
       "mesh.encoding"},
      {"UnknownMethod",
       [](Header& h) { h.mutable_solve()->set_method(NoValue<v1::SolveOptions::Method>()); },
       kInvalid, "solve.method"},
      {"UnknownRule",
       [](Header& h) { h.mutable_solve()->set_rule(NoValue<v1::SolveOptions::Rule>()); }, kInvalid,
       "solve.rule"},
      {"NegativeTolerance", [](Header& h) { h.mutable_solve()->set_tolerance(-1e-9); }, kInvalid,
       "solve.tolerance"},
      {"ToleranceOne", [](Header& h) { h.mutable_solve()->set_tolerance(1); }, kInvalid,
       "solve.tolerance"},
      {"ToleranceNan",
       [](Header& h) {
         h.mutable_solve()->set_tolerance(std::numeric_limits<double>::quiet_NaN());
       },
       kInvalid, "solve.tolerance"},
      {"TooManySweeps", [](Header& h) { h.mutable_solve()->set_max_sweeps(10'001); }, kInvalid,
       "solve.max_sweeps"},
      {"LevelTooHigh", [](Header& h) { h.mutable_surface()->set_level(11); }, kInvalid,
       "surface.level"},
      {"ChordToleranceZero", [](Header& h) { h.mutable_surface()->set_chord_tolerance(0); },
       kInvalid, "surface.chord_tolerance"},
      {"ChordToleranceNegative", [](Header& h) { h.mutable_surface()->set_chord_tolerance(-1); },
       kInvalid, "surface.chord_tolerance"},
      {"ChordToleranceNan",
       [](Header& h) {
         h.mutable_surface()->set_chord_tolerance(std::numeric_limits<double>::quiet_NaN());
       },
       kInvalid, "surface.chord_tolerance"},
      {"ChordToleranceInfinite",
       [](Header& h) {
         h.mutable_surface()->set_chord_tolerance(std::numeric_limits<double>::infinity());
       },
       kInvalid, "surface.chord_tolerance"},
      {"MoreNormalsThanVertices",
       [](Header& h) {
         for (int i = 0; i < 9; ++i) h.mutable_constraints()->add_normals();
       },
       kInvalid, "constraints.normals"},
      {"UnknownBoundary",
       [](Header& h) {
         h.mutable_surface()->set_boundary(NoValue<v1::SurfaceOptions::Boundary>());
       },
       kInvalid, "surface.boundary"},
      {"UnknownOutputEncoding",
       [](Header& h) { h.mutable_output()->set_encoding(NoValue<v1::MeshEncoding>()); }, kInvalid,
       "output.encoding"},
      {"TooFewBits", [](Header& h) { h.mutable_output()->set_quantization_bits(7); }, kInvalid,
       "output.quantization_bits"},
      {"TooManyBits", [](Header& h) { h.mutable_output()->set_quantization_bits(31); }, kInvalid,
       "output.quantization_bits"},
      {"TilesTooSmall", [](Header& h) { h.mutable_output()->set_tile_bytes(4095); }, kInvalid,
       "output.tile_bytes"},
      {"TilesTooLarge", [](Header& h) { h.mutable_output()->set_tile_bytes((1 << 20) + 1); },
       kInvalid, "output.tile_bytes"},
      {"CreasesOfDooSabin", [](Header& h) { h.mutable_constraints()->add_creases(); }, kInvalid,
       "constraints.creases"},
      {"HandlesOfLoop",
       [](Header& h) {
         h.set_scheme(v1::SCHEME_LOOP);
         h.mutable_constraints()->add_shape_handles()->set_value(1);
       },
       kInvalid, "constraints.shape_handles"},
      {"DracoWithHoles",
       [](Header& h) {
         h.mutable_output()->set_encoding(v1::MESH_ENCODING_DRACO);
         h.mutable_output()->set_surface(true);
         h.mutable_constraints()->add_holes(0);
       },
       kInvalid, "output.encoding"},
      {"RuleOfAnswers",
       [](Header& h) { h.mutable_solve()->set_rule(v1::SolveOptions::RULE_FEATURE_VALUES); },
       kInvalid, "solve.rule"},
      {"FeaturesWithRule",
       [](Header& h) {
         h.mutable_solve()->set_rule(v1::SolveOptions::RULE_MODIFIED);
         h.mutable_constraints()->mutable_features();
       },
       kInvalid, "solve.rule"},
      {"FeaturesWithFairing",
       [](Header& h) {
         h.mutable_solve()->set_fair(true);
         h.mutable_constraints()->mutable_features();
       },
       kInvalid, "solve.fair"},
      {"FeaturesOfOthers",
       [](Header& h) {
         h.set_scheme(v1::SCHEME_CATMULL_CLARK);
         h.mutable_constraints()->mutable_features();
       },
       kInvalid, "constraints.features"},
      {"FeaturesOfFacesWithRepair",
       [](Header& h) {
         h.mutable_output()->set_repair(true);
         h.mutable_constraints()->mutable_features()->add_faces();
       },
       kInvalid, "output.repair"},
      {"DracoWithoutConnectivity",
       [](Header& h) {
         h.mutable_output()->set_encoding(v1::MESH_ENCODING_DRACO);
         h.mutable_output()->set_omit_connectivity(true);
       },
       kInvalid, "output.omit_connectivity"},
  };
}

INSTANTIATE_TEST_SUITE_P(Invalid, HeaderFieldTest, testing::ValuesIn(InvalidCases()),
                         [](const auto& test) { return test.param.name; });

TEST(JobSpecTest, AbsentFieldsTakeTheDefaultsOfTheContract) {
  Header header;
  header.mutable_mesh()->set_vertex_count(8);
  const absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_EQ(spec->mesh.encoding(), v1::MESH_ENCODING_PACKED);
  EXPECT_EQ(spec->engine.scheme, Scheme::kDooSabin);
  EXPECT_EQ(spec->engine.solve.method, SolveMethod::kAutomatic);
  EXPECT_EQ(spec->engine.solve.tolerance, 1e-12);
  EXPECT_EQ(spec->engine.solve.max_sweeps, 100U);
  EXPECT_FALSE(spec->engine.rule.has_value());
  EXPECT_FALSE(spec->engine.strict);
  EXPECT_FALSE(spec->engine.boundary.has_value());
  EXPECT_FALSE(spec->engine.fair);
  EXPECT_FALSE(spec->engine.chord_tolerance.has_value());
  EXPECT_FALSE(spec->engine.constraints.interpolate.has_value());
  EXPECT_TRUE(spec->engine.constraints.normals.empty());
  EXPECT_TRUE(spec->engine.constraints.shape_handles.empty());
  EXPECT_FALSE(spec->send_control_mesh);
  EXPECT_FALSE(spec->send_surface);
  EXPECT_FALSE(spec->send_normals);
  EXPECT_FALSE(spec->repair);
  EXPECT_EQ(spec->tiles.encoding, v1::MESH_ENCODING_PACKED);
  EXPECT_EQ(spec->tiles.quantization_bits, 16);
  EXPECT_EQ(spec->tiles.tile_bytes, 512U << 10);
}

TEST(JobSpecTest, GivenFieldsReachEngineAndCodec) {
  Header header = ValidHeader();
  header.mutable_constraints()->add_shape_handles()->set_value(0.4);
  header.mutable_solve()->set_method(v1::SolveOptions::METHOD_JACOBI);
  header.mutable_solve()->set_tolerance(0);
  header.mutable_solve()->set_max_sweeps(0);
  header.mutable_solve()->set_rule(v1::SolveOptions::RULE_STANDARD);
  header.mutable_solve()->set_fair(true);
  header.mutable_solve()->set_strict(true);
  header.mutable_surface()->set_level(5);
  header.mutable_output()->set_encoding(v1::MESH_ENCODING_DRACO_QUANTIZED);
  header.mutable_output()->set_quantization_bits(30);
  header.mutable_output()->set_tile_bytes(1 << 20);
  header.mutable_output()->set_repair(true);
  const absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_EQ(spec->engine.solve.method, SolveMethod::kJacobi);
  EXPECT_EQ(spec->engine.solve.tolerance, 0);
  EXPECT_EQ(spec->engine.solve.max_sweeps, 0U);
  EXPECT_EQ(spec->engine.rule, FirstRule::kStandard);
  EXPECT_EQ(RuleToProto(*spec->engine.rule), v1::SolveOptions::RULE_STANDARD);
  EXPECT_TRUE(spec->engine.strict);
  EXPECT_TRUE(spec->engine.fair);
  ASSERT_EQ(spec->engine.constraints.shape_handles.size(), 1U);
  EXPECT_EQ(spec->engine.constraints.shape_handles[0].value, 0.4);
  EXPECT_EQ(spec->engine.level, 5U);
  EXPECT_TRUE(spec->engine.normals);
  EXPECT_EQ(spec->control_mesh.encoding, v1::MESH_ENCODING_DRACO_QUANTIZED);
  EXPECT_EQ(spec->control_mesh.quantization_bits, 30);
  EXPECT_EQ(spec->tiles.encoding, v1::MESH_ENCODING_DRACO_QUANTIZED);
  EXPECT_EQ(spec->tiles.quantization_bits, 30);
  EXPECT_EQ(spec->tiles.tile_bytes, 1U << 20);
  EXPECT_TRUE(spec->repair);
}

TEST(JobSpecTest, AChordToleranceReachesTheEngineWhereASurfaceIsSent) {
  Header header = ValidHeader();
  header.mutable_surface()->set_chord_tolerance(0.25);
  absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_EQ(spec->engine.chord_tolerance, 0.25);
  header.mutable_output()->set_surface(false);
  spec = JobSpecFromProto(header);
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_FALSE(spec->engine.chord_tolerance.has_value());
  EXPECT_EQ(spec->engine.level, 0U);
}

TEST(JobSpecTest, PrescribedNormalsAreComputedWhetherTheyAreSentOrNot) {
  for (const bool surface : {false, true}) {
    Header header = ValidHeader();
    header.mutable_output()->set_surface(surface);
    header.mutable_output()->set_normals(false);
    absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
    ASSERT_TRUE(spec.ok()) << spec.status();
    EXPECT_FALSE(spec->engine.normals);
    header.mutable_constraints()->add_normals()->mutable_normal()->set_z(1);
    spec = JobSpecFromProto(header);
    ASSERT_TRUE(spec.ok()) << spec.status();
    EXPECT_TRUE(spec->engine.normals);
    EXPECT_FALSE(spec->send_normals);
  }
}

TEST(JobSpecTest, ErrorsOfTheHeaderReachTheClientWithTheirField) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  Header header = MakeHeader(1);
  header.set_scheme(v1::SCHEME_CATMULL_CLARK);
  header.mutable_surface()->set_chord_tolerance(0.1);
  call.Write(MakeUpload(header, MakeSphere(64)));
  call.WritesDone();
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kUnimplemented);
  const v1::ErrorDetails info = ErrorInfoOf(call.rich_status());
  EXPECT_EQ(info.reason(), "UNIMPLEMENTED");
  EXPECT_EQ(info.metadata().at("field"), "surface.chord_tolerance");
}

TEST(JobSpecTest, EveryNameOfTheContractReachesTheEngineAndComesBack) {
  using Solve = v1::SolveOptions;
  using Surface = v1::SurfaceOptions;
  for (const v1::Scheme scheme :
       {v1::SCHEME_DOO_SABIN, v1::SCHEME_CATMULL_CLARK, v1::SCHEME_LOOP}) {
    Header header = ValidHeader();
    header.set_scheme(scheme);
    EXPECT_EQ(SchemeToProto(JobSpecFromProto(header)->engine.scheme), scheme);
  }
  for (const Solve::Method method :
       {Solve::METHOD_CHEBYSHEV, Solve::METHOD_JACOBI, Solve::METHOD_GAUSS_SEIDEL,
        Solve::METHOD_CONJUGATE_GRADIENT, Solve::METHOD_SERIES}) {
    Header header = ValidHeader();
    header.mutable_solve()->set_method(method);
    EXPECT_EQ(MethodToProto(JobSpecFromProto(header)->engine.solve.method), method);
  }
  for (const Solve::Rule rule :
       {Solve::RULE_MODIFIED, Solve::RULE_STANDARD, Solve::RULE_BILINEAR_FIRST_STEP}) {
    Header header = ValidHeader();
    if (rule == Solve::RULE_BILINEAR_FIRST_STEP) header.set_scheme(v1::SCHEME_CATMULL_CLARK);
    header.mutable_solve()->set_rule(rule);
    EXPECT_EQ(RuleToProto(*JobSpecFromProto(header)->engine.rule), rule);
  }
  for (const auto& [name, rule] :
       {std::pair{Surface::BOUNDARY_NONE, BoundaryRule::kNone},
        {Surface::BOUNDARY_EDGE_ONLY, BoundaryRule::kEdgeOnly},
        {Surface::BOUNDARY_EDGE_AND_CORNER, BoundaryRule::kEdgeAndCorner}}) {
    Header header = ValidHeader();
    header.set_scheme(v1::SCHEME_CATMULL_CLARK);
    header.mutable_surface()->set_boundary(name);
    EXPECT_EQ(JobSpecFromProto(header)->engine.boundary, rule);
  }
}

TEST(JobSpecTest, RepairIsOffUnlessAskedFor) {
  Header header;
  header.mutable_mesh()->set_vertex_count(8);
  EXPECT_FALSE(JobSpecFromProto(header)->repair);
  header.mutable_output()->set_repair(true);
  EXPECT_TRUE(JobSpecFromProto(header)->repair);
}

}  // namespace
}  // namespace limn
