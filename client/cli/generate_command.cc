// SPDX-License-Identifier: MIT
// `limn generate`: makes a mesh and writes it.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
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

// "irregular_sphere from 20, torus from 9, ...".
std::string LeastVertices() {
  std::string text;
  for (const MeshKind kind : AllMeshKinds()) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", std::string(MeshKindName(kind)), " from ",
                    MinGeneratedVertices(kind));
  }
  return text;
}

// STL has triangles only.
std::string FacesText(const std::string& path, const PolygonMesh& mesh) {
  std::string text = WithCommas(mesh.face_count()) + " faces";
  const std::string ending = std::filesystem::path(path).extension().string();
  if (absl::AsciiStrToLower(ending) != ".stl") return text;
  const std::uint64_t triangles = mesh.corner_count() - 2 * mesh.face_count();
  return text + ", written as " + WithCommas(triangles) + " triangles";
}

ExitStatus Run(const GenerateFlags& flags) {
  const absl::StatusOr<MeshKind> kind = ParseMeshKind(flags.kind);
  if (!kind.ok()) return FailWithFile(kind.status());
  absl::Status status = CheckWritable(flags.output, OutputKind::kMesh);
  if (!status.ok()) return FailWithFile(status);
  const absl::StatusOr<PolygonMesh> mesh =
      GenerateMesh({.kind = *kind, .vertices = flags.vertices, .seed = flags.seed});
  if (!mesh.ok()) return FailWithFile(mesh.status());
  status = WriteMeshFile(flags.output, *mesh);
  if (!status.ok()) return FailWithFile(status);
  std::printf("%s: %s vertices, %s\n", flags.output.c_str(),
              WithCommas(mesh->vertex_count()).c_str(), FacesText(flags.output, *mesh).c_str());
  return ExitStatus::kOk;
}

}  // namespace

void AddGenerateCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand("generate", "Make a test mesh by code");
  const auto flags = std::make_shared<GenerateFlags>();
  command->add_option("KIND", flags->kind, "What to make (grid and disk are open)")
      ->required()
      ->check(CLI::IsMember(KindNames()));
  command
      ->add_option("--vertices", flags->vertices,
                   "Number of vertices, or a few less: " + LeastVertices())
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
