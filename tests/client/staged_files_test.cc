// SPDX-License-Identifier: MIT
// Output files appear all together or not at all, and older ones survive failures.
#include "client/cli/staged_files.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace limn::cli {
namespace {

namespace fs = std::filesystem;

class StagedFilesTest : public testing::Test {
 protected:
  StagedFilesTest() {
    std::string pattern = (fs::temp_directory_path() / "limn-staged-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~StagedFilesTest() override { fs::remove_all(folder_); }

  std::string At(const std::string& name) const { return (folder_ / name).string(); }
  static void Put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }
  static std::string Get(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::set<std::string> Names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  void Stage(StagedFiles* files, const std::string& name, const std::string& text) const {
    const auto file = files->Create(At(name));
    ASSERT_TRUE(file.ok()) << file.status();
    (*file)->Append(text);
  }

  fs::path folder_;
};

TEST_F(StagedFilesTest, FilesAppearAtTheCommitAndLeaveNothingElse) {
  Put(At("a"), "older");
  {
    StagedFiles files;
    Stage(&files, "a", "newer");
    Stage(&files, "b", "new");
    EXPECT_EQ(Get(At("a")), "older");
    EXPECT_FALSE(fs::exists(At("b")));
    ASSERT_TRUE(files.Commit().ok());
  }
  EXPECT_EQ(Get(At("a")), "newer");
  EXPECT_EQ(Get(At("b")), "new");
  EXPECT_EQ(Names(), (std::set<std::string>{"a", "b"}));
}

TEST_F(StagedFilesTest, WhatIsNotCommittedLeavesTheFolderAsItWas) {
  Put(At("a"), "older");
  {
    StagedFiles files;
    Stage(&files, "a", "newer");
    Stage(&files, "b", "new");
  }
  EXPECT_EQ(Get(At("a")), "older");
  EXPECT_EQ(Names(), std::set<std::string>{"a"});
}

// The last of three cannot be put in its place: a folder has taken it.
TEST_F(StagedFilesTest, AFailedCommitPutsOlderFilesBack) {
  Put(At("a"), "older a");
  {
    StagedFiles files;
    Stage(&files, "a", "newer a");
    Stage(&files, "b", "new b");
    Stage(&files, "c", "new c");
    fs::create_directory(At("c"));
    Put(At("c/inside"), "x");
    EXPECT_FALSE(files.Commit().ok());
  }
  EXPECT_EQ(Get(At("a")), "older a");
  EXPECT_EQ(Names(), (std::set<std::string>{"a", "c"}));
  EXPECT_EQ(Get(At("c/inside")), "x");
}

TEST_F(StagedFilesTest, LinksAreFollowedAlsoToWhatDoesNotExistYet) {
  fs::create_symlink("target", At("dangling"));
  Put(At("real"), "older");
  fs::create_symlink("real", At("link"));
  StagedFiles files;
  Stage(&files, "dangling", "one");
  Stage(&files, "link", "two");
  ASSERT_TRUE(files.Commit().ok());
  EXPECT_TRUE(fs::is_symlink(At("dangling")));
  EXPECT_TRUE(fs::is_symlink(At("link")));
  EXPECT_EQ(Get(At("target")), "one");
  EXPECT_EQ(Get(At("real")), "two");
}

// Nobody can place a link under the name that will be written to.
TEST_F(StagedFilesTest, NamesThatAreTakenAreNotWrittenThrough) {
  Put(At("victim"), "precious");
  for (int i = 0; i < 2000; ++i) {
    for (const char* extension : {".part", ".older", ".obj"}) {
      fs::create_symlink(
          "victim", At(".limn-" + std::to_string(getpid()) + "-" + std::to_string(i) + extension));
    }
  }
  Put(At("out.obj"), "older");
  {
    StagedFiles files;
    Stage(&files, "out.obj", "new");
    ASSERT_TRUE(files.Commit().ok());
  }
  EXPECT_EQ(Get(At("victim")), "precious");
  EXPECT_EQ(Get(At("out.obj")), "new");
  EXPECT_FALSE(fs::is_symlink(At("out.obj")));
}

TEST_F(StagedFilesTest, WritingEndsSoonAfterTheWishToStop) {
  bool stop = false;
  StagedFiles files([&stop] { return stop; });
  const auto file = files.Create(At("large"));
  ASSERT_TRUE(file.ok());
  const std::string block(100'000, 'x');
  for (int i = 0; i < 30; ++i) (*file)->Append(block);
  EXPECT_TRUE((*file)->ok());
  stop = true;
  for (int i = 0; i < 30; ++i) (*file)->Append(block);
  EXPECT_FALSE((*file)->ok());
  EXPECT_EQ(files.Commit().code(), absl::StatusCode::kCancelled);
  EXPECT_FALSE(fs::exists(At("large")));
}

}  // namespace
}  // namespace limn::cli
