// SPDX-License-Identifier: MIT
// Two tagged vertices, normals and shape handles: Zheng and Cai 2005, section 4, Figs. 6 and 8.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "engine/interpolate.h"
#include "tests/experiments/experiments.h"
#include "tests/experiments/first_refined_mesh.h"
#include "tests/experiments/scene.h"

namespace limn::experiments {
namespace {

constexpr Index kSides = 8;
// Cross-sections of a long body: where along x, how wide.
struct Section {
  double x;
  double radius;
};
constexpr std::array<Section, 4> kSections = {{{-1.2, 0.85}, {-0.4, 0.6}, {0.4, 0.55}, {1.1, 1.1}}};
constexpr double kEnd = 2;

// A long closed body: two tips, the leftmost and the rightmost vertex, and rings between them.
// Vertex 0 is the left tip, the last one the right tip.
PolygonMesh LongBody() {
  PolygonMesh mesh;
  mesh.positions.push_back({-kEnd, 0, 0});
  for (const Section& section : kSections) {
    for (Index i = 0; i < kSides; ++i) {
      const double angle = 2 * 3.14159265358979323846 * i / kSides;
      mesh.positions.push_back(
          {section.x, section.radius * std::cos(angle), section.radius * std::sin(angle)});
    }
  }
  mesh.positions.push_back({kEnd, 0, 0});
  const auto last = static_cast<Index>(mesh.vertex_count() - 1);
  const auto at = [](std::size_t ring, Index i) {
    return static_cast<Index>(1 + ring * kSides + i % kSides);
  };
  for (Index i = 0; i < kSides; ++i) {
    mesh.AddFace({0, at(0, i + 1), at(0, i)});
    for (std::size_t r = 0; r + 1 < kSections.size(); ++r) {
      mesh.AddFace({at(r, i), at(r, i + 1), at(r + 1, i + 1), at(r + 1, i)});
    }
    mesh.AddFace({last, at(kSections.size() - 1, i), at(kSections.size() - 1, i + 1)});
  }
  return mesh;
}

// What is asked at the tagged vertices, and where the answers go.
struct Experiment {
  const Setup& setup;
  const PolygonMesh& given;
  std::array<Index, 2> vertices;
  std::array<Vec3, 2> normals;
  Report* report;

  std::vector<Mark> Marks(bool with_normals) const {
    std::vector<Mark> marks;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      marks.push_back({.point = given.positions[vertices[i]]});
      if (with_normals) marks.back().normal = normals[i];
    }
    return marks;
  }
};

// One way to run it, and the letters of its pictures in the paper.
struct Variant {
  bool normals;
  double handle;
  std::string surface;
  // Empty: the paper does not show it.
  std::string given;
  std::string refined;

  std::string name() const {
    return absl::StrCat(normals ? "with normals" : "without normals",
                        handle == 1 ? "" : absl::StrCat(", handles ", handle));
  }
};

const std::array<Variant, 6>& Variants() {
  static const std::array<Variant, 6> kVariants = {{{false, 1, "fig6c", "fig6a", "fig6b"},
                                                    {true, 1, "fig6f", "fig6d", "fig6e"},
                                                    {false, 0.4, "fig8a", "", ""},
                                                    {true, 0.4, "fig8b", "", ""},
                                                    {false, 2.5, "fig8c", "", ""},
                                                    {true, 2.5, "fig8d", "", ""}}};
  return kVariants;
}

// Angle between two directions whose signs do not matter, in radians.
double AngleBetween(const Vec3& a, const Vec3& b) {
  return std::atan2(Norm(Cross(a, b)), std::fabs(Dot(a, b)));
}

// Volume inside a closed surface of quads.
double Volume(const Tessellation& surface) {
  double six = 0;
  for (std::size_t c = 0; c < surface.face_vertices.size(); c += 4) {
    const auto p = [&](std::size_t i) { return surface.positions[surface.face_vertices[c + i]]; };
    six += Dot(p(0), Cross(p(1), p(2))) + Dot(p(0), Cross(p(2), p(3)));
  }
  return six / 6;
}

InterpolateResult Run(const Experiment& experiment, const Variant& variant) {
  InterpolateOptions options = {.level = 5, .keep_patches = true};
  Constraints& constraints = options.constraints;
  constraints.interpolate.emplace(experiment.vertices.begin(), experiment.vertices.end());
  for (std::size_t i = 0; i < experiment.vertices.size(); ++i) {
    const Index v = experiment.vertices[i];
    if (variant.normals) constraints.normals.push_back({v, experiment.normals[i]});
    if (variant.handle != 1) constraints.shape_handles.push_back({v, variant.handle});
  }
  return OrDie(Interpolate(experiment.setup.context, experiment.given, options));
}

// A closed mesh whose vertices have four faces each, of the same kind as the given one.
void CheckRefined(const Experiment& experiment, const Variant& variant,
                  const PolygonMesh& refined) {
  const Context& context = experiment.setup.context;
  const auto euler = [](const HalfEdgeMesh& mesh) {
    return mesh.vertex_count() + mesh.face_count() - mesh.edge_count();
  };
  const HalfEdgeMesh given = OrDie(HalfEdgeMesh::Build(context, experiment.given));
  const HalfEdgeMesh mesh = OrDie(HalfEdgeMesh::Build(context, refined));
  bool well = mesh.boundary_edge_count() == 0 && euler(mesh) == euler(given);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) well = well && mesh.valence(v) == 4;
  experiment.report->Check(
      absl::StrCat(
          "Two tagged vertices, ", variant.name(),
          ": the refined mesh is closed, its valences are 4, its genus is the given one's"),
      well);
}

