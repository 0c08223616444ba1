// SPDX-License-Identifier: MIT
// What limn and limnd say to somebody who makes a mistake, word by word.
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

constexpr const char* kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

struct Mistake {
  std::string name;
  // @ stands for the workspace's folder, in the message too.
  std::vector<std::string> line;
  int status = 0;
  std::string message;
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

std::string Placed(std::string text, const std::string& folder) {
  for (std::size_t at = text.find('@'); at != std::string::npos; at = text.find('@')) {
    text.replace(at, 1, folder);
  }
  return text;
}

class MessageE2e : public testing::TestWithParam<Mistake> {
 protected:
  Workspace space_;
};

TEST_P(MessageE2e, IsThisOne) {
  WriteAll(space_.path("in.obj"), kCube);
  WriteAll(space_.path("hole.json"), R"({"holes": [2000]})");
  WriteAll(space_.path("point.txt"), "0 0 1 1\n");
  const std::vector<std::string> before = space_.Files();
  const std::string folder = space_.path("").parent_path();
  std::vector<std::string> line;
  for (const std::string& word : GetParam().line) line.push_back(Placed(word, folder));
  const RunResult run = space_.Limn(line);
  EXPECT_EQ(run.status, GetParam().status) << run.errors;
  EXPECT_EQ(run.errors, "limn: " + Placed(GetParam().message, folder) + "\n");
  EXPECT_EQ(run.output, "");
  EXPECT_EQ(space_.Files(), before);
}

std::vector<Mistake> Mistakes() {
  const std::string commands =
      "interpolate, batch, filter, features, evaluate, generate, health, info, load";
  const std::string in = "@/in.obj";
  const std::string see = "; see 'limn interpolate --help'";
  const std::string otherwise =
      ": boundary rules belong to Catmull-Clark and Loop surfaces. Leave them out or choose "
      "another scheme";
  return {
      {"NoCommand", {}, 2, "a command is missing; there are " + commands + "; see 'limn --help'"},
      {"UnknownCommand",
       {"frobnicate"},
       2,
       "there is no command frobnicate; there are " + commands + "; see 'limn --help'"},
      {"MisspeltCommand",
       {"interpolat", in},
       2,
       "there is no command interpolat; did you mean interpolate?; there are " + commands +
           "; see 'limn --help'"},
      {"UnknownFlag", {"interpolate", in, "--colour", "red"}, 2, "there is no flag --colour" + see},
      {"MisspeltFlag",
       {"interpolate", in, "--levle", "2"},
       2,
       "there is no flag --levle; did you mean --level?" + see},
      {"MisspeltFlagWithValue",
       {"interpolate", in, "--levle=2"},
       2,
       "there is no flag --levle; did you mean --level?" + see},
      {"BeginningOfAFlag",
       {"evaluate", in, "--at", "@/point.txt", "--cons", "c.json"},
       2,
       "there is no flag --cons; did you mean --constraints?; see 'limn evaluate --help'"},
      {"ArgumentsInTheirOrder",
       {"interpolate", in, "b", "c", "d"},
       2,
       "there are arguments too many: b c d" + see},
      {"OneArgument",
       {"info", in, "b"},
       2,
       "there is an argument too many: b; see 'limn info --help'"},
      {"BoundaryOfDooSabin",
       {"interpolate", in, "--boundary", "none"},
       2,
       "--boundary" + otherwise + see},
      {"BoundaryOfDooSabinEvaluated",
       {"evaluate", in, "--at", "@/point.txt", "--boundary", "none"},
       2,
       "--boundary" + otherwise + "; see 'limn evaluate --help'"},
      {"BilinearDooSabin",
       {"interpolate", in, "--rule", "bilinear"},
       2,
       "--rule: the bilinear first step belongs to Catmull-Clark surfaces. Choose the modified or "
       "the standard rule" +
           see},
      {"ModifiedCatmullClark",
       {"interpolate", in, "--scheme", "catmull-clark", "--rule", "modified"},
       2,
       "--rule: the modified rule belongs to Doo-Sabin. Choose the standard rule or none" + see},
      {"FairCatmullClark",
       {"interpolate", in, "--scheme", "catmull-clark", "--fair"},
       2,
       "--fair: fairing belongs to Doo-Sabin surfaces. Leave it out or choose Doo-Sabin" + see},
      {"StrictDooSabin",
       {"interpolate", in, "--strict"},
       2,
       "--strict: it belongs to Catmull-Clark and Loop surfaces. Leave it out or choose another "
       "scheme" +
           see},
      {"BitsOfNothing",
       {"interpolate", in, "--encoding", "draco", "--quantization-bits", "12"},
       2,
       "--quantization-bits: they belong to --encoding draco-quantized. Leave them out or choose "
       "that" +
           see},
      {"BitsOfNothingInFeatures",
       {"features", in, "--features", "@/hole.json", "--quantization-bits", "12"},
       2,
       "--quantization-bits: they belong to --encoding draco-quantized. Leave them out or choose "
       "that; see 'limn features --help'"},
      {"DracoWithoutItsBoundary",
       {"interpolate", in, "--scheme", "catmull-clark", "--boundary", "none", "--encoding", "draco",
        "-o", "@/s.obj"},
       2,
       "--encoding: a Draco surface cannot have the vertices inside holes. Use --encoding packed "
       "for surfaces with holes"},
      {"UnknownEndingOfTheInput",
       {"interpolate", "@/in.xyz"},
       2,
       "mesh files of extension \".xyz\" cannot be read: @/in.xyz. Known extensions are .obj, "
       ".off, .ply and .stl"},
      {"UnknownEndingOfTheOutput",
       {"interpolate", in, "-o", "@/s.xyz"},
       2,
       "a surface cannot be written to a file of extension \".xyz\": @/s.xyz. Known extensions are "
       ".obj, .off, .ply, .stl, .glb"},
      {"NoFolder",
       {"interpolate", in, "-o", "@/no/such/s.obj"},
       1,
       "cannot write @/no/such/s.obj: the folder @/no/such does not exist"},
      {"NoSuchFace",
       {"interpolate", in, "--scheme", "catmull-clark", "--constraints", "@/hole.json"},
       1,
       "@/hole.json: constraints.holes[0]: there is no face 2000, the mesh has 6. Vertices and "
       "faces are counted from 0"},
      {"SingularCube",
       {"interpolate", in, "--scheme", "catmull-clark", "--strict"},
       1,
       "--strict: the interpolation problem of this mesh is singular or nearly so. Leave strict "
       "out, which takes half of the first refinement bilinear, or interpolate fewer vertices"},
  };
}

INSTANTIATE_TEST_SUITE_P(Lines, MessageE2e, testing::ValuesIn(Mistakes()),
                         [](const auto& mistake) { return mistake.param.name; });

class ServerMessageE2e : public testing::Test {
 protected:
  // What limnd says to this command line on standard error.
  std::string Says(const std::vector<std::string>& flags, int status) {
    std::vector<std::string> command = {LIMND_BINARY};
    command.insert(command.end(), flags.begin(), flags.end());
    Process process(command, space_.log("limnd-refused"));
    EXPECT_EQ(process.Wait(20), status);
    EXPECT_EQ(process.Output(), "");
    return process.ErrorText();
  }

