// SPDX-License-Identifier: MIT
// Thousands of random meshes through every scheme: what the certificate says of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/constraints/certificate.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/slowdown.h"

namespace limn {
namespace {

constexpr std::uint64_t kMeshes = 3000 / oracle::kSlowdown;

// The certificate of the surface that comes back, by the points that went in.
Certificate CertificateOf(const PolygonMesh& mesh, const InterpolateResult& result,
                          const Constraints& constraints) {
  Buffer<Vec3> targets(mesh.positions.begin(), mesh.positions.end());
  CertificateBuilder builder(std::move(targets), constraints);
  builder.AddRun(0, result.surface.positions);
  builder.AddNormalRun(0, result.surface.normals);
  EXPECT_TRUE(builder.complete());
  return builder.Finish();
}

// One random job: a mesh of some kind, all or some of its vertices, a level.
class RandomMeshes : public testing::TestWithParam<Scheme> {
 protected:
  void Run(std::uint64_t seed) {
    SCOPED_TRACE(absl::StrCat("seed ", seed));
    std::mt19937_64 random(seed);
    const absl::Span<const MeshKind> kinds = AllMeshKinds();
    const MeshKind kind = kinds[random() % kinds.size()];
    LIMN_ASSERT_OK_AND_ASSIGN(
        PolygonMesh mesh,
        GenerateMesh({.kind = kind, .vertices = 32 + random() % 80, .seed = random()}));
    if (GetParam() == Scheme::kLoop) mesh = oracle::Triangulated(mesh);
    InterpolateOptions options = {.scheme = GetParam(),
                                  .level = static_cast<std::uint32_t>(random() % 3)};
    if (random() % 3 == 0) {
      options.constraints.interpolate.emplace();
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (random() % 2 == 0) options.constraints.interpolate->push_back(v);
      }
    }
    const auto result = Interpolate(Context(), mesh, options);
    ASSERT_TRUE(result.ok()) << result.status();
    const Certificate certificate = CertificateOf(mesh, *result, options.constraints);
    EXPECT_LE(certificate.max_error, 4e-12 * certificate.bounding_box_diagonal)
        << MeshKindName(kind) << ", residual " << result->solve.residual;
    EXPECT_TRUE(result->solve.converged) << MeshKindName(kind);
    for (const Vec3& p : result->surface.positions) ASSERT_TRUE(IsFinite(p));
    // Not a wild shape either: nothing is far from what it passes through.
    for (const Vec3& p : result->control_positions) {
      ASSERT_LE(MaxAbs(p), 16 * (certificate.bounding_box_diagonal + LargestOf(mesh)));
    }
  }

  static double LargestOf(const PolygonMesh& mesh) {
    double largest = 0;
    for (const Vec3& p : mesh.positions) largest = std::max(largest, MaxAbs(p));
    return largest;
  }
};

TEST_P(RandomMeshes, AreInterpolatedToTheTolerance) {
  for (std::uint64_t seed = 1; seed <= kMeshes; ++seed) Run(seed);
}

INSTANTIATE_TEST_SUITE_P(Schemes, RandomMeshes,
                         testing::Values(Scheme::kDooSabin, Scheme::kCatmullClark, Scheme::kLoop),
                         [](const auto& test) {
                           switch (test.param) {
                             case Scheme::kDooSabin:
                               return "DooSabin";
                             case Scheme::kCatmullClark:
                               return "CatmullClark";
                             case Scheme::kLoop:
                               break;
                           }
                           return "Loop";
                         });

}  // namespace
}  // namespace limn
