// SPDX-License-Identifier: MIT
// A batch against a server that does what it can to lose jobs, or to have them done twice.
#include "client/batch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "client/batch_job.h"
#include "client/sha256.h"
#include "engine/base/error.h"
#include "engine/mesh/generate.h"
#include "proto/wire/status.h"
#include "tests/client/fake_batch_server.h"

namespace limn {
namespace {

using Event = FakeBatchServer::Event;
using Kind = FakeBatchServer::Event::Kind;
using Script = FakeBatchServer::Script;

PolygonMesh MakeMesh(std::uint64_t seed) {
  absl::StatusOr<PolygonMesh> mesh =
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 40 + 7 * seed, .seed = seed});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

std::string IdOf(std::size_t number) { return absl::StrCat("job-", number); }

BatchJob MakeJob(std::size_t number) {
  v1::InterpolateHeader header;
  header.mutable_output()->set_control_mesh(true);
  return {.id = IdOf(number), .header = header, .mesh = MakeMesh(number)};
}

// Quick to try again.
BatchOptions Quick() {
  return {.max_tries = 4,
          .first_pause = std::chrono::milliseconds(1),
          .longest_pause = std::chrono::milliseconds(4)};
}

// Small chunks, so that every mesh has several.
Client ClientOf(FakeBatchServer* server, double deadline = 0) {
  return Client(server->Channel(), {.deadline_seconds = deadline, .chunk_bytes = 500});
}

// What a caller sees of a batch.
struct Outcome {
  absl::Status status;
  std::map<std::string, std::vector<BatchResult>> results;
  std::size_t taken = 0;
  std::size_t most_open = 0;
  std::size_t progress = 0;
  BatchTotals totals;

