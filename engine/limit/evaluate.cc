// SPDX-License-Identifier: MIT
#include "engine/limit/evaluate.h"

#include <atomic>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/limit/control_ring.h"
#include "engine/limit/ring_patch.h"

namespace limn {
namespace {

// Parameters per chunk, some hundred microseconds of work.
constexpr std::size_t kGrain = 256;

bool InUnitInterval(double t) { return t >= 0 && t <= 1; }

std::size_t Arity(const HalfEdgeMesh& mesh, Index face) {
  return mesh.face_begin()[face + 1] - mesh.face_begin()[face];
}

bool IsValid(const HalfEdgeMesh& mesh, const SurfaceParameter& p) {
  return p.face < mesh.face_count() && p.corner < Arity(mesh, p.face) && InUnitInterval(p.u) &&
         InUnitInterval(p.v);
}

// What is wrong with parameter number i.
absl::Status Refusal(const HalfEdgeMesh& mesh, const SurfaceParameter& p, std::uint64_t i) {
  const auto error = [&](Reason reason, const char* field, const std::string& value,
                         const std::string& range) {
    const std::string path = absl::StrCat("parameters[", i, "].", field);
    return MakeError(absl::StrCat(path, " is ", value),
                     {.reason = reason,
                      .field = path,
                      .index = i,
                      .remedy = absl::StrCat("It must be from 0 to ", range)});
  };
  if (p.face >= mesh.face_count()) {
    return error(Reason::kIndexOutOfRange, "face", absl::StrCat(p.face),
                 absl::StrCat(mesh.face_count() - 1));
  }
  if (p.corner >= Arity(mesh, p.face)) {
    return error(Reason::kIndexOutOfRange, "corner", absl::StrCat(p.corner),
                 absl::StrCat(Arity(mesh, p.face) - 1, " in face ", p.face));
  }
  if (!InUnitInterval(p.u)) return error(Reason::kInvalidOption, "u", absl::StrCat(p.u), "1");
  return error(Reason::kInvalidOption, "v", absl::StrCat(p.v), "1");
}

// The boundary curve from a vertex to the middle of an edge: a quadratic Bezier curve. Its end is
// summed alike from both sides of the edge.
Vec3 HalfEdgeCurve(const Vec3& vertex, const Vec3& near, const Vec3& far, double t) {
  const double s = 1 - t;
  return s * s * vertex + 2 * s * t * near + t * t * (0.5 * (near + far));
}

// The point in the model's frame.
Vec3 PointAt(const DooSabinSurface& surface, Index h, const SurfaceParameter& p,
             const Vec3& local) {
  const BoundaryCurve& curve = surface.boundary;
  if (p.v == 0 && surface.mesh.twin()[h] == kNoIndex) {
    const Index i = curve.Find(h);
    return HalfEdgeCurve(curve.centre[i], curve.start[i], curve.end[i], p.u);
  }
  if (p.u == 0) {
    const Index prev = PolygonWalk(surface.mesh).Prev(h);
    if (surface.mesh.twin()[prev] == kNoIndex) {
      const Index i = curve.Find(prev);
      return HalfEdgeCurve(curve.centre[curve.next[i]], curve.end[i], curve.start[i], p.v);
    }
  }
  return local + curve.origin;
}

// Writes samples begin .. end - 1. Returns the first invalid parameter of these, or end.
std::size_t EvaluateRange(const DooSabinSurface& surface, RingGatherer* gatherer,
                          absl::Span<const SurfaceParameter> parameters,
                          const SurfaceSamples& samples,
                          std::pair<std::size_t, std::size_t> range) {
  for (std::size_t i = range.first; i < range.second; ++i) {
    const SurfaceParameter& p = parameters[i];
    if (!IsValid(surface.mesh, p)) return i;
    const Index h = surface.mesh.face_begin()[p.face] + p.corner;
    const PatchSample sample = EvaluateRing(gatherer->Gather(h), p.u, p.v);
    if (!samples.points.empty()) samples.points[i] = PointAt(surface, h, p, sample.point);
    if (!samples.du.empty()) samples.du[i] = sample.du;
    if (!samples.dv.empty()) samples.dv[i] = sample.dv;
    if (!samples.normals.empty()) samples.normals[i] = sample.normal;
  }
  return range.second;
}

}  // namespace

SurfaceEvaluator::SurfaceEvaluator(const DooSabinSurface& surface, LargeFaces large_faces)
    : surface_(&surface), large_faces_(std::move(large_faces)) {}

absl::StatusOr<SurfaceEvaluator> SurfaceEvaluator::Create(const Context& context,
                                                          const DooSabinSurface& surface) {
  LIMN_ASSIGN_OR_RETURN(LargeFaces large_faces, LargeFaces::Find(context, surface));
  return SurfaceEvaluator(surface, std::move(large_faces));
}

absl::Status SurfaceEvaluator::Evaluate(const Context& context,
                                        absl::Span<const SurfaceParameter> parameters,
                                        const SurfaceSamples& samples, std::uint64_t first) const {
  // The smallest of all that are found, whatever their order.
  std::atomic<std::size_t> wrong = parameters.size();
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, parameters.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        RingGatherer gatherer(*surface_, large_faces_);
        const std::size_t found =
            EvaluateRange(*surface_, &gatherer, parameters, samples, {begin, end});
        if (found == end) return;
        std::size_t known = wrong.load();
        while (found < known && !wrong.compare_exchange_weak(known, found)) {
        }
      }));
  const std::size_t i = wrong.load();
  if (i == parameters.size()) return absl::OkStatus();
  return Refusal(surface_->mesh, parameters[i], first + i);
}

absl::Status EvaluateSurface(const Context& context, const DooSabinSurface& surface,
                             absl::Span<const SurfaceParameter> parameters,
                             const SurfaceSamples& samples) {
  LIMN_ASSIGN_OR_RETURN(const SurfaceEvaluator evaluator,
                        SurfaceEvaluator::Create(context, surface));
  return evaluator.Evaluate(context, parameters, samples);
}

}  // namespace limn
