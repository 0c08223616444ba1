// SPDX-License-Identifier: MIT
// Words that were meant, and the contract's names in the words of the command line.
#include "client/cli/usage.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/cli/flag_names.h"
#include "client/cli/progress_bar.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

const std::vector<std::string> kKnown = {"--level", "--deadline", "--scheme", "--constraints"};

TEST(UsageTest, NearestWordTakesWhatIsWrongMissingTooMuchOrSwapped) {
  for (const char* word : {"--levle", "--leve", "--levell", "--lavel", "-level"}) {
    EXPECT_EQ(NearestWord(word, kKnown), "--level") << word;
  }
  EXPECT_EQ(NearestWord("--constrains", kKnown), "--constraints");
  EXPECT_EQ(NearestWord("--cons", kKnown), "--constraints");
}

TEST(UsageTest, NearestWordIsNothingWhereNoneIsNear) {
  for (const std::string word : {"--colour", "", "-x", "frobnicate"}) {
    EXPECT_EQ(NearestWord(word, kKnown), std::nullopt) << word;
  }
  EXPECT_EQ(NearestWord(std::string(100'000, 'x'), kKnown), std::nullopt);
  EXPECT_EQ(NearestWord("--level", {}), std::nullopt);
}

TEST(FlagNamesTest, FlagStandsInThePlaceOfTheFieldOrBeforeTheMessage) {
  const auto error = [](const std::string& message, const std::string& field) {
    return MakeError(message, {.reason = Reason::kInvalidOption, .field = field, .remedy = "Try"});
  };
  EXPECT_EQ(MessageInFlags(error("surface.level: it is high", "surface.level")),
            "--level: it is high. Try");
  EXPECT_EQ(MessageInFlags(error("it is high", "surface.level")), "--level: it is high. Try");
  EXPECT_EQ(MessageInFlags(error("--level: it is high", "surface.level")),
            "--level: it is high. Try");
  EXPECT_EQ(MessageInFlags(error("faces[3]: it is small", "mesh.faces")),
            "faces[3]: it is small. Try");
  EXPECT_EQ(MessageInFlags(error("use MESH_ENCODING_DRACO_QUANTIZED or MESH_ENCODING_PACKED", "")),
            "use --encoding draco-quantized or --encoding packed. Try");
  EXPECT_EQ(MessageInFlags(absl::UnknownError("somebody else's")), "somebody else's");
  EXPECT_EQ(FlagOf("surface"), "");
}

TEST(ProgressBarTest, WhatIsNotKnownHasNoBar) {
  EXPECT_EQ(FormatProgress("collect", ProgressBar::kUnknown, "1,000 vertices", 80),
            "collect, 1,000 vertices");
  EXPECT_EQ(FormatProgress("solve", 0.5, "", 80), "[############------------]  50 % solve");
}

}  // namespace
}  // namespace limn::cli
