// SPDX-License-Identifier: MIT
// Constraints files: what they hold arrives; what is wrong is said with file, field and place.
#include "client/cli/constraints_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/base/error.h"

namespace limn::cli {
namespace {

TEST(ConstraintsFileTest, HoldsSubsetNormalsAndHandles) {
  const auto got = ParseConstraints(
      R"({"interpolate": {"vertices": [0, 5]},
          "normals": [{"vertex": 12, "normal": {"x": 0, "y": -0.5, "z": 1e-3}}],
          "shapeHandles": [{"vertex": 12, "value": 0.4}, {"vertex": 3, "value": 2.5}]})",
      "c.json");
  ASSERT_TRUE(got.ok()) << got.status();
  ASSERT_EQ(got->interpolate().vertices_size(), 2);
  EXPECT_EQ(got->interpolate().vertices(1), 5U);
  ASSERT_EQ(got->normals_size(), 1);
  EXPECT_EQ(got->normals(0).vertex(), 12U);
  EXPECT_EQ(got->normals(0).normal().x(), 0);
  EXPECT_EQ(got->normals(0).normal().y(), -0.5);
  EXPECT_EQ(got->normals(0).normal().z(), 1e-3);
  ASSERT_EQ(got->shape_handles_size(), 2);
  EXPECT_EQ(got->shape_handles(1).vertex(), 3U);
  EXPECT_EQ(got->shape_handles(1).value(), 2.5);
}

TEST(ConstraintsFileTest, TakesTheNamesOfTheContractToo) {
  const auto got = ParseConstraints(R"({"shape_handles": [{"value": 2}]})", "c.json");
  ASSERT_TRUE(got.ok()) << got.status();
  EXPECT_EQ(got->shape_handles_size(), 1);
}

TEST(ConstraintsFileTest, AnEmptyObjectAsksNothing) {
  const auto got = ParseConstraints("{}", "c.json");
  ASSERT_TRUE(got.ok()) << got.status();
  EXPECT_FALSE(got->has_interpolate());
}

// What JSON cannot say is said as a string, as the JSON mapping has it; the server refuses it.
TEST(ConstraintsFileTest, NumbersThatAreNotFiniteAreHandedOn) {
  const auto got =
      ParseConstraints(R"({"shapeHandles": [{"value": "NaN"}, {"value": "-Infinity"}]})", "c.json");
  ASSERT_TRUE(got.ok()) << got.status();
  EXPECT_TRUE(std::isnan(got->shape_handles(0).value()));
  EXPECT_EQ(got->shape_handles(1).value(), -INFINITY);
}

struct BadText {
  std::string name;
  std::string json;
  // Stand in the message.
  std::vector<std::string> words;
};

void PrintTo(const BadText& c, std::ostream* out) { *out << c.name; }

class BadTextTest : public testing::TestWithParam<BadText> {};

TEST_P(BadTextTest, IsRefusedWithFileFieldAndPlace) {
  const auto got = ParseConstraints(GetParam().json, "dir/c.json");
  ASSERT_FALSE(got.ok());
  const auto detail = GetErrorDetail(got.status());
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, Reason::kMalformedFile);
  const std::string message(got.status().message());
  EXPECT_TRUE(message.starts_with("dir/c.json: ")) << message;
  EXPECT_LT(message.size(), 300U);
  for (const std::string& word : GetParam().words) {
    EXPECT_NE(message.find(word), std::string::npos) << word << " in: " << message;
  }
}