void WriteMeshes(const Experiment& experiment, const Variant& variant,
                 const InterpolateResult& result) {
  const std::vector<Mark> marks = experiment.Marks(variant.normals);
  WriteScene(experiment.setup, variant.surface, result.surface, marks);
  if (variant.refined.empty()) return;
  const PolygonMesh refined = FirstRefinedMesh(std::get<DooSabinSurface>(*result.patches));
  CheckRefined(experiment, variant, refined);
  WriteScene(experiment.setup, variant.given, experiment.given, marks);
  WriteScene(experiment.setup, variant.refined, refined, marks);
}

// Checks that points and normals are met; the row of the table.
Report::Row Measure(const Experiment& experiment, const Variant& variant,
                    const InterpolateResult& result) {
  double distance = 0;
  double angle = 0;
  for (std::size_t i = 0; i < experiment.vertices.size(); ++i) {
    const Index v = experiment.vertices[i];
    distance =
        std::max(distance, Norm(result.surface.positions[v] - experiment.given.positions[v]));
    angle = std::max(angle, AngleBetween(result.surface.normals[v], experiment.normals[i]));
  }
  const std::string name = absl::StrCat("Two tagged vertices, ", variant.name());
  experiment.report->CheckAtMost(absl::StrCat(name, ": distance from the surface"), distance,
                                 1e-12);
  if (variant.normals) {
    experiment.report->CheckAtMost(absl::StrCat(name, ": angle to the prescribed normals, rad"),
                                   angle, 1e-10);
  }
  return {variant.surface, variant.name(), Scientific(distance), Scientific(angle),
          absl::StrFormat("%.3f", Volume(result.surface))};
}

void CheckTogether(const Experiment& experiment, const std::vector<InterpolateResult>& results) {
  bool same = true;
  for (const InterpolateResult& result : results) {
    same = same && result.control_positions == results[0].control_positions;
  }
  experiment.report->Check(
      "Two tagged vertices: the auxiliary mesh is the same to the bit in all six cases", same);
  std::size_t moved = 0;
  for (std::size_t v = 0; v < experiment.given.vertex_count(); ++v) {
    if (results[0].control_positions[v] != experiment.given.positions[v]) ++moved;
  }
  experiment.report->Check("Two tagged vertices: the auxiliary mesh is the given one but for them",
                           moved == 2);
  const auto volume = [&](std::size_t i) { return Volume(results[i].surface); };
  experiment.report->Check(
      "Handles of 0.4 make it slim, those of 2.5 fat, with and without normals",
      volume(2) < volume(0) && volume(0) < volume(4) && volume(3) < volume(1) &&
          volume(1) < volume(5));
}

void AddFigures(const std::vector<Report::Row>& rows, Report* report) {
  report->Heading("Fig. 6: two tagged vertices, without and with prescribed normals (section 4.1)");
  report->Paragraph(
      "The leftmost and the rightmost vertex are interpolated, the others only shape the surface. "
      "Green: those vertices and the normals prescribed there. The auxiliary mesh is the same with "
      "and without them.");
  report->Pictures({{"fig6a.png", "6a: given"},
                    {"fig6b.png", "6b: perturbed first refined mesh"},
                    {"fig6c.png", "6c: surface"}});
  report->Pictures({{"fig6d.png", "6d: given, with normals"},
                    {"fig6e.png", "6e: perturbed first refined mesh"},
                    {"fig6f.png", "6f: surface"}});
  report->Heading("Fig. 8: shape handles at the same vertices (section 4.2)");
  report->Pictures({{"fig8a.png", "8a: handles 0.4"}, {"fig8b.png", "8b: 0.4, with normals"}});
  report->Pictures({{"fig8c.png", "8c: handles 2.5"}, {"fig8d.png", "8d: 2.5, with normals"}});
  report->Paragraph(
      "Largest distance between a tagged vertex and the surface, in model units; largest angle "
      "between its normal and the one that is prescribed with normals; volume inside:");
  report->Table({"surface", "", "distance", "angle, rad", "volume"}, rows);
}

}  // namespace

void RunTagged(const Setup& setup, Report* report) {
  const PolygonMesh given = LongBody();
  const auto last = static_cast<Index>(given.vertex_count() - 1);
  const double half = std::sqrt(0.5);
  const Experiment experiment = {
      setup, given, {0, last}, {{{-half, 0, half}, {half, 0, half}}}, report};
  std::vector<InterpolateResult> results;
  std::vector<Report::Row> rows;
  for (const Variant& variant : Variants()) {
    results.push_back(Run(experiment, variant));
    WriteMeshes(experiment, variant, results.back());
    rows.push_back(Measure(experiment, variant, results.back()));
  }
  CheckTogether(experiment, results);
  AddFigures(rows, report);
}

}  // namespace limn::experiments
