// SPDX-License-Identifier: MIT
// `limn evaluate` with the real binaries, inside the process and against a server.
#include <gtest/gtest.h>

#include <csignal>
#include <sstream>
#include <string>
#include <vector>

#include "tests/e2e/obj_file.h"
#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

std::vector<std::vector<double>> Rows(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    std::vector<double>& row = rows.emplace_back();
    for (double x = 0; numbers >> x;) row.push_back(x);
  }
  return rows;
}

class EvaluateE2e : public testing::Test {
 protected:
  EvaluateE2e() {
    Generate("irregular_sphere", "400");
    WriteAll(At("p.txt"), "# some\n0 0 0 0\n0 1 0.5 0.25\n\n7 2 1 1\n3 1 1e-300 0.75\n");
  }
  void Generate(const std::string& kind, const std::string& vertices) const {
    EXPECT_EQ(
        space_
            .Limn({"generate", kind, "--vertices", vertices, "--seed", "4", "-o", At("given.obj")})
            .status,
        0);
  }
  std::string At(const std::string& name) const { return space_.path(name); }
  RunResult Evaluate(const std::vector<std::string>& flags) const {
    std::vector<std::string> arguments = {"evaluate", At("given.obj")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return space_.Limn(arguments);
  }

  Workspace space_;
};

TEST_F(EvaluateE2e, GivesTheVerticesAtTheCornersOfClosedAndOpenMeshes) {
  for (const std::string kind : {"irregular_sphere", "disk"}) {
    Generate(kind, "400");
    const ObjFile given = ReadObj(At("given.obj"));
    std::string parameters;
    for (std::size_t f = 0; f < given.faces.size(); ++f) {
      for (std::size_t c = 0; c < given.faces[f].size(); ++c) {
        parameters += std::to_string(f) + " " + std::to_string(c) + " 0 0\n";
      }
    }
    WriteAll(At("corners.txt"), parameters);
    const RunResult run = Evaluate({"--at", At("corners.txt")});
    ASSERT_EQ(run.status, 0) << run.errors;
    const std::vector<std::vector<double>> rows = Rows(run.output);
    std::size_t row = 0;
    for (const auto& face : given.faces) {
      for (const auto vertex : face) {
        ASSERT_LT(row, rows.size());
        ASSERT_EQ(rows[row].size(), 12U);
        const auto& p = given.positions[static_cast<std::size_t>(vertex)];
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_NEAR(rows[row][i], p[i], 1e-12 * Diagonal(given));
        }
        ++row;
      }
    }
    EXPECT_EQ(row, rows.size());
  }
}

TEST_F(EvaluateE2e, ServerAndEmbeddedServerAndAnyThreadsGiveTheSameBytes) {
  ServerProcess server(space_);
  const RunResult here = Evaluate({"--at", At("p.txt")});
  ASSERT_EQ(here.status, 0) << here.errors;
  EXPECT_EQ(Rows(here.output).size(), 4U);
  EXPECT_EQ(here.output, Evaluate({"--at", At("p.txt"), "--threads", "1"}).output);
  const RunResult there = Evaluate({"--at", At("p.txt"), "--server", server.address()});
  EXPECT_EQ(there.status, 0) << there.errors << server.Log();
  EXPECT_EQ(there.output, here.output);
  EXPECT_TRUE(server.WaitForLog("method=Evaluate")) << server.Log();
}

TEST_F(EvaluateE2e, WritesTextCsvAndJson) {
  const std::string text = Evaluate({"--at", At("p.txt")}).output;
  for (const std::string extension : {"txt", "csv", "json"}) {
    const std::string name = "s." + extension;
    const RunResult run = Evaluate({"--at", At("p.txt"), "-o", At(name), "--quiet"});
    ASSERT_EQ(run.status, 0) << run.errors;
    EXPECT_EQ(run.output, "");
    const std::string format = extension == "txt" ? "text" : extension;
    EXPECT_EQ(ReadAll(At(name)), Evaluate({"--at", At("p.txt"), "--format", format}).output);
  }
  EXPECT_EQ(ReadAll(At("s.txt")), text);
  EXPECT_TRUE(ReadAll(At("s.csv")).starts_with("face,corner,u,v,x,y,z,"));
  EXPECT_TRUE(ReadAll(At("s.json")).starts_with("{\"samples\": [\n"));
  // The flag is stronger than the extension.
  ASSERT_EQ(Evaluate({"--at", At("p.txt"), "-o", At("s.dat"), "--format", "csv"}).status, 0);
  EXPECT_EQ(ReadAll(At("s.dat")), ReadAll(At("s.csv")));
}

TEST_F(EvaluateE2e, WritesTableAndReportBesideAFile) {
  const RunResult run =
      Evaluate({"--at", At("p.txt"), "-o", At("s.txt"), "--report", At("r.json")});
  ASSERT_EQ(run.status, 0) << run.errors;
  EXPECT_NE(run.output.find("evaluate"), std::string::npos) << run.output;
  EXPECT_NE(ReadAll(At("r.json")).find("\"evaluate\""), std::string::npos);
}

