// SPDX-License-Identifier: MIT
// `limn generate`: makes a mesh and writes it.
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/commands.h"
#include "client/cli/report.h"
#include "client/io/mesh_writer.h"
#include "engine/mesh/generate.h"

namespace limn::cli {
namespace {

struct GenerateFlags {
  std::string kind;
  std::uint64_t vertices = 0;
  std::uint64_t seed = 1;
  std::string output;
};

std::vector<std::string> KindNames() {
  std::vector<std::string> names;
  for (const MeshKind kind : AllMeshKinds()) names.emplace_back(MeshKindName(kind));
  return names;
}

ExitStatus Run(const GenerateFlags& flags) {
  const absl::StatusOr<MeshKind> kind = ParseMeshKind(flags.kind);
  if (!kind.ok()) return FailWithOption(kind.status());
  absl::Status status = CheckWritable(flags.output, OutputKind::kMesh);
  if (!status.ok()) return FailWithOption(status);
  const absl::StatusOr<PolygonMesh> mesh =
      GenerateMesh({.kind = *kind, .vertices = flags.vertices, .seed = flags.seed});
  if (!mesh.ok()) return FailWithOption(mesh.status());
  status = WriteMeshFile(flags.output, *mesh);
  if (!status.ok()) return FailWithFile(status);
  std::printf("%s: %s vertices, %s faces\n", flags.output.c_str(),
              WithCommas(mesh->vertex_count()).c_str(), WithCommas(mesh->face_count()).c_str());
  return ExitStatus::kOk;
}

}  // namespace

void AddGenerateCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand("generate", "Make a test mesh by code");
  const auto flags = std::make_shared<GenerateFlags>();
  command->add_option("KIND", flags->kind, "What to make (grid and disk are open)")
      ->required()
      ->check(CLI::IsMember(KindNames()));
  command->add_option("--vertices", flags->vertices, "Number of vertices, or a few less")
      ->required()
      ->check(CLI::Range(std::uint64_t{1}, kMaxGeneratedVertices))
      ->type_name("N");
  command->add_option("--seed", flags->seed, "Another seed gives another mesh of the kind")
      ->capture_default_str()
      ->type_name("S");
  command->add_option("-o,--output", flags->output, "Where to: .obj, .off, .ply or .stl")
      ->required()
      ->type_name("FILE");
  command->callback([flags, status] { *status = Run(*flags); });
}

}  // namespace limn::cli
