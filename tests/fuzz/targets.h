// SPDX-License-Identifier: MIT
// What reads foreign bytes, as functions of any bytes that must neither crash nor hang nor take
// much memory. libFuzzer runs them (fuzz_main.cc), and so do tests with the seeds and damaged
// seeds.
#pragma once

#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace limn::fuzz {

struct Target {
  std::string_view name;
  // Whether the bytes are sound. Ends the process by std::abort when a promise is broken.
  bool (*run)(std::string_view bytes);
  // Sound inputs, and bad ones that once did harm to a program that reads the same format.
  std::vector<std::string> (*seeds)();
};

// For messages of tests.
inline void PrintTo(const Target& target, std::ostream* out) { *out << target.name; }

// "draco_header", "mesh_codec", "constraints", "engine_build".
const std::vector<Target>& Targets();

// That of the name; null when there is none.
const Target* FindTarget(std::string_view name);

}  // namespace limn::fuzz
