// SPDX-License-Identifier: MIT
#include "tests/experiments/experiment.h"

#include <cstdlib>
#include <fstream>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "engine/mesh/validate.h"

namespace limn::experiments {

void Die(const absl::Status& status) {
  std::cerr << "experiment: " << status.message() << "\n";
  std::exit(1);
}

Model MakeModel(const Setup& setup, MeshKind kind, std::uint64_t vertices) {
  PolygonMesh given = OrDie(GenerateMesh({.kind = kind, .vertices = vertices, .seed = 1}));
  BoundingBox box;
  OrDie(ValidatePositions(setup.context, given.positions, &box));
  HalfEdgeMesh mesh = OrDie(HalfEdgeMesh::Build(setup.context, given));
  std::string name =
      absl::StrCat(std::string(MeshKindName(kind)), " ", Count(given.vertex_count()));
  return {.name = std::move(name),
          .given = std::move(given),
          .mesh = std::move(mesh),
          .scale = box.diagonal()};
}

void WriteText(const Setup& setup, const std::string& name, const std::string& text) {
  const std::string path = setup.out + "/" + name;
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) Die(absl::UnknownError(absl::StrCat(path, " could not be written")));
}

}  // namespace limn::experiments