  Workspace space_;
};

TEST_F(ServerMessageE2e, UsageErrorsAreSaidInTheFormOfLimns) {
  EXPECT_EQ(Says({"--foo"}, 2), "limnd: there is no flag --foo; see 'limnd --help'\n");
  EXPECT_EQ(Says({"a", "b"}, 2), "limnd: there is an argument too many: a; see 'limnd --help'\n");
  EXPECT_EQ(Says({"--workers", "0"}, 2),
            "limnd: --workers: Value 0 not in range 1 to 1024; see 'limnd --help'\n");
}

TEST_F(ServerMessageE2e, ATakenPortIsOneLine) {
  ServerProcess first(space_);
  EXPECT_EQ(Says({"--listen", first.address()}, 3),
            "limnd: cannot listen on " + first.address() +
                ". Is the port taken? Port 0 picks a free one\n");
}

TEST_F(ServerMessageE2e, AFolderThatDoesNotExistIsNamed) {
  const std::string folder = space_.path("no/such");
  const std::string text =
      Says({"--listen", "127.0.0.1:0", "--log-level", "off", "--port-file", folder + "/port"}, 3);
  EXPECT_EQ(text, "limnd: cannot write the port to " + folder + "/port: the folder " + folder +
                      " does not exist\n");
}

class WarningE2e : public testing::Test {
 protected:
  WarningE2e() { WriteAll(At("in.obj"), kCube); }
  std::string At(const std::string& name) const { return space_.path(name); }
  Workspace space_;
};

// The cube needs some sweeps; `evaluate` solves the same way.
TEST_F(WarningE2e, AToleranceThatIsNotMetIsSaidWithItsRemedyAndIsNoFailure) {
  WriteAll(At("p.txt"), "0 0 1 1\n");
  for (const std::vector<std::string>& line :
       {std::vector<std::string>{"interpolate", At("in.obj"), "-o", At("s.obj")},
        std::vector<std::string>{"evaluate", At("in.obj"), "--at", At("p.txt")}}) {
    std::vector<std::string> few = line;
    few.insert(few.end(), {"--quiet", "--max-sweeps", "1"});
    const RunResult run = space_.Limn(few);
    EXPECT_EQ(run.status, 0) << run.errors;
    EXPECT_TRUE(run.errors.starts_with(
        "limn: warning: the tolerance was not met in 1 sweep, the residual is "))
        << run.errors;
    EXPECT_TRUE(
        run.errors.ends_with(" of the bounding box; allow more by --max-sweeps, or ask for "
                             "less by --tolerance\n"))
        << run.errors;
    std::vector<std::string> asked = few;
    asked.insert(asked.end(), {"--tolerance", "0"});
    EXPECT_EQ(space_.Limn(asked).errors, "");
    std::vector<std::string> all = line;
    all.push_back("--quiet");
    EXPECT_EQ(space_.Limn(all).errors, "");
  }
}

TEST_F(WarningE2e, TheDeadlinesFlagIsNamed) {
  ASSERT_EQ(space_.Limn({"generate", "torus", "--vertices", "50000", "-o", At("given.obj")}).status,
            0);
  const RunResult run = space_.Limn({"interpolate", At("given.obj"), "--deadline", "0.001"});
  EXPECT_EQ(run.status, 3);
  EXPECT_EQ(run.errors,
            "limn: the job took longer than --deadline allows; allow it more seconds\n");
}

TEST_F(WarningE2e, MemoryIsSaidInUnitsAndWithoutAServersLimit) {
  ASSERT_EQ(
      space_.Limn({"generate", "torus", "--vertices", "100000", "-o", At("given.obj")}).status, 0);
  const std::vector<std::string> line = {"interpolate", At("given.obj"), "--level", "10",
                                         "-o",          At("s.obj")};
  const RunResult own = space_.Limn(line);
  EXPECT_EQ(own.status, 3);
  EXPECT_TRUE(own.errors.starts_with("limn: --level: the job may need ")) << own.errors;
  for (const char* word : {" TiB (", " bytes) of memory, more than ",
                           "(limit: two thirds of the memory there is). Ask for a lower level"}) {
    EXPECT_NE(own.errors.find(word), std::string::npos) << word << own.errors;
  }
  ServerProcess server(space_, {"--max-level", "10"});
  std::vector<std::string> elsewhere = line;
  elsewhere.insert(elsewhere.end(), {"--server", server.address()});
  const RunResult far = space_.Limn(elsewhere);
  EXPECT_EQ(far.status, 3);
  EXPECT_NE(far.errors.find("more than 8.0 GiB (8589934592 bytes) (limit max-job-bytes)"),
            std::string::npos)
      << far.errors;
}

TEST_F(WarningE2e, CountsAreInTheSingularAndOfWhatIsWritten) {
  const RunResult made =
      space_.Limn({"generate", "disk", "--vertices", "60", "-o", At("disk.stl")});
  EXPECT_EQ(made.status, 0) << made.errors;
  EXPECT_EQ(made.output, At("disk.stl") + ": 60 vertices, 47 faces, written as 98 triangles\n");
  const RunResult info = space_.Limn({"info", At("disk.stl")});
  EXPECT_NE(info.output.find("\nfaces              98\n"), std::string::npos) << info.output;
  EXPECT_NE(info.output.find("\nboundary           1 loop of 20 edges\n"), std::string::npos)
      << info.output;
}

TEST_F(WarningE2e, HelpTellsTheLeastVerticesOfEachKindAndEveryConstraint) {
  const RunResult generate = space_.Limn({"generate", "--help"});
  EXPECT_NE(generate.output.find("torus from 9"), std::string::npos) << generate.output;
  const RunResult interpolate = space_.Limn({"interpolate", "--help"});
  for (const char* word : {"normals", "shapeHandles", "features", "creases", "corners", "holes"}) {
    EXPECT_NE(interpolate.output.find(word), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace limn::e2e