  // The one result of a job.
  const BatchResult& Of(std::size_t number) const {
    static const BatchResult none{.id = "", .result = absl::NotFoundError("no result")};
    const auto found = results.find(IdOf(number));
    if (found == results.end()) return none;
    EXPECT_EQ(found->second.size(), 1U) << IdOf(number) << " was reported more than once";
    return found->second[0];
  }
};

struct Course {
  std::size_t jobs = 12;
  BatchOptions options = Quick();
  double deadline = 0;
  std::function<BatchJob(std::size_t)> make = MakeJob;
  std::function<absl::Status(const BatchResult&, ClientBatch*)> on_result = {};
  std::function<void(std::size_t, ClientBatch*)> on_take = {};
};

Outcome RunBatch(FakeBatchServer* server, const Course& course) {
  ClientBatch batch(ClientOf(server, course.deadline), course.options);
  Outcome outcome;
  std::atomic<std::size_t> taken = 0;
  std::atomic<std::size_t> ended = 0;
  BatchCallbacks callbacks;
  callbacks.next = [&]() -> std::optional<BatchJob> {
    if (taken == course.jobs) return std::nullopt;
    if (course.on_take) course.on_take(taken, &batch);
    outcome.most_open = std::max<std::size_t>(outcome.most_open, taken + 1 - ended);
    return course.make(taken++);
  };
  callbacks.on_result = [&](BatchResult result) {
    const absl::Status status =
        course.on_result ? course.on_result(result, &batch) : absl::OkStatus();
    ++ended;
    outcome.results[result.id].push_back(std::move(result));
    return status;
  };
  callbacks.on_job_progress = [&](const std::string&, const v1::Progress&) { ++outcome.progress; };
  callbacks.on_totals = [&](const BatchTotals& totals) { outcome.totals = totals; };
  outcome.status = batch.Run(callbacks);
  outcome.taken = taken;
  return outcome;
}

void ExpectMeshes(const PolygonMesh& got, const PolygonMesh& wanted) {
  EXPECT_TRUE(std::ranges::equal(got.positions, wanted.positions));
  EXPECT_TRUE(std::ranges::equal(got.face_begin, wanted.face_begin));
  EXPECT_TRUE(std::ranges::equal(got.corner_vertex, wanted.corner_vertex));
}

// All jobs have succeeded, each with its own mesh, and nothing was done that must not be.
void ExpectAllWell(const FakeBatchServer& server, const Outcome& outcome, std::size_t jobs) {
  EXPECT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(outcome.results.size(), jobs);
  for (std::size_t i = 0; i < jobs; ++i) {
    const BatchResult& result = outcome.Of(i);
    ASSERT_TRUE(result.result.ok()) << IdOf(i) << ": " << result.result.status();
    ExpectMeshes(result.result->control_mesh, MakeMesh(i));
    EXPECT_EQ(result.result->summary.request_id(), IdOf(i));
  }
  EXPECT_EQ(outcome.totals.taken, jobs);
  EXPECT_EQ(outcome.totals.succeeded, jobs);
  EXPECT_EQ(outcome.totals.failed, 0U);
  EXPECT_EQ(server.books().violations, std::vector<std::string>{});
}

absl::Status Retryable() {
  return MakeError("others have the place", {.reason = Reason::kLimitExceeded, .retryable = true});
}

Reason ReasonOf(const absl::Status& status) {
  const auto detail = GetErrorDetail(status);
  EXPECT_TRUE(detail.has_value()) << "there is no error";
  return detail.has_value() ? detail->reason : Reason::kInternal;
}

TEST(BatchTest, EveryJobIsAnsweredUnderItsIdAndAcknowledged) {
  FakeBatchServer server({});
  const Outcome outcome = RunBatch(&server, {.jobs = 40});
  ExpectAllWell(server, outcome, 40);
  const FakeBatchServer::Books books = server.books();
  EXPECT_EQ(books.streams, 1);
  ASSERT_EQ(books.headers.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(books.headers[i], IdOf(i));
    EXPECT_EQ(books.worked.at(IdOf(i)), 1);
    EXPECT_EQ(books.acknowledged.count(IdOf(i)), 1U);
    EXPECT_EQ(outcome.Of(i).tries, 1U);
    EXPECT_EQ(outcome.Of(i).digest.size(), 32U);
  }
  EXPECT_EQ(outcome.progress, 40U);
}

TEST(BatchTest, NoMoreJobsAreTakenThanTheServersWindowHas) {
  FakeBatchServer server({.window = 3});
  const Outcome outcome = RunBatch(&server, {.jobs = 30});
  ExpectAllWell(server, outcome, 30);
  EXPECT_LE(outcome.most_open, 3U);
}

TEST(BatchTest, NoMoreJobsAreTakenThanTheCallersWindowHas) {
  FakeBatchServer server({.window = 8});
  BatchOptions options = Quick();
  options.window = 2;
  const Outcome outcome = RunBatch(&server, {.jobs = 20, .options = options});
  ExpectAllWell(server, outcome, 20);
  EXPECT_LE(outcome.most_open, 2U);
}

TEST(BatchTest, NoJobIsTakenWhileAsManyBytesAreKeptAsMayBe) {
  FakeBatchServer server({.window = 8});
  BatchOptions options = Quick();
  options.mesh_bytes = 1;
  const Outcome outcome = RunBatch(&server, {.jobs = 10, .options = options});
  ExpectAllWell(server, outcome, 10);
  EXPECT_EQ(outcome.most_open, 1U);
}

TEST(BatchTest, AnswersMayComeInterleavedAndInAnyOrder) {
  FakeBatchServer server({.window = 4, .hold = 4});
  ExpectAllWell(server, RunBatch(&server, {.jobs = 24}), 24);
}

TEST(BatchTest, AnAnswerThatComesTwiceIsReportedOnce) {
  FakeBatchServer server({.window = 4, .hold = 2, .stutter = true});
  ExpectAllWell(server, RunBatch(&server, {.jobs = 10}), 10);
}

TEST(BatchTest, NoJobsAreNoError) {
  FakeBatchServer server({});
  const Outcome outcome = RunBatch(&server, {.jobs = 0});
  EXPECT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_TRUE(outcome.results.empty());
}

TEST(BatchTest, ErrorsOfJobsDoNotEndTheBatch) {
  const absl::Status bad =
      MakeError("no", {.reason = Reason::kNonManifoldEdge, .field = "faces", .index = 7});
  FakeBatchServer server({.errors = {{IdOf(2), {bad}}, {IdOf(5), {bad}}}});
  const auto make = [](std::size_t number) {
    BatchJob job = MakeJob(number);
    if (number == 3) job.mesh = absl::NotFoundError("no such file");
    if (number == 4) job.id = "not visible";
    return job;
  };
  const Outcome outcome = RunBatch(&server, {.jobs = 8, .make = make});
  EXPECT_TRUE(outcome.status.ok()) << outcome.status;
  for (const std::size_t i : {2U, 5U}) {
    const absl::Status status = outcome.Of(i).result.status();
    EXPECT_EQ(ReasonOf(status), Reason::kNonManifoldEdge) << status;
    EXPECT_EQ(GetErrorDetail(status)->index, 7U);
  }
  EXPECT_EQ(outcome.Of(3).result.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(outcome.Of(3).tries, 0U);
  EXPECT_EQ(ReasonOf(outcome.results.at("not visible")[0].result.status()), Reason::kInvalidOption);
  for (const std::size_t i : {0U, 1U, 6U, 7U}) EXPECT_TRUE(outcome.Of(i).result.ok());
  EXPECT_EQ(outcome.totals.succeeded, 4U);
  EXPECT_EQ(outcome.totals.failed, 4U);
}

TEST(BatchTest, AJobOfANameThatIsNotAnsweredIsRefused) {
  FakeBatchServer server({.window = 4, .hold = 2});
  const auto make = [](std::size_t number) {
    BatchJob job = MakeJob(number);
    if (number == 1) job.id = IdOf(0);
    return job;
  };
  const Outcome outcome = RunBatch(&server, {.jobs = 3, .make = make});
  EXPECT_TRUE(outcome.status.ok());
  const auto& results = outcome.results.at(IdOf(0));
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(ReasonOf(results[0].result.status()), Reason::kInvalidOption);
  EXPECT_TRUE(results[1].result.ok());
  EXPECT_TRUE(outcome.Of(2).result.ok());
}

TEST(BatchTest, AHeaderTooLargeForAMessageFailsAlone) {
  FakeBatchServer server({.max_message_bytes = 2000});
  const auto make = [](std::size_t number) {
    BatchJob job = MakeJob(number);
    for (std::uint32_t i = 0; number == 1 && i < 2000; ++i) {
      job.header.mutable_constraints()->mutable_interpolate()->add_vertices(i);
    }
    return job;
  };
  const Outcome outcome = RunBatch(&server, {.jobs = 3, .make = make});
  EXPECT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(ReasonOf(outcome.Of(1).result.status()), Reason::kLimitExceeded);
  EXPECT_TRUE(outcome.Of(0).result.ok() && outcome.Of(2).result.ok());
}

TEST(BatchTest, ErrorsThatMayPassAreTriedAgain) {
  FakeBatchServer server({.errors = {{IdOf(1), {Retryable(), Retryable()}}}});
  const Outcome outcome = RunBatch(&server, {.jobs = 5});
  ExpectAllWell(server, outcome, 5);
  EXPECT_EQ(outcome.Of(1).tries, 3U);
  EXPECT_EQ(outcome.Of(0).tries, 1U);
}

TEST(BatchTest, ErrorsThatDoNotPassAreReportedAfterAsManyTriesAsMayBe) {
  FakeBatchServer server({.errors = {{IdOf(1), std::vector<absl::Status>(50, Retryable())}}});
  const Outcome outcome = RunBatch(&server, {.jobs = 5});
  EXPECT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(ReasonOf(outcome.Of(1).result.status()), Reason::kLimitExceeded);
  EXPECT_EQ(outcome.Of(1).tries, 4U);
  EXPECT_EQ(outcome.totals.succeeded, 4U);
}

// A stream that breaks at a point, in one of the ways in which streams break.
struct Break {
  const char* name;
  Kind kind;
  int count;
  grpc::Status status;
  bool resume;
};

class BrokenStream : public testing::TestWithParam<Break> {};

TEST_P(BrokenStream, LosesNoJobAndDoesNoneTwiceThatTheServerKnows) {
  const Break& broken = GetParam();
  FakeBatchServer server({.window = 4,
                          .on_event =
                              [&](const Event& event) {
                                const bool here = event.stream < 2 && event.kind == broken.kind &&
                                                  event.count == broken.count;
                                return here ? broken.status : grpc::Status::OK;
                              },
                          .resume = broken.resume,
                          .hold = 2});
  const Outcome outcome = RunBatch(&server, {.jobs = 12});
  ExpectAllWell(server, outcome, 12);
  const FakeBatchServer::Books books = server.books();
  EXPECT_EQ(books.streams, 3);
  for (std::size_t i = 0; broken.resume && i < 12; ++i) {
    EXPECT_EQ(books.worked.at(IdOf(i)), 1) << IdOf(i) << " was done twice";
  }
  EXPECT_TRUE(broken.resume || books.resumed.empty());
}

std::vector<Break> AllBreaks() {
  const grpc::Status cut(grpc::StatusCode::UNAVAILABLE, "Socket closed");
  const grpc::Status removed(grpc::StatusCode::UNKNOWN, "Stream removed");
  const grpc::Status stop =
      wire::ToGrpcStatus(MakeError("stopping", {.reason = Reason::kShuttingDown}));
  const grpc::Status long_enough = wire::ToGrpcStatus(
      MakeError("long", {.reason = Reason::kLimitExceeded, .limit = "stream-seconds"}));
  std::vector<Break> breaks;
  for (const bool resume : {true, false}) {
    breaks.push_back({"Header", Kind::kHeader, 3, cut, resume});
    breaks.push_back({"FirstHeader", Kind::kHeader, 1, removed, resume});
    breaks.push_back({"Accepted", Kind::kAccepted, 2, stop, resume});
    breaks.push_back({"Chunk", Kind::kChunk, 4, long_enough, resume});
    breaks.push_back({"Complete", Kind::kComplete, 3, cut, resume});
    breaks.push_back({"HalfAnswered", Kind::kHalfAnswered, 5, stop, resume});
    breaks.push_back({"Answered", Kind::kAnswered, 1, removed, resume});
  }
  return breaks;
}

INSTANTIATE_TEST_SUITE_P(Everywhere, BrokenStream, testing::ValuesIn(AllBreaks()),
                         [](const auto& broken) {
                           return std::string(broken.param.name) +
                                  (broken.param.resume ? "Resumed" : "Lost");
                         });

TEST(BatchTest, MeshesOfJobsThatAreTakenUpAreNotSentAgain) {
  std::map<std::string, int> before;
  FakeBatchServer* looked_at = nullptr;
  FakeBatchServer server({.window = 3,
                          .on_event =
                              [](const Event& event) {
                                const bool here = event.stream == 0 &&
                                                  event.kind == Kind::kComplete && event.count == 3;
                                return here ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "cut")
                                            : grpc::Status::OK;
                              },
                          .hold = 3});
  looked_at = &server;
  const Outcome outcome = RunBatch(&server, {.jobs = 3});
  ExpectAllWell(server, outcome, 3);
  FakeBatchServer whole({.window = 3, .hold = 3});
  ExpectAllWell(whole, RunBatch(&whole, {.jobs = 3}), 3);
  EXPECT_EQ(looked_at->books().chunks, whole.books().chunks);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(server.books().resumed.at(IdOf(i)), 1);
    EXPECT_EQ(outcome.Of(i).tries, 1U);
  }
}

