// SPDX-License-Identifier: MIT
// Random meshes, sound ones that were broken and mere soups, are held against the oracle.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/engine/repair_testing.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::BoundarySides;

TEST(RepairRandom, RandomFacesBecomeAMeshThatBuildAccepts) {
  constexpr std::uint64_t kSeed = 4711;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  int split_off = 0;
  int cut = 0;
  int empty = 0;
  int folded = 0;
  for (int round = 0; round < 6000; ++round) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    const auto vertices = 3 + random() % 12;
    Faces faces;
    for (auto n = 1 + random() % 30; n > 0; --n) {
      std::vector<Index> face;
      if (!faces.empty() && random() % 6 == 0) {
        // An earlier one, backwards.
        face = faces[random() % faces.size()];
        faces.emplace_back(face.rbegin(), face.rend());
        continue;
      }
      for (auto corners = random() % 3 + (random() % 9 == 0 ? 0 : 3); corners > 0; --corners) {
        face.push_back(static_cast<Index>(random() % vertices));
      }
      faces.push_back(face);
    }
    const PolygonMesh mesh = WithFaces(vertices, faces);
    const auto repaired = Repair(Context(), mesh);
    if (!repaired.ok()) {
      EXPECT_EQ(ReasonName(GetErrorDetail(repaired.status())->reason), "EMPTY_MESH");
      ++empty;
      continue;
    }
    oracle::ExpectRepaired(mesh, *repaired);
    ExpectUntouched(repaired->mesh);
    split_off += repaired->report.faces_split_off > 0 ? 1 : 0;
    folded += repaired->report.folded_faces_removed > 0 ? 1 : 0;
    cut += repaired->report.edges_cut > 0 ? 1 : 0;
    if (HasFailure()) return;
  }
  // The hard cases are among them.
  EXPECT_GT(split_off, 20);
  EXPECT_GT(cut, 20);
  EXPECT_GT(folded, 20);
  EXPECT_GT(empty, 20);
}

// Sound meshes that were broken here and there, larger than the soups.
TEST(RepairRandom, BrokenSoundMeshesAreMended) {
  constexpr std::uint64_t kSeed = 99;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  const std::vector<std::string> names = oracle::ClosedMeshNames();
  for (int round = 0; round < 400; ++round) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    const PolygonMesh sound = oracle::ClosedMesh(names[random() % names.size()]);
    PolygonMesh broken = WithFaces(sound.vertex_count() + random() % 3, {});
    for (std::size_t f = 0; f < sound.face_count(); ++f) {
      std::vector<Index> face(sound.face(f).begin(), sound.face(f).end());
      if (random() % 10 == 0) std::reverse(face.begin(), face.end());
      if (random() % 20 == 0) face[0] = static_cast<Index>(random() % broken.vertex_count());
      if (random() % 20 == 0) face.push_back(static_cast<Index>(random() % broken.vertex_count()));
      if (random() % 20 != 0) broken.AddFace(face);
      if (random() % 20 == 0) broken.AddFace(face);
    }
    if (broken.face_count() == 0) continue;
    ExpectUntouched(Checked(broken).mesh);
    if (HasFailure()) return;
  }
}

// The boundary of any set of cubes is closed, and stays so.
TEST(RepairRandom, SolidsOfCubesStayClosed) {
  constexpr std::uint64_t kSeed = 20;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 300; ++round) {
    std::set<std::array<int, 3>> cubes;
    const int size = 2 + static_cast<int>(random() % 5);
    const auto fill = random() % 10 + 1;
    for (int x = 0; x < size; ++x) {
      for (int y = 0; y < size; ++y) {
        for (int z = 0; z < size; ++z) {
          if (random() % 11 < fill) cubes.insert({x, y, z});
        }
      }
    }
    if (cubes.empty()) continue;
    const PolygonMesh mesh = oracle::CubesSurface(cubes);
    SCOPED_TRACE(absl::StrCat("round ", round, ", ", mesh.face_count(), " faces"));
    const RepairedMesh repaired = Checked(mesh);
    EXPECT_EQ(BoundarySides(repaired.mesh), 0U) << repaired.report.faces_split_off;
    EXPECT_EQ(repaired.report.faces_reoriented, 0U);
  }
}

}  // namespace
}  // namespace limn
