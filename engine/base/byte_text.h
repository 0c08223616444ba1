// SPDX-License-Identifier: MIT
// Numbers of bytes for people and for flags.
#pragma once

#include <cstdint>
#include <string>

namespace limn {

// "20.1 GiB (21617117763 bytes)", with the largest of KiB, MiB, GiB and TiB that there is one of;
// "1000 bytes" below them. Thread-safe.
[[nodiscard]] std::string ByteText(std::uint64_t bytes);

}  // namespace limn
