// SPDX-License-Identifier: MIT
// Many jobs on one stream: each gets the answer that it gets alone, one's failure is not another's,
// the client is held back rather than refused, and jobs with a digest survive their stream.
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/result_collector.h"
#include "proto/wire/status.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using std::chrono::milliseconds;

std::vector<v1::BatchRequest> JobUpload(const std::string& id, const v1::InterpolateHeader& header,
                                        const PolygonMesh& mesh, const std::string& digest = "") {
  std::vector<v1::BatchRequest> messages;
  for (v1::InterpolateRequest& part : MakeUpload(header, mesh)) {
    v1::BatchRequest& message = messages.emplace_back();
    message.set_job_id(id);
    if (part.has_header()) message.set_digest(digest);
    *message.mutable_request() = std::move(part);
  }
  return messages;
}

std::string Digest(std::string text) {
  text.resize(32, '.');
  return text;
}

v1::BatchRequest Acknowledge(const std::string& id) {
  v1::BatchRequest message;
  message.set_job_id(id);
  message.mutable_acknowledge();
  return message;
}

v1::BatchRequest Cancel(const std::string& id) {
  v1::BatchRequest message;
  message.set_job_id(id);
  message.mutable_cancel();
  return message;
}

// What came back, put together.
struct Answers {
  std::map<std::string, JobResult> results;
  std::map<std::string, absl::Status> errors;
  std::map<std::string, int> accepted;
  std::map<std::string, int> resumed;
  v1::BatchProgress totals;
  std::map<std::string, ResultCollector> open;

  // The id of the job that it completed, or "".
  std::string Take(v1::BatchResponse message) {
    const std::string id = message.job_id();
    if (message.has_progress()) totals = message.progress();
    if (message.has_error()) {
      EXPECT_TRUE(errors.emplace(id, wire::FromRichStatus(message.error())).second) << id;
      return id;
    }
    if (!message.has_response()) return "";
    v1::InterpolateResponse& response = *message.mutable_response();
    if (response.has_accepted()) {
      ++accepted[id];
      resumed[id] += response.accepted().resumed() ? 1 : 0;
    }
    const bool last = response.has_summary();
    const absl::Status status = open[id].Add(std::move(response));
    EXPECT_TRUE(status.ok()) << status;
    if (!last) return "";
    absl::StatusOr<JobResult> result = open[id].Finish();
    open.erase(id);
    EXPECT_TRUE(result.ok()) << result.status();
    EXPECT_TRUE(results.emplace(id, *std::move(result)).second) << id;
    return id;
  }
  void TakeAll(RawBatch* batch) {
    while (std::optional<v1::BatchResponse> message = batch->Read()) Take(*std::move(message));
  }
  // Until this job has been answered.
  void TakeUntil(RawBatch* batch, const std::string& id) {
    while (std::optional<v1::BatchResponse> message = batch->Read()) {
      if (Take(*std::move(message)) == id) return;
    }
    ADD_FAILURE() << "the stream ended before the answer of " << id << ": " << batch->Finish();
  }
};

void ExpectSame(const JobResult& a, const JobResult& b) {
  EXPECT_EQ(a.control_mesh.positions, b.control_mesh.positions);
  EXPECT_EQ(a.control_mesh.corner_vertex, b.control_mesh.corner_vertex);
  EXPECT_EQ(a.surface.positions, b.surface.positions);
  EXPECT_EQ(a.surface.normals, b.surface.normals);
  EXPECT_EQ(a.surface.face_vertices, b.surface.face_vertices);
}

