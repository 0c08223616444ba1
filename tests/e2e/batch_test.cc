// SPDX-License-Identifier: MIT
// `limn batch` with the real binaries: the same bytes as one by one, whatever is killed in between.
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

namespace fs = std::filesystem;

constexpr int kPartial = 4;
constexpr int kInterrupted = 130;

class BatchE2e : public testing::Test {
 protected:
  std::string At(const std::string& name) const { return space_.path(name); }

  // Meshes/mesh-0.obj and so on; some are shared by several jobs.
  void Generate(int count, int vertices) const {
    fs::create_directories(At("meshes"));
    for (int i = 0; i < count; ++i) {
      const RunResult run =
          space_.Limn({"generate", "irregular_sphere", "--vertices", std::to_string(vertices + i),
                       "--seed", std::to_string(i + 1), "-o", MeshOf(i)});
      ASSERT_EQ(run.status, 0) << run.errors;
    }
  }
  std::string MeshOf(int number) const {
    return At("meshes/mesh-" + std::to_string(number) + ".obj");
  }

  // One mesh that is none, and jobs of the others in turn, at several levels.
  void WriteManifest(int jobs, int meshes, bool bad) const {
    std::string text;
    for (int i = 0; i < jobs; ++i) {
      text += R"({"input": "meshes/mesh-)" + std::to_string(i % meshes) + R"(.obj", "id": "job-)" +
              std::to_string(i) + R"(", "level": )" + std::to_string(LevelOf(i, meshes)) + "}\n";
      if (bad && i == jobs / 2) text += "{\"input\": \"bad.obj\"}\n\n";
    }
    WriteAll(At("jobs.jsonl"), text);
    WriteAll(At("bad.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\n");
  }
  static int LevelOf(int job, int meshes) { return job / meshes % 3; }

  // Every job's surface is what `limn interpolate` makes of the same.
  void ExpectSurfaces(int jobs, int meshes, const std::string& folder) {
    for (int i = 0; i < jobs; ++i) {
      const int mesh = i % meshes;
      const int level = LevelOf(i, meshes);
      std::string& wanted = surfaces_[{mesh, level}];
      if (wanted.empty()) {
        const RunResult run = space_.Limn({"interpolate", MeshOf(mesh), "--level",
                                           std::to_string(level), "-o", At("one.ply"), "--quiet"});
        ASSERT_EQ(run.status, 0) << run.errors;
        wanted = ReadAll(At("one.ply"));
      }
      EXPECT_TRUE(ReadAll(At(folder + "/job-" + std::to_string(i) + ".ply")) == wanted) << i;
    }
  }

  std::size_t Surfaces(const std::string& folder) const {
    std::error_code error;
    std::size_t count = 0;
    for (fs::directory_iterator at(At(folder), error), end; !error && at != end;
         at.increment(error)) {
      count += at->path().extension() == ".ply" ? 1 : 0;
    }
    return count;
  }
  // What was begun and is no whole file.
  std::size_t Parts(const std::string& folder) const {
    std::size_t count = 0;
    for (const auto& file : fs::directory_iterator(At(folder))) {
      count += file.path().filename().string().starts_with(".limn") ? 1 : 0;
    }
    return count;
  }
  // How often a job has succeeded by the journal.
  std::map<std::string, int> Successes(const std::string& folder) const {
    std::map<std::string, int> successes;
    const std::string text = ReadAll(At(folder + "/limn-batch.jsonl"));
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos;
         end = text.find('\n', begin)) {
      const google::protobuf::Struct line = Parse(text.substr(begin, end - begin));
      if (line.fields().contains("status") &&
          line.fields().at("status").string_value() == "succeeded") {
        ++successes[line.fields().at("id").string_value()];
      }
      begin = end + 1;
    }
    return successes;
  }
  void ExpectEachSucceededOnce(int jobs, const std::string& folder) const {
    const std::map<std::string, int> successes = Successes(folder);
    EXPECT_EQ(successes.size(), static_cast<std::size_t>(jobs));
    for (const auto& [id, count] : successes) EXPECT_EQ(count, 1) << id;
  }

  static google::protobuf::Struct Parse(const std::string& json) {
    google::protobuf::Struct object;
    const auto status = google::protobuf::util::JsonStringToMessage(json, &object);
    EXPECT_TRUE(status.ok()) << json;
    return object;
  }
  double Number(const google::protobuf::Struct& object, const std::string& name) const {
    const auto found = object.fields().find(name);
    return found == object.fields().end() ? -1 : found->second.number_value();
  }

  // limnd at a port that others of the test have had.
  std::unique_ptr<Process> StartAgain(const std::string& address) const {
    auto server = std::make_unique<Process>(
        std::vector<std::string>{LIMND_BINARY, "--listen", address}, space_.log("limnd-again"));
    EXPECT_TRUE(WaitUntil(20, [&] {
      return space_.Limn({"health", "--server", address}).status == 0;
    })) << server->ErrorText();
    return server;
  }

  Workspace space_;
  std::map<std::pair<int, int>, std::string> surfaces_;
};

