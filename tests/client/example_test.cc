// SPDX-License-Identifier: MIT
// The README's example, compiled and run.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

// [README]
#include <iostream>
#include <string>

#include "client/client.h"
#include "client/io/mesh_reader.h"
#include "client/io/mesh_writer.h"

// Has a server find the smooth surface through the vertices of a mesh file.
absl::Status Smooth(const std::string& in, const std::string& out, const std::string& address) {
  const absl::StatusOr<limn::PolygonMesh> mesh = limn::ReadMeshFile(in);
  if (!mesh.ok()) return mesh.status();

  limn::v1::InterpolateHeader header;  // what is not set has a default
  header.mutable_surface()->set_level(2);
  header.mutable_output()->set_surface(true);
  header.mutable_output()->set_normals(true);

  const limn::Client client = limn::Client::Connect(address);  // such as "127.0.0.1:7410"
  const auto on_progress = [](const limn::v1::Progress& progress) {
    std::cout << progress.stage() << " " << progress.fraction() << "\n";
    return true;  // false cancels the job, on the server too
  };
  const absl::StatusOr<limn::JobResult> result = client.Run(header, *mesh, on_progress);
  if (!result.ok()) return result.status();
  std::cout << "largest error: " << result->summary.certificate().max_error() << "\n";
  return limn::WriteSurfaceFile(out, result->surface);
}
// [README]

#include "engine/mesh/generate.h"
#include "server/server.h"

namespace limn {
namespace {

TEST(ExampleTest, TheExampleOfTheReadmeWorks) {
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  const auto server = Server::Start(options);
  ASSERT_TRUE(server.ok()) << server.status();
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("limn-example-" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  const std::string in = folder / "in.obj";
  const std::string out = folder / "out.obj";
  const auto mesh = GenerateMesh({.kind = MeshKind::kTorus, .vertices = 200});
  ASSERT_TRUE(mesh.ok() && WriteMeshFile(in, *mesh).ok());

  const absl::Status status = Smooth(in, out, "127.0.0.1:" + std::to_string((*server)->port()));
  EXPECT_TRUE(status.ok()) << status;
  const auto surface = ReadMeshFile(out);
  ASSERT_TRUE(surface.ok()) << surface.status();
  ASSERT_GT(surface->vertex_count(), mesh->vertex_count());
  for (std::size_t v = 0; v < mesh->vertex_count(); ++v) {
    EXPECT_LE(Norm(surface->positions[v] - mesh->positions[v]), 1e-14) << "vertex " << v;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace limn