JobResult Alone(Server& server, const v1::InterpolateHeader& header, const PolygonMesh& mesh) {
  absl::StatusOr<JobResult> result = Client(server.InProcessChannel()).Run(header, mesh);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

std::string Name(int i) { return absl::StrCat("job-", i); }

// Sends while it reads.
Answers RunAll(RawBatch* batch, const std::vector<std::vector<v1::BatchRequest>>& jobs) {
  std::thread sender([&] {
    for (const auto& job : jobs) {
      if (!batch->Write(job)) return;
    }
    batch->WritesDone();
  });
  Answers answers;
  answers.TakeAll(batch);
  sender.join();
  return answers;
}

TEST(BatchTest, EveryJobGetsTheAnswerThatItGetsAlone) {
  const std::unique_ptr<Server> server = StartServer();
  RawBatch batch(server->InProcessChannel());
  std::vector<std::vector<v1::BatchRequest>> jobs;
  for (int i = 0; i < 60; ++i) {
    jobs.push_back(JobUpload(Name(i), MakeHeader(i % 3), MakeSphere(40 + i, i + 1)));
  }
  const Answers answers = RunAll(&batch, jobs);
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  ASSERT_EQ(answers.results.size(), jobs.size());
  EXPECT_TRUE(answers.errors.empty());
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    ExpectSame(answers.results.at(Name(i)),
               Alone(*server, MakeHeader(i % 3), MakeSphere(40 + i, i + 1)));
  }
  EXPECT_EQ(answers.totals.received(), 60U);
  EXPECT_EQ(answers.totals.succeeded(), 60U);
  EXPECT_EQ(answers.totals.failed(), 0U);
}