TEST(BatchTest, AnotherBatchOfTheSameNameTakesUpJobsAndOneOfAnotherDoesNot) {
  for (const bool same : {true, false}) {
    FakeBatchServer server({.window = 2, .silent = {}});
    BatchOptions options = Quick();
    options.name = "one";
    // Nobody acknowledges what the first batch did not take.
    const auto refuse = [](const BatchResult&, ClientBatch*) {
      return absl::ResourceExhaustedError("the disk is full");
    };
    const Outcome first = RunBatch(&server, {.jobs = 1, .options = options, .on_result = refuse});
    EXPECT_EQ(first.status.message(), "the disk is full");
    EXPECT_EQ(server.books().acknowledged.size(), 0U);
    options.name = same ? "one" : "other";
    ExpectAllWell(server, RunBatch(&server, {.jobs = 1, .options = options}), 1);
    EXPECT_EQ(server.books().worked.at(IdOf(0)), same ? 1 : 2);
  }
}

TEST(BatchTest, AJobThatTakesEveryServerWithItFailsAndTheOthersDoNot) {
  FakeBatchServer server(
      {.window = 2,
       .on_event =
           [](const Event& event) {
             const bool here = event.id == IdOf(1) && event.kind == Kind::kComplete;
             return here ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "crash") : grpc::Status::OK;
           },
       .resume = false});
  const Outcome outcome = RunBatch(&server, {.jobs = 6});
  EXPECT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(outcome.Of(1).result.status().code(), absl::StatusCode::kUnavailable);
  for (const std::size_t i : {0U, 2U, 3U, 4U, 5U}) EXPECT_TRUE(outcome.Of(i).result.ok()) << i;
}

