// SPDX-License-Identifier: MIT
#include "engine/base/byte_text.h"

#include <array>
#include <string_view>

#include "absl/strings/str_cat.h"

namespace limn {

std::string ByteText(std::uint64_t bytes) {
  constexpr std::array<std::string_view, 4> kUnits = {" KiB", " MiB", " GiB", " TiB"};
  constexpr double kNext = 1024;
  if (bytes < 1024) return absl::StrCat(bytes, bytes == 1 ? " byte" : " bytes");
  double value = static_cast<double>(bytes) / kNext;
  std::size_t unit = 0;
  for (; unit + 1 < kUnits.size() && value >= kNext; ++unit) value /= kNext;
  const auto tenths = static_cast<std::uint64_t>(10 * value + 0.5);
  return absl::StrCat(tenths / 10, ".", tenths % 10, std::string(kUnits[unit]), " (", bytes,
                      " bytes)");
}

}  // namespace limn
