// SPDX-License-Identifier: MIT
// The engine's limit operator applied to points, in and out in vertex order.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "engine/base/context.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/stencil/limit_operator.h"
#include "engine/stencil/limit_stencil.h"

namespace limn::oracle {

inline std::vector<Vec3> LimitsOf(const HalfEdgeMesh& mesh, const LimitStencil& stencil,
                                  const std::vector<Vec3>& points) {
  const Context context;
  const auto limit = LimitOperator::Make(context, mesh, stencil);
  EXPECT_TRUE(limit.ok()) << limit.status();
  std::vector<Vec3> slots(points.size());
  std::vector<Vec3> values(limit->face_value_count());
  std::vector<Vec3> limit_slots(points.size());
  std::vector<Vec3> limits(points.size());
  double largest = 0;
  EXPECT_TRUE(limit->ToSlots(context, points, absl::MakeSpan(slots)).ok());
  EXPECT_TRUE(limit->FaceValues(context, slots, absl::MakeSpan(values)).ok());
  EXPECT_TRUE(limit
                  ->VisitLimits(
                      context, slots.data(), values.data(),
                      [&](Index slot, const Vec3& point) {
                        limit_slots[slot] = point;
                        return 0.0;
                      },
                      &largest)
                  .ok());
  EXPECT_TRUE(limit->FromSlots(context, limit_slots, absl::MakeSpan(limits)).ok());
  return limits;
}

}  // namespace limn::oracle