TEST(BatchTest, StreamsThatBringNothingAreGivenUp) {
  FakeBatchServer server({.on_event = [](const Event&) {
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "always");
  }});
  const Outcome outcome = RunBatch(&server, {.jobs = 9});
  EXPECT_EQ(outcome.status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(server.books().streams, 4);
  EXPECT_EQ(outcome.results.size(), outcome.taken);
  for (const auto& [id, results] : outcome.results) {
    ASSERT_EQ(results.size(), 1U);
    EXPECT_EQ(results[0].result.status().message(), "always");
  }
}

TEST(BatchTest, AnErrorThatWaitingDoesNotCureEndsTheBatch) {
  for (const Reason reason : {Reason::kUnauthenticated, Reason::kMalformedRequest}) {
    FakeBatchServer server({.on_event =
                                [&](const Event& event) {
                                  if (event.kind != Kind::kHeader || event.count < 5) {
                                    return grpc::Status::OK;
                                  }
                                  return wire::ToGrpcStatus(MakeError("no", {.reason = reason}));
                                },
                            .silent = {IdOf(2), IdOf(3)}});
    const Outcome outcome = RunBatch(&server, {.jobs = 30});
    EXPECT_EQ(ReasonOf(outcome.status), reason);
    EXPECT_EQ(server.books().streams, 1);
    EXPECT_EQ(outcome.results.size(), outcome.taken);
    EXPECT_TRUE(outcome.Of(0).result.ok());
    EXPECT_EQ(ReasonOf(outcome.Of(2).result.status()), reason);
    EXPECT_EQ(ReasonOf(outcome.Of(4).result.status()), reason);
  }
}

