// SPDX-License-Identifier: MIT
// What admission thinks a job takes grows with everything that makes it longer.
#include "server/job_cost.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace limn {
namespace {

JobSpec PlainSpec() {
  JobSpec spec;
  spec.mesh.set_vertex_count(10'000);
  spec.mesh.set_face_count(10'000);
  spec.mesh.set_corner_count(40'000);
  spec.engine.scheme = Scheme::kCatmullClark;
  spec.engine.level = 0;
  spec.send_surface = true;
  return spec;
}

TEST(JobCostTest, EverythingThatTakesLongerCostsMore) {
  const std::vector<std::pair<std::string, std::function<void(JobSpec*)>>> changes = {
      {"level", [](JobSpec* spec) { spec->engine.level = 3; }},
      {"corners", [](JobSpec* spec) { spec->mesh.set_corner_count(400'000); }},
      {"sweeps",
       [](JobSpec* spec) {
         spec->engine.solve.tolerance = 0;
         spec->engine.solve.max_sweeps = 10'000;
       }},
      {"repair", [](JobSpec* spec) { spec->repair = true; }},
      {"normals", [](JobSpec* spec) { spec->engine.constraints.normals.resize(5000); }},
      {"surface points",
       [](JobSpec* spec) { spec->engine.constraints.surface_points.resize(100); }},
      {"region",
       [](JobSpec* spec) {
         spec->engine.constraints.surface_points.resize(1);
         spec->engine.constraints.surface_points[0].region.resize(100'000);
       }},
      {"filter",
       [](JobSpec* spec) { spec->filter = FilterOptions{.gains = std::vector<double>(1024, 1)}; }},
  };
  const std::uint64_t plain = EstimateMilliseconds(PlainSpec());
  EXPECT_GE(plain, 1U);
  for (const auto& [name, change] : changes) {
    JobSpec spec = PlainSpec();
    change(&spec);
    EXPECT_GT(EstimateMilliseconds(spec), plain + 5) << name;
  }
}

}  // namespace
}  // namespace limn