TEST_F(BatchE2e, GivesTheSameBytesAsOneByOneAndABadMeshFailsAlone) {
  constexpr int kJobs = 120;
  constexpr int kMeshes = 8;
  Generate(kMeshes, 100);
  WriteManifest(kJobs, kMeshes, true);
  ServerProcess server(space_);
  const std::vector<std::vector<std::string>> ways = {{}, {"--server", server.address()}};
  for (const auto& way : ways) {
    const std::string folder = way.empty() ? "embedded" : "served";
    std::vector<std::string> command = {"batch",    At("jobs.jsonl"), "-o",
                                        At(folder), "--report",       At(folder + ".json")};
    command.insert(command.end(), way.begin(), way.end());
    const RunResult run = space_.Limn(command);
    EXPECT_EQ(run.status, kPartial) << run.errors << server.Log();
    EXPECT_NE(run.errors.find("bad: "), std::string::npos) << run.errors;
    EXPECT_NE(run.errors.find("1 of 121 jobs failed"), std::string::npos) << run.errors;
    EXPECT_NE(run.output.find("INCONSISTENT_ORIENTATION: 1"), std::string::npos) << run.output;
    ExpectSurfaces(kJobs, kMeshes, folder);
    EXPECT_FALSE(fs::exists(At(folder + "/bad.ply")));
    EXPECT_EQ(Parts(folder), 0U);
    ExpectEachSucceededOnce(kJobs, folder);

    const google::protobuf::Struct report = Parse(ReadAll(At(folder + ".json")));
    EXPECT_EQ(Number(report, "jobs"), 121);
    EXPECT_EQ(Number(report, "succeeded"), 120);
    EXPECT_EQ(Number(report, "failed"), 1);
    const auto& results = report.fields().at("results").list_value();
    ASSERT_EQ(results.values_size(), 121);
    const auto& bad = results.values(kJobs / 2 + 1).struct_value().fields();
    EXPECT_EQ(bad.at("id").string_value(), "bad");
    EXPECT_EQ(bad.at("reason").string_value(), "INCONSISTENT_ORIENTATION");
    EXPECT_NE(bad.at("message").string_value(), "");
  }
}

TEST_F(BatchE2e, AFolderIsABatchAndEveryJobHasTheFilesThatAreAskedFor) {
  Generate(3, 80);
  const RunResult run =
      space_.Limn({"batch", At("meshes"), "-o", At("out"), "--format", "glb", "--format", "obj",
                   "--control-mesh", "--job-reports", "--scheme", "catmull-clark"});
  ASSERT_EQ(run.status, 0) << run.errors;
  for (int i = 0; i < 3; ++i) {
    const std::string base = At("out/mesh-" + std::to_string(i));
    ASSERT_EQ(space_
                  .Limn({"interpolate", MeshOf(i), "-o", At("s.glb"), "-o", At("s.obj"),
                         "--control-mesh", At("c.obj"), "--scheme", "catmull-clark", "-q"})
                  .status,
              0);
    EXPECT_EQ(ReadAll(base + ".glb"), ReadAll(At("s.glb")));
    EXPECT_EQ(ReadAll(base + ".obj"), ReadAll(At("s.obj")));
    EXPECT_EQ(ReadAll(base + ".control.obj"), ReadAll(At("c.obj")));
    EXPECT_EQ(Number(Parse(ReadAll(base + ".json")), "level"), 2);
  }
}

