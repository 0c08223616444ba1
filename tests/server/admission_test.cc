// SPDX-License-Identifier: MIT
// Jobs that are too large or too many are refused before anything is done for them.
#include "server/admission.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "proto/wire/status.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

v1::InterpolateRequest HeaderMessage() { return MakeUpload(MakeHeader(1), MakeSphere(64)).front(); }

TEST(AdmissionTest, TheJobAfterTheLastPlaceIsRefusedExactly) {
  constexpr std::uint64_t kWorkers = 2;
  constexpr std::uint64_t kQueue = 3;
  ServerOptions options{.threads = 1};
  options.limits.workers = kWorkers;
  options.limits.queue_length = kQueue;
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = server->InProcessChannel();
  std::vector<std::unique_ptr<RawCall>> calls;
  for (std::uint64_t i = 0; i < kWorkers + kQueue; ++i) {
    calls.push_back(std::make_unique<RawCall>(channel));
    ASSERT_TRUE(calls.back()->Write(HeaderMessage()));
    const std::optional<v1::InterpolateResponse> accepted = calls.back()->Read();
    ASSERT_TRUE(accepted.has_value()) << i << ": " << calls.back()->Finish();
    EXPECT_EQ(accepted->accepted().queue_position(), i < kWorkers ? 0 : i + 1 - kWorkers);
  }
  for (int attempt = 0; attempt < 3; ++attempt) {
    RawCall refused(channel);
    refused.Write(HeaderMessage());
    EXPECT_EQ(refused.Finish().code(), absl::StatusCode::kResourceExhausted);
    const v1::RichStatus rich = refused.rich_status();
    EXPECT_EQ(ErrorInfoOf(rich).reason(), "LIMIT_EXCEEDED");
    EXPECT_EQ(ErrorInfoOf(rich).metadata().at("limit"), "queue-length");
    EXPECT_TRUE(HasRetryInfo(rich));
    EXPECT_NE(rich.message().find("queue-length"), std::string::npos) << rich.message();
  }
  calls.pop_back();
  EXPECT_TRUE(PlaceBecomesFree(channel));
}

struct LimitCase {
  std::string name;
  std::function<void(ServerLimits&)> set;
  // Both in the details of the error.
  std::string limit;
  std::string field;
};

void PrintTo(const LimitCase& c, std::ostream* out) { *out << c.name; }

class LimitTest : public testing::TestWithParam<LimitCase> {};

TEST_P(LimitTest, IsHeldAndNamed) {
  ServerOptions options{.threads = 1};
  GetParam().set(options.limits);
  const std::unique_ptr<Server> server = StartServer(options);
  RawCall call(server->InProcessChannel());
  call.Write(MakeUpload(MakeHeader(3), MakeSphere(200)));
  const absl::Status status = call.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(ReasonOf(status), Reason::kLimitExceeded);
  const v1::RichStatus rich = call.rich_status();
  EXPECT_EQ(ErrorInfoOf(rich).metadata().at("limit"), GetParam().limit) << status;
  EXPECT_EQ(ErrorInfoOf(rich).metadata().at("field"), GetParam().field) << status;
  EXPECT_FALSE(HasRetryInfo(rich));
}

