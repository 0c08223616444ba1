// SPDX-License-Identifier: MIT
// What a job allocates stays below what admission sets aside for it.
#include "server/job_memory.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "engine/mesh/generate.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/mesh_memory.h"
#include "server/admission.h"
#include "server/job.h"
#include "tests/engine/allocation_meter.h"
#include "tests/oracle/slowdown.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

constexpr v1::MeshEncoding kEncodings[] = {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO,
                                           v1::MESH_ENCODING_DRACO_QUANTIZED};

PolygonMesh Generate(MeshKind kind, std::uint64_t vertices) {
  absl::StatusOr<PolygonMesh> mesh = GenerateMesh({.kind = kind, .vertices = vertices, .seed = 1});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

// Triangles without a neighbour: three vertices, edges and boundary edges for each face.
PolygonMesh LoneTriangles(std::uint64_t count) {
  PolygonMesh mesh;
  mesh.face_begin.push_back(0);
  for (std::uint64_t f = 0; f < count; ++f) {
    for (int i = 0; i < 3; ++i) {
      mesh.corner_vertex.push_back(static_cast<Index>(mesh.positions.size()));
      mesh.positions.push_back({static_cast<double>(f), i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0});
    }
    mesh.face_begin.push_back(static_cast<Index>(mesh.corner_vertex.size()));
  }
  return mesh;
}

struct Shape {
  std::string name;
  PolygonMesh mesh;
};

std::vector<Shape> Shapes() {
  std::vector<Shape> shapes;
  for (const std::uint64_t vertices : {200, 6000 / oracle::kSlowdown}) {
    shapes.push_back({"sphere", Generate(MeshKind::kIrregularSphere, vertices)});
    shapes.push_back({"torus", Generate(MeshKind::kTorus, vertices)});
    shapes.push_back({"high genus", Generate(MeshKind::kHighGenus, vertices)});
    shapes.push_back({"hub", Generate(MeshKind::kHub, vertices)});
    shapes.push_back({"ngons", Generate(MeshKind::kNgons, vertices)});
    shapes.push_back({"grid", Generate(MeshKind::kGrid, vertices)});
    shapes.push_back({"disk", Generate(MeshKind::kDisk, vertices)});
    shapes.push_back({"triangles", LoneTriangles(vertices / 3)});
  }
  for (Shape& shape : shapes) {
    shape.name += " of " + std::to_string(shape.mesh.vertex_count());
  }
  return shapes;
}

// Runs a job as the server does, and says what it held at the most.
std::uint64_t PeakOf(const JobSpec& spec, const std::string& encoded) {
  const AllocationMeter meter;
  wire::ChunkAssembler upload(encoded.size());
  {
    wire::ChunkReader chunks(encoded, 100'000);
    v1::MeshChunk chunk;
    while (chunks.Next(&chunk)) EXPECT_TRUE(upload.Add(chunk).ok());
  }
  Job job(spec, Context{});
  absl::Status status = job.Decode(upload.TakeBytes());
  EXPECT_TRUE(status.ok()) << status;
  status = job.Run();
  EXPECT_TRUE(status.ok()) << status;
  for (bool more = true; more;) {
    v1::InterpolateResponse message;
    const absl::StatusOr<bool> next = job.NextMessage(&message);
    EXPECT_TRUE(next.ok()) << next.status();
    more = next.ok() && *next;
  }
  return meter.peak();
}

// Of what is estimated for a job of some size, the job uses at least this part: an estimate of
// everything would be an upper bound too.
constexpr double kUsedPart = 0.25;
constexpr std::uint64_t kSomeSize = 5 << 20;

// Without what may be long.
std::string Described(v1::InterpolateHeader header) {
  header.clear_constraints();
  return header.ShortDebugString();
}

void ExpectBelowEstimate(const Shape& shape, const v1::InterpolateHeader& header,
                         v1::MeshEncoding upload) {
  SCOPED_TRACE(shape.name + ", sent as " + v1::MeshEncoding_Name(upload) + ", " +
               Described(header));
  const auto encoded = wire::EncodeMesh(Context{}, shape.mesh, {.encoding = upload});
  ASSERT_TRUE(encoded.ok()) << encoded.status();
  v1::InterpolateHeader claimed = header;
  *claimed.mutable_mesh() = encoded->header;
  absl::StatusOr<JobSpec> spec = JobSpecFromProto(claimed);
  ASSERT_TRUE(spec.ok()) << spec.status();
  // A level may be chosen that needs less than is set aside, but not much less here.
  FitFinestLevel({.max_bytes = std::uint64_t{16} << 20}, &*spec);
  const std::uint64_t peak = PeakOf(*spec, encoded->bytes);
  EXPECT_LE(peak, EstimateJobBytes(*spec));
  // Repair is reckoned with at its worst.
  if (peak < kSomeSize || spec->repair) return;
  EXPECT_GE(static_cast<double>(peak), kUsedPart * static_cast<double>(EstimateJobBytes(*spec)));
}

class JobMemoryTest : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(JobMemoryTest, WhatAJobAllocatesIsBelowItsEstimate) {
  const v1::MeshEncoding upload = kEncodings[std::get<0>(GetParam())];
  const v1::MeshEncoding answer = kEncodings[std::get<1>(GetParam())];
  for (const Shape& shape : Shapes()) {
    for (const std::uint32_t level : {0U, 1U, 2U}) {
      for (const bool control_mesh : {false, true}) {
        for (const bool surface : {false, true}) {
          v1::InterpolateHeader header = MakeHeader(level);
          header.mutable_output()->set_encoding(answer);
          header.mutable_output()->set_control_mesh(control_mesh);
          header.mutable_output()->set_surface(surface);
          // Decoding does not depend on the level, and the level not on what is not sent.
          if (level > 0 && (!surface || upload != v1::MESH_ENCODING_PACKED)) continue;
          ExpectBelowEstimate(shape, header, upload);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Encodings, JobMemoryTest,
                         testing::Combine(testing::Range(0, 3), testing::Range(0, 3)));

PolygonMesh Triangulated(const PolygonMesh& mesh) {
  PolygonMesh triangles;
  triangles.positions = mesh.positions;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      triangles.AddFace({face[0], face[i], face[i + 1]});
    }
  }
  return triangles;
}

// What is asked of the surface, by name.
struct Wish {
  std::string name;
  std::function<void(const PolygonMesh&, v1::InterpolateHeader*)> make;
};

// The same crease along the first face, again and again.
void AddCreases(const PolygonMesh& mesh, v1::InterpolateHeader* header) {
  for (int i = 0; i < 20'000; ++i) {
    v1::Crease* crease = header->mutable_constraints()->add_creases();
    for (const Index v : mesh.face(0)) crease->add_vertices(v);
    crease->add_sharpness(2.5F);
  }
}

void AddNormals(const PolygonMesh& mesh, v1::InterpolateHeader* header) {
  for (std::size_t v = 0; v < mesh.vertex_count(); v += 3) {
    v1::NormalConstraint* wish = header->mutable_constraints()->add_normals();
    wish->set_vertex(static_cast<std::uint32_t>(v));
    wish->mutable_normal()->set_z(1);
  }
}

void AddSubset(const PolygonMesh& mesh, v1::InterpolateHeader* header) {
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    header->mutable_constraints()->mutable_interpolate()->add_vertices(
        static_cast<std::uint32_t>(v));
  }
}

void AddCorners(const PolygonMesh& mesh, v1::InterpolateHeader* header) {
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    v1::SharpVertex* corner = header->mutable_constraints()->add_corners();
    corner->set_vertex(static_cast<std::uint32_t>(v));
    corner->set_sharpness(3);
  }
}

TEST(JobEstimateTest, OtherSchemesAndTheirConstraintsAreCounted) {
  const Wish wishes[] = {
      {"nothing", [](const auto&, auto*) {}},
      {"creases", AddCreases},
      {"corners", AddCorners},
      {"subset", AddSubset},
      {"repair", [](const auto&, auto* header) { header->mutable_output()->set_repair(true); }},
      {"repair of constraints",
       [](const auto& mesh, auto* header) {
         header->mutable_output()->set_repair(true);
         AddSubset(mesh, header);
         AddCorners(mesh, header);
         AddCreases(mesh, header);
       }},
      {"gains", [](const auto&, auto* header) { header->mutable_filter()->add_gains(0.5); }},
  };
  for (const Shape& shape : Shapes()) {
    for (const v1::Scheme scheme : {v1::SCHEME_CATMULL_CLARK, v1::SCHEME_LOOP}) {
      const Shape used = {shape.name,
                          scheme == v1::SCHEME_LOOP ? Triangulated(shape.mesh) : shape.mesh};
      for (const Wish& wish : wishes) {
        SCOPED_TRACE(wish.name);
        for (const std::uint32_t level : {0U, 1U, 2U}) {
          v1::InterpolateHeader header = MakeHeader(level);
          header.set_scheme(scheme);
          wish.make(used.mesh, &header);
          ExpectBelowEstimate(used, header, v1::MESH_ENCODING_PACKED);
        }
      }
    }
  }
}

TEST(JobEstimateTest, ConstraintsOfDooSabinAreCounted) {
  const Wish wishes[] = {
      {"normals", AddNormals},
      {"subset", AddSubset},
      {"repair of constraints",
       [](const auto& mesh, auto* header) {
         header->mutable_output()->set_repair(true);
         AddSubset(mesh, header);
         AddNormals(mesh, header);
       }},
      {"features",
       [](const auto& mesh, auto* header) {
         for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
           auto* vertex = header->mutable_constraints()->mutable_features()->add_vertices();
           vertex->set_vertex(static_cast<std::uint32_t>(v));
           vertex->set_value(0.5);
         }
       }},
  };
  for (const MeshKind kind : {MeshKind::kIrregularSphere, MeshKind::kTorus, MeshKind::kHub}) {
    const Shape shape = {"sphere", Generate(kind, 6000 / oracle::kSlowdown)};
    for (const Wish& wish : wishes) {
      SCOPED_TRACE(wish.name);
      for (const std::uint32_t level : {0U, 1U, 2U}) {
        v1::InterpolateHeader header = MakeHeader(level);
        wish.make(shape.mesh, &header);
        ExpectBelowEstimate(shape, header, v1::MESH_ENCODING_PACKED);
      }
    }
  }
}

TEST(JobEstimateTest, FineQuantizationIsCounted) {
  const Shape shape{"sphere", Generate(MeshKind::kIrregularSphere, 2000)};
  for (const std::uint32_t bits : {8U, 16U, 20U, 24U, 30U}) {
    v1::InterpolateHeader header = MakeHeader(1);
    header.mutable_output()->set_encoding(v1::MESH_ENCODING_DRACO_QUANTIZED);
    header.mutable_output()->set_quantization_bits(bits);
    ExpectBelowEstimate(shape, header, v1::MESH_ENCODING_PACKED);
  }
}

TEST(JobEstimateTest, JobsToAChordToleranceAreCountedAtTheFinestLevelThatFits) {
  v1::InterpolateHeader header = MakeHeader(1);
  header.mutable_surface()->set_chord_tolerance(1e-3);
  header.mutable_mesh()->set_vertex_count(1000);
  header.mutable_mesh()->set_face_count(1000);
  header.mutable_mesh()->set_corner_count(4000);
  absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  ASSERT_TRUE(spec.ok()) << spec.status();
  Limits limits;
  limits.max_bytes = std::uint64_t{64} << 20;
  FitFinestLevel(limits, &*spec);
  const std::uint64_t estimate = EstimateJobBytes(*spec);
  EXPECT_LE(estimate, limits.max_bytes);
  EXPECT_GT(spec->engine.finest, 0U);
  ++spec->engine.finest;
  EXPECT_GT(EstimateJobBytes(*spec), limits.max_bytes);
  limits.max_level = 1;
  FitFinestLevel(limits, &*spec);
  EXPECT_EQ(spec->engine.finest, 1U);
}

TEST(JobEstimateTest, ChoosingALevelIsCounted) {
  const Shape shape{"sphere", Generate(MeshKind::kIrregularSphere, 2000)};
  v1::InterpolateHeader header = MakeHeader(1);
  header.mutable_surface()->set_chord_tolerance(0.5);
  ExpectBelowEstimate(shape, header, v1::MESH_ENCODING_PACKED);
}

// So what was set aside for finer levels can be given back.
TEST(JobEstimateTest, OnceTheLevelIsChosenThatOfTheLevelIsEnough) {
  const PolygonMesh mesh = Generate(MeshKind::kIrregularSphere, 6000 / oracle::kSlowdown);
  const absl::StatusOr<wire::EncodedMesh> encoded =
      wire::EncodeMesh(Context(), mesh, {.encoding = v1::MESH_ENCODING_PACKED});
  ASSERT_TRUE(encoded.ok()) << encoded.status();
  v1::InterpolateHeader header = MakeHeader(1);
  header.mutable_surface()->set_chord_tolerance(0.5);
  *header.mutable_mesh() = encoded->header;
  const absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  ASSERT_TRUE(spec.ok()) << spec.status();
  const AllocationMeter meter;
  Job job(*spec, Context{});
  ASSERT_TRUE(job.Decode(encoded->bytes).ok());
  const std::uint64_t before = EstimateJobBytes(job.spec());
  ASSERT_TRUE(job.Run().ok());
  const std::uint64_t after = EstimateJobBytes(job.spec());
  v1::Summary summary;
  for (bool more = true; more;) {
    v1::InterpolateResponse message;
    const absl::StatusOr<bool> next = job.NextMessage(&message);
    ASSERT_TRUE(next.ok()) << next.status();
    more = *next;
    if (message.has_summary()) summary = message.summary();
  }
  EXPECT_EQ(job.spec().engine.finest, summary.level());
  EXPECT_LT(after, before / 16);
  EXPECT_LE(meter.peak(), after);
}

TEST(JobEstimateTest, DecodingIsBelowWhatTheBytesSayOfThemselves) {
  for (const Shape& shape : Shapes()) {
    for (const v1::MeshEncoding encoding : kEncodings) {
      SCOPED_TRACE(shape.name + ", " + v1::MeshEncoding_Name(encoding));
      const auto encoded = wire::EncodeMesh(Context{}, shape.mesh, {.encoding = encoding});
      ASSERT_TRUE(encoded.ok()) << encoded.status();
      v1::MeshHeader header = encoded->header;
      if (encoding != v1::MESH_ENCODING_PACKED) {
        header.set_vertex_count(0);
        header.set_face_count(0);
        header.set_corner_count(0);
      }
      const auto estimate = wire::DecodeMemory(header, encoded->bytes);
      ASSERT_TRUE(estimate.ok()) << estimate.status();
      const AllocationMeter meter;
      const auto mesh = wire::DecodeMesh(Context{}, header, encoded->bytes);
      EXPECT_TRUE(mesh.ok()) << mesh.status();
      EXPECT_LE(meter.peak(), *estimate);
    }
  }
}

}  // namespace
}  // namespace limn
