// SPDX-License-Identifier: MIT
// Doo-Sabin surfaces in a job. Source: Zheng and Cai 2005, section 3.4.
#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/pipeline/scheme_job.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

class DooSabinJob : public SchemeJob {
 public:
  explicit DooSabinJob(JobFrame* frame);

  absl::Status Start(HalfEdgeMesh mesh) override;
  absl::Status LimitPoints(absl::Span<const Vec3> control, absl::Span<Vec3> limits) override;
  absl::Status FindControlMesh() override;
  const BoundaryControl& boundary_control() const override { return boundary_control_; }
  absl::Status StartSurface() override;
  absl::StatusOr<ChordLevel> ChooseLevel(double tolerance) override;
  absl::Status Refine() override;
  absl::Status Tessellate() override;

 protected:
  // result.patches, if they are to be kept.
  void KeepPatches();

  JobFrame& frame_;
  const Context& context_;
  std::uint32_t level_ = 0;
  // T^(level - 1) and the points of M^level; at level 0, T^0 and M^1.
  std::optional<DooSabinSurface> patches_;

 private:
  absl::Status FindBoundaryControl(const ControlMeshProblem& problem);
  absl::Status MoveSurfaceBack();

  const FirstRule rule_;
  BoundaryControl boundary_control_;
  ExtraordinaryFans fans_;
};

}  // namespace limn