TEST_F(BatchE2e, GoesOnWhenTheServerIsKilledAndComesBack) {
  constexpr int kJobs = 120;
  constexpr int kMeshes = 4;
  Generate(kMeshes, 6000);
  WriteManifest(kJobs, kMeshes, false);
  ServerProcess server(space_);
  Process* batch =
      space_.StartLimn({"batch", At("jobs.jsonl"), "-o", At("out"), "--server", server.address()});
  ASSERT_TRUE(WaitUntil(30, [&] { return Surfaces("out") >= 5; })) << batch->ErrorText();
  server.process().Signal(SIGKILL);
  server.process().Wait();
  EXPECT_LT(Surfaces("out"), static_cast<std::size_t>(kJobs)) << "too quick to be killed";
  const auto again = StartAgain(server.address());
  EXPECT_EQ(batch->Wait(60), 0) << batch->ErrorText();
  ExpectSurfaces(kJobs, kMeshes, "out");
  ExpectEachSucceededOnce(kJobs, "out");
}

TEST_F(BatchE2e, ResumeDoesWhatAServerThatStayedAwayLeft) {
  constexpr int kJobs = 120;
  constexpr int kMeshes = 4;
  Generate(kMeshes, 6000);
  WriteManifest(kJobs, kMeshes, false);
  ServerProcess server(space_);
  Process* batch = space_.StartLimn(
      {"batch", At("jobs.jsonl"), "-o", At("out"), "--tries", "2", "--server", server.address()});
  ASSERT_TRUE(WaitUntil(30, [&] { return Surfaces("out") >= 5; })) << batch->ErrorText();
  server.process().Signal(SIGKILL);
  EXPECT_EQ(batch->Wait(60), 3);
  EXPECT_NE(batch->ErrorText().find("--resume"), std::string::npos) << batch->ErrorText();
  const std::map<std::string, int> before = Successes("out");
  EXPECT_GE(before.size(), 5U);
  EXPECT_EQ(Parts("out"), 0U);

  const auto again = StartAgain(server.address());
  const RunResult run = space_.Limn({"batch", At("jobs.jsonl"), "-o", At("out"), "--resume",
                                     "--server", server.address(), "--report", At("r.json")});
  EXPECT_EQ(run.status, 0) << run.errors;
  EXPECT_EQ(Number(Parse(ReadAll(At("r.json"))), "skipped"), before.size());
  ExpectSurfaces(kJobs, kMeshes, "out");
  ExpectEachSucceededOnce(kJobs, "out");
}

TEST_F(BatchE2e, CtrlCKeepsWhatIsDoneAndResumeDoesTheRest) {
  constexpr int kJobs = 120;
  constexpr int kMeshes = 4;
  Generate(kMeshes, 6000);
  WriteManifest(kJobs, kMeshes, false);
  Process* batch = space_.StartLimn({"batch", At("jobs.jsonl"), "-o", At("out")});
  ASSERT_TRUE(WaitUntil(30, [&] { return Surfaces("out") >= 5; })) << batch->ErrorText();
  batch->Signal(SIGINT);
  EXPECT_EQ(batch->Wait(20), kInterrupted);
  EXPECT_NE(batch->ErrorText().find("interrupted; "), std::string::npos) << batch->ErrorText();
  EXPECT_NE(batch->ErrorText().find("--resume"), std::string::npos) << batch->ErrorText();
  EXPECT_EQ(Parts("out"), 0U);
  const std::map<std::string, int> before = Successes("out");
  EXPECT_EQ(Surfaces("out"), before.size());
  EXPECT_LT(before.size(), static_cast<std::size_t>(kJobs)) << "too quick to be interrupted";

  EXPECT_EQ(space_.Limn({"batch", At("jobs.jsonl"), "-o", At("out")}).status, 2)
      << "it has to be said what is to become of what there is";
  const RunResult run = space_.Limn({"batch", At("jobs.jsonl"), "-o", At("out"), "--resume"});
  EXPECT_EQ(run.status, 0) << run.errors;
  ExpectSurfaces(kJobs, kMeshes, "out");
  ExpectEachSucceededOnce(kJobs, "out");
}