std::vector<BadText> BadTexts() {
  return {
      {"UnknownField",
       R"({"colour": 1})",
       {"dir/c.json: constraints.colour: there is no such field"}},
      {"UnknownFieldInside",
       R"({"normals": [{"vertex": 1}, {"vertx": 2}]})",
       {"normals[1].vertx: there is no such field"}},
      {"UnknownFieldDeeper",
       R"({"normals": [{"normal": {"w": 2}}]})",
       {"normals[0].normal.w: there is no such field"}},
      {"TextForVertex",
       R"({"normals": [{"vertex": "a"}]})",
       {"normals[0].vertex: \"a\" is not a whole number from 0 to 4294967295"}},
      {"NegativeVertex",
       R"({"interpolate": {"vertices": [3, -1]}})",
       {"interpolate.vertices[1]: -1 is not a whole number"}},
      {"FractionForVertex",
       R"({"shapeHandles": [{"vertex": 1.5}]})",
       {"shape_handles[0].vertex: 1.5 is not a whole number"}},
      {"VertexBeyond32Bits",
       R"({"interpolate": {"vertices": [4294967296]}})",
       {"interpolate.vertices[0]: 4294967296 is not a whole number"}},
      {"TruthForVertex",
       R"({"normals": [{"vertex": true}]})",
       {"normals[0].vertex: true is not a whole number"}},
      {"TextForHandle",
       R"({"shapeHandles": [{"value": "x"}]})",
       {"shape_handles[0].value: \"x\" is not a number"}},
      {"NumberForNormal",
       R"({"normals": [{"vertex": 1, "normal": 5}]})",
       {"normals[0].normal: 5 is not an object"}},
      {"ListForNormal",
       R"({"normals": [{"vertex": 1, "normal": [0, 0, 1]}]})",
       {"normals[0].normal: a list does not belong here"}},
      {"ListForInterpolate", R"({"interpolate": [0, 5]})", {"interpolate: a list does not belong"}},
      {"UnknownName",
       R"({"features": {"defaultFace": "FLAT"}})",
       {"dir/c.json: constraints.features.default_face: \"FLAT\" is none of "
        "FACE_KIND_UNSPECIFIED, FACE_KIND_PLANE, FACE_KIND_SURFACE"}},
      {"NumberForEntry", R"({"normals": [7]})", {"normals[0]: 7 is not an object"}},
      {"List", "[1, 2]", {"there is no object"}},
      {"Null", "null", {"there is no object"}},
      {"Number", "5", {"there is no object"}},
      {"Empty", "", {"no JSON at its end: Unexpected end"}},
      {"Blank", " \n ", {"no JSON at its end: Unexpected end"}},
      {"Unfinished", R"({"normals": [)", {"no JSON at its end: Unexpected end"}},
      {"BareNan",
       "{\n\"shapeHandles\":\n[{\"value\": NaN}]}",
       {"no JSON in line 3 at 'NaN}]}'", "Unexpected token"}},
      {"BareInfinity", R"({"shapeHandles": [{"value": Infinity}]})", {"line 1 at 'Infinity}]}'"}},
      {"OverflowingNumber", R"({"shapeHandles": [{"value": 1e999}]})", {"range of double"}},
      {"Comment", "{} // none", {"line 1 at '// none'"}},
      {"TwoObjects", "{}\n{}", {"line 2 at '{}'"}},
      {"MissingComma",
       "{\"normals\": [{\"vertex\": 1,\n \"normal\": {\"x\": 1 \"y\": 2}}]}",
       {"line 2 at '\"y\": 2}}]}'", "Expected , or }"}},
      {"NotUtf8", "\xff\xfe{}", {"UTF-8"}},
      {"TooDeep",
       [] {
         std::string deep;
         for (int i = 0; i < 10'000; ++i) deep += "{\"interpolate\":";
         return deep;
       }(),
       {"too deep"}},
      {"DeepList", std::string(100'000, '['), {"dir/c.json"}},
      {"LongValue",
       "{\"normals\": [{\"vertex\": \"" + std::string(100'000, 'x') + "\"}]}",
       {"normals[0].vertex: \"xxx", "... is not a whole number"}},
      {"LongName", "{\"" + std::string(100'000, 'x') + "\": 1}", {"...: there is no such field"}},
  };
}

INSTANTIATE_TEST_SUITE_P(Texts, BadTextTest, testing::ValuesIn(BadTexts()),
                         [](const auto& test) { return test.param.name; });

TEST(ConstraintsFileTest, FilesThatAreNotThereOrNoFilesAreNamed) {
  for (const std::string path : {"/no/such/c.json", "/tmp"}) {
    const auto got = ReadConstraintsFile(path);
    ASSERT_FALSE(got.ok());
    EXPECT_NE(std::string(got.status().message()).find(path), std::string::npos) << got.status();
  }
}

TEST(ConstraintsFileTest, AFileThatNeverEndsIsRefused) {
  const auto got = ReadConstraintsFile("/dev/zero");
  ASSERT_FALSE(got.ok());
  EXPECT_NE(std::string(got.status().message()).find("/dev/zero: it is larger than 268435456"),
            std::string::npos)
      << got.status();
}

TEST(NameConstraintsFileTest, NamesTheFileWhereTheConstraintsAreWrongAndKeepsTheRest) {
  const absl::Status wrong = MakeError("constraints.normals[3].vertex: there is no vertex 9",
                                       {.reason = Reason::kIndexOutOfRange,
                                        .field = "constraints.normals[3].vertex",
                                        .index = 3,
                                        .remedy = "Count from 0"});
  const absl::Status named = NameConstraintsFile(wrong, "c.json");
  EXPECT_EQ(named.code(), wrong.code());
  EXPECT_EQ(named.message(),
            "c.json: constraints.normals[3].vertex: there is no vertex 9. Count from 0");
  EXPECT_EQ(GetErrorDetail(named)->field, "constraints.normals[3].vertex");
  EXPECT_EQ(GetErrorDetail(named)->index, 3U);
  EXPECT_EQ(NameConstraintsFile(wrong, ""), wrong);
}

TEST(NameConstraintsFileTest, LeavesOtherErrorsAlone) {
  const absl::Status mesh =
      MakeError("no manifold", {.reason = Reason::kNonManifoldEdge, .field = "mesh.faces"});
  EXPECT_EQ(NameConstraintsFile(mesh, "c.json"), mesh);
  EXPECT_TRUE(NameConstraintsFile(absl::OkStatus(), "c.json").ok());
}

TEST(NameConstraintsFileTest, SaysThatTheyAreTooManyForOneMessage) {
  const absl::Status refused =
      absl::ResourceExhaustedError("Received message larger than max (3000000 vs. 2097152)");
  const std::string message(NameConstraintsFile(refused, "c.json").message());
  EXPECT_TRUE(message.starts_with("c.json: ")) << message;
  EXPECT_NE(message.find("--max-message-bytes"), std::string::npos) << message;
}

}  // namespace
}  // namespace limn::cli