TEST_F(EvaluateE2e, TakesJsonParametersAndConstraints) {
  WriteAll(At("p.json"), R"({"faces": [0, 0], "corners": [0, 1], "u": [0, 0.5], "v": [0, 0.25]})");
  const RunResult all = Evaluate({"--at", At("p.json")});
  ASSERT_EQ(all.status, 0) << all.errors;
  EXPECT_TRUE(Evaluate({"--at", At("p.txt")}).output.starts_with(all.output));
  WriteAll(At("c.json"), R"({"interpolate": {"vertices": []}})");
  const RunResult none = Evaluate({"--at", At("p.json"), "--constraints", At("c.json")});
  ASSERT_EQ(none.status, 0) << none.errors;
  EXPECT_NE(none.output, all.output);
  WriteAll(At("c.json"), R"({"interpolate": {"vertices": [4000]}})");
  const RunResult bad = Evaluate({"--at", At("p.json"), "--constraints", At("c.json")});
  EXPECT_EQ(bad.status, 1);
  EXPECT_NE(bad.errors.find("c.json"), std::string::npos) << bad.errors;
}

TEST_F(EvaluateE2e, RefusalsNameFileAndLineAndLeaveNoFile) {
  const std::vector<std::string> before = space_.Files();
  struct Case {
    std::string text;
    std::string words;
  };
  for (const Case& c :
       {Case{"0 0 0 0\n0 0 0\n", "bad.txt:2: v"},
        Case{"0 0 0 0\n\n100000 0 0 0\n", "bad.txt:3: parameters[1].face"},
        Case{"0 99 0 0\n", "bad.txt:1: parameters[0].corner"},
        Case{"0 0 1.5 0\n", "bad.txt:1: parameters[0].u is 1.5"},
        Case{"0 0 0 nan\n", "bad.txt:1: parameters[0].v"}, Case{"{\"faces\": [1]}", "bad.txt: "}}) {
    WriteAll(At("bad.txt"), c.text);
    const RunResult run = Evaluate({"--at", At("bad.txt"), "-o", At("s.csv")});
    EXPECT_EQ(run.status, 1) << run.errors;
    EXPECT_NE(run.errors.find(c.words), std::string::npos) << run.errors;
    EXPECT_EQ(run.output, "");
  }
  std::filesystem::remove(At("bad.txt"));
  const RunResult missing = Evaluate({"--at", At("missing.txt")});
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.errors.find("missing.txt"), std::string::npos) << missing.errors;
  EXPECT_EQ(space_.Files(), before);
}

TEST_F(EvaluateE2e, UsageErrorsEndWithTwo) {
  const std::vector<std::string> before = space_.Files();
  const std::string p = At("p.txt");
  for (const std::vector<std::string>& flags : std::vector<std::vector<std::string>>{
           {},
           {"--at", p, "-o", At("s.xyz")},
           {"--at", p, "-o", At("s")},
           {"--at", p, "--format", "xml"},
           {"--at", p, "-o", p},
           {"--at", p, "-o", At("given.obj"), "--format", "csv"},
           {"--at", p, "-o", At("s.csv"), "--report", At("s.csv")},
           {"--at", p, "--level", "2"},
           {"--at", p, "--repair"},
           {"--at", p, "--tolerance", "2"}}) {
    const RunResult run = Evaluate(flags);
    EXPECT_EQ(run.status, 2) << run.errors;
    EXPECT_TRUE(run.errors.starts_with("limn: ")) << run.errors;
    EXPECT_EQ(run.output, "");
  }
  EXPECT_EQ(space_.Files(), before);
}

TEST_F(EvaluateE2e, HelpNamesEveryFlag) {
  const RunResult help = space_.Limn({"evaluate", "--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* word : {"--at", "--output", "--format", "--report", "--constraints", "--scheme",
                           "--solver", "--rule", "--tolerance", "--max-sweeps", "--server",
                           "--threads", "--deadline", "--fair", "--quiet"}) {
    EXPECT_NE(help.output.find(word), std::string::npos) << word;
  }
  EXPECT_NE(space_.Limn({"--help"}).output.find("evaluate"), std::string::npos);
}

TEST_F(EvaluateE2e, CtrlCCancelsOnTheServer) {
  ServerProcess server(space_);
  Generate("irregular_sphere", "100000");
  Process* client = space_.StartLimn({"evaluate", At("given.obj"), "--at", At("p.txt"), "-o",
                                      At("s.csv"), "--solver", "gauss-seidel", "--tolerance", "0",
                                      "--max-sweeps", "10000", "--server", server.address()});
  ASSERT_TRUE(WaitUntil(30, [&] { return client->ErrorText().find("solve") != std::string::npos; }))
      << server.Log() << client->ErrorText();
  client->Signal(SIGINT);
  EXPECT_EQ(client->Wait(10), 130) << client->ErrorText();
  EXPECT_TRUE(server.WaitForLog("CANCELLED", 10)) << server.Log();
  EXPECT_EQ(space_.Files(), (std::vector<std::string>{"given.obj", "p.txt"}));
}

TEST_F(EvaluateE2e, NoServerIsExitStatusThree) {
  const RunResult run = Evaluate({"--at", At("p.txt"), "--server", "127.0.0.1:1"});
  EXPECT_EQ(run.status, 3) << run.errors;
  EXPECT_NE(run.errors.find("127.0.0.1:1"), std::string::npos) << run.errors;
}

}  // namespace
}  // namespace limn::e2e
