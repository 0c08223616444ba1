// SPDX-License-Identifier: MIT
// libFuzzer's entry. `tests/fuzz/run` builds it, writes the seeds and runs it for a while; the
// target is named by LIMN_FUZZ_TARGET, and LIMN_FUZZ_SEEDS=DIR has the seeds written there and
// nothing else done.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/fuzz/targets.h"

namespace {

const limn::fuzz::Target* target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* const name = std::getenv("LIMN_FUZZ_TARGET");
  target = limn::fuzz::FindTarget(name == nullptr ? "" : name);
  if (target == nullptr) {
    std::fprintf(stderr, "LIMN_FUZZ_TARGET names no target\n");
    std::exit(2);
  }
  if (const char* const directory = std::getenv("LIMN_FUZZ_SEEDS")) {
    int number = 0;
    for (const std::string& seed : target->seeds()) {
      std::ofstream(std::string(directory) + "/seed" + std::to_string(number++), std::ios::binary)
          << seed;
    }
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target->run({reinterpret_cast<const char*>(data), size});
  return 0;
}