TEST(BatchTest, AJobsFailureIsItsOwn) {
  const std::unique_ptr<Server> server = StartServer();
  RawBatch batch(server->InProcessChannel());
  PolygonMesh broken = MakeSphere(50);
  broken.positions[3].x = std::numeric_limits<double>::quiet_NaN();
  v1::InterpolateHeader wrong = MakeHeader(1);
  wrong.mutable_solve()->set_tolerance(7);
  v1::InterpolateHeader large = MakeHeader(1);
  std::vector<v1::BatchRequest> too_large = JobUpload("large", large, MakeSphere(50));
  too_large[0].mutable_request()->mutable_header()->mutable_mesh()->set_byte_count(1ULL << 45);
  std::vector<v1::BatchRequest> cut_short = JobUpload("cut", MakeHeader(1), MakeSphere(50));
  cut_short.pop_back();
  const Answers answers =
      RunAll(&batch,
             {JobUpload("a", MakeHeader(1), MakeSphere(50)),
              JobUpload("broken", MakeHeader(1), broken), JobUpload("wrong", wrong, MakeSphere(50)),
              too_large, cut_short, JobUpload("b", MakeHeader(1), MakeSphere(50))});
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  EXPECT_EQ(answers.results.size(), 2U);
  EXPECT_TRUE(answers.results.contains("a"));
  EXPECT_TRUE(answers.results.contains("b"));
  ASSERT_EQ(answers.errors.size(), 4U);
  EXPECT_EQ(answers.errors.at("broken").code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(GetErrorDetail(answers.errors.at("wrong"))->field, "solve.tolerance");
  EXPECT_EQ(ReasonOf(answers.errors.at("large")), Reason::kLimitExceeded);
  EXPECT_EQ(ReasonOf(answers.errors.at("cut")), Reason::kMalformedRequest);
  EXPECT_EQ(answers.totals.received(), 6U);
  EXPECT_EQ(answers.totals.succeeded(), 2U);
  EXPECT_EQ(answers.totals.failed(), 4U);
}

TEST(BatchTest, IdsMayBeUsedAgainAfterTheAnswer) {
  const std::unique_ptr<Server> server = StartServer();
  RawBatch batch(server->InProcessChannel());
  for (int i = 0; i < 3; ++i) {
    Answers answers;
    ASSERT_TRUE(batch.Write(JobUpload("same", MakeHeader(1), MakeSphere(50 + i))));
    answers.TakeUntil(&batch, "same");
    EXPECT_EQ(answers.results.size(), 1U);
  }
}

TEST(BatchTest, JobsAreHeldBackAndNotRefusedForWantOfRoom) {
  ServerOptions options{.threads = 2};
  options.limits.batch_window = 3;
  options.limits.workers = 1;
  options.limits.queue_length = 0;
  options.limits.max_uploads = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch one(server->InProcessChannel());
  RawBatch two(server->InProcessChannel());
  std::vector<std::vector<v1::BatchRequest>> jobs;
  for (int i = 0; i < 20; ++i) jobs.push_back(JobUpload(Name(i), MakeHeader(1), MakeSphere(60)));
  Answers of_one;
  std::thread other([&] { of_one = RunAll(&one, jobs); });
  const Answers of_two = RunAll(&two, jobs);
  other.join();
  for (const Answers* answers : {&std::as_const(of_one), &of_two}) {
    EXPECT_EQ(answers->results.size(), 20U);
    for (const auto& [id, status] : answers->errors) ADD_FAILURE() << id << ": " << status;
  }
}

TEST(BatchTest, ASlowReaderIsSentNoMoreThanItsWindow) {
  ServerOptions options{.threads = 2};
  options.limits.batch_window = 2;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  std::atomic<int> sent = 0;
  std::vector<std::vector<v1::BatchRequest>> jobs;
  for (int i = 0; i < 40; ++i) jobs.push_back(JobUpload(Name(i), MakeHeader(3), MakeSphere(2000)));
  std::thread sender([&] {
    for (const auto& job : jobs) {
      if (!batch.Write(job)) return;
      ++sent;
    }
    batch.WritesDone();
  });
  // Nothing is read: the sender comes to a stop.
  int before = -1;
  while (sent != before) {
    before = sent;
    std::this_thread::sleep_for(milliseconds(400));
  }
  EXPECT_LT(sent, 20);
  Answers answers;
  answers.TakeAll(&batch);
  sender.join();
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  EXPECT_EQ(answers.results.size(), 40U);
}

TEST(BatchTest, CancelEndsOneJobWhereverItIs) {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  ASSERT_TRUE(batch.Write(JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000))));
  ASSERT_TRUE(batch.Write(JobUpload("queued", MakeHeader(1), MakeSphere(60))));
  std::vector<v1::BatchRequest> half = JobUpload("half", MakeHeader(1), MakeSphere(5000));
  half.pop_back();
  ASSERT_TRUE(batch.Write(half));
  Answers answers;
  // It runs.
  bool running = false;
  while (!running) {
    std::optional<v1::BatchResponse> message = batch.Read();
    ASSERT_TRUE(message.has_value());
    running = message->job_id() == "endless" && message->response().progress().sweep() > 0;
    answers.Take(*std::move(message));
  }
  for (const char* id : {"half", "queued", "endless", "nobody"}) {
    ASSERT_TRUE(batch.Write(Cancel(id)));
  }
  ASSERT_TRUE(batch.Write(JobUpload("last", MakeHeader(1), MakeSphere(60))));
  batch.WritesDone();
  answers.TakeAll(&batch);
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  for (const char* id : {"half", "queued", "endless"}) {
    ASSERT_TRUE(answers.errors.contains(id)) << id;
    EXPECT_EQ(answers.errors.at(id).code(), absl::StatusCode::kCancelled);
  }
  EXPECT_EQ(answers.errors.size(), 3U);
  EXPECT_TRUE(answers.results.contains("last"));
}

TEST(BatchTest, MessagesThatMakeNoSenseEndTheCall) {
  const std::unique_ptr<Server> server = StartServer();
  const std::vector<v1::BatchRequest> good = JobUpload("good", MakeHeader(1), MakeSphere(5000));
  std::vector<std::vector<v1::BatchRequest>> bad;
  bad.push_back({good[0]});
  bad.back()[0].clear_job_id();
  bad.push_back({good[0]});
  bad.back()[0].set_job_id(std::string(129, 'x'));
  bad.push_back({good[0]});
  bad.back()[0].set_job_id("two words");
  bad.push_back({good[1]});
  bad.push_back({good[0], good[0]});
  bad.push_back({good[0]});
  bad.back()[0].clear_request();
  bad.push_back({good[0]});
  bad.back()[0].mutable_request()->clear_header();
  for (std::size_t i = 0; i < bad.size(); ++i) {
    SCOPED_TRACE(i);
    RawBatch batch(server->InProcessChannel());
    batch.Write(bad[i]);
    batch.WritesDone();
    EXPECT_EQ(ReasonOf(batch.Finish()), Reason::kMalformedRequest);
    EXPECT_EQ(batch.Finish().code(), absl::StatusCode::kInvalidArgument);
  }
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
}

