// SPDX-License-Identifier: MIT
// What a scheme contributes to evaluation: its patches. Everything else is
// engine/limit/evaluate.cc's.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/limit/evaluate.h"
#include "engine/limit/patch_sample.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

class PatchSource {
 public:
  PatchSource() = default;
  PatchSource(const PatchSource&) = delete;
  PatchSource& operator=(const PatchSource&) = delete;
  virtual ~PatchSource() = default;

  // Faces of T^0 and their corners.
  virtual std::size_t face_count() const = 0;
  virtual std::size_t arity(Index face) const = 0;
  // Whether u + v must be at most 1.
  virtual bool triangles() const = 0;

  // Writes the samples range.first to range.second - 1, whose parameters are valid. May return
  // early when the context asks to stop. Thread-safe.
  virtual void Evaluate(const Context& context, absl::Span<const SurfaceParameter> parameters,
                        const SurfaceSamples& samples,
                        std::pair<std::size_t, std::size_t> range) const = 0;
};

// The surface must outlive the source. Errors: CANCELLED, DEADLINE_EXCEEDED.
[[nodiscard]] absl::StatusOr<std::unique_ptr<PatchSource>> MakeDooSabinPatches(
    const Context& context, const DooSabinSurface& surface);
[[nodiscard]] std::unique_ptr<PatchSource> MakePrimalPatches(const PrimalSurface& surface);

// Writes sample number i.
inline void WriteSample(const PatchSample& sample, std::size_t i, const SurfaceSamples& samples) {
  if (!samples.points.empty()) samples.points[i] = sample.point;
  if (!samples.du.empty()) samples.du[i] = sample.du;
  if (!samples.dv.empty()) samples.dv[i] = sample.dv;
  if (!samples.normals.empty()) samples.normals[i] = sample.normal;
}

}  // namespace limn
