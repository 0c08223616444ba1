// SPDX-License-Identifier: MIT
// Whole jobs: time, and memory against the arrays that they have to hold.
#include <sstream>
#include <stdexcept>

#include "engine/base/parallel.h"
#include "engine/interpolate.h"
#include "engine/mesh/half_edge_mesh.h"
#include "tests/benchmarks/comparison/kernels.h"
#include "tests/benchmarks/comparison/measure.h"

namespace limn::comparison {
namespace {

struct Job {
  const char* name;
  Scheme scheme;
  Meshes meshes;
};

constexpr std::uint32_t kLevel = 2;

double ResultBytes(const InterpolateResult& result) {
  return static_cast<double>(sizeof(Vec3)) *
             static_cast<double>(result.control_positions.size() + result.surface.positions.size() +
                                 result.surface.normals.size()) +
         static_cast<double>(sizeof(Index)) *
             static_cast<double>(result.surface.face_vertices.size());
}

// What the tessellation of level 2 is made from. Doo-Sabin: M^2 and T^1; else: T^2 and its points.
double LastStageBytes(const PolygonMesh& mesh, const Job& job) {
  const auto c = static_cast<double>(mesh.corner_count());
  const auto n = static_cast<double>(mesh.vertex_count());
  const auto f = static_cast<double>(mesh.face_count());
  const double e = c / 2;
  const bool loop = job.scheme == Scheme::kLoop;
  // Of T^1, and of T^2: vertices, edges, half-edges. A split mesh has three indices for each
  // half-edge and one for each edge and vertex.
  const double n1 = n + e + (loop ? 0 : f);
  const double c1 = 4 * c;
  if (job.scheme == Scheme::kDooSabin) return 24 * c1 + 12 * c1 + 4 * (c1 / 2) + 4 * n1;
  const double n2 = n1 + c1 / 2 + (loop ? 0 : c);
  const double c2 = 4 * c1;
  return 24 * n2 + 12 * c2 + 4 * (c2 / 2) + 4 * n2;
}

JobOutcome MeasureJob(const Job& job, std::uint64_t vertices) {
  const PolygonMesh mesh = MakeMesh(job.meshes, vertices);
  const std::string text = InChild([&](std::FILE* out) {
    double seconds = 0;
    double result_bytes = 0;
    const double peak = PeakBytes([&] {
      ThreadArena(1).Execute([&] {
        const double begin = Now().clock;
        const auto result = Interpolate(
            Context(), mesh, {.scheme = job.scheme, .solve = {.tolerance = 1e-6}, .level = kLevel});
        seconds = Now().clock - begin;
        if (!result.ok()) throw std::runtime_error(std::string(result.status().message()));
        result_bytes = ResultBytes(*result);
      });
    });
    std::fprintf(out, "%.17g %.17g %.17g\n", seconds, peak, result_bytes);
  });
  JobOutcome outcome = {.name = job.name, .vertices = mesh.vertex_count()};
  std::istringstream(text) >> outcome.seconds >> outcome.peak_bytes >> outcome.result_bytes;
  outcome.held_bytes = outcome.result_bytes + LastStageBytes(mesh, job);
  return outcome;
}

}  // namespace

std::vector<JobOutcome> MeasureJobs(std::uint64_t vertices) {
  constexpr Job kJobs[] = {{"Doo-Sabin, polygons", Scheme::kDooSabin, Meshes::kPolygons},
                           {"Catmull-Clark, polygons", Scheme::kCatmullClark, Meshes::kPolygons},
                           {"Loop, triangles", Scheme::kLoop, Meshes::kTriangles}};
  std::vector<JobOutcome> outcomes;
  for (const Job& job : kJobs) outcomes.push_back(MeasureJob(job, vertices));
  return outcomes;
}

}  // namespace limn::comparison