TEST(BatchTest, AVanishedClientFreesItsJobs) {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.queue_length = 0;
  options.limits.interactive_milliseconds = 0;
  const std::unique_ptr<Server> server = StartServer(options);
  {
    RawBatch batch(server->InProcessChannel());
    ASSERT_TRUE(batch.Write(JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000))));
    while (!batch.Read()->response().has_progress()) {
    }
  }
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
}

// The stages at which a stream may break.
enum class BrokenAt { kUpload, kRun, kAnswer, kAnswered };
class ResumeTest : public testing::TestWithParam<BrokenAt> {};

TEST_P(ResumeTest, AJobWithADigestIsTakenUpAndNotDoneTwice) {
  const EventLog log;
  ServerOptions options{.threads = 2};
  options.log = log.log();
  const std::unique_ptr<Server> server = StartServer(options);
  v1::InterpolateHeader header = MakeHeader(3);
  header.mutable_output()->set_tile_bytes(16 << 10);
  const PolygonMesh mesh = MakeSphere(3000);
  std::vector<v1::BatchRequest> upload = JobUpload("job", header, mesh, Digest("digest"));
  const bool complete = GetParam() != BrokenAt::kUpload;
  {
    RawBatch batch(server->InProcessChannel());
    if (!complete) upload.pop_back();
    ASSERT_TRUE(batch.Write(upload));
    Answers answers;
    for (bool enough = false; !enough;) {
      std::optional<v1::BatchResponse> message = batch.Read();
      ASSERT_TRUE(message.has_value());
      const v1::InterpolateResponse& response = message->response();
      enough = GetParam() == BrokenAt::kAnswer     ? response.has_tile()
               : GetParam() == BrokenAt::kAnswered ? response.has_summary()
                                                   : response.has_accepted();
      answers.Take(*std::move(message));
    }
    batch.Cancel();
  }
  // The server needs a moment to see it, during which the header waits.
  RawBatch batch(server->InProcessChannel());
  upload = JobUpload("job", header, mesh, Digest("digest"));
  // What was there is taken up without its mesh; chunks are dropped.
  ASSERT_TRUE(complete ? batch.Write(upload.front()) : batch.Write(upload));
  Answers answers;
  answers.TakeUntil(&batch, "job");
  ASSERT_TRUE(batch.Write(Acknowledge("job")));
  batch.WritesDone();
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  EXPECT_EQ(answers.resumed["job"], complete ? 1 : 0);
  ASSERT_TRUE(answers.results.contains("job"));
  ExpectSame(answers.results.at("job"), Alone(*server, header, mesh));
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
}
std::string StageName(const testing::TestParamInfo<BrokenAt>& stage) {
  constexpr const char* kNames[] = {"Upload", "Run", "Answer", "Answered"};
  return kNames[static_cast<int>(stage.param)];
}
INSTANTIATE_TEST_SUITE_P(Stages, ResumeTest,
                         testing::Values(BrokenAt::kUpload, BrokenAt::kRun, BrokenAt::kAnswer,
                                         BrokenAt::kAnswered),
                         StageName);

