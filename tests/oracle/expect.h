// SPDX-License-Identifier: MIT
// Shorthands of the engine's tests: statuses, errors, meshes by name.
#pragma once

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/half_edge_mesh.h"
#include "tests/oracle/mesh.h"
#include "tests/oracle/test_meshes.h"

// The value of an absl::StatusOr, or the end of the test.
#define LIMN_ASSERT_OK_AND_ASSIGN(lhs, expr) \
  LIMN_ASSERT_OK_AND_ASSIGN_IMPL(LIMN_CONCAT(limn_test_statusor_, __LINE__), lhs, expr)
#define LIMN_ASSERT_OK_AND_ASSIGN_IMPL(statusor, lhs, expr) \
  auto statusor = (expr);                                   \
  ASSERT_TRUE(statusor.ok()) << statusor.status();          \
  lhs = *std::move(statusor)

namespace limn::oracle {

struct ExpectedError {
  Reason reason;
  std::string field = {};
  std::optional<std::uint64_t> index = std::nullopt;
};

// The status is that error, with its code, field and index, and with a remedy for bad input.
inline void ExpectError(const absl::Status& status, const ExpectedError& expected) {
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.code(), CodeOf(expected.reason)) << status;
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(ReasonName(detail->reason), ReasonName(expected.reason)) << status;
  EXPECT_EQ(detail->field, expected.field) << status;
  EXPECT_EQ(detail->index, expected.index) << status;
  if (status.code() == absl::StatusCode::kInvalidArgument) {
    EXPECT_NE(detail->remedy, "") << status;
    EXPECT_NE(status.message().find(detail->remedy), std::string_view::npos) << status;
  }
}

// f() in an arena of that many threads, also where there are fewer processors.
template <class F>
auto WithThreads(int threads, F&& f) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  ThreadArena arena(threads);
  return arena.Execute(std::forward<F>(f));
}

// The connectivity of a mesh that is known to be good.
inline HalfEdgeMesh BuildOrDie(const PolygonMesh& mesh) {
  auto built = HalfEdgeMesh::Build(Context(), mesh);
  EXPECT_TRUE(built.ok()) << built.status();
  return *std::move(built);
}

// Tests that run once for every closed mesh.
class ClosedMeshTest : public testing::TestWithParam<std::string> {
 protected:
  ClosedMeshTest() : mesh_(ClosedMesh(GetParam())), given_(FromPolygonMesh(mesh_)) {}

  const PolygonMesh mesh_;
  // The same for the oracle.
  const Mesh given_;
  const Context context_;
};

}  // namespace limn::oracle

#define LIMN_FOR_CLOSED_MESHES(suite)                                                         \
  INSTANTIATE_TEST_SUITE_P(Closed, suite, testing::ValuesIn(limn::oracle::ClosedMeshNames()), \
                           [](const auto& mesh) { return mesh.param; })
