// SPDX-License-Identifier: MIT
// Table 1 of Cheng et al., "Progressive interpolation using Loop subdivision surfaces", 2008: plain
// progressive iterations until the largest error is 1e-3 in the unit box, on meshes of the paper's
// sizes made by code, and beside it Chebyshev's. Run:
//   build/release/bin/progressive
// Prints a table in Markdown. Exit status: 0 if what the paper promises held.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "engine/base/heap.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/validate.h"
#include "tests/experiments/report.h"
#include "tests/oracle/test_meshes.h"

namespace limn::experiments {
namespace {

constexpr double kWanted = 1e-3;
constexpr std::uint32_t kMost = 100;

// A row of the paper's table.
struct PaperRow {
  const char* model;
  std::uint64_t vertices;
  int iterations;
};
constexpr PaperRow kPaper[] = {{"Hog", 606, 10},    {"Rabbit", 453, 13}, {"Tiger", 956, 9},
                               {"Statue", 711, 11}, {"Boy", 17342, 6},   {"Turtle", 445, 10},
                               {"Bird", 1129, 9}};

template <class T>
T OrDie(absl::StatusOr<T> value) {
  if (!value.ok()) {
    std::fprintf(stderr, "progressive: %s\n", value.status().ToString().c_str());
    std::exit(1);
  }
  return *std::move(value);
}

// Irregular triangles around a lumpy sphere, in the unit box, of about so many vertices: cutting
// its polygons into triangles adds a vertex to most of them.
PolygonMesh Model(std::uint64_t wanted) {
  const auto vertices = static_cast<std::uint64_t>(static_cast<double>(wanted) / 1.586);
  PolygonMesh mesh = oracle::Triangulated(OrDie(
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices, .seed = vertices})));
  BoundingBox box;
  if (!ValidatePositions(Context(), mesh.positions, &box).ok()) std::exit(1);
  const Vec3 size = box.max - box.min;
  const double scale = 1 / std::max({size.x, size.y, size.z});
  for (Vec3& p : mesh.positions) p = scale * (p - box.min);
  return mesh;
}

struct Errors {
  std::uint32_t iterations = 0;
  double most = 0;
  double mean = 0;
};

Errors ErrorsAfter(const PolygonMesh& mesh, SolveMethod method, std::uint32_t iterations) {
  const InterpolateResult result =
      OrDie(Interpolate(Context(), mesh,
                        {.scheme = Scheme::kLoop,
                         .solve = {.method = method, .tolerance = 0, .max_sweeps = iterations},
                         .level = 0}));
  Errors errors = {.iterations = iterations};
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double error = Norm(result.surface.positions[v] - mesh.positions[v]);
    errors.most = std::max(errors.most, error);
    errors.mean += error / static_cast<double>(mesh.vertex_count());
  }
  return errors;
}

Errors UntilWanted(const PolygonMesh& mesh, SolveMethod method) {
  Errors errors;
  for (std::uint32_t k = 0; k <= kMost; ++k) {
    errors = ErrorsAfter(mesh, method, k);
    if (errors.most <= kWanted) break;
  }
  return errors;
}

int Main() {
  KeepHeap();
  Report report;
  report.Heading("Progressive interpolation to 1e-3 of the unit box");
  std::vector<Report::Row> rows;
  for (const PaperRow& paper : kPaper) {
    const PolygonMesh mesh = Model(paper.vertices);
    const Errors series = UntilWanted(mesh, SolveMethod::kSeries);
    const Errors chebyshev = UntilWanted(mesh, SolveMethod::kChebyshev);
    rows.push_back({paper.model, Count(mesh.vertex_count()), std::to_string(paper.iterations),
                    std::to_string(series.iterations), Scientific(series.most),
                    Scientific(series.mean), std::to_string(chebyshev.iterations),
                    Scientific(chebyshev.most), Scientific(chebyshev.mean)});
    const std::string model = "largest error, size of " + std::string(paper.model);
    report.CheckAtMost(model + ", progressive", series.most, kWanted);
    report.CheckAtMost(model + ", Chebyshev", chebyshev.most, kWanted);
    report.CheckAtMost("sweeps of Chebyshev less those of progressive iteration",
                       static_cast<double>(chebyshev.iterations) - series.iterations, 0);
  }
  report.Table({"size of", "vertices", "iterations, paper", "here", "max error", "mean error",
                "Chebyshev", "max error", "mean error"},
               rows);
  std::fputs(report.Markdown().c_str(), stdout);
  return report.all_held() ? 0 : 1;
}

}  // namespace
}  // namespace limn::experiments

int main() { return limn::experiments::Main(); }