INSTANTIATE_TEST_SUITE_P(
    Limits, LimitTest,
    testing::Values(LimitCase{"Vertices", [](ServerLimits& l) { l.max_vertices = 199; },
                              "max-vertices", "mesh.vertex_count"},
                    LimitCase{"Corners", [](ServerLimits& l) { l.max_corners = 100; },
                              "max-corners", "mesh.corner_count"},
                    LimitCase{"Level", [](ServerLimits& l) { l.max_level = 2; }, "max-level",
                              "surface.level"},
                    LimitCase{"MeshBytes", [](ServerLimits& l) { l.max_mesh_bytes = 1000; },
                              "max-mesh-bytes", "mesh.byte_count"},
                    LimitCase{"JobBytes", [](ServerLimits& l) { l.max_job_bytes = 100'000; },
                              "max-job-bytes", "surface.level"},
                    LimitCase{"TotalBytes", [](ServerLimits& l) { l.max_total_bytes = 100'000; },
                              "max-total-bytes", "surface.level"}),
    [](const auto& test) { return test.param.name; });

TEST(AdmissionTest, MemoryOfAllJobsIsBoundedAndComesBack) {
  JobSpec spec;
  spec.mesh.set_vertex_count(1000);
  spec.mesh.set_face_count(1000);
  spec.mesh.set_corner_count(4000);
  spec.mesh.set_byte_count(24'000 + 4 * 5000);
  spec.mesh.set_encoding(v1::MESH_ENCODING_PACKED);
  ServerLimits limits;
  limits.max_total_bytes = 2 * EstimateJobBytes(spec);
  Lane lane({.name = "jobs", .workers = 1, .queue_length = 9, .threads = 1});
  Admission admission(limits, lane);
  {
    const auto first = admission.Admit(spec);
    ASSERT_TRUE(first.ok()) << first.status();
    EXPECT_EQ(admission.reserved_bytes(), EstimateJobBytes(spec));
    const auto second = admission.Admit(spec);
    ASSERT_TRUE(second.ok());
    const auto third = admission.Admit(spec);
    EXPECT_EQ(ReasonOf(third.status()), Reason::kLimitExceeded);
    EXPECT_EQ(GetErrorDetail(third.status())->field, wire::kQueueField);
    EXPECT_EQ(GetErrorDetail(third.status())->limit, "max-total-bytes");
    EXPECT_EQ(lane.places_taken(), 2U);
  }
  EXPECT_EQ(admission.reserved_bytes(), 0U);
  EXPECT_EQ(lane.places_taken(), 0U);
}

TEST(AdmissionTest, EstimateGrowsWithLevelAndSize) {
  JobSpec spec;
  spec.mesh.set_vertex_count(1000);
  spec.mesh.set_face_count(1000);
  spec.mesh.set_corner_count(4000);
  spec.engine.level = 1;
  const std::uint64_t small = EstimateJobBytes(spec);
  spec.engine.level = 4;
  const std::uint64_t fine = EstimateJobBytes(spec);
  EXPECT_GT(fine, 16 * (small / 4));
  spec.mesh.set_vertex_count(2000);
  EXPECT_GT(EstimateJobBytes(spec), fine);
}

TEST(AdmissionTest, EstimateCountsConstraints) {
  JobSpec spec;
  spec.mesh.set_vertex_count(1000);
  spec.mesh.set_face_count(1000);
  spec.mesh.set_corner_count(4000);
  const std::uint64_t without = EstimateJobBytes(spec);
  Constraints& constraints = spec.engine.constraints;
  constraints.interpolate.emplace(1000);
  const std::uint64_t subset = EstimateJobBytes(spec);
  EXPECT_GE(subset, without + 2 * 1000 * sizeof(Index));
  constraints.normals.resize(1000);
  const std::uint64_t normals = EstimateJobBytes(spec);
  EXPECT_GE(normals, subset + 3 * 1000 * sizeof(NormalConstraint));
  constraints.shape_handles.resize(1000);
  EXPECT_GE(EstimateJobBytes(spec), normals + 2 * 1000 * sizeof(ShapeHandle));
}

TEST(AdmissionTest, EstimateCoversTheWorstThatRepairMayMakeOfAMesh) {
  JobSpec spec;
  spec.mesh.set_vertex_count(1000);
  spec.mesh.set_face_count(10);
  spec.mesh.set_corner_count(3000);
  spec.engine.level = 2;
  const std::uint64_t without = EstimateJobBytes(spec);
  spec.repair = true;
  const std::uint64_t with = EstimateJobBytes(spec);
  EXPECT_GT(with, without);
  // A vertex for every corner, and triangles.
  JobSpec worst = spec;
  worst.repair = false;
  worst.mesh.set_vertex_count(3000);
  worst.mesh.set_face_count(1000);
  EXPECT_GT(with, EstimateJobBytes(worst));
  // When little is computed, repair itself is what needs most.
  spec.engine.level = 0;
  EXPECT_GT(EstimateJobBytes(spec), EstimateRepairBytes(1000, 10, 3000));
}

}  // namespace
}  // namespace limn
