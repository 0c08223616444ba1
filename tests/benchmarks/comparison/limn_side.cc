// SPDX-License-Identifier: MIT
// Limn in the comparison.
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/base/parallel.h"
#include "engine/limit/vertex_limit.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "engine/mesh/validate.h"
#include "engine/refine/catmull_clark_refine.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/loop_refine.h"
#include "engine/solve/solve.h"
#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {
namespace {

void OrThrow(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(std::string(status.message()));
}
template <class T>
T OrThrow(absl::StatusOr<T> value) {
  OrThrow(value.status());
  return *std::move(value);
}

std::vector<Vec3> Copied(absl::Span<const Vec3> points) { return {points.begin(), points.end()}; }

class Limn : public Contestant {
 public:
  Limn(const PolygonMesh& given, int threads) : given_(given), arena_(threads) {}
  void Prepare() override { Drop(); }
  void Run() override {
    arena_.Execute([this] { Work(); });
  }

 protected:
  virtual void Drop() = 0;
  virtual void Work() = 0;

  const Context context_;
  const PolygonMesh& given_;
  ThreadArena arena_;
};

class Build : public Limn {
 public:
  using Limn::Limn;
  void Drop() override { mesh_.reset(); }
  void Work() override { mesh_ = OrThrow(HalfEdgeMesh::Build(context_, given_)); }
  Answer GetAnswer() override { return {Copied(given_.positions), {}, true}; }

 private:
  std::optional<HalfEdgeMesh> mesh_;
};

class SolveTo : public Limn {
 public:
  SolveTo(const PolygonMesh& given, int threads, double tolerance)
      : Limn(given, threads),
        mesh_(OrThrow(HalfEdgeMesh::Build(context_, given))),
        tolerance_(tolerance),
        solution_(given.positions) {
    OrThrow(ValidatePositions(context_, given.positions, &box_));
  }
  void Drop() override {}
  void Work() override {
    OrThrow(Solve(context_,
                  {.mesh = mesh_,
                   .stencil = stencil_,
                   .points = given_.positions,
                   .scale = box_.diagonal()},
                  {.tolerance = tolerance_}, absl::MakeSpan(solution_))
                .status());
  }
  Answer GetAnswer() override { return {Copied(solution_), {}, true}; }

 private:
  const HalfEdgeMesh mesh_;
  const LimitStencil stencil_ = DooSabinModifiedStencil();
  const double tolerance_;
  Buffer<Vec3> solution_;
  BoundingBox box_;
};

class DooSabinStep : public Limn {
 public:
  DooSabinStep(const PolygonMesh& given, int threads)
      : Limn(given, threads), mesh_(OrThrow(HalfEdgeMesh::Build(context_, given))) {}
  void Drop() override {
    dual_.reset();
    points_ = Buffer<Vec3>();
  }
  void Work() override {
    points_.resize(mesh_.half_edge_count());
    OrThrow(FirstRefinement(context_, mesh_, given_.positions, absl::MakeSpan(points_),
                            FirstRule::kStandard));
    dual_ = OrThrow(SplitIntoQuads(context_, mesh_));
  }
  Answer GetAnswer() override { return {Copied(points_), {}, false}; }

 private:
  const HalfEdgeMesh mesh_;
  std::optional<HalfEdgeMesh> dual_;
  Buffer<Vec3> points_;
};

// Catmull-Clark or Loop: as much of build, split, refinement and limits as a task asks for.
class Primal : public Limn {
 public:
  struct Parts {
    bool loop = false;
    bool build = false;
    bool split = true;
    bool limit = false;
  };
  Primal(const PolygonMesh& given, int threads, Parts parts) : Limn(given, threads), parts_(parts) {
    if (!parts.build) mesh_ = OrThrow(HalfEdgeMesh::Build(context_, given));
  }
  void Drop() override {
    if (!parts_.split) return;
    if (parts_.build) mesh_.reset();
    refined_mesh_.reset();
    points_ = limits_ = normals_ = Buffer<Vec3>();
  }
  void Work() override {
    if (parts_.build) mesh_ = OrThrow(HalfEdgeMesh::Build(context_, given_));
    if (parts_.split) {
      refined_mesh_ = OrThrow(parts_.loop ? SplitIntoTriangles(context_, *mesh_)
                                          : SplitIntoQuads(context_, *mesh_));
    }
    const std::size_t faces = parts_.loop ? 0 : mesh_->face_count();
    points_.resize(mesh_->vertex_count() + mesh_->edge_count() + faces);
    const SurfaceLevel level = {*mesh_, sharpness_};
    const auto out = absl::MakeSpan(points_);
    OrThrow(parts_.loop ? RefineLoop(context_, level, given_.positions, out)
                        : RefineCatmullClark(context_, level, given_.positions, out));
    if (parts_.limit) Limit();
  }
  Answer GetAnswer() override {
    if (parts_.limit) return {Copied(limits_), Copied(normals_), false};
    return {Copied(points_), {}, false};
  }

 private:
  void Limit() {
    limits_.resize(points_.size());
    normals_.resize(points_.size());
    const SurfaceLevel level = {*refined_mesh_, sharpness_};
    const VertexLimits out = {absl::MakeSpan(limits_), {}, absl::MakeSpan(normals_)};
    OrThrow(parts_.loop ? LoopLimits(context_, level, points_, out)
                        : CatmullClarkLimits(context_, level, points_, out));
  }

  const Parts parts_;
  const Sharpness sharpness_;
  std::optional<HalfEdgeMesh> mesh_;
  std::optional<HalfEdgeMesh> refined_mesh_;
  Buffer<Vec3> points_;
  Buffer<Vec3> limits_;
  Buffer<Vec3> normals_;
};

std::unique_ptr<Contestant> Make(Task task, const PolygonMesh& mesh, int threads) {
  const auto primal = [&](Primal::Parts parts) {
    return std::make_unique<Primal>(mesh, threads, parts);
  };
  switch (task) {
    case Task::kBuild:
      return std::make_unique<Build>(mesh, threads);
    case Task::kSolve6:
      return std::make_unique<SolveTo>(mesh, threads, 1e-6);
    case Task::kSolve12:
      return std::make_unique<SolveTo>(mesh, threads, 1e-12);
    case Task::kDooSabinStep:
      return std::make_unique<DooSabinStep>(mesh, threads);
    case Task::kCatmullClarkStep:
      return primal({.loop = false});
    case Task::kLoopStep:
      return primal({.loop = true});
    case Task::kCatmullClark:
      return primal({.loop = false, .build = true});
    case Task::kLoop:
      return primal({.loop = true, .build = true});
    case Task::kCatmullClarkPoints:
      return primal({.loop = false, .split = false});
    case Task::kLoopPoints:
      return primal({.loop = true, .split = false});
    case Task::kCatmullClarkLimit:
      return primal({.loop = false, .build = true, .limit = true});
    default:
      return primal({.loop = true, .build = true, .limit = true});
  }
}

}  // namespace

std::vector<Entry> LimnEntries(Task task) {
  std::vector<Entry> entries;
  for (const int threads : {1, 2}) {
    entries.push_back(
        {.name = "Limn",
         .rival = "",
         .threads = threads,
         .agreement = task == Task::kSolve6 ? 2e-6 : 2e-12,
         .make = [task, threads](const PolygonMesh& mesh) { return Make(task, mesh, threads); }});
  }
  return entries;
}

Answer ExactSolution(const PolygonMesh& mesh) {
  SolveTo solve(mesh, 1, 1e-15);
  solve.Run();
  return solve.GetAnswer();
}

}  // namespace limn::comparison