TEST(BatchTest, WithoutAServerItIsUnreachableAtOnceAndNoJobIsTaken) {
  ClientBatch batch(Client::Connect("127.0.0.1:1"));
  const absl::Status status =
      batch.Run({.next = []() -> std::optional<BatchJob> {
                   ADD_FAILURE() << "a job was taken";
                   return std::nullopt;
                 },
                 .on_result = [](const BatchResult&) { return absl::OkStatus(); }});
  EXPECT_EQ(ReasonOf(status), Reason::kUnreachable);
}

TEST(BatchTest, CancelEndsTheJobsUnderWayOnTheServerToo) {
  FakeBatchServer server({.window = 4, .silent = {IdOf(3), IdOf(4), IdOf(5), IdOf(6)}});
  const auto cancel = [](std::size_t number, ClientBatch* batch) {
    // While the source gives its seventh job, three are answered.
    if (number == 6) batch->Cancel();
  };
  const Outcome outcome = RunBatch(&server, {.jobs = 100, .on_take = cancel});
  EXPECT_EQ(outcome.status.code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(outcome.taken, 7U);
  EXPECT_EQ(outcome.results.size(), 7U);
  for (const std::size_t i : {0U, 1U, 2U}) EXPECT_TRUE(outcome.Of(i).result.ok()) << i;
  for (const std::size_t i : {3U, 4U, 5U, 6U}) {
    EXPECT_EQ(outcome.Of(i).result.status().code(), absl::StatusCode::kCancelled) << i;
  }
  for (const std::size_t i : {3U, 4U, 5U}) EXPECT_EQ(server.books().cancelled.count(IdOf(i)), 1U);
}

TEST(BatchTest, CancelDoesNotWaitForAServerThatDoesNotListen) {
  FakeBatchServer server({.window = 2, .silent = {IdOf(0), IdOf(1)}, .deaf = true});
  ClientBatch* running = nullptr;
  std::atomic<bool> taken = false;
  std::thread canceller([&] {
    while (!taken) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    running->Cancel();
  });
  const auto start = std::chrono::steady_clock::now();
  const auto note = [&](std::size_t number, ClientBatch* batch) {
    running = batch;
    taken = number == 1;
  };
  const Outcome outcome = RunBatch(&server, {.jobs = 2, .on_take = note});
  canceller.join();
  EXPECT_EQ(outcome.status.code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(outcome.results.size(), 2U);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(8));
}

TEST(BatchTest, CancelledBeforeItRunsItTakesNothing) {
  FakeBatchServer server({});
  ClientBatch batch(ClientOf(&server), Quick());
  batch.Cancel();
  const absl::Status status =
      batch.Run({.next = []() -> std::optional<BatchJob> {
                   ADD_FAILURE() << "a job was taken";
                   return std::nullopt;
                 },
                 .on_result = [](const BatchResult&) { return absl::OkStatus(); }});
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
}

TEST(BatchTest, WhenAResultIsNotTakenTheBatchEndsWithThat) {
  FakeBatchServer server({.window = 4});
  std::size_t calls = 0;
  const auto refuse = [&](const BatchResult& result, ClientBatch*) {
    ++calls;
    return result.id == IdOf(3) ? absl::DataLossError("full") : absl::OkStatus();
  };
  const Outcome outcome = RunBatch(&server, {.jobs = 30, .on_result = refuse});
  EXPECT_EQ(outcome.status.code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(calls, 4U);
  EXPECT_EQ(server.books().acknowledged.count(IdOf(3)), 0U);
}

TEST(BatchTest, TheDeadlineIsAJobs) {
  FakeBatchServer server({.window = 2, .silent = {IdOf(1)}});
  const auto start = std::chrono::steady_clock::now();
  const Outcome outcome = RunBatch(&server, {.jobs = 6, .deadline = 0.3});
  EXPECT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(ReasonOf(outcome.Of(1).result.status()), Reason::kDeadlineExceeded);
  for (const std::size_t i : {0U, 2U, 3U, 4U, 5U}) EXPECT_TRUE(outcome.Of(i).result.ok()) << i;
  EXPECT_EQ(server.books().cancelled.count(IdOf(1)), 1U);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(4));
}

TEST(BatchTest, OptionsThatMakeNoSenseAreRefused) {
  FakeBatchServer server({});
  BatchOptions options = Quick();
  options.max_tries = 0;
  EXPECT_EQ(ReasonOf(RunBatch(&server, {.options = options}).status), Reason::kInvalidOption);
  ClientBatch batch(ClientOf(&server));
  EXPECT_EQ(ReasonOf(batch.Run({})), Reason::kInvalidOption);
}

TEST(Sha256Test, IsThatOfTheStandard) {
  EXPECT_EQ(absl::BytesToHexString(Sha256().Add("a").Add("bc").Finish()),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(absl::BytesToHexString(Sha256().Finish()),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(JobDigestTest, DependsOnNameHeaderAndMeshAndOnNothingElse) {
  const auto digest = [](std::string_view name, std::uint32_t level, std::uint64_t seed) {
    v1::InterpolateHeader header;
    header.mutable_surface()->set_level(level);
    const absl::StatusOr<MeshUpload> upload = MeshUpload::Make(header, MakeMesh(seed), {});
    EXPECT_TRUE(upload.ok()) << upload.status();
    return JobDigest(name, *upload);
  };
  const std::string one = digest("a", 1, 1);
  EXPECT_EQ(one, digest("a", 1, 1));
  EXPECT_NE(one, digest("b", 1, 1));
  EXPECT_NE(one, digest("a", 2, 1));
  EXPECT_NE(one, digest("a", 1, 2));
}

}  // namespace
}  // namespace limn
