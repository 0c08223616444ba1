// SPDX-License-Identifier: MIT
// Limn beside its peers: tables to standard output, progress to standard error, and results.json
// and ratios-*.tsv to a folder. tests/benchmarks/compare builds and calls it.
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

#include "engine/base/heap.h"
#include "tests/benchmarks/comparison/report.h"

namespace limn::comparison {
namespace {

constexpr char kUsage[] =
    "usage: comparison FOLDER [--sizes N,N,...] [--tasks NAME,NAME,...] [--meshes NAME,...]\n"
    "                  [--budget SECONDS] [--patience SECONDS] [--no-kernels]\n";

struct Options {
  std::string folder;
  std::vector<std::uint64_t> sizes = {562, 11'540, 100'000, 1'000'000};
  // Empty: all.
  std::vector<std::string> tasks;
  std::vector<std::string> meshes;
  MeasureOptions measure;
  bool kernels = true;
};

std::vector<std::string> Split(const std::string& list) {
  std::vector<std::string> parts;
  std::istringstream in(list);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

bool Wanted(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

// False for what is not understood.
bool Parse(int argc, char** argv, Options* options) {
  for (int i = 1; i < argc; ++i) {
    const std::string flag = argv[i];
    if (flag == "--no-kernels") {
      options->kernels = false;
      continue;
    }
    if (flag.rfind("--", 0) != 0) {
      options->folder = flag;
      continue;
    }
    if (++i == argc) return false;
    const std::string value = argv[i];
    if (flag == "--sizes") {
      options->sizes.clear();
      for (const std::string& size : Split(value)) options->sizes.push_back(std::stoull(size));
      std::sort(options->sizes.begin(), options->sizes.end());
    } else if (flag == "--tasks") {
      options->tasks = Split(value);
    } else if (flag == "--meshes") {
      options->meshes = Split(value);
    } else if (flag == "--budget") {
      options->measure.budget = std::stod(value);
    } else if (flag == "--patience") {
      options->measure.patience = std::stod(value);
    } else {
      return false;
    }
  }
  return !options->folder.empty() && !options->sizes.empty();
}

void MeasureMeshes(const Options& options, Meshes meshes, Report* report) {
  // The cells of the size before, by task.
  std::vector<Cell> before(AllTasks().size());
  for (const std::uint64_t size : options.sizes) {
    const PolygonMesh mesh = MakeMesh(meshes, size);
    for (std::size_t i = 0; i < AllTasks().size(); ++i) {
      const TaskInfo& task = AllTasks()[i];
      if (!Wanted(options.tasks, task.name)) continue;
      if (task.triangles_only && meshes != Meshes::kTriangles) continue;
      std::cerr << task.name << ", " << MeshesName(meshes) << ", " << mesh.vertex_count() << "\n";
      Cell cell = Measure(task.task, meshes, mesh, options.measure,
                          before[i].vertices == 0 ? nullptr : &before[i]);
      report->cells.push_back(cell);
      before[i] = std::move(cell);
    }
  }
}

bool AllAgree(const Report& report) {
  bool agree = true;
  for (const Cell& cell : report.cells) {
    for (const Outcome& outcome : cell.outcomes) agree = agree && outcome.agrees;
  }
  return agree;
}

int Main(int argc, char** argv) {
  Options options;
  if (!Parse(argc, argv, &options)) {
    std::cerr << kUsage;
    return 2;
  }
  KeepHeap();
  Report report;
  for (const Meshes meshes : {Meshes::kQuads, Meshes::kTriangles, Meshes::kPolygons}) {
    if (Wanted(options.meshes, MeshesName(meshes))) MeasureMeshes(options, meshes, &report);
  }
  if (options.kernels) {
    std::cerr << "kernels and jobs\n";
    report.kernels = MeasureKernels(options.sizes.back());
    report.jobs = MeasureJobs(options.sizes.back());
  }
  std::cout << Markdown(report);
  std::ofstream(options.folder + "/results.json") << Json(report);
  WriteRatios(report, options.folder);
  if (AllAgree(report)) return 0;
  std::cerr << "compare: some answers disagree; see the tables\n";
  return 1;
}

}  // namespace
}  // namespace limn::comparison

int main(int argc, char** argv) {
  try {
    return limn::comparison::Main(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "compare: " << error.what() << "\n";
    return 2;
  }
}
