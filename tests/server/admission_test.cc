// SPDX-License-Identifier: MIT
// Jobs that are too large or too many are refused before anything is done for them.
#include "server/admission.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/job_cost.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

v1::InterpolateRequest HeaderMessage() { return MakeUpload(MakeHeader(1), MakeSphere(64)).front(); }

Lanes MakeLanes() {
  const LaneOptions options{.name = "jobs", .workers = 1, .queue_length = 9, .threads = 1};
  return {.interactive = Lane(options), .batch = Lane(options), .interactive_milliseconds = 0};
}

void ExpectBusy(RawCall& call, const std::string& limit) {
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kResourceExhausted) << call.Finish();
  const v1::RichStatus rich = call.rich_status();
  EXPECT_EQ(ErrorInfoOf(rich).reason(), "LIMIT_EXCEEDED");
  EXPECT_EQ(ErrorInfoOf(rich).metadata().at("limit"), limit);
  EXPECT_TRUE(HasRetryInfo(rich));
  EXPECT_NE(rich.message().find(limit), std::string::npos) << rich.message();
}

TEST(AdmissionTest, TheJobAfterTheLastPlaceIsRefusedExactly) {
  constexpr std::size_t kPlaces = 2 + 3;
  constexpr std::size_t kTooMany = 4;
  ServerOptions options{.threads = 1};
  options.limits.workers = 2;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_length = 3;
  const std::unique_ptr<Server> server = StartServer(options);
  const std::vector<v1::InterpolateRequest> upload =
      MakeUpload(MakeEndlessHeader(), MakeSphere(20'000));
  std::vector<std::unique_ptr<RawCall>> calls;
  for (std::size_t i = 0; i < kPlaces + kTooMany; ++i) {
    calls.push_back(std::make_unique<RawCall>(server->InProcessChannel()));
  }
  // All at the same time; each reads until its call has ended.
  std::mutex mutex;
  std::vector<RawCall*> ended;
  std::vector<std::thread> threads;
  for (const std::unique_ptr<RawCall>& call : calls) {
    threads.emplace_back([&, raw = call.get()] {
      raw->Write(upload);
      (void)raw->Finish();
      const std::lock_guard lock(mutex);
      ended.push_back(raw);
    });
  }
  const auto count = [&] {
    const std::lock_guard lock(mutex);
    return ended.size();
  };
  for (int i = 0; i < 1000 && count() < kTooMany; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  // Those that were not refused at once are not refused later either.
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(count(), kTooMany);
  const std::vector<RawCall*> refused = [&] {
    const std::lock_guard lock(mutex);
    return ended;
  }();
  for (RawCall* call : refused) ExpectBusy(*call, "queue-length");
  for (const std::unique_ptr<RawCall>& call : calls) call->Cancel();
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
}

// One job runs, three wait, and the fourth would be above a bound that three of them fill.
void ExpectFifthIsRefused(const std::function<void(const JobSpec&, ServerLimits*)>& limit_to_three,
                          const std::string& limit) {
  ServerOptions options{.threads = 1};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  const std::vector<v1::InterpolateRequest> upload =
      MakeUpload(MakeEndlessHeader(), MakeSphere(20'000));
  const absl::StatusOr<JobSpec> spec = JobSpecFromProto(upload.front().header());
  ASSERT_TRUE(spec.ok()) << spec.status();
  limit_to_three(*spec, &options.limits);
  const std::unique_ptr<Server> server = StartServer(options);
  // The first runs, and each of the others has its place, before the next one comes.
  const auto wait_for = [&](std::uint32_t waiting) {
    const std::string depth = "limn_queue_depth{lane=\"batch\"} " + std::to_string(waiting) + "\n";
    for (int attempt = 0; attempt < 1000; ++attempt) {
      const std::string metrics = server->MetricsText();
      if (metrics.find(depth) != std::string::npos &&
          metrics.find("limn_running_jobs{lane=\"batch\"} 1\n") != std::string::npos) {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  };
  std::vector<std::unique_ptr<RawCall>> calls;
  const auto add = [&] {
    calls.push_back(std::make_unique<RawCall>(server->InProcessChannel()));
    EXPECT_TRUE(calls.back()->Write(upload));
    EXPECT_TRUE(calls.back()->Read().has_value()) << calls.back()->Finish();
  };
  for (std::uint32_t i = 0; i < 4; ++i) {
    add();
    ASSERT_TRUE(wait_for(i)) << i;
  }
  for (int attempt = 0; attempt < 2; ++attempt) {
    RawCall refused(server->InProcessChannel());
    refused.Write(upload);
    ExpectBusy(refused, limit);
  }
  // One that gives up makes room for one.
  calls.pop_back();
  ASSERT_TRUE(wait_for(2));
  add();
  EXPECT_TRUE(wait_for(3));
}

TEST(AdmissionTest, TheJobAfterTheLastBytesIsRefusedExactly) {
  ExpectFifthIsRefused(
      [](const JobSpec& spec, ServerLimits* limits) {
        limits->queue_bytes = 3 * EstimateJobBytes(spec);
      },
      "queue-bytes");
}

TEST(AdmissionTest, TheJobAfterTheLastOfTheCostIsRefusedExactly) {
  ExpectFifthIsRefused(
      [](const JobSpec& spec, ServerLimits* limits) {
        limits->queue_milliseconds = 3 * EstimateMilliseconds(spec);
      },
      "queue-milliseconds");
}

TEST(AdmissionTest, TheUploadAfterTheLastIsRefusedExactly) {
  ServerOptions options{.threads = 1};
  options.limits.max_uploads = 3;
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = server->InProcessChannel();
  std::vector<std::unique_ptr<RawCall>> calls;
  for (int i = 0; i < 3; ++i) {
    calls.push_back(std::make_unique<RawCall>(channel));
    ASSERT_TRUE(calls.back()->Write(HeaderMessage()));
    const std::optional<v1::InterpolateResponse> accepted = calls.back()->Read();
    ASSERT_TRUE(accepted.has_value()) << i << ": " << calls.back()->Finish();
    // No place is taken yet.
    EXPECT_EQ(accepted->accepted().queue_position(), 0U);
  }
  for (int attempt = 0; attempt < 3; ++attempt) {
    RawCall refused(channel);
    refused.Write(HeaderMessage());
    ExpectBusy(refused, "max-uploads");
  }
  calls.pop_back();
  EXPECT_TRUE(PlaceBecomesFree(channel));
}

TEST(AdmissionTest, AnUploadHoldsNeitherAPlaceNorTheMemoryOfItsJob) {
  ServerOptions options{.threads = 1};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_length = 0;
  const std::vector<v1::InterpolateRequest> large = MakeUpload(MakeHeader(5), MakeSphere(2000));
  v1::InterpolateHeader header = large.front().header();
  const absl::StatusOr<JobSpec> spec = JobSpecFromProto(header);
  ASSERT_TRUE(spec.ok()) << spec.status();
  options.limits.max_total_bytes = EstimateJobBytes(*spec) + (16 << 20);
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = server->InProcessChannel();
  RawCall slow(channel);
  ASSERT_TRUE(slow.Write(large.front()));
  const std::optional<v1::InterpolateResponse> accepted = slow.Read();
  ASSERT_TRUE(accepted.has_value()) << slow.Finish();
  EXPECT_EQ(accepted->accepted().estimated_bytes(), EstimateJobBytes(*spec));
  // There is one place, and memory for one such job.
  RawCall quick(channel);
  quick.Write(large);
  EXPECT_TRUE(quick.Finish().ok()) << quick.Finish();
}

TEST(AdmissionTest, UnclaimedMeshesAreHeldAgainstTheTotalOnceTheyAreDecoded) {
  v1::InterpolateHeader header = MakeEndlessHeader();
  header.mutable_mesh()->set_encoding(v1::MESH_ENCODING_DRACO);
  std::vector<v1::InterpolateRequest> upload = MakeUpload(header, MakeSphere(20'000));
  const absl::StatusOr<JobSpec> spec = JobSpecFromProto(upload.front().header());
  ASSERT_TRUE(spec.ok()) << spec.status();
  v1::MeshHeader& mesh = *upload.front().mutable_header()->mutable_mesh();
  mesh.set_vertex_count(0);
  mesh.set_face_count(0);
  mesh.set_corner_count(0);

  ServerOptions options{.threads = 1};
  options.limits.workers = 2;
  options.limits.interactive_milliseconds = 0;
  options.limits.max_total_bytes = EstimateJobBytes(*spec) / 2 * 3;
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = server->InProcessChannel();
  auto first = std::make_unique<RawCall>(channel);
  ASSERT_TRUE(first->Write(upload));
  for (std::string stage; stage != "solve";) {
    const std::optional<v1::InterpolateResponse> message = first->Read();
    ASSERT_TRUE(message.has_value()) << first->Finish();
    stage = message->progress().stage();
  }
  RawCall second(channel);
  second.Write(upload);
  ExpectBusy(second, "max-total-bytes");
  first.reset();
  // Alone it is taken.
  for (int attempt = 0;; ++attempt) {
    RawCall third(channel, std::chrono::seconds(1));
    third.Write(upload);
    const absl::Status status = third.Finish();
    if (status.code() == absl::StatusCode::kDeadlineExceeded) break;
    ASSERT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    ASSERT_LT(attempt, 100);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

TEST(AdmissionTest, AnUnclaimedMeshThatNeedsMoreThanAJobMayIsRefused) {
  v1::InterpolateHeader header = MakeHeader(4);
  header.mutable_mesh()->set_encoding(v1::MESH_ENCODING_DRACO);
  std::vector<v1::InterpolateRequest> upload = MakeUpload(header, MakeSphere(2000));
  v1::MeshHeader& mesh = *upload.front().mutable_header()->mutable_mesh();
  mesh.set_vertex_count(0);
  mesh.set_face_count(0);
  mesh.set_corner_count(0);
  ServerOptions options{.threads = 1};
  options.limits.max_job_bytes = 20 << 20;
  const std::unique_ptr<Server> server = StartServer(options);
  RawCall call(server->InProcessChannel());
  call.Write(upload);
  EXPECT_EQ(ReasonOf(call.Finish()), Reason::kLimitExceeded) << call.Finish();
  EXPECT_EQ(ErrorInfoOf(call.rich_status()).metadata().at("limit"), "max-job-bytes");
  EXPECT_FALSE(HasRetryInfo(call.rich_status()));
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
  EXPECT_TRUE(std::any_of(LimitTable().begin(), LimitTable().end(),
                          [](const LimitEntry& entry) { return entry.name == GetParam().limit; }));
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
  limits.max_total_bytes = 2 * EstimateJobBytes(spec) + EstimateUploadBytes(spec);
  Lanes lanes = MakeLanes();
  Admission admission(limits, lanes);
  {
    auto first = admission.Admit(spec);
    ASSERT_TRUE(first.ok()) << first.status();
    EXPECT_EQ(admission.reserved_bytes(), EstimateUploadBytes(spec));
    EXPECT_EQ(admission.uploads(), 1U);
    EXPECT_EQ(lanes.batch.places_taken(), 0U);
    auto second = admission.Admit(spec);
    ASSERT_TRUE(second.ok());
    auto third = admission.Admit(spec);
    ASSERT_TRUE(third.ok());
    ASSERT_TRUE(admission.Enqueue(&*first).ok());
    EXPECT_EQ(lanes.batch.places_taken(), 1U);
    EXPECT_EQ(admission.uploads(), 2U);
    ASSERT_TRUE(admission.Enqueue(&*second).ok());
    const absl::Status refused = admission.Enqueue(&*third);
    EXPECT_EQ(ReasonOf(refused), Reason::kLimitExceeded);
    EXPECT_TRUE(GetErrorDetail(refused)->retryable);
    EXPECT_EQ(GetErrorDetail(refused)->limit, "max-total-bytes");
    // So is a job that comes now, before it uploads anything.
    EXPECT_EQ(GetErrorDetail(admission.Admit(spec).status())->limit, "max-total-bytes");
    EXPECT_EQ(admission.reserved_bytes(), limits.max_total_bytes);
  }
  EXPECT_EQ(admission.reserved_bytes(), 0U);
  EXPECT_EQ(admission.uploads(), 0U);
  EXPECT_EQ(lanes.batch.places_taken(), 0U);
}

TEST(AdmissionTest, AReservationGrowsAndIsNotTouchedWhereItCannot) {
  ServerLimits limits;
  limits.max_job_bytes = 1000;
  limits.max_total_bytes = 1500;
  Lanes lanes = MakeLanes();
  Admission admission(limits, lanes);
  Admission::Reservation first;
  Admission::Reservation second;
  ASSERT_TRUE(admission.Grow(400, &first).ok());
  ASSERT_TRUE(admission.Grow(300, &first).ok());
  EXPECT_EQ(first.bytes(), 400U);
  ASSERT_TRUE(admission.Grow(1000, &first).ok());
  ASSERT_TRUE(admission.Grow(500, &second).ok());
  EXPECT_EQ(admission.reserved_bytes(), 1500U);
  const absl::Status total = admission.Grow(501, &second);
  EXPECT_EQ(GetErrorDetail(total)->limit, "max-total-bytes");
  EXPECT_TRUE(GetErrorDetail(total)->retryable);
  const absl::Status job = admission.Grow(1001, &first);
  EXPECT_EQ(GetErrorDetail(job)->limit, "max-job-bytes");
  EXPECT_FALSE(GetErrorDetail(job)->retryable);
  EXPECT_EQ(first.bytes(), 1000U);
  EXPECT_EQ(second.bytes(), 500U);
  first.Release();
  EXPECT_EQ(admission.reserved_bytes(), 500U);
  EXPECT_TRUE(admission.Grow(1000, &second).ok());
}

TEST(AdmissionTest, AReservationGivesBackWhatItTurnsOutNotToNeed) {
  ServerLimits limits;
  limits.max_total_bytes = 1500;
  Lanes lanes = MakeLanes();
  Admission admission(limits, lanes);
  {
    Admission::Reservation nothing;
    nothing.Shrink(0);
    Admission::Reservation first;
    Admission::Reservation second;
    ASSERT_TRUE(admission.Grow(1500, &first).ok());
    first.Shrink(2000);
    EXPECT_EQ(first.bytes(), 1500U);
    EXPECT_FALSE(admission.Grow(1, &second).ok());
    first.Shrink(400);
    EXPECT_EQ(first.bytes(), 400U);
    EXPECT_EQ(admission.reserved_bytes(), 400U);
    EXPECT_TRUE(admission.Grow(1100, &second).ok());
  }
  EXPECT_EQ(admission.reserved_bytes(), 0U);
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

TEST(AdmissionTest, EstimateCountsTheListsOfWhatIsSharp) {
  JobSpec spec;
  spec.mesh.set_vertex_count(100'000);
  spec.mesh.set_face_count(100'000);
  spec.mesh.set_corner_count(400'000);
  const std::uint64_t without = EstimateJobBytes(spec);
  CreaseConstraint crease;
  crease.vertices.resize(100'000);
  crease.sharpness.resize(1);
  spec.engine.constraints.creases = {crease};
  // The call's, the job's, and those in one list, with a sharpness for each edge.
  EXPECT_GE(EstimateJobBytes(spec), without + 100'000 * (3 * sizeof(Index) + sizeof(float)));
}

TEST(AdmissionTest, EstimateCountsWhatRepairMayMakeOfConstraints) {
  JobSpec spec;
  spec.mesh.set_vertex_count(1000);
  spec.mesh.set_face_count(1000);
  spec.mesh.set_corner_count(400'000);
  spec.repair = true;
  const std::uint64_t without = EstimateJobBytes(spec);
  // One vertex may become as many as there are corners.
  spec.engine.constraints.normals.resize(1);
  EXPECT_GE(EstimateJobBytes(spec), without + 2 * 400'000 * sizeof(NormalConstraint));
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