TEST(BatchResumeTest, AnotherDigestIsAnotherJob) {
  const std::unique_ptr<Server> server = StartServer();
  {
    RawBatch batch(server->InProcessChannel());
    ASSERT_TRUE(batch.Write(JobUpload("job", MakeHeader(1), MakeSphere(60), Digest("one"))));
    Answers answers;
    answers.TakeUntil(&batch, "job");
    batch.Cancel();
  }
  RawBatch batch(server->InProcessChannel());
  ASSERT_TRUE(batch.Write(JobUpload("job", MakeHeader(1), MakeSphere(61), Digest("two"))));
  Answers answers;
  answers.TakeUntil(&batch, "job");
  EXPECT_EQ(answers.resumed["job"], 0);
  ExpectSame(answers.results.at("job"), Alone(*server, MakeHeader(1), MakeSphere(61)));
}

TEST(BatchResumeTest, AnAcknowledgedAnswerIsForgotten) {
  const std::unique_ptr<Server> server = StartServer();
  {
    RawBatch batch(server->InProcessChannel());
    ASSERT_TRUE(batch.Write(JobUpload("job", MakeHeader(1), MakeSphere(60), Digest("one"))));
    Answers answers;
    answers.TakeUntil(&batch, "job");
    ASSERT_TRUE(batch.Write(Acknowledge("job")));
    batch.WritesDone();
    EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  }
  RawBatch batch(server->InProcessChannel());
  ASSERT_TRUE(batch.Write(JobUpload("job", MakeHeader(1), MakeSphere(60), Digest("one"))));
  Answers answers;
  answers.TakeUntil(&batch, "job");
  EXPECT_EQ(answers.resumed["job"], 0);
}

TEST(BatchResumeTest, AnswersWithoutAcknowledgementDoNotFillTheWindow) {
  ServerOptions options{.threads = 2};
  options.limits.batch_window = 2;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  std::vector<std::vector<v1::BatchRequest>> jobs;
  for (int i = 0; i < 12; ++i) {
    jobs.push_back(JobUpload(Name(i), MakeHeader(1), MakeSphere(60), Digest("digest")));
  }
  const Answers answers = RunAll(&batch, jobs);
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  EXPECT_EQ(answers.results.size(), 12U);
}

TEST(BatchResumeTest, JobsOfAClientThatDoesNotComeBackAreEnded) {
  const EventLog log;
  ServerOptions options{.threads = 2};
  options.limits.resume_seconds = 0;
  options.limits.workers = 1;
  options.limits.queue_length = 0;
  options.limits.interactive_milliseconds = 0;
  options.log = log.log();
  const std::unique_ptr<Server> server = StartServer(options);
  {
    RawBatch batch(server->InProcessChannel());
    ASSERT_TRUE(
        batch.Write(JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000), Digest("d"))));
    while (!batch.Read()->response().has_progress()) {
    }
    batch.Cancel();
  }
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
  EXPECT_NE(log.WaitFor("did not come back"), "");
}

TEST(BatchResumeTest, DigestsOfOtherLengthsAreRefused) {
  const std::unique_ptr<Server> server = StartServer();
  RawBatch batch(server->InProcessChannel());
  const Answers answers =
      RunAll(&batch, {JobUpload("short", MakeHeader(1), MakeSphere(60), std::string(15, 'x')),
                      JobUpload("long", MakeHeader(1), MakeSphere(60), std::string(65, 'x')),
                      JobUpload("right", MakeHeader(1), MakeSphere(60), std::string(16, 'x'))});
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  EXPECT_TRUE(answers.results.contains("right"));
  for (const char* id : {"short", "long"}) {
    ASSERT_TRUE(answers.errors.contains(id));
    EXPECT_EQ(GetErrorDetail(answers.errors.at(id))->field, "digest");
  }
}

