// SPDX-License-Identifier: MIT
// The method against Nasri's, iterations against direct solvers: Zheng and Cai 2005, section 3.5.
#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "engine/interpolate.h"
#include "engine/solve/solve.h"
#include "tests/experiments/direct_solve.h"
#include "tests/experiments/experiments.h"
#include "tests/experiments/scene.h"

namespace limn::experiments {
namespace {

struct Rule {
  FirstRule rule;
  const char* name;
  LimitStencil stencil;
};

std::vector<Rule> Rules() {
  return {{FirstRule::kStandard, "Nasri", DooSabinStandardStencil()},
          {FirstRule::kModified, "Zheng and Cai", DooSabinModifiedStencil()}};
}

// One way to find the auxiliary mesh, of one rule for one model.
struct Contest {
  const Setup& setup;
  const Model& model;
  const Rule& rule;
  Report* report;
  std::vector<Report::Row>* rows;

  void AddRow(const std::string& solver, const std::string& steps, double time,
              std::size_t numbers) const {
    rows->push_back({model.name, rule.name, solver, steps, Milliseconds(time), Count(numbers)});
  }
};

// By Limn; returns the auxiliary mesh.
Buffer<Vec3> Iterate(const Contest& contest, double tolerance, const std::string& tolerance_name) {
  const Model& model = contest.model;
  Buffer<Vec3> control(model.given.vertex_count());
  SolveReport solve;
  const double time = BestMilliseconds(contest.setup, [&] {
    solve = OrDie(Solve(contest.setup.context,
                        {.mesh = model.mesh,
                         .stencil = contest.rule.stencil,
                         .points = model.given.positions,
                         .scale = model.scale},
                        {.tolerance = tolerance}, absl::MakeSpan(control)));
  });
  // Three points a vertex, and one a face or a corner for what faces hand out.
  const std::size_t values = contest.rule.stencil.face_rule == FaceRule::kCentroid
                                 ? model.mesh.face_count()
                                 : model.mesh.half_edge_count();
  contest.AddRow(absl::StrCat("Chebyshev to ", tolerance_name),
                 absl::StrCat(solve.sweeps, " sweeps"), time,
                 3 * (3 * model.mesh.vertex_count() + values));
  return control;
}

void SolveInOneGo(const Contest& contest, DirectMethod method, const Buffer<Vec3>& control) {
  const Model& model = contest.model;
  DirectSolution solution;
  const double time = BestMilliseconds(contest.setup, [&] {
    solution = SolveDirectly(method, LimitMatrix(model.mesh, contest.rule.stencil),
                             RightSide(model.mesh, model.given.positions));
  });
  const std::string name(DirectMethodName(method));
  contest.AddRow(name, "-", time, solution.factor_size);
  contest.report->CheckAtMost(
      absl::StrCat(model.name, ", ", contest.rule.name,
                   ": distance between the auxiliary meshes of ", name, " and Limn"),
      LargestDistance(control, solution.x) / model.scale, 1e-9);
}

void Compare(const Contest& contest) {
  Iterate(contest, 0.003, "0.3 %");
  const Buffer<Vec3> control = Iterate(contest, 1e-12, "1e-12");
  SolveInOneGo(contest, DirectMethod::kSparseLdlt, control);
  SolveInOneGo(contest, DirectMethod::kSparseLu, control);
  if (contest.model.mesh.vertex_count() <= kSmallModel) {
    SolveInOneGo(contest, DirectMethod::kDense, control);
  }
}

struct Surfaces {
  PolygonMesh auxiliary;
  Tessellation surface;
};

Surfaces MakeSurfaces(const Setup& setup, const Model& model, FirstRule rule, Report* report) {
  InterpolateResult result = OrDie(Interpolate(setup.context, model.given, {.rule = rule}));
  double largest = 0;
  for (std::size_t v = 0; v < model.given.vertex_count(); ++v) {
    largest = std::max(largest, Norm(result.surface.positions[v] - model.given.positions[v]));
  }
  report->CheckAtMost(absl::StrCat(model.name, rule == FirstRule::kStandard ? ", Nasri" : "",
                                   ": distance of surface and vertices"),
                      largest / model.scale, 1e-12);
  PolygonMesh auxiliary = model.given;
  auxiliary.positions = std::move(result.control_positions);
  return {std::move(auxiliary), std::move(result.surface)};
}

// How far the auxiliary mesh goes beyond the given one, over the diagonal.
double LargestMove(const Model& model, const PolygonMesh& auxiliary) {
  double largest = 0;
  for (std::size_t v = 0; v < model.given.vertex_count(); ++v) {
    largest = std::max(largest, Norm(auxiliary.positions[v] - model.given.positions[v]));
  }
  return largest / model.scale;
}

void AddFigure4(const Setup& setup, Report* report) {
  const Model model = MakeModel(setup, MeshKind::kNgons, kSmallModel);
  const Surfaces ours = MakeSurfaces(setup, model, FirstRule::kModified, report);
  const Surfaces nasri = MakeSurfaces(setup, model, FirstRule::kStandard, report);
  WriteScene(setup, "fig4a", model.given);
  WriteScene(setup, "fig4b", ours.auxiliary);
  WriteScene(setup, "fig4c", ours.surface);
  WriteScene(setup, "fig4d", nasri.auxiliary);
  WriteScene(setup, "fig4e", nasri.surface);
  report->Heading("Figs. 4 and 5: given mesh, auxiliary mesh, surface (section 3.5)");
  report->Pictures({{"fig4a.png", absl::StrCat("4a: given, ", model.name)},
                    {"fig4b.png", "4b: auxiliary mesh, Zheng and Cai"},
                    {"fig4c.png", "4c: its surface"}});
  report->Pictures({{"fig4d.png", "4d: auxiliary mesh, Nasri"}, {"fig4e.png", "4e: its surface"}});
  report->Paragraph(absl::StrFormat(
      "Nasri's auxiliary mesh is the wilder one: its vertices are up to %.1f %% of the bounding "
      "box's diagonal away from the given ones, those of Zheng and Cai up to %.1f %%.",
      100 * LargestMove(model, nasri.auxiliary), 100 * LargestMove(model, ours.auxiliary)));
}

void AddFigure5(const Setup& setup, const Model& model, Report* report) {
  const Surfaces large = MakeSurfaces(setup, model, FirstRule::kModified, report);
  WriteScene(setup, "fig5a", model.given);
  WriteScene(setup, "fig5b", large.auxiliary);
  WriteScene(setup, "fig5c", large.surface);
  report->Pictures({{"fig5a.png", absl::StrCat("5a: given, ", model.name)},
                    {"fig5b.png", "5b: auxiliary mesh"},
                    {"fig5c.png", "5c: its surface"}});
}

}  // namespace

void RunNasri(const Setup& setup, Report* report) {
  std::vector<Model> models;
  models.push_back(MakeModel(setup, MeshKind::kIrregularSphere, kSmallModel));
  if (!setup.quick) models.push_back(MakeModel(setup, MeshKind::kIrregularSphere, kLargeModel));
  std::vector<Report::Row> rows;
  const std::vector<Rule> rules = Rules();
  for (const Model& model : models) {
    for (const Rule& rule : rules) Compare({setup, model, rule, report, &rows});
  }
  AddFigure4(setup, report);
  if (models.size() > 1) AddFigure5(setup, models[1], report);
  report->Heading("Nasri's method, direct solvers and Limn (section 3.5)");
  report->Paragraph(absl::StrCat(
      "Time to find the auxiliary mesh; direct solvers (Eigen) assemble the matrix, factorise it "
      "and solve for three coordinates. The paper: Nasri's method by dense Gaussian elimination "
      "took 1.4 s for 562 vertices, and failed for 11,540: the full matrix alone would be ",
      Count(8 * kLargeModel * kLargeModel / 1000000),
      " MB. Numbers kept: those of the factors, or Limn's points."));
  report->Table({"model", "method", "solver", "steps", "ms", "numbers kept"}, rows);
}

}  // namespace limn::experiments
