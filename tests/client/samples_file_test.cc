// SPDX-License-Identifier: MIT
// Files of parameters and samples: what they hold arrives; what is wrong is said with its place.
#include "client/cli/samples_file.h"

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

std::string MessageOf(const std::string& text) {
  const auto file = ParseParameters(text, "p.txt");
  EXPECT_FALSE(file.ok()) << text;
  if (file.ok()) return "";
  EXPECT_EQ(GetErrorDetail(file.status())->reason == Reason::kMalformedFile ||
                GetErrorDetail(file.status())->reason == Reason::kMalformedRequest,
            true);
  return std::string(file.status().message());
}

TEST(ParametersFile, LinesHoldFaceCornerUV) {
  const auto file = ParseParameters(
      "# made by hand\n0 1 0.5 0.25\n\r\n  4294967295\t2 1e-300 -0  # why not\n+3 0 nan inf",
      "p.txt");
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_EQ(file->parameters.size(), 3U);
  EXPECT_EQ(file->parameters[0].face, 0U);
  EXPECT_EQ(file->parameters[0].corner, 1U);
  EXPECT_EQ(file->parameters[0].u, 0.5);
  EXPECT_EQ(file->parameters[0].v, 0.25);
  EXPECT_EQ(file->parameters[1].face, 4294967295U);
  EXPECT_EQ(file->parameters[1].u, 1e-300);
  EXPECT_TRUE(std::isnan(file->parameters[2].u));
  EXPECT_EQ(file->lines, (std::vector<std::uint64_t>{2, 4, 5}));
}

TEST(ParametersFile, NothingIsNoParameters) {
  for (const char* text : {"", "\n\n", "# only a comment", "{}", " \n {}\n"}) {
    const auto file = ParseParameters(text, "p.txt");
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_TRUE(file->parameters.empty());
  }
}

TEST(ParametersFile, JsonIsThatOfParameterBlock) {
  const auto file = ParseParameters(
      R"({"faces": [7, 0], "corners": [1, 2], "u": [0.5, 5e-324], "v": [1, "NaN"]})", "p.json");
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_EQ(file->parameters.size(), 2U);
  EXPECT_EQ(file->parameters[0].face, 7U);
  EXPECT_EQ(file->parameters[1].corner, 2U);
  EXPECT_EQ(file->parameters[1].u, 5e-324);
  EXPECT_TRUE(std::isnan(file->parameters[1].v));
  EXPECT_TRUE(file->lines.empty());
}

TEST(ParametersFile, WhatIsWrongIsSaidWithItsLine) {
  const auto expect = [](const std::string& text, const std::vector<std::string>& words) {
    const std::string message = MessageOf(text);
    for (const std::string& word : words) {
      EXPECT_NE(message.find(word), std::string::npos) << message;
    }
  };
  expect("0 0 0 0\nx 0 0 0", {"p.txt:2: ", "face", "\"x\""});
  expect("0 -1 0 0", {"p.txt:1: ", "corner", "\"-1\""});
  expect("0 4294967296 0 0", {"p.txt:1: ", "corner"});
  expect("0 1.5 0 0", {"corner"});
  expect("0 0 half 0", {"p.txt:1: u is", "\"half\""});
  expect("0 0 0", {"p.txt:1: v is the end of the line"});
  expect("#\n0 0 0 0 0", {"p.txt:2: ", "after the four"});
  expect("0,0,0,0", {"p.txt:1: ", "face"});
  expect("{\"faces\": [1]}", {"p.txt: ", "1 faces, but 0 corners"});
  expect("{\"faces\": [1], \"corners\": [1], \"u\": [0], \"v\": []}", {"0 v"});
  expect("{\"face\": 1}", {"p.txt: ", "face", "no such field"});
  expect("{\"faces\": [-1]}", {"p.txt: ", "faces"});
  expect("{", {"p.txt: ", "no JSON"});
}

TEST(ParametersFile, ErrorsOfTheServerAreGivenTheirLine) {
  const ParametersFile lines = {.name = "p.txt", .parameters = {{}, {}}, .lines = {3, 9}};
  const ParametersFile json = {.name = "p.json", .parameters = {{}, {}}};
  const absl::Status status = MakeError(
      "it is 2", {.reason = Reason::kInvalidOption, .field = "parameters[1].u", .index = 1});
  EXPECT_EQ(NameParametersFile(status, lines).message(), "p.txt:9: it is 2");
  EXPECT_EQ(GetErrorDetail(NameParametersFile(status, lines))->field, "parameters[1].u");
  EXPECT_EQ(NameParametersFile(status, json).message(), "p.json: it is 2");
  const absl::Status other =
      MakeError("no", {.reason = Reason::kIndexOutOfRange, .field = "mesh.faces", .index = 1});
  EXPECT_EQ(NameParametersFile(other, lines), other);
}

