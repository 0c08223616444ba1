// SPDX-License-Identifier: MIT
// Fig. 8 of Xu and Kondo.
#include <array>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/experiments/first_refined_mesh.h"
#include "tests/experiments/scene.h"
#include "tests/experiments/xu_kondo.h"

namespace limn::experiments {
namespace {

PolygonMesh Cube() {
  PolygonMesh mesh;
  for (const double z : {-1., 1.}) {
    mesh.positions.insert(mesh.positions.end(), {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}});
  }
  for (const std::array<Index, 4>& face : {std::array<Index, 4>{0, 3, 2, 1},
                                           {4, 5, 6, 7},
                                           {0, 1, 5, 4},
                                           {1, 2, 6, 5},
                                           {2, 3, 7, 6},
                                           {3, 0, 4, 7}}) {
    mesh.AddFace(face);
  }
  return mesh;
}

// The two that Fig. 8(d) sharpens: on one edge of the upper face, to the front.
constexpr std::array<Index, 2> kSharp = {4, 5};
constexpr double kSharpValue = 0.05;

}  // namespace

void RunCube(const Setup& setup, Report* report) {
  const PolygonMesh cube = Cube();
  const std::uint32_t level = setup.quick ? 3 : 6;
  report->Heading("Fig. 8: a cube");
  report->Paragraph(
      "All faces are surface faces. EFV 0.2, 0.4 and 0.6 for all edges with VFV 1, then VFV 0.05 "
      "at "
      "two vertices in all their faces.");
  std::vector<Report::Row> rows;
  std::vector<Tessellation> surfaces;
  std::vector<double> distances;
  std::vector<Report::Picture> polyhedra;
  std::vector<Report::Picture> pictures;
  for (const std::string letter : {"a", "b", "c", "d"}) {
    FeatureValues values = {.default_edge = letter == "a" ? 0.2 : letter == "b" ? 0.4 : 0.6};
    if (letter == "d") {
      for (const Index v : kSharp) values.vertices.push_back({v, std::nullopt, kSharpValue});
    }
    const InterpolateResult result = Shape(setup, cube, values, level);
    WriteScene(setup, "fig8" + letter + "-first",
               FirstRefinedMesh(std::get<DooSabinSurface>(*result.patches)));
    WriteScene(setup, "fig8" + letter, result.surface);
    const std::string caption = absl::StrCat("8", letter, ": EFV ", values.default_edge,
                                             letter == "d" ? ", two vertices sharp" : "");
    polyhedra.push_back({"fig8" + letter + "-first.png", caption});
    pictures.push_back({"fig8" + letter + ".png", caption});
    distances.push_back(Norm(result.surface.positions[kSharp[0]] - cube.positions[kSharp[0]]));
    rows.push_back({"8" + letter, absl::StrFormat("%.3f", VolumeOf(result.surface)),
                    absl::StrFormat("%.4f", distances.back())});
    surfaces.push_back(result.surface);
  }
  report->Pictures(polyhedra);
  report->Pictures(pictures);
  report->Paragraph("Volume (the cube's is 8), and distance of a vertex that (d) sharpens:");
  report->Table({"", "volume", "distance"}, rows);
  report->Check("Cube: the larger the EFV, the rounder: volumes fall",
                VolumeOf(surfaces[0]) > VolumeOf(surfaces[1]) &&
                    VolumeOf(surfaces[1]) > VolumeOf(surfaces[2]));
  report->CheckAtMost("Cube: VFV 0.05 leaves that part of the distance, off by",
                      std::fabs(distances[3] - kSharpValue * distances[2]), 1e-14);
  const std::size_t far = 2;
  report->CheckAtMost("Cube: the other side of (d) is that of (c), off by",
                      Norm(surfaces[3].positions[far] - surfaces[2].positions[far]), 0);
  WriteScene(setup, "row8", SideBySide({.surfaces = surfaces, .step = {2.7, 0, 0}}));
}

}  // namespace limn::experiments
