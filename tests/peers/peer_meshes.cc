// SPDX-License-Identifier: MIT
#include "tests/peers/peer_meshes.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>

#include "client/io/mesh_reader.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/validate.h"
#include "tests/oracle/creased_level.h"

namespace limn::peers {
namespace {

std::filesystem::path Folder() {
  const char* folder = std::getenv("LIMN_MESHES");
  return folder == nullptr ? "" : folder;
}

// What is no manifold mesh of which the peers can be asked is for other tests to refuse.
bool Serves(const std::filesystem::path& file) {
  const auto mesh = ReadMeshFile(file);
  BoundingBox box;
  return mesh.ok() && mesh->vertex_count() <= 20'000 &&
         HalfEdgeMesh::Build(Context(), *mesh).ok() &&
         ValidatePositions(Context(), mesh->positions, &box).ok();
}

}  // namespace

std::vector<std::string> PeerMeshNames(std::vector<std::string> names) {
  std::erase_if(names,
                [](const std::string& name) { return oracle::AnyMesh(name).vertex_count() > 60; });
  if (Folder().empty()) return names;
  for (const auto& entry : std::filesystem::directory_iterator(Folder())) {
    if (Serves(entry.path())) names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool IsFromFolder(const std::string& name) { return name.find('.') != std::string::npos; }

PolygonMesh PeerMesh(const std::string& name) {
  if (!IsFromFolder(name)) return oracle::AnyMesh(name);
  return ReadMeshFile(Folder() / name).value();
}

std::string TestName(std::string name) {
  std::replace_if(
      name.begin(), name.end(),
      [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

}  // namespace limn::peers
