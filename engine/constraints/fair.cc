// SPDX-License-Identifier: MIT
#include "engine/constraints/fair.h"

#include <utility>

#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/constraints/fair_faces.h"
#include "engine/constraints/fair_smooth.h"
#include "engine/limit/bending_energy.h"

namespace limn {
namespace {

// The candidates, each made from the one before, and the best of them.
class Trial {
 public:
  Trial(const Context& context, const DooSabinSurface& surface, BendingEnergyMeter meter,
        FairFaces faces)
      : context_(context),
        surface_(surface),
        meter_(std::move(meter)),
        faces_(std::move(faces)),
        corners_(surface.corners) {}

  // Ends with the corners to take in *best; empty: those of the surface.
  absl::StatusOr<FairnessReport> Run(Buffer<Vec3>* best) {
    LIMN_ASSIGN_OR_RETURN(report_.energy_before, Measure(0));
    report_.energy_after = report_.energy_before;
    LIMN_RETURN_IF_ERROR(faces_.ApplyHandles(context_, kFairExtent, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(Judge(1, {.shape_handles = true}, best));
    LIMN_RETURN_IF_ERROR(SmoothCorners(context_, faces_, kFairSweeps, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(faces_.Settle(context_, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(faces_.ApplyHandles(context_, kSmoothedExtent, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(Judge(2, {.shape_handles = true, .smoothing = true}, best));
    return report_;
  }

 private:
  struct Cures {
    bool shape_handles = false;
    bool smoothing = false;
  };

  absl::StatusOr<double> Measure(int candidate) {
    constexpr double kCandidates = 3;
    context_.Report({.stage = "fair", .fraction = candidate / kCandidates});
    return meter_.Measure(context_, corners_, &surface_.boundary);
  }

  absl::Status Judge(int candidate, const Cures& cures, Buffer<Vec3>* best) {
    LIMN_ASSIGN_OR_RETURN(const double energy, Measure(candidate));
    if (!(energy < report_.energy_after)) return absl::OkStatus();
    report_.energy_after = energy;
    report_.shape_handles = cures.shape_handles;
    report_.smoothing = cures.smoothing;
    *best = corners_;
    return absl::OkStatus();
  }

  const Context& context_;
  const DooSabinSurface& surface_;
  BendingEnergyMeter meter_;
  FairFaces faces_;
  Buffer<Vec3> corners_;
  FairnessReport report_;
};

}  // namespace

absl::StatusOr<FairnessReport> Fair(const Context& context, const FairInput& input,
                                    DooSabinSurface* surface) {
  static const VertexPlan kNoPlan;
  const VertexPlan& plan = input.plan != nullptr ? *input.plan : kNoPlan;
  LIMN_ASSIGN_OR_RETURN(BendingEnergyMeter meter, BendingEnergyMeter::Make(context, surface->mesh));
  LIMN_ASSIGN_OR_RETURN(FairFaces faces, FairFaces::Make(context, *surface, plan));
  Buffer<Vec3> best;
  LIMN_ASSIGN_OR_RETURN(const FairnessReport report,
                        Trial(context, *surface, std::move(meter), std::move(faces)).Run(&best));
  if (report.smoothing || report.shape_handles) surface->corners = std::move(best);
  return report;
}

}  // namespace limn
