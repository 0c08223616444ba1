// SPDX-License-Identifier: MIT
// Generated meshes are valid, of the promised size and shape, and the same everywhere.
#include "engine/mesh/generate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/mesh_info.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

std::string Describe(const GenerateOptions& options) {
  return std::string(MeshKindName(options.kind)) + " of " + std::to_string(options.vertices) +
         " vertices, seed " + std::to_string(options.seed);
}

PolygonMesh Generate(const GenerateOptions& options) {
  absl::StatusOr<PolygonMesh> mesh = GenerateMesh(options);
  EXPECT_TRUE(mesh.ok()) << mesh.status() << " for " << Describe(options);
  return mesh.ok() ? *std::move(mesh) : PolygonMesh();
}

double SignedVolume(const PolygonMesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const absl::Span<const Index> face = mesh.face(f);
    for (std::size_t i = 2; i < face.size(); ++i) {
      sum +=
          Dot(mesh.positions[face[0]], Cross(mesh.positions[face[i - 1]], mesh.positions[face[i]]));
    }
  }
  return sum / 6;
}

// The vertices that the kind's comment promises.
std::uint64_t PromisedVertices(const GenerateOptions& options) {
  if (options.kind == MeshKind::kHighGenus) return options.vertices / 8 * 8;
  if (options.kind == MeshKind::kNgons) return options.vertices / 2 * 2;
  return options.vertices;
}

void ExpectSound(const GenerateOptions& options) {
  SCOPED_TRACE(Describe(options));
  const PolygonMesh mesh = Generate(options);
  const absl::Status built = HalfEdgeMesh::Build(Context(), mesh).status();
  ASSERT_TRUE(built.ok()) << built;
  BoundingBox box;
  ASSERT_TRUE(ValidatePositions(Context(), mesh.positions, &box).ok());
  const MeshInfo info = DescribeMesh(mesh);
  EXPECT_EQ(info.components, 1U);
  EXPECT_EQ(info.closed(), IsClosedKind(options.kind));
  EXPECT_EQ(info.boundary_loops, IsClosedKind(options.kind) ? 0U : 1U);
  EXPECT_GE(info.valences.begin()->first, IsClosedKind(options.kind) ? 3U : 2U);
  if (options.kind == MeshKind::kCube || options.kind == MeshKind::kGradedBox) {
    EXPECT_LE(info.vertices, options.vertices);
    if (options.vertices >= 200) {
      EXPECT_GE(10 * info.vertices, 9 * options.vertices);
    }
  } else {
    EXPECT_EQ(info.vertices, PromisedVertices(options));
  }
  // Counter-clockwise from outside.
  if (IsClosedKind(options.kind)) {
    EXPECT_GT(SignedVolume(mesh), 0);
  }
}

class GenerateTest : public testing::TestWithParam<MeshKind> {};

TEST_P(GenerateTest, EverySmallSizeIsValid) {
  const std::uint64_t least = MinGeneratedVertices(GetParam());
  for (std::uint64_t vertices = least; vertices < least + 120; ++vertices) {
    for (const std::uint64_t seed : {1, 2, 3}) ExpectSound({GetParam(), vertices, seed});
  }
}

TEST_P(GenerateTest, LargeSizesAreValid) {
  for (const std::uint64_t vertices : {1000, 11540, 60001}) {
    ExpectSound({GetParam(), vertices, 7});
  }
}

TEST_P(GenerateTest, SameOptionsGiveTheSameBits) {
  const GenerateOptions options = {GetParam(), 500, 12345678901234567U};
  EXPECT_EQ(Generate(options), Generate(options));
}

TEST_P(GenerateTest, SeedsGiveDifferentMeshes) {
  EXPECT_NE(Generate({GetParam(), 500, 1}).positions, Generate({GetParam(), 500, 2}).positions);
}

TEST_P(GenerateTest, SizesOutOfRangeAreRefused) {
  const std::uint64_t least = MinGeneratedVertices(GetParam());
  for (const std::uint64_t vertices :
       {std::uint64_t{0}, least - 1, kMaxGeneratedVertices + 1, ~std::uint64_t{0}}) {
    const absl::Status status = GenerateMesh({GetParam(), vertices, 1}).status();
    oracle::ExpectError(status, {Reason::kInvalidOption, "vertices"});
    EXPECT_NE(std::string(status.message()).find(std::to_string(least)), std::string::npos);
  }
}

