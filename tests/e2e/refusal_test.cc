// SPDX-License-Identifier: MIT
// Files that are no usable meshes: a message, exit status 1, and no output file.
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/e2e/process.h"

namespace limn::e2e {
namespace {

constexpr const char* kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

std::string Replaced(std::string text, const std::string& what, const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

std::string Garbage(std::size_t bytes) {
  std::mt19937 random(20260101);
  std::string garbage(bytes, 0);
  for (char& c : garbage) c = static_cast<char>(random());
  return garbage;
}

struct BrokenFile {
  std::string name;
  std::string extension;
  std::string bytes;
};

std::vector<BrokenFile> BrokenFiles() {
  const std::string cube = kCube;
  const std::string off = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty "
      "double z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
      "0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n";
  std::vector<BrokenFile> files = {
      {"NotANumber", "obj", Replaced(cube, "v 1 1 1", "v 1 nan 1")},
      {"Infinite", "obj", Replaced(cube, "v 1 1 1", "v 1 inf 1")},
      {"TooLarge", "obj", Replaced(cube, "v 1 1 1", "v 1e308 -1e308 1e308")},
      {"OverflowingNumber", "obj", Replaced(cube, "v 1 1 1", "v 1e999 1 1")},
      {"TextForANumber", "obj", Replaced(cube, "v 1 1 1", "v one 1 1")},
      {"IndexTooLarge", "obj", Replaced(cube, "f 5 6 7 8", "f 5 6 7 9")},
      {"IndexZero", "obj", Replaced(cube, "f 5 6 7 8", "f 0 6 7 8")},
      {"IndexHuge", "obj", Replaced(cube, "f 5 6 7 8", "f 5 6 7 99999999999999999999")},
      {"IndexNegativeTooFar", "obj", Replaced(cube, "f 5 6 7 8", "f -9 -3 -2 -1")},
      {"FaceOfTwo", "obj", Replaced(cube, "f 5 6 7 8", "f 5 6")},
      {"RepeatedVertex", "obj", Replaced(cube, "f 5 6 7 8", "f 5 6 6 8")},
      {"RepeatedFace", "obj", cube + "f 4 3 2 1\n"},
      {"TurnedFace", "obj", Replaced(cube, "f 5 6 7 8", "f 8 7 6 5")},
      {"IsolatedVertex", "obj", "v 9 9 9\n" + Replaced(cube, "f 4 3 2 1", "f 5 4 3 2")},
      {"NoFaces", "obj", cube.substr(0, cube.find('f'))},
      {"NoVertices", "obj", "f 1 2 3\n"},
      {"TruncatedOff", "off", off},
      {"OffWithHugeCounts", "off", "OFF\n4000000000 4000000000 0\n0 0 0\n"},
      {"OffWithNegativeCounts", "off", "OFF\n-4 -4 0\n0 0 0\n"},
      {"OffIndexTooLarge", "off", off + "3 1 2 4\n"},
      {"TruncatedPly", "ply", ply},
      {"PlyIndexTooLarge", "ply", ply + "3 0 3 2\n3 1 2 77\n"},
      {"PlyNegativeIndex", "ply", ply + "3 0 3 2\n3 1 2 -1\n"},
      {"TruncatedStl", "stl", std::string(80, ' ') + std::string("\x08\0\0\0", 4) + "short"},
      {"StlWithHugeCount", "stl", std::string(80, ' ') + "\xff\xff\xff\xff" + std::string(50, 0)},
  };
  for (const std::string extension : {"obj", "off", "ply", "stl"}) {
    files.push_back({"Empty_" + extension, extension, ""});
    files.push_back({"Newline_" + extension, extension, "\n"});
    files.push_back({"Garbage_" + extension, extension, Garbage(5000)});
    files.push_back({"Zeros_" + extension, extension, std::string(5000, 0)});
  }
  return files;
}

class BrokenFileE2e : public testing::TestWithParam<BrokenFile> {
 protected:
  // Runs the job on the broken file and expects a refusal.
  void ExpectRefused(const std::vector<std::string>& flags) {
    const std::string in = space_.path("in." + GetParam().extension);
    WriteAll(in, GetParam().bytes);
    std::vector<std::string> arguments = {"interpolate",
                                          in,
                                          "-o",
                                          space_.path("s.obj"),
                                          "--control-mesh",
                                          space_.path("c.obj"),
                                          "--report",
                                          space_.path("r.json")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const RunResult run = space_.Limn(arguments);
    EXPECT_EQ(run.status, 1) << run.output << run.errors;
    EXPECT_TRUE(run.errors.starts_with("limn: ")) << run.errors;
    EXPECT_GT(run.errors.size(), 20U) << run.errors;
    EXPECT_EQ(space_.Files(), std::vector<std::string>{"in." + GetParam().extension});
  }

  Workspace space_;
};

TEST_P(BrokenFileE2e, IsRefusedAndLeavesNothing) { ExpectRefused({}); }

TEST_P(BrokenFileE2e, IsRefusedByTheServerWhichLivesOn) {
  ServerProcess server(space_);
  ExpectRefused({"--server", server.address()});
  EXPECT_TRUE(server.process().Running()) << server.Log();
  WriteAll(space_.path("good.obj"), kCube);
  const RunResult run = space_.Limn({"interpolate", space_.path("good.obj"), "-o",
                                     space_.path("s.obj"), "--server", server.address()});
  EXPECT_EQ(run.status, 0) << run.errors << server.Log();
}

TEST_P(BrokenFileE2e, InfoDoesNotCrash) {
  const std::string in = space_.path("in." + GetParam().extension);
  WriteAll(in, GetParam().bytes);
  EXPECT_LE(space_.Limn({"info", in}).status, 1);
  EXPECT_LE(space_.Limn({"info", in, "--json"}).status, 1);
}

INSTANTIATE_TEST_SUITE_P(Files, BrokenFileE2e, testing::ValuesIn(BrokenFiles()),
                         [](const auto& file) { return file.param.name; });

class RefusalE2e : public testing::Test {
 protected:
  std::string At(const std::string& name) const { return space_.path(name); }
  Workspace space_;
};

// A text file that ends early is cut at many bytes. What is left may be a mesh, an open one.
TEST_F(RefusalE2e, NoTruncationCrashesOrLeavesAnOutputAfterAFailure) {
  const std::string cube = kCube;
  int worked = 0;
  for (std::size_t length = 0; length < cube.size(); length += 7) {
    WriteAll(At("in.obj"), cube.substr(0, length));
    const RunResult run = space_.Limn({"interpolate", At("in.obj"), "-o", At("s.obj")});
    if (run.status == 0) {
      ++worked;
      EXPECT_EQ(space_.Files(), (std::vector<std::string>{"in.obj", "s.obj"}));
      std::filesystem::remove(At("s.obj"));
      continue;
    }
    EXPECT_EQ(run.status, 1) << length << run.errors;
    EXPECT_EQ(space_.Files(), std::vector<std::string>{"in.obj"});
  }
  EXPECT_LE(worked, 5);
}

TEST_F(RefusalE2e, MessageNamesTheFileOrThePlaceAndTheRemedy) {
  const std::string cube = kCube;
  WriteAll(At("in.obj"), Replaced(cube, "f 5 6 7 8", "f 5 6 7 9"));
  const RunResult index = space_.Limn({"interpolate", At("in.obj")});
  for (const char* word : {"in.obj", "line 10", "face 1", "8 vertices"}) {
    EXPECT_NE(index.errors.find(word), std::string::npos) << word << " in " << index.errors;
  }
  WriteAll(At("in.obj"), cube + "f 1 2 3 4\n");
  const RunResult edge = space_.Limn({"interpolate", At("in.obj")});
  for (const char* word : {"non-manifold edges", "face", "edge"}) {
    EXPECT_NE(edge.errors.find(word), std::string::npos) << word << " in " << edge.errors;
  }
}

TEST_F(RefusalE2e, WhatRepairWouldMendSaysSo) {
  const std::string cube = kCube;
  const std::string broken[] = {
      Replaced(cube, "f 5 6 7 8", "f 5 6"),
      Replaced(cube, "f 5 6 7 8", "f 5 6 6 8"),
      cube + "f 4 3 2 1\n",
      Replaced(cube, "f 5 6 7 8", "f 8 7 6 5"),
      "v 9 9 9\n" + Replaced(cube, "f 4 3 2 1", "f 5 4 3 2"),
  };
  for (const std::string& bytes : broken) {
    WriteAll(At("in.obj"), bytes);
    const RunResult run = space_.Limn({"interpolate", At("in.obj")});
    EXPECT_EQ(run.status, 1);
    EXPECT_NE(run.errors.find("--repair"), std::string::npos) << run.errors;
  }
}

TEST_F(RefusalE2e, FilesThatAreNotThereOrOfNoKnownKindAreNamed) {
  const RunResult missing = space_.Limn({"interpolate", At("nowhere.obj"), "-o", At("s.obj")});
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.errors.find("nowhere.obj"), std::string::npos) << missing.errors;
  WriteAll(At("in.docx"), kCube);
  const RunResult unknown = space_.Limn({"interpolate", At("in.docx"), "-o", At("s.obj")});
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.errors.find("docx"), std::string::npos) << unknown.errors;
  const RunResult directory = space_.Limn({"interpolate", At("."), "-o", At("s.obj")});
  EXPECT_EQ(directory.status, 1);
  EXPECT_NE(directory.errors.find("is not a regular file"), std::string::npos) << directory.errors;
  EXPECT_EQ(space_.Files(), std::vector<std::string>{"in.docx"});
}

// The table is printed before the files appear.
TEST_F(RefusalE2e, AFullStandardOutputLeavesNoFile) {
  WriteAll(At("in.obj"), kCube);
  const std::string command = "'" LIMN_BINARY "' interpolate '" + At("in.obj") + "' -o '" +
                              At("s.obj") + "' >/dev/full 2>'" + At("errors") + "'";
  EXPECT_NE(std::system(command.c_str()), 0);
  EXPECT_FALSE(std::filesystem::exists(At("s.obj")));
  EXPECT_NE(ReadAll(At("errors")).find("standard output"), std::string::npos);
}

TEST_F(RefusalE2e, AByteOrderMarkIsNoPartOfTheFile) {
  WriteAll(At("in.obj"), std::string("\xef\xbb\xbf") + kCube);
  const RunResult run = space_.Limn({"info", At("in.obj")});
  EXPECT_EQ(run.status, 0) << run.errors;
  EXPECT_NE(run.output.find("vertices"), std::string::npos);
  EXPECT_EQ(space_.Limn({"interpolate", At("in.obj"), "-o", At("s.off")}).status, 0);
  const std::string off = ReadAll(At("s.off"));
  // 8 vertices, 24 corners, 12 edges and 6 faces make 26 vertices at level 1, 98 at level 2.
  EXPECT_TRUE(off.starts_with("OFF\n98 96 ")) << off.substr(0, 20);
}

TEST_F(RefusalE2e, AFailureLeavesAnOlderOutputAsItWas) {
  WriteAll(At("in.obj"), "f 1 2 3\n");
  WriteAll(At("s.obj"), "older");
  EXPECT_EQ(space_.Limn({"interpolate", At("in.obj"), "-o", At("s.obj")}).status, 1);
  EXPECT_EQ(ReadAll(At("s.obj")), "older");
}

}  // namespace
}  // namespace limn::e2e