TEST_F(BatchE2e, AClientThatIsKilledGoesOnByResumeThoughItsLastLineWasCutOff) {
  constexpr int kJobs = 120;
  constexpr int kMeshes = 4;
  Generate(kMeshes, 6000);
  WriteManifest(kJobs, kMeshes, false);
  ServerProcess server(space_);
  const std::vector<std::string> command = {"batch",   At("jobs.jsonl"), "-o",
                                            At("out"), "--server",       server.address()};
  Process* batch = space_.StartLimn(command);
  ASSERT_TRUE(WaitUntil(30, [&] { return Surfaces("out") >= 5; })) << batch->ErrorText();
  batch->Signal(SIGKILL);
  batch->Wait();
  const std::string journal = At("out/limn-batch.jsonl");
  WriteAll(journal, ReadAll(journal) + R"({"id": "job-119", "digest": "12)");
  std::vector<std::string> again = command;
  again.emplace_back("--resume");
  const RunResult run = space_.Limn(again);
  EXPECT_EQ(run.status, 0) << run.errors << server.Log();
  ExpectSurfaces(kJobs, kMeshes, "out");
  ExpectEachSucceededOnce(kJobs, "out");
}

TEST_F(BatchE2e, ResumeDoesAgainWhatChangedOrIsGoneAndNothingElse) {
  Generate(4, 80);
  const std::vector<std::string> command = {"batch",    At("meshes"), "-o",        At("out"),
                                            "--resume", "--report",   At("r.json")};
  ASSERT_EQ(space_.Limn(command).status, 0);
  const auto first = Parse(ReadAll(At("r.json")));
  EXPECT_EQ(Number(first, "succeeded"), 4);
  ASSERT_EQ(space_.Limn(command).status, 0);
  EXPECT_EQ(Number(Parse(ReadAll(At("r.json"))), "skipped"), 4);

  fs::remove(At("out/mesh-1.ply"));
  fs::copy_file(MeshOf(0), MeshOf(2), fs::copy_options::overwrite_existing);
  ASSERT_EQ(space_.Limn(command).status, 0);
  const auto second = Parse(ReadAll(At("r.json")));
  EXPECT_EQ(Number(second, "skipped"), 2);
  EXPECT_EQ(Number(second, "succeeded"), 2);
  EXPECT_EQ(ReadAll(At("out/mesh-2.ply")), ReadAll(At("out/mesh-0.ply")));

  std::vector<std::string> finer = command;
  finer.insert(finer.end(), {"--level", "1"});
  ASSERT_EQ(space_.Limn(finer).status, 0);
  EXPECT_EQ(Number(Parse(ReadAll(At("r.json"))), "succeeded"), 4);
}

TEST_F(BatchE2e, ConstraintsOfALineWinAndErrorsNameTheFile) {
  Generate(2, 80);
  WriteAll(At("some.json"), R"({"interpolate": {"vertices": [0, 5]}})");
  WriteAll(At("wrong.json"), R"({"interpolate": {"vertices": [0, 5000]}})");
  WriteAll(At("jobs.jsonl"), R"({"input": "meshes/mesh-0.obj"})"
                             "\n"
                             R"({"input": "meshes/mesh-1.obj", "constraints": "wrong.json"})"
                             "\n");
  const RunResult run =
      space_.Limn({"batch", At("jobs.jsonl"), "-o", At("out"), "--constraints", At("some.json")});
  EXPECT_EQ(run.status, kPartial) << run.errors;
  EXPECT_NE(run.errors.find("mesh-1: " + At("wrong.json") + ": constraints.interpolate"),
            std::string::npos)
      << run.errors;
  ASSERT_EQ(
      space_.Limn({"interpolate", MeshOf(0), "--constraints", At("some.json"), "-o", At("s.ply")})
          .status,
      0);
  EXPECT_TRUE(ReadAll(At("s.ply")) == ReadAll(At("out/mesh-0.ply")));
}