TEST_P(GenerateTest, NamesLeadBackToTheKind) {
  const absl::StatusOr<MeshKind> kind = ParseMeshKind(MeshKindName(GetParam()));
  ASSERT_TRUE(kind.ok());
  EXPECT_EQ(*kind, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Kinds, GenerateTest,
                         testing::ValuesIn(AllMeshKinds().begin(), AllMeshKinds().end()),
                         [](const auto& kind) { return std::string(MeshKindName(kind.param)); });

TEST(GenerateKindsTest, UnknownNameListsTheKnownOnes) {
  const absl::Status status = ParseMeshKind("klein_bottle").status();
  oracle::ExpectError(status, {Reason::kInvalidOption, "kind"});
  for (const MeshKind kind : AllMeshKinds()) {
    EXPECT_NE(std::string(status.message()).find(std::string(MeshKindName(kind))),
              std::string::npos);
  }
}

TEST(GenerateKindsTest, DefaultIsTheIrregularSphereOfTheQuickStart) {
  const GenerateOptions options;
  EXPECT_EQ(options.kind, MeshKind::kIrregularSphere);
  EXPECT_EQ(options.vertices, 11540U);
  EXPECT_EQ(options.seed, 1U);
}

MeshInfo InfoOf(const GenerateOptions& options) { return DescribeMesh(Generate(options)); }

TEST(GenerateKindsTest, IrregularSphereHasAllAritiesAndValences) {
  const MeshInfo info = InfoOf({});
  EXPECT_EQ(info.genus, 0);
  EXPECT_EQ(info.arities.begin()->first, 3U);
  EXPECT_EQ(info.arities.rbegin()->first, 8U);
  EXPECT_EQ(info.arities.size(), 6U);
  EXPECT_EQ(info.valences.begin()->first, 3U);
  EXPECT_EQ(info.valences.rbegin()->first, 9U);
  EXPECT_EQ(info.valences.size(), 7U);
}

// Its faces face away from the origin in every triangle of their fans: nothing folds over.
TEST(GenerateKindsTest, IrregularSphereIsStarShaped) {
  for (const std::uint64_t vertices : {5, 12, 100, 11540}) {
    const PolygonMesh mesh = Generate({MeshKind::kIrregularSphere, vertices, 1});
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      const absl::Span<const Index> face = mesh.face(f);
      for (std::size_t i = 2; i < face.size(); ++i) {
        EXPECT_GT(Dot(mesh.positions[face[0]],
                      Cross(mesh.positions[face[i - 1]], mesh.positions[face[i]])),
                  0);
      }
    }
  }
}

TEST(GenerateKindsTest, TorusHasOneHandleAndMixedFaces) {
  const MeshInfo info = InfoOf({MeshKind::kTorus, 2000, 1});
  EXPECT_EQ(info.genus, 1);
  for (const std::uint64_t arity : {3, 4, 5, 6}) EXPECT_GT(info.arities.at(arity), 10U);
}

TEST(GenerateKindsTest, HighGenusHasManyHandlesOfQuads) {
  const MeshInfo info = InfoOf({MeshKind::kHighGenus, 8000, 1});
  EXPECT_EQ(info.arities.size(), 1U);
  EXPECT_EQ(info.arities.begin()->first, 4U);
  // 1000 nodes in a cube of 10: 2700 bars, of which 999 hang together without a loop.
  EXPECT_EQ(info.genus, 2700 - 999);
}

TEST(GenerateKindsTest, HubHasOneVertexOfHalfTheValence) {
  for (const std::uint64_t vertices : {10, 1000, 50001}) {
    const PolygonMesh mesh = Generate({MeshKind::kHub, vertices, 1});
    EXPECT_EQ(oracle::BuildOrDie(mesh).valence(0), vertices / 2);
    EXPECT_EQ(DescribeMesh(mesh).genus, 0);
  }
}

TEST(GenerateKindsTest, NgonsMeetInThreesAndHaveUpToTwelveSides) {
  const MeshInfo info = InfoOf({MeshKind::kNgons, 11540, 1});
  EXPECT_EQ(info.valences, (std::map<std::uint64_t, std::uint64_t>{{3, 11540}}));
  EXPECT_EQ(info.arities.begin()->first, 3U);
  EXPECT_EQ(info.arities.rbegin()->first, 12U);
  EXPECT_EQ(info.genus, 0);
}

double LongestOverShortestEdge(const PolygonMesh& mesh) {
  double shortest = 1e300;
  double longest = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const absl::Span<const Index> face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vec3& end = mesh.positions[face[(i + 1) % face.size()]];
      const double length = Norm(end - mesh.positions[face[i]]);
      shortest = std::min(shortest, length);
      longest = std::max(longest, length);
    }
  }
  return longest / shortest;
}

TEST(GenerateKindsTest, BoxesHaveUnequalEdges) {
  const std::vector<std::pair<MeshKind, double>> boxes = {{MeshKind::kCube, 3},
                                                          {MeshKind::kGradedBox, 20}};
  for (const auto& [kind, least] : boxes) {
    const PolygonMesh mesh = Generate({kind, 5000, 1});
    const MeshInfo info = DescribeMesh(mesh);
    EXPECT_EQ(info.arities.size(), 1U);
    EXPECT_EQ(info.genus, 0);
    EXPECT_GT(LongestOverShortestEdge(mesh), least);
    EXPECT_LT(LongestOverShortestEdge(mesh), 100);
  }
}

// The bits of one mesh, so that a platform that differs shows up.
TEST(GenerateKindsTest, BitsAreThoseOfEveryPlatform) {
  const PolygonMesh mesh = Generate({MeshKind::kIrregularSphere, 1000, 1});
  std::uint64_t hash = 14695981039346656037U;
  const auto add = [&hash](const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211U;
    }
  };
  add(mesh.positions.data(), mesh.positions.size() * sizeof(Vec3));
  add(mesh.face_begin.data(), mesh.face_begin.size() * sizeof(Index));
  add(mesh.corner_vertex.data(), mesh.corner_vertex.size() * sizeof(Index));
  EXPECT_EQ(hash, 5766992126213563171U) << "the generator's results have changed";
}

}  // namespace
}  // namespace limn