TEST(SamplesFile, FormatsAreKnownByExtension) {
  EXPECT_EQ(*SampleFormatOf("a/b.txt"), SampleFormat::kText);
  EXPECT_EQ(*SampleFormatOf("b.c.csv"), SampleFormat::kCsv);
  EXPECT_EQ(*SampleFormatOf("b.json"), SampleFormat::kJson);
  for (const char* path : {"b", "b.obj", "txt", "b.txt.gz", ""}) {
    EXPECT_EQ(GetErrorDetail(SampleFormatOf(path).status())->reason, Reason::kInvalidOption);
  }
}

class SamplesFileTest : public testing::Test {
 protected:
  SamplesFileTest() {
    const double third = 1.0 / 3;
    for (int i = 0; i < 1000; ++i) {
      const double x = third * i;
      parameters_.push_back({static_cast<Index>(i), 2, x / 400, 0x1p-1074});
      result_.points.push_back({x, -x, 1e300 * x});
      result_.normals.push_back({0, 0.6, -0.8});
      result_.du.push_back({x * x, 5e-324, std::nextafter(1.0, 2.0)});
      result_.dv.push_back({-0.0, 1e-17, 123456789.123456789});
    }
  }
  std::string Text(SampleFormat format) const {
    std::string text;
    WriteSamples(format, parameters_, result_, [&](std::string_view piece) {
      text += piece;
      return true;
    });
    return text;
  }
  // The twelve numbers of sample i.
  std::vector<double> Numbers(std::size_t i) const {
    std::vector<double> numbers;
    for (const Vec3& a : {result_.points[i], result_.normals[i], result_.du[i], result_.dv[i]}) {
      numbers.insert(numbers.end(), {a.x, a.y, a.z});
    }
    return numbers;
  }
  static double Read(absl::string_view token) {
    double value = 0;
    EXPECT_EQ(std::from_chars(token.data(), token.data() + token.size(), value).ptr,
              token.data() + token.size())
        << std::string(token);
    return value;
  }

  std::vector<SurfaceParameter> parameters_;
  EvaluateResult result_;
};

TEST_F(SamplesFileTest, TextAndCsvReadBackToTheBit) {
  for (const SampleFormat format : {SampleFormat::kText, SampleFormat::kCsv}) {
    const bool csv = format == SampleFormat::kCsv;
    const std::string text = Text(format);
    std::vector<std::string> lines = absl::StrSplit(text, '\n');
    ASSERT_EQ(lines.size(), parameters_.size() + (csv ? 2 : 1));
    EXPECT_EQ(lines.back(), "");
    if (csv) {
      EXPECT_EQ(lines[0], "face,corner,u,v,x,y,z,nx,ny,nz,dux,duy,duz,dvx,dvy,dvz");
      lines.erase(lines.begin());
    }
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
      const std::vector<absl::string_view> tokens = absl::StrSplit(lines[i], csv ? ',' : ' ');
      std::vector<double> expected = Numbers(i);
      if (csv) {
        const SurfaceParameter& p = parameters_[i];
        expected.insert(expected.begin(), {static_cast<double>(p.face), 2, p.u, p.v});
      }
      ASSERT_EQ(tokens.size(), expected.size());
      for (std::size_t j = 0; j < tokens.size(); ++j) {
        ASSERT_EQ(Read(tokens[j]), expected[j]) << lines[i];
        ASSERT_EQ(std::signbit(Read(tokens[j])), std::signbit(expected[j])) << lines[i];
      }
    }
  }
}

TEST_F(SamplesFileTest, JsonHasOneObjectPerSample) {
  parameters_.resize(2);
  EXPECT_EQ(Text(SampleFormat::kJson),
            R"({"samples": [
  {"face": 0, "corner": 2, "u": 0, "v": 5e-324, "point": [0, -0, 0], "normal": [0, 0.6, -0.8], )"
            R"("du": [0, 5e-324, 1.0000000000000002], "dv": [-0, 1e-17, 123456789.12345679]},
  {"face": 1, "corner": 2, "u": 0.0008333333333333333, "v": 5e-324, )"
            R"("point": [0.3333333333333333, -0.3333333333333333, 3.3333333333333335e+299], )"
            R"("normal": [0, 0.6, -0.8], "du": [0.1111111111111111, 5e-324, 1.0000000000000002], )"
            R"("dv": [-0, 1e-17, 123456789.12345679]}
]}
)");
  parameters_.clear();
  EXPECT_EQ(Text(SampleFormat::kJson), "{\"samples\": []}\n");
  EXPECT_EQ(Text(SampleFormat::kText), "");
}

TEST_F(SamplesFileTest, WritingEndsWhenNobodyTakesMore) {
  int calls = 0;
  WriteSamples(SampleFormat::kCsv, parameters_, result_, [&](std::string_view) {
    ++calls;
    return false;
  });
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace limn::cli