TEST_F(BatchE2e, WhatMakesNoSenseIsRefusedBeforeAnyWork) {
  Generate(2, 80);
  struct Case {
    std::string manifest;
    std::vector<std::string> flags;
    int status;
    std::string message;
  };
  const std::string one = R"({"input": "meshes/mesh-0.obj"})";
  const std::string other = R"({"input": "meshes/mesh-1.obj")";
  const std::vector<Case> cases = {
      {one + "\n" + one + "\n", {}, 2, "jobs.jsonl:2: the id 'mesh-0' is that of"},
      {one + "\n\n" + other + R"(, "output": "mesh-0"})", {}, 2, "jobs.jsonl:3: the output"},
      {other + R"(, "output": "../x"})", {}, 2, "jobs.jsonl:1: the output '../x' is no plain name"},
      {other + R"(, "levle": 1})", {}, 1, "no member 'levle'; did you mean level?"},
      {other + R"(, "level": 11})", {}, 1, "level is not a whole number from 0 to 10"},
      {other + R"(, "level": "1"})", {}, 1, "level is not a whole number from 0 to 10"},
      {other + R"(, "scheme": "lop"})", {}, 1, "scheme is not doo-sabin"},
      {other + R"(, "level": 1, "chordTolerance": 1})", {}, 2, "both a level and"},
      {one + "\n" + other, {}, 1, "jobs.jsonl:2: no JSON"},
      {"[1]", {}, 1, "jobs.jsonl:1: "},
      {R"({"id": "a"})", {}, 1, "jobs.jsonl:1: it has no input"},
      {"\n", {}, 1, "there are no jobs in it"},
      {one, {"--format", "gltf"}, 2, "--format"},
      {one, {"--report", At("out/mesh-0.ply")}, 2, "would be written by two jobs"},
      {one, {"--report", At("jobs.jsonl")}, 2, "is an input"},
      {R"({"input": "out/mesh-0.ply"})", {}, 2, "is an input"},
      {one, {"--window", "0"}, 2, "--window"},
      {one, {"--strict"}, 2, "--strict"},
  };
  for (const Case& wrong : cases) {
    WriteAll(At("jobs.jsonl"), wrong.manifest);
    std::vector<std::string> command = {"batch", At("jobs.jsonl"), "-o", At("out")};
    command.insert(command.end(), wrong.flags.begin(), wrong.flags.end());
    const RunResult run = space_.Limn(command);
    EXPECT_EQ(run.status, wrong.status) << wrong.manifest << run.errors;
    EXPECT_NE(run.errors.find(wrong.message), std::string::npos) << wrong.manifest << run.errors;
    EXPECT_EQ(Surfaces("out"), 0U);
    EXPECT_FALSE(fs::exists(At("out/limn-batch.jsonl"))) << wrong.manifest;
  }
  const RunResult run = space_.Limn({"batch", At("meshes"), "-o", At("meshes")});
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.errors.find("-o is the folder of the meshes"), std::string::npos) << run.errors;
}

TEST_F(BatchE2e, OneFolderHasOneBatchAtATime) {
  Generate(2, 3000);
  WriteManifest(40, 2, false);
  Process* batch = space_.StartLimn({"batch", At("jobs.jsonl"), "-o", At("out")});
  ASSERT_TRUE(WaitUntil(30, [&] { return Surfaces("out") >= 1; })) << batch->ErrorText();
  const RunResult run = space_.Limn({"batch", At("jobs.jsonl"), "-o", At("out"), "--resume"});
  EXPECT_EQ(run.status, 2);
  EXPECT_NE(run.errors.find("another batch is writing there"), std::string::npos) << run.errors;
  EXPECT_EQ(batch->Wait(60), 0) << batch->ErrorText();
  EXPECT_NE(batch->ErrorText().find(" of 40 jobs"), std::string::npos) << "there was no bar";
}

TEST_F(BatchE2e, AResultThatHasNoPlaceFailsAloneAndADiskThatTakesNothingEndsTheBatch) {
  Generate(3, 80);
  fs::create_directories(At("one/mesh-0.ply"));
  const RunResult one = space_.Limn({"batch", At("meshes"), "-o", At("one")});
  EXPECT_EQ(one.status, kPartial) << one.errors;
  EXPECT_NE(one.errors.find("mesh-0.ply"), std::string::npos) << one.errors;
  EXPECT_TRUE(fs::is_regular_file(At("one/mesh-1.ply")));

  fs::create_directories(At("all"));
  fs::create_symlink(At("gone/mesh-0.ply"), At("all/mesh-0.ply"));
  const RunResult all = space_.Limn({"batch", At("meshes"), "-o", At("all")});
  EXPECT_EQ(all.status, 1) << all.errors;
  EXPECT_NE(all.errors.find("0 of 3 jobs done; --resume"), std::string::npos) << all.errors;
  fs::remove(At("all/mesh-0.ply"));
  EXPECT_EQ(space_.Limn({"batch", At("meshes"), "-o", At("all"), "--resume"}).status, 0);
}

}  // namespace
}  // namespace limn::e2e