TEST(BatchResumeTest, NobodyEndsOrGetsAnothersJobByItsId) {
  const std::unique_ptr<Server> server = StartServer();
  const v1::InterpolateHeader header = MakeHeader(1);
  RawBatch one(server->InProcessChannel());
  RawBatch two(server->InProcessChannel());
  Answers of_one;
  Answers of_two;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(one.Write(JobUpload(Name(i), header, MakeSphere(60 + i), Digest("one"))));
    ASSERT_TRUE(two.Write(JobUpload(Name(i), header, MakeSphere(80 + i), Digest("two"))));
    of_one.TakeUntil(&one, Name(i));
    of_two.TakeUntil(&two, Name(i));
    ExpectSame(of_one.results.at(Name(i)), Alone(*server, header, MakeSphere(60 + i)));
    ExpectSame(of_two.results.at(Name(i)), Alone(*server, header, MakeSphere(80 + i)));
  }
}

TEST(BatchResumeTest, TheVerySameJobOfTwoCallsWaitsForOneAndIsRefusedInTheEnd) {
  ServerOptions options{.threads = 2};
  options.limits.queue_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch one(server->InProcessChannel());
  ASSERT_TRUE(
      one.Write(JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000), Digest("d"))));
  Answers of_one;
  of_one.Take(*one.Read());
  RawBatch two(server->InProcessChannel());
  const Answers of_two =
      RunAll(&two, {JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000), Digest("d")),
                    JobUpload("other", MakeHeader(1), MakeSphere(60))});
  ASSERT_TRUE(of_two.errors.contains("endless"));
  EXPECT_EQ(GetErrorDetail(of_two.errors.at("endless"))->field, "job_id");
  EXPECT_TRUE(GetErrorDetail(of_two.errors.at("endless"))->retryable);
  EXPECT_TRUE(of_two.results.contains("other"));
}

TEST(BatchTest, CancelAndAcknowledgeGetPastAHeaderThatWaits) {
  ServerOptions options{.threads = 2};
  options.limits.batch_window = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  Answers answers;
  ASSERT_TRUE(batch.Write(JobUpload("kept", MakeHeader(1), MakeSphere(60), Digest("d"))));
  answers.TakeUntil(&batch, "kept");
  ASSERT_TRUE(batch.Write(JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000))));
  ASSERT_TRUE(batch.Write(JobUpload("waits", MakeHeader(1), MakeSphere(60)).front()));
  ASSERT_TRUE(batch.Write(Acknowledge("kept")));
  ASSERT_TRUE(batch.Write(Cancel("waits")));
  answers.TakeUntil(&batch, "waits");
  ASSERT_TRUE(batch.Write(JobUpload("next", MakeHeader(1), MakeSphere(60)).front()));
  ASSERT_TRUE(batch.Write(Cancel("endless")));
  answers.TakeUntil(&batch, "endless");
  for (const char* id : {"waits", "endless"}) {
    EXPECT_EQ(answers.errors.at(id).code(), absl::StatusCode::kCancelled);
  }
  ASSERT_TRUE(batch.Write(JobUpload("next", MakeHeader(1), MakeSphere(60)).back()));
  answers.TakeUntil(&batch, "next");
  EXPECT_TRUE(answers.results.contains("next"));
}

TEST(BatchTest, AHeaderThatWaitsWhenTheStreamEndsFailsForItsMesh) {
  ServerOptions options{.threads = 2};
  options.limits.batch_window = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  // A place that becomes free only after the end has been read: by an answer that is taken late.
  ASSERT_TRUE(batch.Write(JobUpload("first", MakeHeader(3), MakeSphere(3000))));
  ASSERT_TRUE(batch.Write(JobUpload("half", MakeHeader(1), MakeSphere(60)).front()));
  batch.WritesDone();
  Answers answers;
  answers.TakeAll(&batch);
  EXPECT_TRUE(batch.Finish().ok()) << batch.Finish();
  EXPECT_TRUE(answers.results.contains("first"));
  ASSERT_TRUE(answers.errors.contains("half"));
  EXPECT_EQ(ReasonOf(answers.errors.at("half")), Reason::kMalformedRequest);
}

