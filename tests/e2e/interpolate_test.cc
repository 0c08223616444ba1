// SPDX-License-Identifier: MIT
// The main job with the real binaries: file in, server over loopback, files out.
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "limn/v1/interpolate.pb.h"
#include "tests/e2e/obj_file.h"
#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

class InterpolateE2e : public testing::Test {
 protected:
  // Makes a mesh by code and returns its path.
  std::string Generate(const std::string& kind, const std::string& vertices) const {
    std::string path = space_.path("given.obj");
    const RunResult run =
        space_.Limn({"generate", kind, "--vertices", vertices, "--seed", "7", "-o", path});
    EXPECT_EQ(run.status, 0) << run.errors;
    return path;
  }
  std::string At(const std::string& name) const { return space_.path(name); }

  Workspace space_;
};

void ExpectInterpolates(const ObjFile& given, const ObjFile& surface) {
  EXPECT_LE(LargestDistance(given, surface), 1e-12 * Diagonal(given));
}

// Every kind of closed mesh, through the server.
class EveryKindE2e : public InterpolateE2e, public testing::WithParamInterface<const char*> {};

TEST_P(EveryKindE2e, SurfacePassesThroughEveryGivenVertexInOrder) {
  ServerProcess server(space_);
  const std::string given_path = Generate(GetParam(), "1000");
  const RunResult run = space_.Limn({"interpolate", given_path, "--server", server.address(), "-o",
                                     At("s.obj"), "--control-mesh", At("c.obj")});
  ASSERT_EQ(run.status, 0) << run.errors << server.Log();

  const ObjFile given = ReadObj(given_path);
  const ObjFile surface = ReadObj(At("s.obj"));
  const ObjFile control = ReadObj(At("c.obj"));
  ExpectInterpolates(given, surface);
  EXPECT_EQ(control.faces, given.faces);
  EXPECT_EQ(control.positions.size(), given.positions.size());
  // Two refinements: each face of m sides becomes m quads, each of them four.
  std::size_t corners = 0;
  for (const auto& face : given.faces) corners += face.size();
  EXPECT_EQ(surface.faces.size(), 4 * corners);
  for (const auto& face : surface.faces) ASSERT_EQ(face.size(), 4U);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryKindE2e,
                         testing::Values("irregular_sphere", "torus", "high_genus", "hub", "ngons",
                                         "cube"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST_F(InterpolateE2e, VerticesAreInterpolatedWhateverTheSolverAndItsTolerance) {
  const std::string given_path = Generate("irregular_sphere", "500");
  const ObjFile given = ReadObj(given_path);
  const std::vector<std::vector<std::string>> variants = {
      {"--tolerance", "0.5"},       {"--max-sweeps", "0"}, {"--solver", "jacobi"}, {"--level", "0"},
      {"--solver", "gauss-seidel"}, {"--level", "3"},      {"--encoding", "draco"}};
  for (const auto& variant : variants) {
    std::vector<std::string> arguments = {"interpolate", given_path, "-o", At("s.obj")};
    arguments.insert(arguments.end(), variant.begin(), variant.end());
    const RunResult run = space_.Limn(arguments);
    ASSERT_EQ(run.status, 0) << variant[0] << " " << variant[1] << ": " << run.errors;
    SCOPED_TRACE(variant[0] + " " + variant[1]);
    ExpectInterpolates(given, ReadObj(At("s.obj")));
  }
}

TEST_F(InterpolateE2e, ServerAndEmbeddedServerAndAnyNumberOfThreadsGiveTheSameBytes) {
  ServerProcess server(space_);
  const std::string given = Generate("irregular_sphere", "3000");
  const std::vector<std::vector<std::string>> ways = {
      {"--server", server.address()}, {}, {"--threads", "1"}, {"--threads", "2"}};
  std::vector<std::string> surfaces;
  for (const auto& way : ways) {
    std::vector<std::string> arguments = {"interpolate", given, "-o", At("s.obj")};
    arguments.insert(arguments.end(), way.begin(), way.end());
    const RunResult run = space_.Limn(arguments);
    ASSERT_EQ(run.status, 0) << run.errors << server.Log();
    surfaces.push_back(ReadAll(At("s.obj")));
  }
  for (const std::string& surface : surfaces) EXPECT_TRUE(surface == surfaces[0]);
}

// Without sweeps the control points are the given points, so a mesh goes through reader, both
// encoders, both decoders and writer.
TEST_F(InterpolateE2e, ObjKeepsSeventeenDigitsThroughTheWholeWay) {
  const std::string text =
      "v 0.1 0.2 0.30000000000000004\nv 1 1e-17 3.3333333333333335\nv -1.7976931348623157e+30 5 6\n"
      "v 123456789.01234567 -0.1 2.2250738585072014e-308\n"
      "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n";
  WriteAll(At("in.obj"), text);
  for (const std::string encoding : {"packed", "draco"}) {
    const RunResult run =
        space_.Limn({"interpolate", At("in.obj"), "--max-sweeps", "0", "-o", At("s.obj"),
                     "--encoding", encoding, "--control-mesh", At("c.obj")});
    ASSERT_EQ(run.status, 0) << run.errors;
    const ObjFile in = ReadObj(At("in.obj"));
    const ObjFile control = ReadObj(At("c.obj"));
    EXPECT_EQ(control.positions, in.positions) << encoding;
    EXPECT_EQ(control.faces, in.faces) << encoding;
  }
}

TEST_F(InterpolateE2e, ObjHasAUnitNormalForEveryVertex) {
  const std::string given = Generate("torus", "400");
  ASSERT_EQ(space_.Limn({"interpolate", given, "-o", At("s.obj")}).status, 0);
  const ObjFile surface = ReadObj(At("s.obj"));
  ASSERT_EQ(surface.normals.size(), surface.positions.size());
  for (const auto& n : surface.normals) {
    ASSERT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-6);
  }
}

TEST_F(InterpolateE2e, ReportIsTheSummaryInJson) {
  const std::string given_path = Generate("irregular_sphere", "2000");
  const RunResult run =
      space_.Limn({"interpolate", given_path, "-o", At("s.obj"), "--report", At("report.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  v1::Summary summary;
  const auto parsed =
      google::protobuf::util::JsonStringToMessage(ReadAll(At("report.json")), &summary);
  ASSERT_TRUE(parsed.ok()) << ReadAll(At("report.json"));

  const ObjFile given = ReadObj(given_path);
  const ObjFile surface = ReadObj(At("s.obj"));
  EXPECT_EQ(summary.input_vertices(), given.positions.size());
  EXPECT_EQ(summary.input_faces(), given.faces.size());
  EXPECT_EQ(summary.surface_vertices(), surface.positions.size());
  EXPECT_EQ(summary.surface_faces(), surface.faces.size());
  EXPECT_EQ(summary.certificate().points_checked(), given.positions.size());
  EXPECT_NEAR(summary.certificate().bounding_box_diagonal(), Diagonal(given), 1e-12);
  EXPECT_NEAR(summary.certificate().max_error(), LargestDistance(given, surface), 1e-15);
  EXPECT_TRUE(summary.certificate().after_encoding());
  EXPECT_TRUE(summary.solve().converged());
  EXPECT_GE(summary.solve().sweeps(), 1U);
  EXPECT_LE(summary.solve().sweeps(), 18U);
  EXPECT_GT(summary.bytes_received(), 0U);
  EXPECT_GT(summary.bytes_sent(), summary.bytes_received());
  EXPECT_GT(summary.stages_size(), 4);
}

TEST_F(InterpolateE2e, TheCertificateTellsWhatQuantisationCosts) {
  const std::string given_path = Generate("irregular_sphere", "1000");
  const RunResult run =
      space_.Limn({"interpolate", given_path, "-o", At("s.obj"), "--report", At("report.json"),
                   "--encoding", "draco-quantized", "--quantization-bits", "12"});
  ASSERT_EQ(run.status, 0) << run.errors;
  v1::Summary summary;
  ASSERT_TRUE(
      google::protobuf::util::JsonStringToMessage(ReadAll(At("report.json")), &summary).ok());
  const ObjFile given = ReadObj(given_path);
  const double measured = LargestDistance(given, ReadObj(At("s.obj")));
  EXPECT_GT(measured, 1e-8 * Diagonal(given));
  EXPECT_LT(measured, 1e-3 * Diagonal(given));
  EXPECT_NEAR(summary.certificate().max_error(), measured, 1e-6 * Diagonal(given));
}

TEST_F(InterpolateE2e, OneRunWritesSeveralFormats) {
  const std::string given = Generate("cube", "200");
  const RunResult run = space_.Limn({"interpolate", given, "-o", At("s.obj"), "-o", At("s.glb"),
                                     "-o", At("s.ply"), "-o", At("s.off"), "--level", "1"});
  ASSERT_EQ(run.status, 0) << run.errors;
  EXPECT_EQ(space_.Files(),
            (std::vector<std::string>{"given.obj", "s.glb", "s.obj", "s.off", "s.ply"}));
  EXPECT_EQ(ReadAll(At("s.glb")).substr(0, 4), "glTF");
}

TEST_F(InterpolateE2e, EveryFormatThatIsWrittenIsReadAgain) {
  for (const std::string extension : {"obj", "off", "ply", "stl"}) {
    const std::string given = At("given." + extension);
    const RunResult made =
        space_.Limn({"generate", "irregular_sphere", "--vertices", "300", "-o", given});
    ASSERT_EQ(made.status, 0) << extension << ": " << made.errors;
    const RunResult run = space_.Limn({"interpolate", given, "-o", At("s." + extension)});
    EXPECT_EQ(run.status, 0) << extension << ": " << run.errors;
  }
}

TEST_F(InterpolateE2e, TwoRunsGiveTheSameFilesAndReplaceThem) {
  const std::string given = Generate("ngons", "400");
  const std::vector<std::string> arguments = {"interpolate",    given,      "-o", At("s.obj"),
                                              "--control-mesh", At("c.obj")};
  ASSERT_EQ(space_.Limn(arguments).status, 0);
  const std::string surface = ReadAll(At("s.obj"));
  const std::string control = ReadAll(At("c.obj"));
  WriteAll(At("s.obj"), "something older");
  ASSERT_EQ(space_.Limn(arguments).status, 0);
  EXPECT_TRUE(ReadAll(At("s.obj")) == surface);
  EXPECT_TRUE(ReadAll(At("c.obj")) == control);
  EXPECT_EQ(space_.Files(), (std::vector<std::string>{"c.obj", "given.obj", "s.obj"}));
}

// A cube with a face turned, one given twice, one of two corners, and a vertex of no face.
TEST_F(InterpolateE2e, RepairOnRequestSaysWhatWasChangedAndWhereItCameFrom) {
  const std::string vertices =
      "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
  WriteAll(At("in.obj"), vertices +
                             "f 5 4 3 2\nf 9 8 7 6\nf 2 3 7 6\nf 3 4 8 7\nf 4 3 7 8\nf 4 5 9 8\n"
                             "f 2 3\nf 5 2 6 9\n");
  WriteAll(At("sound.obj"), vertices.substr(vertices.find('\n') + 1) +
                                "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n"
                                "f 4 1 5 8\n");
  ServerProcess server(space_);
  const RunResult refused =
      space_.Limn({"interpolate", At("in.obj"), "--server", server.address()});
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.errors.find("--repair"), std::string::npos) << refused.errors;

  const RunResult run =
      space_.Limn({"interpolate", At("in.obj"), "--repair", "--server", server.address(), "-o",
                   At("s.obj"), "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors << server.Log();
  for (const char* row : {"degenerate faces removed: 1", "repeated faces removed: 1",
                          "faces turned round: 1", "isolated vertices removed: 1"}) {
    EXPECT_NE(run.output.find(row), std::string::npos) << row << " in " << run.output;
  }
  ExpectInterpolates(ReadObj(At("sound.obj")), ReadObj(At("s.obj")));
  const std::string report = ReadAll(At("r.json"));
  for (const char* member :
       {"\"inputVertices\": \"9\"", "\"originalVertex\": [1, 2, 3, 4, 5, 6, 7, 8]",
        "\"originalFace\": [0, 1, 2, 3, 5, 7]"}) {
    EXPECT_NE(report.find(member), std::string::npos) << member << " in " << report;
  }

  // A sound mesh is as it was.
  ASSERT_EQ(space_.Limn({"interpolate", At("sound.obj"), "-o", At("a.obj")}).status, 0);
  const RunResult idle =
      space_.Limn({"interpolate", At("sound.obj"), "--repair", "-o", At("b.obj")});
  EXPECT_NE(idle.output.find("nothing: there was no need"), std::string::npos) << idle.output;
  EXPECT_EQ(ReadAll(At("a.obj")), ReadAll(At("b.obj")));

  const RunResult info = space_.Limn({"info", At("in.obj")});
  EXPECT_NE(info.output.find("--repair mends that"), std::string::npos) << info.output;
  const RunResult json = space_.Limn({"info", At("in.obj"), "--json"});
  EXPECT_NE(json.output.find("\"repairable\": true"), std::string::npos) << json.output;
}

}  // namespace
}  // namespace limn::e2e
