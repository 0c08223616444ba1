// SPDX-License-Identifier: MIT
#include "tests/fuzz/targets.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/repair.h"
#include "proto/wire/draco_header.h"
#include "proto/wire/mesh_codec.h"
#include "server/job_cost.h"
#include "server/job_memory.h"
#include "server/options_from_proto.h"

namespace limn::fuzz {
namespace {

// Small, so that a run is quick; above them is above any limit.
Limits SmallLimits() {
  return {.max_vertices = 1 << 12, .max_corners = 1 << 14, .max_level = 3, .max_bytes = 64 << 20};
}

void Demand(bool promise) {
  if (!promise) std::abort();
}

// Takes numbers off the front; zeros when there are no more bytes.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  T Take() {
    T value{};
    const std::size_t size = std::min(sizeof value, rest_.size());
    std::memcpy(&value, rest_.data(), size);
    rest_.remove_prefix(size);
    return value;
  }
  std::string_view rest() const { return rest_; }
  bool empty() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

template <class T>
void Put(T value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::vector<PolygonMesh> Meshes() {
  std::vector<PolygonMesh> meshes;
  for (const MeshKind kind :
       {MeshKind::kCube, MeshKind::kTorus, MeshKind::kIrregularSphere, MeshKind::kGrid}) {
    absl::StatusOr<PolygonMesh> mesh = GenerateMesh({.kind = kind, .vertices = 24, .seed = 3});
    if (mesh.ok()) meshes.push_back(*std::move(mesh));
  }
  return meshes;
}

// 1e8 triangles in 66 bytes, by edgebreaker and by the sequential coder.
std::vector<std::string> DracoBombs() {
  const std::string many = "\x80\xc2\xd7\x2f";  // 100,000,000 as a varint
  std::string edgebreaker("DRACO\x02\x02\x01\x01\0\0\0", 12);
  edgebreaker += many + many + '\1' + many + '\0';
  std::string sequential("DRACO\x02\x02\x01\0\0\0", 11);
  sequential += many + many;
  std::string deep("DRACO\x02\x02\x01\0\0\x80\0", 12);
  for (int i = 0; i < 300; ++i) deep += std::string("\0\1\0", 3);
  std::vector<std::string> bombs = {edgebreaker, sequential, deep};
  for (std::string& bomb : bombs) bomb.resize(std::max<std::size_t>(66, bomb.size()), '\0');
  return bombs;
}

std::vector<std::string> DracoSeeds() {
  std::vector<std::string> seeds = DracoBombs();
  for (const PolygonMesh& mesh : Meshes()) {
    for (const v1::MeshEncoding encoding :
         {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
      absl::StatusOr<wire::EncodedMesh> encoded =
          wire::EncodeMesh(Context(), mesh, {.encoding = encoding});
      if (encoded.ok()) seeds.push_back(encoded->bytes);
    }
  }
  return seeds;
}

bool RunDracoHeader(std::string_view bytes) {
  const absl::StatusOr<wire::DracoHeader> header = wire::ReadDracoHeader(bytes);
  if (!header.ok()) return false;
  // What is let through is justified by the bytes.
  Demand(header->triangles <= 2 * 8 * bytes.size());
  (void)wire::DracoDecodeBytes(*header);
  return true;
}

// Layout: encoding, flags, three counts of 16 bits, the mesh.
bool RunMeshCodec(std::string_view input) {
  Bytes bytes(input);
  v1::MeshHeader header;
  header.set_encoding(static_cast<v1::MeshEncoding>(1 + bytes.Take<std::uint8_t>() % 3));
  const bool any_arity = (bytes.Take<std::uint8_t>() & 1) != 0;
  header.set_vertex_count(bytes.Take<std::uint16_t>());
  header.set_face_count(bytes.Take<std::uint16_t>());
  header.set_corner_count(bytes.Take<std::uint16_t>());
  header.set_byte_count(bytes.rest().size());
  const Context context(SmallLimits());
  const absl::StatusOr<PolygonMesh> mesh =
      wire::DecodeMesh(context, header, bytes.rest(), {.any_arity = any_arity});
  if (!mesh.ok()) return false;
  Demand(mesh->vertex_count() <= SmallLimits().max_vertices);
  Demand(std::all_of(mesh->corner_vertex.begin(), mesh->corner_vertex.end(),
                     [&](Index v) { return v < mesh->vertex_count(); }));
  // What was decoded is encoded and decoded to the same.
  const absl::StatusOr<wire::EncodedMesh> again =
      wire::EncodeMesh(context, *mesh, {.any_arity = any_arity});
  if (!again.ok()) return true;
  const absl::StatusOr<PolygonMesh> same =
      wire::DecodeMesh(context, again->header, again->bytes, {.any_arity = any_arity});
  Demand(same.ok() && same->corner_vertex == mesh->corner_vertex);
  return true;
}

std::vector<std::string> MeshCodecSeeds() {
  std::vector<std::string> seeds;
  const auto add = [&](std::uint8_t encoding, const v1::MeshHeader& header,
                       const std::string& mesh) {
    std::string seed;
    Put<std::uint8_t>(encoding, &seed);
    Put<std::uint8_t>(0, &seed);
    Put(static_cast<std::uint16_t>(header.vertex_count()), &seed);
    Put(static_cast<std::uint16_t>(header.face_count()), &seed);
    Put(static_cast<std::uint16_t>(header.corner_count()), &seed);
    seeds.push_back(seed + mesh);
  };
  for (const PolygonMesh& mesh : Meshes()) {
    for (std::uint8_t encoding = 0; encoding < 3; ++encoding) {
      const absl::StatusOr<wire::EncodedMesh> encoded = wire::EncodeMesh(
          Context(), mesh, {.encoding = static_cast<v1::MeshEncoding>(1 + encoding)});
      if (encoded.ok()) add(encoding, encoded->header, encoded->bytes);
    }
  }
  for (const std::string& bomb : DracoBombs()) add(1, v1::MeshHeader(), bomb);
  return seeds;
}

// A header as it comes from a client, and the job that it describes, on a small mesh.
bool RunConstraints(std::string_view bytes) {
  v1::InterpolateHeader header;
  if (!header.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return false;
  static const PolygonMesh* const kMesh = new PolygonMesh(Meshes()[2]);
  v1::MeshHeader& claims = *header.mutable_mesh();
  claims.set_vertex_count(kMesh->vertex_count());
  claims.set_face_count(kMesh->face_count());
  claims.set_corner_count(kMesh->corner_count());
  absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  if (!spec.ok()) return false;
  (void)EstimateMilliseconds(*spec);
  FitFinestLevel(SmallLimits(), &*spec);
  spec->engine.level = std::min(spec->engine.level, 2U);
  spec->engine.finest = std::min(spec->engine.finest, 2U);
  spec->engine.solve.max_sweeps = std::min(spec->engine.solve.max_sweeps, 30U);
  const absl::StatusOr<InterpolateResult> result =
      Interpolate(Context(SmallLimits()), *kMesh, spec->engine);
  if (result.ok()) Demand(result->control_positions.size() == kMesh->vertex_count());
  return result.ok();
}

std::vector<std::string> ConstraintSeeds() {
  std::vector<v1::InterpolateHeader> headers(4);
  for (v1::InterpolateHeader& header : headers) {
    header.set_scheme(v1::SCHEME_DOO_SABIN);
    header.mutable_surface()->set_level(1);
    header.mutable_output()->set_surface(true);
  }
  v1::Constraints& constraints = *headers[1].mutable_constraints();
  for (const std::uint32_t v : {0U, 5U, 7U}) constraints.mutable_interpolate()->add_vertices(v);
  v1::NormalConstraint& normal = *constraints.add_normals();
  normal.set_vertex(5);
  normal.mutable_normal()->set_z(1);
  v1::ShapeHandle& handle = *constraints.add_shape_handles();
  handle.set_vertex(3);
  handle.set_value(0.5);
  headers[2].set_scheme(v1::SCHEME_CATMULL_CLARK);
  v1::Crease& crease = *headers[2].mutable_constraints()->add_creases();
  const PolygonMesh mesh = Meshes()[2];
  for (const Index v : mesh.face(0).subspan(0, 3)) crease.add_vertices(v);
  crease.add_sharpness(10);
  headers[2].mutable_constraints()->add_holes(1);
  v1::FeatureValues& features = *headers[3].mutable_constraints()->mutable_features();
  features.set_default_edge(0.3);
  v1::FeatureValues::Face& face = *features.add_faces();
  face.set_kind(v1::FeatureValues::FACE_KIND_PLANE);
  std::vector<std::string> seeds;
  for (const v1::InterpolateHeader& header : headers) seeds.push_back(header.SerializeAsString());
  return seeds;
}

// Layout: scheme and level, number of vertices, their coordinates, then faces: an arity and that
// many vertices of 8 bits, 255 standing for an index far out of range.
bool RunEngineBuild(std::string_view input) {
  Bytes bytes(input);
  const auto choice = bytes.Take<std::uint8_t>();
  PolygonMesh mesh;
  mesh.positions.resize(bytes.Take<std::uint8_t>() % 64);
  for (Vec3& p : mesh.positions) {
    p = {bytes.Take<double>(), bytes.Take<double>(), bytes.Take<double>()};
  }
  std::vector<Index> face;
  while (!bytes.empty() && mesh.corner_count() < 512) {
    face.resize(bytes.Take<std::uint8_t>() % 16);
    for (Index& v : face) {
      const auto index = bytes.Take<std::uint8_t>();
      v = index == 255 ? ~Index{0} - 1 : index;
    }
    mesh.AddFace(face);
  }
  const Context context(SmallLimits());
  (void)HalfEdgeMesh::Build(context, mesh);
  InterpolateOptions options;
  options.scheme = static_cast<Scheme>(choice % 3);
  options.level = (choice / 3) % 3;
  options.solve.max_sweeps = 30;
  const absl::StatusOr<InterpolateResult> result = Interpolate(context, mesh, options);
  const absl::StatusOr<RepairedMesh> repaired = Repair(context, mesh);
  if (!repaired.ok()) return false;
  // What repair makes is built without complaint, but for coordinates.
  const absl::Status built = HalfEdgeMesh::Build(context, repaired->mesh).status();
  Demand(built.ok() || built.code() == absl::StatusCode::kInvalidArgument);
  (void)Interpolate(context, repaired->mesh, options);
  return result.ok();
}

std::vector<std::string> EngineBuildSeeds() {
  std::vector<std::string> seeds;
  std::uint8_t choice = 0;
  for (const PolygonMesh& mesh : Meshes()) {
    for (int variant = 0; variant < 4; ++variant) {
      std::string seed;
      Put<std::uint8_t>(choice++, &seed);
      Put(static_cast<std::uint8_t>(mesh.vertex_count()), &seed);
      for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
        const double odd[] = {mesh.positions[v].x, 1e308, 4.9e-324, 0.0 / 0.0 * 0};
        Put(v == 3 ? odd[variant] : mesh.positions[v].x, &seed);
        Put(mesh.positions[v].y, &seed);
        Put(mesh.positions[v].z, &seed);
      }
      for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        Put(static_cast<std::uint8_t>(mesh.arity(f)), &seed);
        for (const Index v : mesh.face(f)) Put(static_cast<std::uint8_t>(v), &seed);
      }
      seeds.push_back(seed);
    }
  }
  return seeds;
}

}  // namespace

const std::vector<Target>& Targets() {
  static const auto* const kTargets =
      new std::vector<Target>{{"draco_header", RunDracoHeader, DracoSeeds},
                              {"mesh_codec", RunMeshCodec, MeshCodecSeeds},
                              {"constraints", RunConstraints, ConstraintSeeds},
                              {"engine_build", RunEngineBuild, EngineBuildSeeds}};
  return *kTargets;
}

const Target* FindTarget(std::string_view name) {
  for (const Target& target : Targets()) {
    if (target.name == name) return &target;
  }
  return nullptr;
}

}  // namespace limn::fuzz
