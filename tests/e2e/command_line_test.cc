// SPDX-License-Identifier: MIT
// Help, version, usage errors, `limn generate` and `limn info` as a shell sees them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/obj_file.h"
#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

class CommandLineE2e : public testing::Test {
 protected:
  std::string At(const std::string& name) const { return space_.path(name); }
  RunResult Server(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command = {LIMND_BINARY};
    command.insert(command.end(), arguments.begin(), arguments.end());
    Process process(command, space_.log("limnd"));
    const int status = process.Wait();
    return {status, process.Output(), process.ErrorText()};
  }

  Workspace space_;
};

TEST_F(CommandLineE2e, HelpNamesEveryCommandAndFlagOnStandardOutput) {
  const RunResult top = space_.Limn({"--help"});
  EXPECT_EQ(top.status, 0);
  EXPECT_EQ(top.errors, "");
  for (const char* word : {"interpolate", "generate", "info", "--version", "Exit status"}) {
    EXPECT_NE(top.output.find(word), std::string::npos) << word;
  }
  const RunResult interpolate = space_.Limn({"interpolate", "--help"});
  EXPECT_EQ(interpolate.status, 0);
  for (const char* word :
       {"--scheme", "--level", "--control-mesh", "--report", "--solver", "--tolerance",
        "--max-sweeps", "--threads", "--server", "--encoding", "--quantization-bits", "--deadline",
        "--quiet", "--output", "--constraints", "--rule", "--fair", "--repair"}) {
    EXPECT_NE(interpolate.output.find(word), std::string::npos) << word;
  }
  const RunResult generate = space_.Limn({"generate", "--help"});
  EXPECT_EQ(generate.status, 0);
  for (const char* word : {"irregular_sphere", "--vertices", "--seed", "--output"}) {
    EXPECT_NE(generate.output.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(space_.Limn({"info", "--help"}).status, 0);
  const RunResult server = Server({"--help"});
  EXPECT_EQ(server.status, 0);
  EXPECT_NE(server.output.find("--listen"), std::string::npos);
}

TEST_F(CommandLineE2e, VersionIsThatOfTheBuild) {
  const RunResult limn = space_.Limn({"--version"});
  EXPECT_EQ(limn.status, 0);
  EXPECT_EQ(limn.output, "limn " LIMN_VERSION "\n");
  const RunResult limnd = Server({"--version"});
  EXPECT_EQ(limnd.status, 0);
  EXPECT_EQ(limnd.output, "limnd " LIMN_VERSION "\n");
}

TEST_F(CommandLineE2e, UsageErrorsEndWithTwoAndSayWhat) {
  WriteAll(At("in.obj"),
           "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string in = At("in.obj");
  const std::string out = At("out.obj");
  const std::vector<std::vector<std::string>> lines = {
      {},
      {"paint"},
      {"interpolate"},
      {"interpolate", in, "--colour", "red"},
      {"interpolate", in, "-o", out, "--level", "11"},
      {"interpolate", in, "-o", out, "--level", "-1"},
      {"interpolate", in, "-o", out, "--level", "two"},
      {"interpolate", in, "-o", out, "--tolerance", "1"},
      {"interpolate", in, "-o", out, "--tolerance", "-1e-3"},
      {"interpolate", in, "-o", out, "--tolerance", "nan"},
      {"interpolate", in, "-o", out, "--max-sweeps", "10001"},
      {"interpolate", in, "--chord-tolerance", "1e-3", "--report", At("report.json")},
      {"interpolate", in, "-o", out, "--solver", "magic"},
      {"interpolate", in, "-o", out, "--scheme", "magic"},
      {"interpolate", in, "-o", out, "--rule", "magic"},
      {"interpolate", in, "-o", out, "--constraints"},
      {"interpolate", in, "-o", out, "--constraints", in, "--constraints", in},
      {"interpolate", in, "-o", in, "--constraints", in},
      {"interpolate", in, "-o", out, "--encoding", "zip"},
      {"interpolate", in, "-o", out, "--quantization-bits", "31"},
      {"interpolate", in, "-o", out, "--deadline", "0"},
      {"interpolate", in, "-o", out, "--deadline", "nan"},
      {"interpolate", in, "-o", out, "--threads", "-1"},
      {"interpolate", in, "-o", out, "--server", "localhost"},
      {"interpolate", in, "-o", out, "--server", "127.0.0.1:1", "--threads", "2"},
      {"interpolate", in, "-o", At("out.txt")},
      {"interpolate", in, "-o", At("out")},
      {"interpolate", in, "-o", out, "-o", out},
      {"interpolate", in, "-o", out, "--control-mesh", out},
      {"interpolate", in, "-o", in},
      {"generate"},
      {"generate", "pyramid", "--vertices", "100", "-o", out},
      {"generate", "torus", "-o", out},
      {"generate", "torus", "--vertices", "100"},
      {"generate", "torus", "--vertices", "0", "-o", out},
      {"generate", "torus", "--vertices", "-4", "-o", out},
      {"generate", "torus", "--vertices", "100", "-o", At("out.xyz")},
      {"info"},
  };
  for (const auto& line : lines) {
    std::string shown;
    for (const std::string& word : line) shown += word + " ";
    const RunResult run = space_.Limn(line);
    EXPECT_EQ(run.status, 2) << shown << run.errors;
    EXPECT_TRUE(run.errors.starts_with("limn: ")) << shown << run.errors;
    EXPECT_EQ(run.output, "") << shown;
  }
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"in.obj"});
}

TEST_F(CommandLineE2e, WhereNothingCanBeWrittenIsSaidBeforeTheWorkStarts) {
  ASSERT_EQ(space_.Limn({"generate", "torus", "--vertices", "100", "-o", At("in.obj")}).status, 0);
  for (const std::string flag : {"-o", "--control-mesh", "--report"}) {
    const std::string name = flag == "--report" ? "no/such/r.json" : "no/such/s.obj";
    const RunResult run =
        space_.Limn({"interpolate", At("in.obj"), "-o", At("first.obj"), flag, At(name)});
    EXPECT_EQ(run.status, 1) << flag << run.errors;
    EXPECT_NE(run.errors.find("no/such"), std::string::npos) << run.errors;
  }
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"in.obj"});
}

