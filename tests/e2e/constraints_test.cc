// SPDX-License-Identifier: MIT
// Constraints files with the real binaries: what they ask is met, what is wrong with them is said.
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "limn/v1/interpolate.pb.h"
#include "tests/e2e/obj_file.h"
#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

constexpr const char* kConstraints =
    R"({"interpolate": {"vertices": [0, 5, 12, 77]},
        "normals": [{"vertex": 12, "normal": {"x": 0, "y": 3, "z": -4}}],
        "shapeHandles": [{"vertex": 12, "value": 0.4}, {"vertex": 13, "value": 2.5}]})";

double Distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

class ConstraintsE2e : public testing::Test {
 protected:
  ConstraintsE2e() {
    EXPECT_EQ(space_
                  .Limn({"generate", "irregular_sphere", "--vertices", "400", "--seed", "3", "-o",
                         At("given.obj")})
                  .status,
              0);
    WriteAll(At("c.json"), kConstraints);
  }

  std::string At(const std::string& name) const { return space_.path(name); }

  RunResult Interpolate(const std::vector<std::string>& flags) const {
    std::vector<std::string> arguments = {"interpolate", At("given.obj"), "-o", At("s.obj")};
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

TEST_F(ConstraintsE2e, SurfaceMeetsTheNamedVerticesAndNormalsAndNoOthers) {
  const RunResult run = Interpolate({"--constraints", At("c.json"), "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  const ObjFile given = ReadObj(At("given.obj"));
  const ObjFile surface = ReadObj(At("s.obj"));
  std::vector<std::size_t> met;
  for (std::size_t v = 0; v < given.positions.size(); ++v) {
    if (Distance(given.positions[v], surface.positions[v]) <= 1e-12 * Diagonal(given)) {
      met.push_back(v);
    }
  }
  EXPECT_EQ(met, (std::vector<std::size_t>{0, 5, 12, 77}));
  const auto& n = surface.normals[12];
  EXPECT_NEAR(std::fabs(0.6 * n[1] - 0.8 * n[2]), 1, 1e-12);
  EXPECT_NEAR(std::hypot(n[0], 0.8 * n[1] + 0.6 * n[2]), 0, 1e-6);

  const v1::Certificate certificate = Report().certificate();
  EXPECT_EQ(certificate.points_checked(), 4U);
  EXPECT_EQ(certificate.normals_checked(), 1U);
  EXPECT_LE(certificate.max_normal_deviation(), 1e-7);
  EXPECT_EQ(Report().solve().rule(), v1::SolveOptions::RULE_MODIFIED);
  for (const char* row : {"points checked         4\n", "normals checked        1\n"}) {
    EXPECT_NE(run.output.find(row), std::string::npos) << run.output;
  }
}

TEST_F(ConstraintsE2e, ServerAndEmbeddedServerGiveTheSameBytes) {
  ASSERT_EQ(Interpolate({"--constraints", At("c.json")}).status, 0);
  const std::string embedded = ReadAll(At("s.obj"));
  ServerProcess server(space_);
  const RunResult run = Interpolate({"--constraints", At("c.json"), "--server", server.address()});
  ASSERT_EQ(run.status, 0) << run.errors << server.Log();
  EXPECT_TRUE(ReadAll(At("s.obj")) == embedded);
}

TEST_F(ConstraintsE2e, EachConstraintChangesTheSurface) {
  ASSERT_EQ(Interpolate({}).status, 0);
  const std::string plain = ReadAll(At("s.obj"));
  WriteAll(At("c.json"), "{}");
  ASSERT_EQ(Interpolate({"--constraints", At("c.json")}).status, 0);
  EXPECT_TRUE(ReadAll(At("s.obj")) == plain);
  for (const std::string json : {R"({"interpolate": {"vertices": [3]}})",
                                 R"({"normals": [{"vertex": 3, "normal": {"x": 1, "y": 1}}]})",
                                 R"({"shapeHandles": [{"vertex": 3, "value": 0.4}]})"}) {
    WriteAll(At("c.json"), json);
    ASSERT_EQ(Interpolate({"--constraints", At("c.json")}).status, 0) << json;
    EXPECT_FALSE(ReadAll(At("s.obj")) == plain) << json;
  }
}

TEST_F(ConstraintsE2e, TheRuleIsTheOneThatIsNamedAndTold) {
  const RunResult run = Interpolate({"--rule", "standard", "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  EXPECT_EQ(Report().solve().rule(), v1::SolveOptions::RULE_STANDARD);
  EXPECT_NE(run.output.find("standard rule"), std::string::npos) << run.output;
  EXPECT_EQ(Report().certificate().points_checked(), 400U);
  const std::string standard = ReadAll(At("s.obj"));
  ASSERT_EQ(Interpolate({"--rule", "modified", "--report", At("r.json")}).status, 0);
  EXPECT_EQ(Report().solve().rule(), v1::SolveOptions::RULE_MODIFIED);
  EXPECT_FALSE(ReadAll(At("s.obj")) == standard);
}

struct BadFile {
  std::string name;
  std::string json;
  // Stand in the message, beside the file's name.
  std::string words;
  int status = 1;
};

void PrintTo(const BadFile& c, std::ostream* out) { *out << c.name; }

class BadConstraintsE2e : public ConstraintsE2e, public testing::WithParamInterface<BadFile> {
 protected:
  void ExpectRefused(const std::vector<std::string>& flags) {
    WriteAll(At("c.json"), GetParam().json);
    std::vector<std::string> all = {"--constraints", At("c.json"), "--report", At("r.json")};
    all.insert(all.end(), flags.begin(), flags.end());
    const RunResult run = Interpolate(all);
    EXPECT_EQ(run.status, GetParam().status) << run.output << run.errors;
    EXPECT_TRUE(run.errors.starts_with("limn: " + At("c.json") + ": ")) << run.errors;
    EXPECT_NE(run.errors.find(GetParam().words), std::string::npos) << run.errors;
    EXPECT_EQ(run.output, "");
    EXPECT_EQ(space_.Files(), (std::vector<std::string>{"c.json", "given.obj"}));
  }
};

TEST_P(BadConstraintsE2e, AreRefusedByFileAndFieldAndLeaveNothing) { ExpectRefused({}); }

TEST_P(BadConstraintsE2e, AreRefusedByTheServerWhichLivesOn) {
  ServerProcess server(space_);
  ExpectRefused({"--server", server.address()});
  EXPECT_EQ(Interpolate({"--server", server.address()}).status, 0) << server.Log();
}

std::vector<BadFile> BadFiles() {
  return {
      {"Empty", "", "no JSON"},
      {"Text", "vertex 5", "no JSON in line 1"},
      {"Unfinished", R"({"normals": [)", "no JSON at its end"},
      {"List", "[5]", "there is no object"},
      {"UnknownField", R"({"normales": []})", "normales: there is no such field"},
      {"UnknownFieldInside", R"({"normals": [{"vertexx": 1}]})",
       "normals[0].vertexx: there is no such field"},
      {"TextForVertex", R"({"normals": [{"vertex": "one"}]})",
       "normals[0].vertex: \"one\" is not a whole number"},
      {"NegativeVertex", R"({"interpolate": {"vertices": [-1]}})",
       "interpolate.vertices[0]: -1 is not a whole number"},
      {"ListForNormal", R"({"normals": [{"vertex": 1, "normal": [0, 0, 1]}]})",
       "normals[0].normal: a list does not belong here"},
      {"BareNan", R"({"shapeHandles": [{"vertex": 1, "value": NaN}]})", "'NaN}]}'"},
      {"SubsetOutOfRange", R"({"interpolate": {"vertices": [0, 400]}})",
       "constraints.interpolate.vertices[1]: there is no vertex 400, the mesh has 400"},
      {"SubsetRepeats", R"({"interpolate": {"vertices": [7, 0, 7]}})",
       "constraints.interpolate.vertices[2]: vertex 7 is named before, at index 0"},
      {"NormalOutOfRange", R"({"normals": [{"vertex": 4000, "normal": {"x": 1}}]})",
       "constraints.normals[0].vertex: there is no vertex 4000"},
      {"NormalRepeats",
       R"({"normals": [{"vertex": 4, "normal": {"x": 1}}, {"vertex": 4, "normal": {"x": 1}}]})",
       "constraints.normals[1].vertex: vertex 4 is named before"},
      {"NormalMissing", R"({"normals": [{"vertex": 4}]})",
       "constraints.normals[0].normal: it is missing"},
      {"NormalZero", R"({"normals": [{"vertex": 4, "normal": {"x": 0}}]})",
       "constraints.normals[0].normal: the normal is zero"},
      {"NormalNan", R"({"normals": [{"vertex": 4, "normal": {"x": "NaN"}}]})",
       "constraints.normals[0].normal: the normal is not finite"},
      {"NormalInfinite", R"({"normals": [{"vertex": 4, "normal": {"y": "-Infinity"}}]})",
       "constraints.normals[0].normal: the normal is not finite"},
      {"NormalElsewhere",
       R"({"interpolate": {"vertices": [1]}, "normals": [{"vertex": 4, "normal": {"x": 1}}]})",
       "constraints.normals[0].vertex: vertex 4 is not interpolated"},
      {"HandleOutOfRange", R"({"shapeHandles": [{"vertex": 400, "value": 1}]})",
       "constraints.shape_handles[0].vertex: there is no vertex 400"},
      {"HandleRepeats",
       R"({"shapeHandles": [{"vertex": 4, "value": 1}, {"vertex": 4, "value": 1}]})",
       "constraints.shape_handles[1].vertex: vertex 4 is named before"},
      {"HandleZero", R"({"shapeHandles": [{"vertex": 4}]})",
       "constraints.shape_handles[0].value: 0 is not from 0.001 to 1000"},
      {"HandleNegative", R"({"shapeHandles": [{"vertex": 4, "value": -1}]})",
       "constraints.shape_handles[0].value: -1 is not"},
      {"HandleNan", R"({"shapeHandles": [{"vertex": 4, "value": "NaN"}]})",
       "constraints.shape_handles[0].value: nan is not"},
      {"HandleInfinite", R"({"shapeHandles": [{"vertex": 4, "value": "Infinity"}]})",
       "constraints.shape_handles[0].value: inf is not"},
      {"CreasesOfDooSabin", R"({"creases": [{"vertices": [1, 2], "sharpness": [1]}]})",
       "constraints.creases: creases belong to Catmull-Clark and Loop surfaces"},
      {"SurfacePointsOfDooSabin", R"({"surfacePoints": [{"vertex": 3, "normal": {"x": 1}}]})",
       "constraints.surface_points: constraints anywhere on the surface belong to Catmull-Clark"},
      {"FeatureFace", R"({"features": {"faces": [{"face": 9999}]}})",
       "constraints.features.faces[0].face: there is no face 9999"},
      {"FeatureValue", R"({"features": {"defaultEdge": 1.5}})",
       "constraints.features.default_edge: 1.5 is not a number from 0 to 1"},
  };
}

INSTANTIATE_TEST_SUITE_P(Files, BadConstraintsE2e, testing::ValuesIn(BadFiles()),
                         [](const auto& file) { return file.param.name; });

// A cube, of valence 3 everywhere, so that half of the first refinement is bilinear.
TEST_F(ConstraintsE2e, CreasesCornersAndHolesReachCatmullClark) {
  WriteAll(At("cube.obj"),
           "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
           "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  WriteAll(At("sharp.json"),
           R"({"creases": [{"vertices": [0, 1, 2], "sharpness": [10]}],
               "corners": [{"vertex": 6, "sharpness": 2.5}], "holes": [5]})");
  const RunResult run =
      space_.Limn({"interpolate", At("cube.obj"), "--scheme", "catmull-clark", "--constraints",
                   At("sharp.json"), "--level", "1", "-o", At("s.obj"), "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  const ObjFile surface = ReadObj(At("s.obj"));
  // Five faces of four quads each; all vertices stay, as the contract numbers them.
  EXPECT_EQ(surface.faces.size(), 20U);
  ASSERT_EQ(surface.positions.size(), 26U);
  const ObjFile given = ReadObj(At("cube.obj"));
  for (std::size_t v = 0; v < 8; ++v) {
    EXPECT_LE(Distance(given.positions[v], surface.positions[v]), 1e-11);
  }
  const v1::Summary summary = Report();
  EXPECT_EQ(summary.scheme(), v1::SCHEME_CATMULL_CLARK);
  EXPECT_EQ(summary.surface_faces(), 20U);
  EXPECT_LE(summary.certificate().max_error(), 1e-11);
  const RunResult bad = space_.Limn({"interpolate", At("cube.obj"), "--scheme", "catmull-clark",
                                     "--strict", "-o", At("bad.obj")});
  EXPECT_EQ(bad.status, 1);
  EXPECT_NE(bad.errors.find("--strict"), std::string::npos) << bad.errors;
}

// The point is checked by evaluation in another run, from the same files.
TEST_F(ConstraintsE2e, PointsAndNormalsOnTheSurfaceAreMet) {
  for (const std::string scheme : {"catmull-clark", "loop"}) {
    const std::string kind = scheme == "loop" ? "torus" : "irregular_sphere";
    ASSERT_EQ(space_.Limn({"generate", kind, "--vertices", "400", "-o", At("t.stl")}).status, 0);
    // STL is made of triangles.
    const std::string input = scheme == "loop" ? At("t.stl") : At("given.obj");
    WriteAll(At("p.json"),
             R"({"surfacePoints": [
                  {"parameter": {"face": 2, "corner": 1, "u": 0.4, "v": 0.5},
                   "point": {"x": 0.25, "y": 0.5, "z": 0.125}, "normal": {"x": 1, "z": 2}},
                  {"vertex": 200, "normal": {"y": 3}}]})");
    WriteAll(At("at.txt"), "2 1 0.4 0.5\n");
    const RunResult run = space_.Limn({"interpolate", input, "--scheme", scheme, "--constraints",
                                       At("p.json"), "-o", At("s.obj"), "--report", At("r.json")});
    ASSERT_EQ(run.status, 0) << run.errors;
    EXPECT_NE(run.output.find("met on the surface"), std::string::npos) << run.output;
    const v1::Summary summary = Report();
    EXPECT_EQ(summary.blend().constraints(), 2U);
    EXPECT_GT(summary.blend().moved_points(), 0U);
    EXPECT_LE(summary.blend().max_point_error(), 1e-10);
    EXPECT_LE(summary.blend().max_normal_deviation(), 1e-10);
    EXPECT_LE(summary.certificate().max_error(), 1e-10);
    EXPECT_NEAR(std::fabs(ReadObj(At("s.obj")).normals[200][1]), 1, 1e-6);
    const RunResult at = space_.Limn({"evaluate", input, "--scheme", scheme, "--constraints",
                                      At("p.json"), "--at", At("at.txt"), "--format", "csv"});
    ASSERT_EQ(at.status, 0) << at.errors;
    double numbers[10] = {};
    const std::string line = at.output.substr(at.output.find('\n') + 1);
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", numbers,
                          numbers + 1, numbers + 2, numbers + 3, numbers + 4, numbers + 5,
                          numbers + 6, numbers + 7, numbers + 8, numbers + 9),
              10)
        << at.output;
    EXPECT_NEAR(numbers[4], 0.25, 1e-10);
    EXPECT_NEAR(numbers[5], 0.5, 1e-10);
    EXPECT_NEAR(numbers[6], 0.125, 1e-10);
    EXPECT_NEAR(std::fabs(numbers[9] / numbers[7]), 2, 1e-9);
  }
}

TEST_F(ConstraintsE2e, AFilterSmoothsTheMesh) {
  const RunResult same = space_.Limn({"filter", At("given.obj"), "--gains", "1,1", "--rest", "1",
                                      "--control-mesh", At("same.obj")});
  ASSERT_EQ(same.status, 0) << same.errors;
  const RunResult smooth =
      space_.Limn({"filter", At("given.obj"), "--gains", "1", "--scheme", "catmull-clark",
                   "--control-mesh", At("smooth.obj"), "-o", At("s.obj"), "--level", "1"});
  ASSERT_EQ(smooth.status, 0) << smooth.errors;
  const ObjFile given = ReadObj(At("given.obj"));
  const ObjFile kept = ReadObj(At("same.obj"));
  const ObjFile smoothed = ReadObj(At("smooth.obj"));
  double moved = 0;
  for (std::size_t v = 0; v < given.positions.size(); ++v) {
    EXPECT_LE(Distance(given.positions[v], kept.positions[v]), 1e-14 * Diagonal(given));
    moved = std::max(moved, Distance(given.positions[v], smoothed.positions[v]));
  }
  EXPECT_GT(moved, 1e-3 * Diagonal(given));
  EXPECT_GT(ReadObj(At("s.obj")).positions.size(), given.positions.size());
  const RunResult none = space_.Limn({"filter", At("given.obj"), "-o", At("s.obj")});
  EXPECT_EQ(none.status, 2);
  EXPECT_NE(none.errors.find("--gains"), std::string::npos) << none.errors;
  const RunResult subset = space_.Limn({"filter", At("given.obj"), "--gains", "1", "--constraints",
                                        At("c.json"), "-o", At("s.obj")});
  EXPECT_EQ(subset.status, 1);
  EXPECT_NE(subset.errors.find("constraints.interpolate"), std::string::npos) << subset.errors;
}

TEST_F(ConstraintsE2e, AChordToleranceChoosesTheLevelAndSaysWhatIsGuaranteed) {
  std::uint32_t last = 0;
  for (const std::string tolerance : {"0.5", "0.05", "0.01"}) {
    const RunResult run = Interpolate({"--chord-tolerance", tolerance, "--report", At("r.json")});
    ASSERT_EQ(run.status, 0) << run.errors;
    EXPECT_NE(run.output.find("from the surface"), std::string::npos) << run.output;
    const v1::Summary summary = Report();
    EXPECT_GT(summary.chord_bound(), 0);
    EXPECT_LE(summary.chord_bound(), std::stod(tolerance));
    EXPECT_GE(summary.level(), last);
    last = summary.level();
  }
  EXPECT_GE(last, 2U);
  const RunResult impossible = Interpolate({"--chord-tolerance", "1e-9", "--report", At("r.json")});
  EXPECT_NE(impossible.status, 0);
  EXPECT_NE(impossible.errors.find("The smallest tolerance that can be met is"), std::string::npos)
      << impossible.errors;
  for (const std::string bad : {"0", "-1", "nan", "inf", "x"}) {
    EXPECT_EQ(Interpolate({"--chord-tolerance", bad}).status, 2) << bad;
  }
  EXPECT_EQ(Interpolate({"--chord-tolerance", "1", "--level", "2"}).status, 2);
}

TEST_F(ConstraintsE2e, FilesThatCannotBeReadAreNamed) {
  for (const std::string name : {"nowhere.json", "."}) {
    const RunResult run = Interpolate({"--constraints", At(name)});
    EXPECT_EQ(run.status, 1) << run.errors;
    EXPECT_NE(run.errors.find(At(name)), std::string::npos) << run.errors;
  }
  EXPECT_EQ(space_.Files(), (std::vector<std::string>{"c.json", "given.obj"}));
}

TEST_F(ConstraintsE2e, TheConstraintsFileIsNeverWrittenOver) {
  const RunResult run = Interpolate({"--constraints", At("c.json"), "--report", At("c.json")});
  EXPECT_EQ(run.status, 2) << run.errors;
  EXPECT_EQ(ReadAll(At("c.json")), kConstraints);
}

TEST_F(ConstraintsE2e, MoreThanAServerTakesInAMessageIsSaidSo) {
  std::string json = R"({"interpolate": {"vertices": [)";
  for (int i = 0; i < 2'300'000; ++i) json += "1,";
  WriteAll(At("c.json"), json + "1]}}");
  ServerProcess server(space_);
  const RunResult run = Interpolate({"--constraints", At("c.json"), "--server", server.address()});
  EXPECT_EQ(run.status, 3) << run.errors;
  for (const char* word : {"c.json", "larger than max", "--max-message-bytes"}) {
    EXPECT_NE(run.errors.find(word), std::string::npos) << run.errors;
  }
  EXPECT_EQ(Interpolate({"--server", server.address()}).status, 0) << server.Log();
}

}  // namespace
}  // namespace limn::e2e
