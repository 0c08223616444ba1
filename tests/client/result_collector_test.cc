// SPDX-License-Identifier: MIT
// Answers that make no sense are INTERNAL, whoever puts them together.
#include "client/result_collector.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>

#include "engine/base/error.h"
#include "proto/wire/mesh_codec.h"

namespace limn {
namespace {

void ExpectInternal(const absl::Status& status) {
  EXPECT_EQ(status.code(), absl::StatusCode::kInternal) << status;
}

v1::InterpolateResponse SummaryOf(std::uint64_t vertices, std::uint64_t faces) {
  v1::InterpolateResponse message;
  message.mutable_summary()->set_surface_vertices(vertices);
  message.mutable_summary()->set_surface_faces(faces);
  return message;
}

// Three points and a triangle.
v1::InterpolateResponse Tile() {
  v1::InterpolateResponse message;
  v1::SurfaceTile& tile = *message.mutable_tile();
  tile.set_encoding(v1::MESH_ENCODING_PACKED);
  tile.set_vertex_count(3);
  tile.set_face_count(1);
  tile.set_arity(3);
  tile.set_positions(std::string(9 * sizeof(double), '\0'));
  const std::uint32_t corners[] = {0, 1, 2};
  tile.set_face_vertices(std::string(reinterpret_cast<const char*>(corners), sizeof corners));
  return message;
}

TEST(ResultCollectorTest, AWholeAnswerIsPutTogether) {
  ResultCollector collector;
  ASSERT_TRUE(collector.Add(Tile()).ok());
  ASSERT_TRUE(collector.Add(SummaryOf(3, 1)).ok());
  const auto result = collector.Finish();
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->surface.vertex_count(), 3U);
  EXPECT_EQ(result->surface.face_count(), 1U);
}

// As when a proxy's server died: the proxy ends the answer as if it were whole.
TEST(ResultCollectorTest, AnAnswerWithoutSummaryBrokeOff) {
  ResultCollector collector;
  ASSERT_TRUE(collector.Add(Tile()).ok());
  EXPECT_EQ(collector.Finish().status().code(), absl::StatusCode::kUnavailable);
}

TEST(ResultCollectorTest, ASurfaceThatIsNotTheSummarysIsRefused) {
  for (const auto& [vertices, faces] : {std::pair{4, 1}, std::pair{3, 2}}) {
    ResultCollector collector;
    ASSERT_TRUE(collector.Add(Tile()).ok());
    ASSERT_TRUE(collector.Add(SummaryOf(vertices, faces)).ok());
    ExpectInternal(collector.Finish().status());
  }
}

TEST(ResultCollectorTest, ChunksOfAControlMeshNeedAHeaderAndAnEnd) {
  v1::InterpolateResponse chunk;
  chunk.mutable_control_mesh()->mutable_chunk()->set_data("x");
  ResultCollector without_header;
  ExpectInternal(without_header.Add(chunk));

  v1::InterpolateResponse header;
  v1::MeshHeader& claims = *header.mutable_control_mesh()->mutable_header();
  claims.set_encoding(v1::MESH_ENCODING_PACKED);
  claims.set_vertex_count(4);
  claims.set_face_count(4);
  claims.set_corner_count(12);
  claims.set_byte_count(4 * 24 + 4 * 4 + 12 * 4);
  ResultCollector without_end;
  ASSERT_TRUE(without_end.Add(header).ok());
  ASSERT_TRUE(without_end.Add(SummaryOf(0, 0)).ok());
  ExpectInternal(without_end.Finish().status());
}

}  // namespace
}  // namespace limn