TEST_F(CommandLineE2e, GenerateGivesTheSameMeshForTheSameSeedOnly) {
  const auto generate = [&](const std::string& seed, const std::string& name) {
    EXPECT_EQ(space_
                  .Limn({"generate", "irregular_sphere", "--vertices", "700", "--seed", seed, "-o",
                         At(name)})
                  .status,
              0);
    return ReadAll(At(name));
  };
  const std::string first = generate("5", "a.obj");
  EXPECT_TRUE(generate("5", "b.obj") == first);
  EXPECT_FALSE(generate("6", "c.obj") == first);
  EXPECT_EQ(ReadObj(At("a.obj")).positions.size(), 700U);
}

TEST_F(CommandLineE2e, TheSampleHas11540Vertices) {
  ASSERT_EQ(space_
                .Limn({"generate", "irregular_sphere", "--vertices", "11540", "--seed", "1", "-o",
                       At("given.obj")})
                .status,
            0);
  EXPECT_EQ(ReadObj(At("given.obj")).positions.size(), 11540U);
}

TEST_F(CommandLineE2e, InfoTellsWhatAMeshIs) {
  WriteAll(At("cube.obj"),
           "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
           "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const RunResult text = space_.Limn({"info", At("cube.obj")});
  EXPECT_EQ(text.status, 0) << text.errors;
  for (const char* word : {"vertices", "faces", "genus"}) {
    EXPECT_NE(text.output.find(word), std::string::npos) << word << text.output;
  }
  const RunResult json = space_.Limn({"info", At("cube.obj"), "--json"});
  EXPECT_EQ(json.status, 0) << json.errors;
  for (const char* field : {"\"vertices\": 8", "\"faces\": 6", "\"edges\": 12", "\"genus\": 0"}) {
    EXPECT_NE(json.output.find(field), std::string::npos) << field << json.output;
  }
}

}  // namespace
}  // namespace limn::e2e
