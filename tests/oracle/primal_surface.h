// SPDX-License-Identifier: MIT
// Catmull-Clark and Loop surfaces to evaluate.
#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "engine/limit/evaluate.h"
#include "engine/limit/primal_surface.h"
#include "tests/oracle/creased_level.h"
#include "tests/oracle/deep_surface.h"

namespace limn::oracle {

// The surface of a control mesh; an error fails the test.
inline PrimalSurface PrimalSurfaceOf(const PolygonMesh& given, Rule rule, const Creases& creases,
                                     double blend = 0) {
  CreasedLevel level(given, rule, creases);
  absl::StatusOr<PrimalSurface> surface =
      rule == Rule::kLoop ? MakeLoopSurface(std::move(level.mesh), std::move(level.sharpness),
                                            std::move(level.points))
                          : MakeCatmullClarkSurface(Context(), level.level(), level.points, blend);
  EXPECT_TRUE(surface.ok()) << surface.status();
  return *std::move(surface);
}

// All four at all parameters; an error fails the test.
inline Samples Evaluated(const PrimalSurface& surface,
                         const std::vector<SurfaceParameter>& parameters) {
  Samples samples(parameters.size());
  const absl::Status status = EvaluateSurface(Context(), surface, parameters, samples.Spans());
  EXPECT_TRUE(status.ok()) << status;
  return samples;
}

}  // namespace limn::oracle
