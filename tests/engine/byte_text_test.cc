// SPDX-License-Identifier: MIT
#include "engine/base/byte_text.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace limn {
namespace {

TEST(ByteTextTest, NumbersHaveTheLargestUnitThatThereIsOneOf) {
  EXPECT_EQ(ByteText(0), "0 bytes");
  EXPECT_EQ(ByteText(1), "1 byte");
  EXPECT_EQ(ByteText(1023), "1023 bytes");
  EXPECT_EQ(ByteText(1024), "1.0 KiB (1024 bytes)");
  EXPECT_EQ(ByteText(1536), "1.5 KiB (1536 bytes)");
  EXPECT_EQ(ByteText(std::uint64_t{8} << 20), "8.0 MiB (8388608 bytes)");
  EXPECT_EQ(ByteText(21'617'117'763), "20.1 GiB (21617117763 bytes)");
  EXPECT_EQ(ByteText(2'742'214'800'391), "2.5 TiB (2742214800391 bytes)");
  EXPECT_EQ(ByteText(std::numeric_limits<std::uint64_t>::max()),
            "16777216.0 TiB (18446744073709551615 bytes)");
}

}  // namespace
}  // namespace limn
