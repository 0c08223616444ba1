// SPDX-License-Identifier: MIT
// Feature values with the real binaries: a cube with a plane face and sharp edges.
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "limn/v1/interpolate.pb.h"
#include "tests/e2e/obj_file.h"
#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

// Face 1 is z = 1.
constexpr const char* kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

// A plane face, an edge that is sharp in one face only, a vertex that is sharp in all.
constexpr const char* kFeatures =
    R"({"defaultEdge": 0.4, "defaultVertex": 1,
        "faces": [{"face": 1, "kind": "FACE_KIND_PLANE"}],
        "edges": [{"from": 1, "to": 0, "face": 0, "value": 0}],
        "vertices": [{"vertex": 3, "value": 0}]})";

class FeaturesE2e : public testing::Test {
 protected:
  FeaturesE2e() {
    WriteAll(At("cube.obj"), kCube);
    WriteAll(At("f.json"), kFeatures);
    WriteAll(At("c.json"), std::string(R"({"features": )") + kFeatures + "}");
  }

  std::string At(const std::string& name) const { return space_.path(name); }

  RunResult Features(const std::vector<std::string>& flags) const {
    std::vector<std::string> arguments = {"features", At("cube.obj"), "--features", At("f.json")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return space_.Limn(arguments);
  }

  v1::Summary Report() const {
    v1::Summary summary;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(ReadAll(At("r.json")), &summary).ok());
    return summary;
  }

  Workspace space_;
};

TEST_F(FeaturesE2e, MakeAPlaneRegionAndASharpVertex) {
  const RunResult run = Features(
      {"--level", "3", "-o", At("s.obj"), "--control-mesh", At("m.obj"), "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  EXPECT_NE(run.output.find("by feature values"), std::string::npos) << run.output;
  const ObjFile surface = ReadObj(At("s.obj"));
  ASSERT_EQ(surface.faces.size(), 24U * 16);
  ASSERT_EQ(surface.positions.size(), 24U * 16 + 2);
  // The quads of face 1, corners 4 to 7.
  for (std::size_t q = 4 * 16; q < 8 * 16; ++q) {
    for (const long v : surface.faces[q]) {
      EXPECT_NEAR(surface.positions[static_cast<std::size_t>(v)][2], 1, 1e-12);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(surface.positions[3][i], i == 1 ? 1 : 0, 1e-15);
  }
  // The given mesh is the control mesh.
  EXPECT_EQ(ReadObj(At("m.obj")).positions, ReadObj(At("cube.obj")).positions);
  const v1::Summary summary = Report();
  EXPECT_EQ(summary.solve().rule(), v1::SolveOptions::RULE_FEATURE_VALUES);
  EXPECT_EQ(summary.solve().sweeps(), 0U);
  EXPECT_EQ(summary.certificate().points_checked(), 0U);
}

TEST_F(FeaturesE2e, TheyAreTheSameWithinConstraintsAndAtAServer) {
  ASSERT_EQ(Features({"--level", "2", "-o", At("s.obj")}).status, 0);
  const std::string alone = ReadAll(At("s.obj"));
  const std::vector<std::string> within = {"interpolate", At("cube.obj"), "--constraints",
                                           At("c.json"),  "--level",      "2",
                                           "-o",          At("t.obj")};
  ASSERT_EQ(space_.Limn(within).status, 0);
  EXPECT_TRUE(ReadAll(At("t.obj")) == alone);
  ServerProcess server(space_);
  const RunResult run = Features({"--level", "2", "-o", At("u.obj"), "--server", server.address()});
  ASSERT_EQ(run.status, 0) << run.errors << server.Log();
  EXPECT_TRUE(ReadAll(At("u.obj")) == alone);
}

TEST_F(FeaturesE2e, InterpolatedVerticesAreMetAndCertified) {
  WriteAll(At("c.json"),
           std::string(R"({"interpolate": {"vertices": [2, 5]}, "features": )") + kFeatures + "}");
  const RunResult run = space_.Limn({"interpolate", At("cube.obj"), "--constraints", At("c.json"),
                                     "-o", At("s.obj"), "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  EXPECT_EQ(Report().certificate().points_checked(), 2U);
  EXPECT_LE(Report().certificate().max_error(), 1e-12);
}

TEST_F(FeaturesE2e, TheSurfaceCanBeEvaluated) {
  WriteAll(At("p.txt"), "1 0 0.5 0.25\n1 2 1 1\n1 3 0 0.5\n0 3 0 0\n");
  const RunResult run = space_.Limn(
      {"evaluate", At("cube.obj"), "--constraints", At("c.json"), "--at", At("p.txt"), "--quiet"});
  ASSERT_EQ(run.status, 0) << run.errors;
  std::istringstream lines(run.output);
  std::string line;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(std::getline(lines, line)) << run.output;
    double x = 0;
    double y = 0;
    double z = 0;
    std::istringstream(line) >> x >> y >> z;
    EXPECT_NEAR(z, 1, 1e-12) << line;
  }
}

TEST_F(FeaturesE2e, ChordTolerancesChooseALevel) {
  const RunResult run =
      Features({"--chord-tolerance", "0.01", "-o", At("s.obj"), "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  EXPECT_LE(Report().chord_bound(), 0.01);
  EXPECT_GE(Report().level(), 2U);
}

TEST_F(FeaturesE2e, WhatIsWrongIsSaidWithFileAndField) {
  const auto errors = [&](const std::string& json, int status,
                          const std::vector<std::string>& flags = {}) {
    WriteAll(At("f.json"), json);
    std::vector<std::string> arguments = {"-o", At("s.obj")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const RunResult run = Features(arguments);
    EXPECT_EQ(run.status, status) << run.errors;
    return run.errors;
  };
  const auto expect = [&](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  expect(errors("[1]", 1), "f.json: there is no object");
  expect(errors(R"({"edgs": []})", 1), "f.json: constraints.features.edgs: there is no such field");
  expect(errors(R"({"faces": [{"face": 1, "kind": "FLAT"}]})", 1),
         "f.json: constraints.features.faces[0].kind: \"FLAT\" is none of FACE_KIND_UNSPECIFIED, "
         "FACE_KIND_PLANE, FACE_KIND_SURFACE");
  expect(errors(R"({"edges": [7]})", 1), "7 is not an object");
  expect(errors(R"({"vertices": [{"vertex": 3}]})", 1),
         "f.json: constraints.features.vertices[0].value: it is missing");
  expect(errors(R"({"edges": [{"from": 0, "to": 6, "value": 0.1}]})", 1),
         "f.json: constraints.features.edges[0].to: no edge joins vertices 0 and 6");
  expect(errors(R"({"vertices": [{"vertex": 0, "value": "NaN"}]})", 1),
         "constraints.features.vertices[0].value: nan is not a number from 0 to 1");
  expect(errors(kFeatures, 2, {"--repair"}), "--repair: repair gives faces other numbers");
  EXPECT_EQ(space_.Limn({"features", At("cube.obj"), "-o", At("s.obj")}).status, 2);
  EXPECT_EQ(Features({"-o", At("s.obj"), "--scheme", "loop"}).status, 2);
  // A file that is not there.
  EXPECT_EQ(space_.Limn({"features", At("cube.obj"), "--features", At("none.json")}).status, 1);
}

}  // namespace
}  // namespace limn::e2e
