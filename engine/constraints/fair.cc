// SPDX-License-Identifier: MIT
#include "engine/constraints/fair.h"

#include <utility>

#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/constraints/fair_choice.h"
#include "engine/constraints/fair_faces.h"
#include "engine/constraints/fair_smooth.h"
#include "engine/limit/bending_energy.h"

namespace limn {
namespace {

constexpr FairCures kHandles = {.shape_handles = true};
constexpr FairCures kBoth = {.shape_handles = true, .smoothing = true};

// The shapes that are tried, and the best of them.
class Trial {
 public:
  Trial(const Context& context, const DooSabinSurface& surface, BendingEnergyMeter meter,
        const FairFaces& faces)
      : context_(context),
        surface_(surface),
        meter_(std::move(meter)),
        faces_(faces),
        choice_(faces),
        corners_(surface.corners) {}

  // Ends with the corners to take in *best; empty: those of the surface.
  absl::StatusOr<FairnessReport> Run(Buffer<Vec3>* best) {
    LIMN_ASSIGN_OR_RETURN(report_.energy_before, Measure(corners_));
    report_.energy_after = report_.energy_before;
    LIMN_RETURN_IF_ERROR(Consider({}));
    LIMN_RETURN_IF_ERROR(faces_.ApplyHandles(context_, kFairExtent, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(Judge(corners_, kHandles, best));
    LIMN_RETURN_IF_ERROR(Consider(kHandles));
    LIMN_RETURN_IF_ERROR(SmoothAndChoose(best));
    LIMN_RETURN_IF_ERROR(choice_.Renew(context_, meter_.patches()));
    corners_ = choice_.corners();
    LIMN_RETURN_IF_ERROR(SmoothAndChoose(best));
    return report_;
  }

 private:
  absl::StatusOr<double> Measure(absl::Span<const Vec3> corners) {
    constexpr double kShapes = 6;
    context_.Report({.stage = "fair", .fraction = measured_++ / kShapes});
    return meter_.Measure(context_, corners, &surface_.boundary);
  }

  // Smooths corners_, and then chooses vertex by vertex.
  absl::Status SmoothAndChoose(Buffer<Vec3>* best) {
    LIMN_RETURN_IF_ERROR(SmoothCorners(context_, faces_, kFairSweeps, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(faces_.Settle(context_, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(faces_.ApplyHandles(context_, kSmoothedExtent, absl::MakeSpan(corners_)));
    LIMN_RETURN_IF_ERROR(Judge(corners_, kBoth, best));
    LIMN_RETURN_IF_ERROR(Consider(kBoth));
    return Judge(choice_.corners(), choice_.cures(), best);
  }

  // Of what was measured last.
  absl::Status Consider(const FairCures& cures) {
    return choice_.Consider(context_,
                            {.corners = corners_, .patches = meter_.patches(), .cures = cures});
  }

  absl::Status Judge(const Buffer<Vec3>& corners, const FairCures& cures, Buffer<Vec3>* best) {
    LIMN_ASSIGN_OR_RETURN(const double energy, Measure(corners));
    if (!(energy < report_.energy_after)) return absl::OkStatus();
    report_.energy_after = energy;
    report_.shape_handles = cures.shape_handles;
    report_.smoothing = cures.smoothing;
    *best = corners;
    return absl::OkStatus();
  }

  const Context& context_;
  const DooSabinSurface& surface_;
  BendingEnergyMeter meter_;
  const FairFaces& faces_;
  FairChoice choice_;
  // The shape that is tried.
  Buffer<Vec3> corners_;
  int measured_ = 0;
  FairnessReport report_;
};

}  // namespace

absl::StatusOr<FairnessReport> Fair(const Context& context, const FairInput& input,
                                    DooSabinSurface* surface) {
  static const VertexPlan kNoPlan;
  const VertexPlan& plan = input.plan != nullptr ? *input.plan : kNoPlan;
  LIMN_ASSIGN_OR_RETURN(BendingEnergyMeter meter, BendingEnergyMeter::Make(context, surface->mesh));
  LIMN_ASSIGN_OR_RETURN(const FairFaces faces, FairFaces::Make(context, *surface, plan));
  Buffer<Vec3> best;
  LIMN_ASSIGN_OR_RETURN(const FairnessReport report,
                        Trial(context, *surface, std::move(meter), faces).Run(&best));
  if (report.smoothing || report.shape_handles) surface->corners = std::move(best);
  return report;
}

}  // namespace limn
