// SPDX-License-Identifier: MIT
// How answers are made: none waits behind another job, and they say what the mesh was.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/mesh/generate.h"
#include "server/job.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

PolygonMesh MakeTorus(std::uint64_t vertices) {
  absl::StatusOr<PolygonMesh> mesh =
      GenerateMesh({.kind = MeshKind::kTorus, .vertices = vertices, .seed = 1});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

// Asks for a control mesh that takes Draco long.
v1::InterpolateHeader MakeSlowToEncodeHeader() {
  v1::InterpolateHeader header;
  header.mutable_output()->set_control_mesh(true);
  header.mutable_output()->set_encoding(v1::MESH_ENCODING_DRACO_QUANTIZED);
  return header;
}

TEST(DeliveryTest, AnAnswerDoesNotWaitForTheEncodingOfAnothersMesh) {
  ServerOptions options{.threads = 1};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  const std::unique_ptr<Server> server = StartServer(options);

  v1::InterpolateHeader header = MakeHeader(2);
  header.mutable_output()->set_tile_bytes(64 << 10);
  RawCall reader(server->InProcessChannel());
  ASSERT_TRUE(reader.Write(MakeUpload(header, MakeSphere(2000))));
  for (bool tile = false; !tile;) {
    const std::optional<v1::InterpolateResponse> message = reader.Read();
    ASSERT_TRUE(message.has_value()) << reader.Finish();
    tile = message->has_tile();
  }

  std::atomic<bool> encoding = false;
  std::atomic<bool> encoded = false;
  RawCall other(server->InProcessChannel());
  ASSERT_TRUE(other.Write(MakeUpload(MakeSlowToEncodeHeader(), MakeTorus(800'000))));
  std::thread other_reader([&] {
    while (const std::optional<v1::InterpolateResponse> message = other.Read()) {
      if (message->progress().stage() == "encode") encoding = true;
      if (message->has_control_mesh()) encoded = true;
    }
    encoded = true;
  });
  while (!encoding && !encoded) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  int tiles = 0;
  while (const std::optional<v1::InterpolateResponse> message = reader.Read()) {
    tiles += message->has_tile() ? 1 : 0;
  }
  const bool still_encoding = !encoded;
  EXPECT_TRUE(reader.Finish().ok()) << reader.Finish();
  EXPECT_GT(tiles, 10);
  EXPECT_TRUE(still_encoding);
  other.Cancel();
  other_reader.join();
}

// Runs a job until its answer can be asked for.
void ComputeJob(Job* job, const std::vector<v1::InterpolateRequest>& upload) {
  std::string encoded;
  for (std::size_t i = 1; i < upload.size(); ++i) encoded += upload[i].chunk().data();
  ASSERT_TRUE(job->Decode(std::move(encoded)).ok());
  ASSERT_TRUE(job->Run().ok());
}

TEST(DeliveryTest, ThePiecesOfAnAnswerAreBounded) {
  for (const v1::MeshEncoding encoding :
       {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    v1::InterpolateHeader header = MakeHeader(2);
    header.mutable_output()->set_encoding(encoding);
    header.mutable_output()->set_tile_bytes(16 << 10);
    const std::vector<v1::InterpolateRequest> upload = MakeUpload(header, MakeSphere(5000));
    std::vector<std::string> stages;
    Context context;
    context.set_progress([&](const ProgressEvent& event) { stages.emplace_back(event.stage); });
    Job job(*JobSpecFromProto(upload.front().header()), context);
    ComputeJob(&job, upload);
    // The whole mesh is encoded where the job is computed, and that is shown.
    ASSERT_FALSE(stages.empty());
    EXPECT_EQ(stages.back(), "encode");
    const std::size_t events = stages.size();
    for (bool more = true; more;) {
      v1::InterpolateResponse message;
      const absl::StatusOr<bool> next = job.NextMessage(&message);
      ASSERT_TRUE(next.ok()) << next.status();
      more = *next;
      EXPECT_LE(message.ByteSizeLong(), (16U << 10) + 1024);
    }
    EXPECT_EQ(stages.size(), events);
  }
}

TEST(DeliveryTest, ASummaryKnowsTheCountsThatNobodyClaimed) {
  const PolygonMesh mesh = MakeSphere(500);
  for (const v1::MeshEncoding encoding :
       {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    const EventLog events;
    const std::unique_ptr<Server> server = StartServer({.threads = 1, .log = events.log()});
    v1::InterpolateHeader header = MakeHeader(1);
    header.mutable_mesh()->set_encoding(encoding);
    std::vector<v1::InterpolateRequest> upload = MakeUpload(header, mesh);
    v1::MeshHeader& claims = *upload.front().mutable_header()->mutable_mesh();
    claims.set_vertex_count(0);
    claims.set_face_count(0);
    claims.set_corner_count(0);
    RawCall call(server->InProcessChannel());
    ASSERT_TRUE(call.Write(upload));
    v1::Summary summary;
    while (const std::optional<v1::InterpolateResponse> message = call.Read()) {
      if (message->has_summary()) summary = message->summary();
    }
    EXPECT_TRUE(call.Finish().ok()) << call.Finish();
    EXPECT_EQ(summary.input_vertices(), mesh.vertex_count());
    EXPECT_EQ(summary.input_faces(), mesh.face_count());
    const std::string line = events.WaitFor("event=job");
    EXPECT_NE(line.find(absl::StrCat(" vertices=", mesh.vertex_count(),
                                     " faces=", mesh.face_count(), " ")),
              std::string::npos)
        << line;
  }
}

}  // namespace
}  // namespace limn
