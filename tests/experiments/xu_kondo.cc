// SPDX-License-Identifier: MIT
// The examples of Xu and Kondo, "Introducing feature values for effective specification of
// polyhedral networks", section 4, Figs. 8 to 12: makes the shapes, checks, and writes report.md
// and meshes to a folder. tests/experiments/xu_kondo adds the pictures.
//
//   xu_kondo FOLDER [--quick]      --quick: coarse surfaces, to see that it works
//
// Exit status: 0 if all checks of the report held.
#include "tests/experiments/xu_kondo.h"

#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>

#include "absl/strings/str_cat.h"

namespace limn::experiments {

InterpolateResult Shape(const Setup& setup, const PolygonMesh& mesh, const FeatureValues& values,
                        std::uint32_t level) {
  InterpolateOptions options = {.level = level, .normals = false, .keep_patches = true};
  options.constraints.features = values;
  return OrDie(Interpolate(setup.context, mesh, options));
}

InterpolateResult Plain(const Setup& setup, const PolygonMesh& mesh, std::uint32_t level) {
  InterpolateOptions options = {
      .rule = FirstRule::kStandard, .solve = {.max_sweeps = 0}, .level = level, .normals = false};
  options.constraints.interpolate.emplace();
  return OrDie(Interpolate(setup.context, mesh, options));
}

double VolumeOf(const Tessellation& surface) {
  double six = 0;
  for (std::size_t c = 0; c < surface.face_vertices.size(); c += 4) {
    const auto p = [&](std::size_t i) { return surface.positions[surface.face_vertices[c + i]]; };
    six += Dot(p(0), Cross(p(1), p(2))) + Dot(p(0), Cross(p(2), p(3)));
  }
  return six / 6;
}

PolygonMesh SideBySide(const Row& row) {
  PolygonMesh all;
  for (std::size_t i = 0; i < row.surfaces.size(); ++i) {
    const Tessellation& surface = row.surfaces[i];
    const auto first = static_cast<Index>(all.vertex_count());
    for (const Vec3& p : surface.positions) {
      all.positions.push_back(p + static_cast<double>(i) * row.step);
    }
    for (std::size_t c = 0; c < surface.face_vertices.size(); c += 4) {
      const Index* const v = surface.face_vertices.data() + c;
      all.AddFace({first + v[0], first + v[1], first + v[2], first + v[3]});
    }
  }
  return all;
}

namespace {

int Run(const Setup& setup) {
  std::filesystem::create_directories(setup.scenes());
  Report report;
  report.Title("The examples of Xu and Kondo");
  report.Paragraph(
      absl::StrCat("Limn ", LIMN_VERSION, ". The mesh of each picture is an OBJ file beside it."));
  RunCube(setup, &report);
  RunClub(setup, &report);
  RunTube(setup, &report);
  WriteText(setup, "report.md", report.Markdown());
  std::cout << report.Markdown();
  for (const std::string& failure : report.failures()) {
    std::cerr << "xu_kondo: FAILED: " << failure << "\n";
  }
  return report.all_held() ? 0 : 1;
}

}  // namespace
}  // namespace limn::experiments

int main(int argc, char** argv) {
  const bool quick = argc == 3 && std::string_view(argv[2]) == "--quick";
  if (argc < 2 || (argc > 2 && !quick)) {
    std::cerr << "usage: xu_kondo FOLDER [--quick]\n";
    return 2;
  }
  return limn::experiments::Run({.context = {}, .out = argv[1], .quick = quick});
}