TEST(BatchTest, ErrorsThatNobodyTakesHoldTheClientBack) {
  ServerOptions options{.threads = 2};
  options.limits.stall_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  v1::BatchRequest header = JobUpload("bad", MakeHeader(1), MakeSphere(60)).front();
  header.mutable_request()->mutable_header()->mutable_solve()->set_tolerance(7);
  int sent = 0;
  // Ended by the server, since nothing is read.
  while (sent < 100'000 && batch.Write(header)) ++sent;
  EXPECT_LT(sent, 10'000);
}

TEST(BatchTest, AnUploadMayWaitBehindACancelledOne) {
  ServerOptions options{.threads = 2};
  options.limits.stall_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  ASSERT_TRUE(batch.Write(JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000))));
  ASSERT_TRUE(batch.Write(JobUpload("half", MakeHeader(1), MakeSphere(5000)).front()));
  ASSERT_TRUE(batch.Write(Cancel("half")));
  Answers answers;
  answers.TakeUntil(&batch, "half");
  // The client's turn is over: it reads, and has nothing to send.
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(3);
  while (std::chrono::steady_clock::now() < until) {
    std::optional<v1::BatchResponse> message = batch.Read();
    ASSERT_TRUE(message.has_value()) << batch.Finish();
    answers.Take(*std::move(message));
  }
  ASSERT_TRUE(batch.Write(JobUpload("next", MakeHeader(1), MakeSphere(5000))));
  answers.TakeUntil(&batch, "next");
  EXPECT_TRUE(answers.results.contains("next"));
}

TEST(BatchTest, JobsWaitForTheirOwnStreamsOthersWithoutEnd) {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_seconds = 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  ASSERT_TRUE(batch.Write(JobUpload("endless", MakeEndlessHeader(), MakeSphere(20'000))));
  ASSERT_TRUE(batch.Write(JobUpload("behind", MakeHeader(1), MakeSphere(60))));
  std::thread canceller([&] {
    std::this_thread::sleep_for(milliseconds(2500));
    batch.Write(Cancel("endless"));
  });
  Answers answers;
  answers.TakeUntil(&batch, "behind");
  canceller.join();
  EXPECT_TRUE(answers.results.contains("behind"));
}

TEST(BatchTest, EachJobHasItsLineInTheLog) {
  const EventLog log;
  ServerOptions options{.threads = 2};
  options.log = log.log();
  const std::unique_ptr<Server> server = StartServer(options);
  RawBatch batch(server->InProcessChannel());
  ASSERT_TRUE(batch.Write(JobUpload("job-7", MakeHeader(1), MakeSphere(60), Digest("d"))));
  Answers answers;
  answers.TakeUntil(&batch, "job-7");
  // Before it is acknowledged.
  const std::string line = log.WaitFor(" job_id=job-7 ");
  EXPECT_NE(line.find("/job-7 "), std::string::npos) << line;
  EXPECT_NE(line.find("BatchJob"), std::string::npos) << line;
}

TEST(BatchDrainTest, WhatWasTakenIsAnsweredAndTheRestIsSentElsewhere) {
  const std::unique_ptr<Server> server = StartServer();
  RawBatch batch(server->InProcessChannel());
  ASSERT_TRUE(batch.Write(JobUpload("taken", MakeHeader(4), MakeSphere(3000))));
  Answers answers;
  answers.Take(*batch.Read());
  ASSERT_EQ(answers.accepted["taken"], 1);
  server->Drain();
  std::thread sender([&] { batch.Write(JobUpload("late", MakeHeader(1), MakeSphere(60))); });
  answers.TakeAll(&batch);
  sender.join();
  EXPECT_TRUE(answers.results.contains("taken"));
  EXPECT_FALSE(answers.results.contains("late"));
  EXPECT_EQ(ReasonOf(batch.Finish()), Reason::kShuttingDown);
  EXPECT_TRUE(HasRetryInfo(batch.rich_status()));

  RawBatch another(server->InProcessChannel());
  EXPECT_EQ(ReasonOf(another.Finish()), Reason::kShuttingDown);
  server->Shutdown(std::chrono::seconds(10));
}

}  // namespace
}  // namespace limn
