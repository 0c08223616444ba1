// SPDX-License-Identifier: MIT
// The experiments of Zheng and Cai, "Making Doo-Sabin surface interpolation always work over
// irregular meshes", The Visual Computer 2005, sections 3.5 and 4: measures, checks, and writes
// report.md, tables and meshes to a folder. tests/experiments/zheng_cai adds the pictures.
//
//   zheng_cai FOLDER [--quick]      --quick: the small model only, everything timed once
//
// Exit status: 0 if all checks of the report held.
#include <malloc.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "engine/base/parallel.h"
#include "tests/experiments/experiments.h"

namespace limn::experiments {
namespace {

std::string ProcessorName() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

// Memory that is given back stays with the process, so that runs after the first one are not
// measured with page faults, whichever experiment comes first.
void KeepMemory() {
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

int Run(const Setup& setup) {
  KeepMemory();
  std::filesystem::create_directories(setup.scenes());
  Report report;
  report.Title("The experiments of Zheng and Cai 2005");
  report.Paragraph(absl::StrCat(
      "Limn ", LIMN_VERSION, " on one thread of: ", ProcessorName(),
      ". All numbers but those that ", "are said to be the paper's were found in this run. ",
      setup.quick ? "Times are of single runs." : "Times are of the fastest of several runs.",
      " The mesh of each picture is an OBJ file beside it."));
  // One thread, as in the paper, and as the direct solvers have.
  ThreadArena(1).Execute([&] {
    RunSweeps(setup, &report);
    RunNasri(setup, &report);
    RunTagged(setup, &report);
  });
  WriteText(setup, "report.md", report.Markdown());
  std::cout << report.Markdown();
  for (const std::string& failure : report.failures()) {
    std::cerr << "zheng_cai: FAILED: " << failure << "\n";
  }
  return report.all_held() ? 0 : 1;
}

}  // namespace
}  // namespace limn::experiments

int main(int argc, char** argv) {
  const bool quick = argc == 3 && std::string_view(argv[2]) == "--quick";
  if (argc < 2 || (argc > 2 && !quick)) {
    std::cerr << "usage: zheng_cai FOLDER [--quick]\n";
    return 2;
  }
  return limn::experiments::Run({.context = {}, .out = argv[1], .quick = quick});
}
