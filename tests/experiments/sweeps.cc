// SPDX-License-Identifier: MIT
// How fast the iterations converge: Zheng and Cai 2005, sections 3.2 to 3.5.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "engine/constraints/perturb.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/solve/solve.h"
#include "tests/experiments/direct_solve.h"
#include "tests/experiments/experiments.h"

namespace limn::experiments {
namespace {

struct Method {
  SolveMethod method;
  const char* name;
};
constexpr std::array<Method, 3> kMethods = {{{SolveMethod::kJacobi, "Jacobi"},
                                             {SolveMethod::kGaussSeidel, "Gauss-Seidel"},
                                             {SolveMethod::kChebyshev, "Chebyshev"}}};
// The paper's, one for drawing, Limn's default.
constexpr std::array<double, 3> kTolerances = {0.003, 1e-6, 1e-12};
constexpr std::uint32_t kMostSweeps = 20;

SolveReport SolveModel(const Setup& setup, const Model& model, const SolveOptions& options,
                       Buffer<Vec3>* control) {
  const LimitStencil stencil = DooSabinModifiedStencil();
  control->resize(model.given.vertex_count());
  return OrDie(Solve(setup.context,
                     {.mesh = model.mesh,
                      .stencil = stencil,
                      .points = model.given.positions,
                      .scale = model.scale},
                     options, absl::MakeSpan(*control)));
}

Report::Row SweepsRow(const Setup& setup, const Model& model, const Method& method,
                      Report* report) {
  Report::Row row = {model.name, method.name};
  Buffer<Vec3> control;
  SolveReport solve;
  bool converged = true;
  for (const double tolerance : kTolerances) {
    const SolveOptions options = {
        .method = method.method, .tolerance = tolerance, .max_sweeps = 1000};
    const double time =
        BestMilliseconds(setup, [&] { solve = SolveModel(setup, model, options, &control); });
    row.push_back(absl::StrCat(solve.sweeps));
    row.push_back(Milliseconds(time));
    converged = converged && solve.converged;
  }
  const std::string name = absl::StrCat(model.name, ", ", method.name);
  report->Check(absl::StrCat(name, ": converges to all tolerances"), converged);
  if (method.method == SolveMethod::kChebyshev) {
    report->CheckAtMost(absl::StrCat(name, ": sweeps to 1e-12"), solve.sweeps, 18);
  }
  return row;
}

void AddSweeps(const Setup& setup, const std::vector<Model>& models, Report* report) {
  std::vector<Report::Row> rows;
  for (const Model& model : models) {
    for (const Method& method : kMethods) rows.push_back(SweepsRow(setup, model, method, report));
  }
  report->Heading("Auxiliary mesh: sweeps and time (sections 3.2 to 3.5)");
  report->Paragraph(
      "Until a sweep moves no vertex by more than the tolerance, as a part of the bounding box's "
      "diagonal; Chebyshev asks the same of what is left. The paper's models, by Gauss-Seidel to "
      "0.3 % on a Pentium 4 of 1.6 GHz: 562 vertices in 3 sweeps and 4.9 ms, 11,540 vertices in 2 "
      "sweeps and 79 ms. Times are those of the solve with all that it prepares, of a mesh whose "
      "half-edges are there.");
  report->Table(
      {"model", "method", "sweeps to 0.3 %", "ms", "sweeps to 1e-6", "ms", "sweeps to 1e-12", "ms"},
      rows);
}

// Largest distance of the auxiliary mesh from the exact one over the diagonal, after 0 to
// kMostSweeps sweeps.
std::vector<double> Errors(const Setup& setup, const Model& model, SolveMethod method,
                           const Columns& exact) {
  std::vector<double> errors;
  Buffer<Vec3> control;
  for (std::uint32_t sweeps = 0; sweeps <= kMostSweeps; ++sweeps) {
    SolveModel(setup, model, {.method = method, .tolerance = 0, .max_sweeps = sweeps}, &control);
    errors.push_back(LargestDistance(control, exact) / model.scale);
  }
  return errors;
}

// Adds three columns to the rows of a table and writes them as a file too.
void AddErrors(const Setup& setup, const Model& model, std::vector<Report::Row>* rows,
               Report* report) {
  const Columns exact =
      SolveDirectly(DirectMethod::kSparseLdlt, LimitMatrix(model.mesh, DooSabinModifiedStencil()),
                    RightSide(model.mesh, model.given.positions))
          .x;
  std::array<std::vector<double>, kMethods.size()> errors;
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    errors[m] = Errors(setup, model, kMethods[m].method, exact);
  }
  std::string text = "sweep";
  for (const Method& method : kMethods) absl::StrAppend(&text, "\t", method.name);
  for (std::size_t sweep = 0; sweep <= kMostSweeps; ++sweep) {
    absl::StrAppend(&text, "\n", sweep);
    for (const std::vector<double>& error : errors) {
      (*rows)[sweep].push_back(Scientific(error[sweep]));
      // A logarithmic scale has no zero.
      absl::StrAppend(&text, "\t", std::max(error[sweep], 1e-17));
    }
  }
  const std::string name = absl::StrReplaceAll(model.name, {{" ", "-"}, {",", ""}});
  WriteText(setup, absl::StrCat("errors-", name, ".tsv"), text + "\n");
  report->CheckAtMost(absl::StrCat(model.name, ": error of Chebyshev after 20 sweeps"),
                      errors.back().back(), 1e-13);
}

void AddErrorTables(const Setup& setup, const std::vector<Model>& models, Report* report) {
  report->Heading("Auxiliary mesh: error after each sweep");
  report->Paragraph(
      "Largest distance of a vertex of the auxiliary mesh from its exact place, as a part of the "
      "bounding box's diagonal. The exact mesh is that of a direct solver (sparse LDL').");
  report->Pictures({{"errors.png", "Error after each sweep"}});
  for (const Model& model : models) {
    Report::Row header = {absl::StrCat(model.name, ": sweep")};
    std::vector<Report::Row> rows;
    for (const Method& method : kMethods) header.emplace_back(method.name);
    for (std::uint32_t sweep = 0; sweep <= kMostSweeps; ++sweep) {
      rows.push_back({absl::StrCat(sweep)});
    }
    AddErrors(setup, model, &rows, report);
    report->Table(header, rows);
  }
}

Report::Row FirstRefinementRow(const Setup& setup, const Model& model, Report* report) {
  Buffer<Vec3> control;
  SolveModel(setup, model, {.method = SolveMethod::kGaussSeidel, .tolerance = kTolerances[0]},
             &control);
  Buffer<Vec3> corners(model.mesh.half_edge_count());
  const double refine = BestMilliseconds(setup, [&] {
    OrDie(FirstRefinement(setup.context, model.mesh, control, absl::MakeSpan(corners)));
  });
  const double perturb = BestMilliseconds(setup, [&] {
    OrDie(PerturbToInterpolate(setup.context, {.mesh = model.mesh, .points = model.given.positions},
                               absl::MakeSpan(corners)));
  });
  double largest = 0;
  for (std::size_t v = 0; v < model.mesh.vertex_count(); ++v) {
    Vec3 sum = {0, 0, 0};
    for (std::size_t i = 0; i < model.mesh.valence(v); ++i) {
      sum += corners[model.mesh.fan()[model.mesh.fan_begin()[v] + i]];
    }
    const Vec3 centroid = (1 / static_cast<double>(model.mesh.valence(v))) * sum;
    largest = std::max(largest, Norm(centroid - model.given.positions[v]));
  }
  largest /= model.scale;
  report->CheckAtMost(
      absl::StrCat(model.name, ": distance of surface and vertices, solved to 0.3 %"), largest,
      1e-12);
  return {model.name,
          Count(corners.size()),
          Milliseconds(refine),
          Milliseconds(perturb),
          Milliseconds(refine + perturb),
          Scientific(largest)};
}

void AddFirstRefinement(const Setup& setup, const std::vector<Model>& models, Report* report) {
  std::vector<Report::Row> rows;
  for (const Model& model : models) rows.push_back(FirstRefinementRow(setup, model, report));
  report->Heading("Perturbed first refined mesh (section 3.3)");
  report->Paragraph(
      "From the auxiliary mesh solved to 0.3 %. The paper: 37 ms and 491 ms. Limn never builds the "
      "connectivity of the refined mesh: it keeps one point for each corner of the given one. The "
      "last column is the largest distance of a vertex from the surface, over the diagonal: it "
      "does "
      "not depend on how well the auxiliary mesh was solved for.");
  report->Table({"model", "refined vertices", "refine, ms", "perturb, ms", "both, ms", "distance"},
                rows);
}

void AddModels(const Setup& setup, const std::vector<Model>& models, Report* report) {
  std::vector<Report::Row> rows;
  for (const Model& model : models) {
    const double build = BestMilliseconds(
        setup, [&] { OrDie(HalfEdgeMesh::Build(setup.context, model.given).status()); });
    rows.push_back({model.name, Count(model.mesh.vertex_count()), Count(model.mesh.edge_count()),
                    Count(model.mesh.face_count()), Milliseconds(build)});
  }
  report->Heading("Models");
  report->Paragraph(
      "Made by code, of the sizes of the paper's, whose own are not at hand: a bumpy sphere of "
      "polygons of 3 to 8 sides and valences 3 to 9, and one of polygons of 3 to 12 sides with "
      "three at each vertex. The last column is the time to pair half-edges and to check that the "
      "mesh is a 2-manifold.");
  report->Table({"model", "vertices", "edges", "faces", "half-edges, ms"}, rows);
}

}  // namespace

void RunSweeps(const Setup& setup, Report* report) {
  std::vector<Model> models;
  for (const std::uint64_t size : {kSmallModel, kLargeModel}) {
    if (setup.quick && size != kSmallModel) continue;
    for (const MeshKind kind : {MeshKind::kIrregularSphere, MeshKind::kNgons}) {
      models.push_back(MakeModel(setup, kind, size));
    }
  }
  AddModels(setup, models, report);
  AddSweeps(setup, models, report);
  AddErrorTables(setup, models, report);
  AddFirstRefinement(setup, models, report);
}

}  // namespace limn::experiments
