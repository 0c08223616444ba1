// SPDX-License-Identifier: MIT
// Fig. 12 of Xu and Kondo: a tube under pressure, with feature values that follow from a simulated
// pressure (section 5, future work 1).
//
// The pressure of a load on the tube at a point p is force * exp(-|p - place|^2 / (2 reach^2)), at
// most 1, and works on a face as far as the face looks against the load. A face without pressure
// has small values and keeps the polyhedron's edges; under full pressure they are 1, and all its
// images are in its middle: edges and vertices give way to the inside.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/experiments/first_refined_mesh.h"
#include "tests/experiments/scene.h"
#include "tests/experiments/xu_kondo.h"

namespace limn::experiments {
namespace {

constexpr Index kSides = 6;
constexpr Index kRings = 9;
constexpr double kRadius = 1;
constexpr double kLength = 6;
// Of edges and vertices without pressure.
constexpr double kEdgeAtRest = 0.15;
constexpr double kVertexAtRest = 0.3;

// Along x, with a vertex on top of each ring, and a face of kSides sides at each end.
PolygonMesh Tube() {
  PolygonMesh mesh;
  for (Index r = 0; r < kRings; ++r) {
    const double x = kLength * (static_cast<double>(r) / (kRings - 1) - 0.5);
    for (Index i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides;
      mesh.positions.push_back({x, kRadius * std::sin(angle), kRadius * std::cos(angle)});
    }
  }
  const auto at = [](Index r, Index i) { return r * kSides + i % kSides; };
  std::vector<Index> first;
  std::vector<Index> last;
  for (Index i = 0; i < kSides; ++i) {
    first.push_back(at(0, i));
    last.push_back(at(kRings - 1, kSides - 1 - i));
    for (Index r = 0; r + 1 < kRings; ++r) {
      mesh.AddFace({at(r, i), at(r + 1, i), at(r + 1, i + 1), at(r, i + 1)});
    }
  }
  mesh.AddFace(first);
  mesh.AddFace(last);
  return mesh;
}

struct Load {
  Vec3 place;
  // Unit length: where it pushes.
  Vec3 direction;
  double force = 1;
  double reach = 1;
};

double PressureAt(const Vec3& p, const Vec3& normal, const std::vector<Load>& loads) {
  double sum = 0;
  for (const Load& load : loads) {
    const Vec3 d = p - load.place;
    sum += load.force * std::max(0.0, -Dot(normal, load.direction)) *
           std::exp(-Dot(d, d) / (2 * load.reach * load.reach));
  }
  return std::min(1.0, sum);
}

FeatureValues ValuesUnder(const PolygonMesh& mesh, const std::vector<Load>& loads) {
  FeatureValues values = {.default_edge = kEdgeAtRest, .default_vertex = kVertexAtRest};
  for (Index f = 0; f < mesh.face_count(); ++f) {
    const absl::Span<const Index> face = mesh.face(f);
    const auto point = [&](std::size_t i) { return mesh.positions[face[i % face.size()]]; };
    const Vec3 normal = NormalizedOrZero(Cross(point(1) - point(0), point(2) - point(1)));
    for (std::size_t i = 0; i < face.size(); ++i) {
      const double edge = PressureAt(0.5 * (point(i) + point(i + 1)), normal, loads);
      const double vertex = PressureAt(point(i), normal, loads);
      values.edges.push_back(
          {face[i], face[(i + 1) % face.size()], f, kEdgeAtRest + (1 - kEdgeAtRest) * edge});
      values.vertices.push_back({face[i], f, kVertexAtRest + (1 - kVertexAtRest) * vertex});
    }
  }
  return values;
}

const Vec3 kTop = {0, 0, kRadius};
constexpr Vec3 kDown = {0, 0, -1};
constexpr Vec3 kUp = {0, 0, 1};

// Where the tube's upper line is in the middle: that vertex is on top of the middle ring.
double Height(const InterpolateResult& result) {
  return result.surface.positions[(kRings / 2) * kSides].z;
}

struct Case {
  std::string letter;
  std::string shape;
  std::string caption;
  std::vector<Load> loads;
};

std::vector<Case> Cases() {
  return {{"b", "f", "from above", {{kTop, kDown, 0.6, 0.8}}},
          {"c", "g", "from above and below, wide", {{kTop, kDown, 2, 1.4}, {-kTop, kUp, 2, 1.4}}},
          {"d",
           "h",
           "at two places, from either side",
           {{{-1.7, 0, kRadius}, kDown, 2.5, 0.7}, {{1.7, 0, -kRadius}, kUp, 2.5, 0.7}}}};
}

}  // namespace

void RunTube(const Setup& setup, Report* report) {
  const PolygonMesh tube = Tube();
  const std::uint32_t level = setup.quick ? 2 : 4;
  const InterpolateResult plain = Plain(setup, tube, level);
  WriteScene(setup, "fig12a", tube);
  WriteScene(setup, "fig12e", plain.surface);
  std::vector<Tessellation> surfaces = {plain.surface};
  std::vector<Report::Picture> polyhedra = {{"fig12a.png", "12a: given"}};
  std::vector<Report::Picture> pictures = {{"fig12e.png", "12e: Doo-Sabin alone"}};
  for (const Case& c : Cases()) {
    const InterpolateResult result = Shape(setup, tube, ValuesUnder(tube, c.loads), level);
    WriteScene(setup, "fig12" + c.letter,
               FirstRefinedMesh(std::get<DooSabinSurface>(*result.patches)));
    WriteScene(setup, "fig12" + c.shape, result.surface);
    polyhedra.push_back({absl::StrCat("fig12", c.letter, ".png"), "12" + c.letter});
    pictures.push_back(
        {absl::StrCat("fig12", c.shape, ".png"), absl::StrCat("12", c.shape, ": ", c.caption)});
    surfaces.push_back(result.surface);
  }
  WriteScene(setup, "row12", SideBySide({.surfaces = surfaces, .step = {0, 0, -2.3}}));
  report->Heading("Fig. 12: a tube under pressure");
  report->Paragraph(
      absl::StrCat("A tube of ", kSides,
                   " sides. The values of each edge and vertex in each face follow from "
                   "the pressure there: e = e0 + (1 - e0) p, with e0 = ",
                   kEdgeAtRest, " for edges and ", kVertexAtRest,
                   " for vertices; p falls off around each load as a bell curve does and works on "
                   "faces that look against it."));
  report->Pictures(polyhedra);
  report->Pictures(pictures);
  std::vector<Report::Row> rows;
  double last = kRadius;
  bool sinks = true;
  for (const double force : {0.0, 0.25, 0.5, 1.0, 2.0}) {
    const InterpolateResult result =
        Shape(setup, tube, ValuesUnder(tube, {{kTop, kDown, force, 1}}), 1);
    rows.push_back({absl::StrFormat("%.2f", force), absl::StrFormat("%.3f", Height(result)),
                    absl::StrFormat("%.3f", VolumeOf(result.surface))});
    sinks = sinks && Height(result) < last;
    last = Height(result);
  }
  report->Paragraph(
      "One load from above on the middle, and the height of the surface below it (the polyhedron's "
      "is 1):");
  report->Table({"force", "height", "volume at level 1"}, rows);
  report->Check("Tube: the greater the load, the deeper the dent", sinks);
}

}  // namespace limn::experiments
