// SPDX-License-Identifier: MIT
// Names and limits of the kinds of generated meshes; the kinds themselves are in generate_rings.cc
// and generate_grids.cc.
#include "engine/mesh/generate.h"

#include <array>
#include <new>
#include <stdexcept>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "engine/base/error.h"
#include "engine/mesh/generate_random.h"
#include "engine/mesh/generate_shapes.h"

namespace limn {
namespace {

using MakeFunction = PolygonMesh (*)(std::uint64_t vertices, generate::Random* random);

struct KindEntry {
  MeshKind kind;
  std::string_view name;
  bool closed;
  std::uint64_t min_vertices;
  MakeFunction make;
};

constexpr std::array kKinds = {
    KindEntry{MeshKind::kIrregularSphere, "irregular_sphere", true, 5, generate::IrregularSphere},
    KindEntry{MeshKind::kTorus, "torus", true, 9, generate::Torus},
    KindEntry{MeshKind::kHighGenus, "high_genus", true, 32, generate::HighGenus},
    KindEntry{MeshKind::kHub, "hub", true, 8, generate::Hub},
    KindEntry{MeshKind::kNgons, "ngons", true, 6, generate::Ngons},
    KindEntry{MeshKind::kCube, "cube", true, 8, generate::Cube},
    KindEntry{MeshKind::kGrid, "grid", false, 4, generate::Grid},
    KindEntry{MeshKind::kDisk, "disk", false, 4, generate::Disk},
    KindEntry{MeshKind::kGradedBox, "graded_box", true, 8, generate::GradedBox},
};

const KindEntry* FindKind(MeshKind kind) {
  for (const KindEntry& entry : kKinds) {
    if (entry.kind == kind) return &entry;
  }
  return nullptr;
}

std::string KnownKinds() {
  return absl::StrCat("Known kinds are ",
                      absl::StrJoin(kKinds, ", ", [](std::string* out, const KindEntry& entry) {
                        out->append(entry.name);
                      }));
}

absl::Status OutOfMemory(std::uint64_t vertices) {
  return MakeError(
      absl::StrCat("no memory to generate ", vertices, " vertices"),
      {.reason = Reason::kOutOfMemory, .field = "vertices", .remedy = "Ask for fewer vertices"});
}

}  // namespace

absl::Span<const MeshKind> AllMeshKinds() {
  static constexpr auto kAll = [] {
    std::array<MeshKind, kKinds.size()> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = kKinds[i].kind;
    return all;
  }();
  return kAll;
}

std::string_view MeshKindName(MeshKind kind) {
  const KindEntry* entry = FindKind(kind);
  return entry == nullptr ? "unknown" : entry->name;
}

absl::StatusOr<MeshKind> ParseMeshKind(std::string_view name) {
  for (const KindEntry& entry : kKinds) {
    if (entry.name == name) return entry.kind;
  }
  return MakeError(absl::StrCat("there is no kind of mesh named \"", std::string(name), "\""),
                   {.reason = Reason::kInvalidOption, .field = "kind", .remedy = KnownKinds()});
}

bool IsClosedKind(MeshKind kind) {
  const KindEntry* entry = FindKind(kind);
  return entry != nullptr && entry->closed;
}

std::uint64_t MinGeneratedVertices(MeshKind kind) {
  const KindEntry* entry = FindKind(kind);
  return entry == nullptr ? 0 : entry->min_vertices;
}

absl::StatusOr<PolygonMesh> GenerateMesh(const GenerateOptions& options) {
  const KindEntry* entry = FindKind(options.kind);
  if (entry == nullptr) {
    return MakeError(absl::StrCat("kind ", static_cast<int>(options.kind), " does not exist"),
                     {.reason = Reason::kInvalidOption, .field = "kind", .remedy = KnownKinds()});
  }
  if (options.vertices < entry->min_vertices || options.vertices > kMaxGeneratedVertices) {
    return MakeError(
        absl::StrCat("a mesh of kind ", std::string(entry->name), " cannot have ", options.vertices,
                     " vertices"),
        {.reason = Reason::kInvalidOption,
         .field = "vertices",
         .remedy = absl::StrCat("Ask for ", entry->min_vertices, " to ", kMaxGeneratedVertices)});
  }
  try {
    generate::Random random(options.seed);
    return entry->make(options.vertices, &random);
  } catch (const std::bad_alloc&) {
    return OutOfMemory(options.vertices);
  } catch (const std::length_error&) {
    return OutOfMemory(options.vertices);
  }
}

}  // namespace limn
