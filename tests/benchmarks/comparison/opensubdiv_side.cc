// SPDX-License-Identifier: MIT
// OpenSubdiv's refiner, stencil tables and limits (Far) in the comparison; Bfr is in bfr_side.cc.
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTable.h>
#include <opensubdiv/far/stencilTableFactory.h>

#include <utility>

#include "tests/benchmarks/comparison/opensubdiv_mesh.h"
#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {
namespace {

namespace Far = OpenSubdiv::Far;
using StencilTable = Far::StencilTableReal<double>;

// A point as OpenSubdiv adds them up.
struct Point {
  Vec3 value = {0, 0, 0};
  void Clear() { value = {0, 0, 0}; }
  void AddWithWeight(const Point& other, double weight) { value += weight * other.value; }
};
using Points = std::vector<Point>;

std::vector<Vec3> Values(const Points& points) {
  std::vector<Vec3> values;
  for (const Point& p : points) values.push_back(p.value);
  return values;
}

std::unique_ptr<const StencilTable> MakeStencils(const Far::TopologyRefiner& refiner) {
  return std::unique_ptr<const StencilTable>(Far::StencilTableFactoryReal<double>::Create(refiner));
}

// What a task asks for, from what there is before.
struct Parts {
  bool loop = false;
  // Starts from index arrays.
  bool build = false;
  // Makes the refined connectivity.
  bool refine = true;
  // Finds points by a stencil table (made before if there is nothing else to make).
  bool stencils = false;
  bool limit = false;
};

class OpenSubdiv : public Contestant {
 public:
  OpenSubdiv(const PolygonMesh& given, Parts parts) : mesh_(given, parts.loop), parts_(parts) {
    for (const Vec3& p : given.positions) given_.push_back({p});
    if (parts.refine) return;
    refiner_ = mesh_.MakeRefiner();
    Refine();
    if (parts.stencils) stencils_ = MakeStencils(*refiner_);
  }
  void Prepare() override {
    if (!parts_.refine) return;
    stencils_.reset();
    points_ = limits_ = Points();
    normals_ = std::vector<Vec3>();
    refiner_ = parts_.build ? nullptr : mesh_.MakeRefiner();
  }
  void Run() override {
    if (parts_.build) refiner_ = mesh_.MakeRefiner();
    if (parts_.refine) Refine();
    points_.resize(static_cast<std::size_t>(refiner_->GetLevel(1).GetNumVertices()));
    if (parts_.stencils) {
      if (parts_.refine) stencils_ = MakeStencils(*refiner_);
      stencils_->UpdateValues(given_.data(), points_.data());
    } else {
      Far::PrimvarRefinerReal<double>(*refiner_).Interpolate(1, given_, points_);
    }
    if (parts_.limit) Limit();
  }
  Answer GetAnswer() override {
    if (parts_.limit) return {Values(limits_), normals_, false};
    return {Values(points_), {}, false};
  }

 private:
  void Refine() {
    Far::TopologyRefiner::UniformOptions uniform(1);
    uniform.fullTopologyInLastLevel = parts_.limit;
    refiner_->RefineUniform(uniform);
  }
  void Limit() {
    limits_.resize(points_.size());
    Points u(points_.size());
    Points v(points_.size());
    Far::PrimvarRefinerReal<double>(*refiner_).Limit(points_, limits_, u, v);
    normals_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      normals_[i] = UnitNormal(u[i].value, v[i].value);
    }
  }

  const OpenSubdivMesh mesh_;
  const Parts parts_;
  Points given_;
  std::unique_ptr<Far::TopologyRefiner> refiner_;
  std::unique_ptr<const StencilTable> stencils_;
  Points points_;
  Points limits_;
  std::vector<Vec3> normals_;
};

void Add(const char* name, const char* rival, Parts parts, std::vector<Entry>* entries) {
  entries->push_back({.name = name, .rival = rival, .make = [parts](const PolygonMesh& mesh) {
                        return std::make_unique<OpenSubdiv>(mesh, parts);
                      }});
}

}  // namespace

std::vector<Entry> OpenSubdivEntries(Task task) {
  std::vector<Entry> entries;
  const bool loop = task == Task::kLoop || task == Task::kLoopStep || task == Task::kLoopPoints ||
                    task == Task::kLoopLimit;
  switch (task) {
    case Task::kCatmullClark:
    case Task::kLoop:
      Add("OpenSubdiv refiner", "OpenSubdiv", {.loop = loop, .build = true}, &entries);
      Add("OpenSubdiv stencils", "OpenSubdiv stencils",
          {.loop = loop, .build = true, .stencils = true}, &entries);
      break;
    case Task::kCatmullClarkStep:
    case Task::kLoopStep:
      Add("OpenSubdiv refiner", "OpenSubdiv", {.loop = loop}, &entries);
      break;
    case Task::kCatmullClarkPoints:
    case Task::kLoopPoints:
      Add("OpenSubdiv refiner", "OpenSubdiv", {.loop = loop, .refine = false}, &entries);
      Add("OpenSubdiv stencils", "OpenSubdiv stencils",
          {.loop = loop, .refine = false, .stencils = true}, &entries);
      break;
    case Task::kCatmullClarkLimit:
    case Task::kLoopLimit:
      Add("OpenSubdiv Far", "Far", {.loop = loop, .build = true, .limit = true}, &entries);
      AddBfrEntries(loop, &entries);
      break;
    default:
      break;
  }
  return entries;
}

}  // namespace limn::comparison
