// SPDX-License-Identifier: MIT
// The rpc Evaluate: what it answers, what it refuses, and that it holds no more than it may.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "engine/interpolate.h"
#include "engine/limit/evaluate.h"
#include "engine/mesh/generate.h"
#include "proto/wire/samples.h"
#include "tests/oracle/test_meshes.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using std::chrono::milliseconds;

std::vector<SurfaceParameter> SomeParameters(const PolygonMesh& mesh, std::size_t n) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<SurfaceParameter> parameters(n);
  for (SurfaceParameter& p : parameters) {
    p.face = static_cast<Index>(random() % mesh.face_count());
    p.corner = static_cast<Index>(random() % mesh.face(p.face).size());
    p.u = coordinate(random);
    p.v = random() % 5 == 0 ? 0 : coordinate(random);
  }
  return parameters;
}

v1::EvaluateRequest MakeBlock(const std::vector<SurfaceParameter>& parameters) {
  v1::EvaluateRequest request;
  wire::WriteParameters(parameters, request.mutable_parameters());
  return request;
}

std::vector<v1::EvaluateRequest> MakeBlocks(const std::vector<SurfaceParameter>& parameters,
                                            std::size_t size) {
  std::vector<v1::EvaluateRequest> blocks;
  for (std::size_t begin = 0; begin < parameters.size(); begin += size) {
    const auto first = parameters.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto count = std::min(size, parameters.size() - begin);
    blocks.push_back(MakeBlock({first, first + static_cast<std::ptrdiff_t>(count)}));
  }
  return blocks;
}

// What the engine says by itself.
wire::SampleArrays Expected(const PolygonMesh& mesh,
                            const std::vector<SurfaceParameter>& parameters,
                            InterpolateOptions options = {}) {
  const Context context;
  options.level = 0;
  options.keep_patches = true;
  auto result = Interpolate(context, mesh, options);
  EXPECT_TRUE(result.ok()) << result.status();
  wire::SampleArrays samples;
  samples.Resize(parameters.size());
  EXPECT_TRUE(EvaluateSurface(context, *result->patches, parameters, samples.Spans()).ok());
  return samples;
}

// One place in the lane and none to wait: one that is not given back is noticed at once.
ServerOptions OnePlace() {
  ServerOptions options{.threads = 2};
  options.limits.workers = 1;
  options.limits.interactive_milliseconds = 0;
  options.limits.queue_length = 0;
  return options;
}

struct Answer {
  std::size_t accepted = 0;
  std::size_t messages = 0;
  std::size_t largest = 0;
  wire::SampleArrays samples;
  std::optional<v1::Summary> summary;
};

// Reads to the end, checking the order of what comes.
Answer ReadAll(RawEvaluation& call) {
  Answer answer;
  while (const std::optional<v1::EvaluateResponse> message = call.Read()) {
    EXPECT_FALSE(answer.summary.has_value()) << "a message after the summary";
    if (message->has_accepted()) {
      ++answer.accepted;
      EXPECT_EQ(answer.messages, 0U);
    } else if (message->has_summary()) {
      answer.summary = message->summary();
    } else if (!message->has_progress()) {
      ++answer.messages;
      answer.largest = std::max(answer.largest, message->positions().size() * 4);
      EXPECT_TRUE(wire::DecodeSamples(*message, &answer.samples).ok());
    }
  }
  return answer;
}

// Writes on another thread, as a client has to that sends more than the server holds.
Answer Ask(RawEvaluation& call, const std::vector<v1::EvaluateRequest>& requests) {
  std::thread writer([&] {
    if (call.Write(requests)) call.WritesDone();
  });
  Answer answer = ReadAll(call);
  writer.join();
  return answer;
}

std::vector<v1::EvaluateRequest> Joined(std::vector<v1::EvaluateRequest> upload,
                                        const std::vector<v1::EvaluateRequest>& blocks) {
  upload.insert(upload.end(), blocks.begin(), blocks.end());
  return upload;
}

void ExpectEqual(const wire::SampleArrays& a, const wire::SampleArrays& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.du, b.du);
  EXPECT_EQ(a.dv, b.dv);
  EXPECT_EQ(a.normals, b.normals);
}

TEST(EvaluateTest, AnswersAreTheEnginesToTheBitInTheirOrder) {
  const std::unique_ptr<Server> server = StartServer();
  const auto disk = GenerateMesh({.kind = MeshKind::kDisk, .vertices = 300});
  ASSERT_TRUE(disk.ok());
  for (const PolygonMesh& mesh : {MakeSphere(300), *disk}) {
    const std::vector<SurfaceParameter> parameters = SomeParameters(mesh, 20'000);
    const wire::SampleArrays expected = Expected(mesh, parameters);
    for (const std::size_t block : {1'000, 7'001, 20'000}) {
      RawEvaluation call(server->InProcessChannel());
      const Answer answer = Ask(call, Joined(MakeEvaluateUpload(MakeEvaluateHeader(), mesh),
                                             MakeBlocks(parameters, block)));
      ASSERT_TRUE(call.Finish().ok()) << call.Finish();
      EXPECT_EQ(answer.accepted, 1U);
      ExpectEqual(answer.samples, expected);
      ASSERT_TRUE(answer.summary.has_value());
    }
  }
}

// With a normal, whose control points are those of the twice refined mesh.
TEST(EvaluateTest, CatmullClarkAndLoopAreEvaluatedToo) {
  const std::unique_ptr<Server> server = StartServer();
  const PolygonMesh triangles = oracle::Triangulated(MakeSphere(300));
  for (const bool normal : {false, true}) {
    for (const v1::Scheme scheme : {v1::SCHEME_CATMULL_CLARK, v1::SCHEME_LOOP}) {
      const bool loop = scheme == v1::SCHEME_LOOP;
      const PolygonMesh mesh = loop ? triangles : MakeSphere(300);
      std::vector<SurfaceParameter> parameters = SomeParameters(mesh, 2'000);
      for (SurfaceParameter& p : parameters) {
        if (loop && p.u + p.v > 1) std::tie(p.u, p.v) = std::pair(1 - p.u, 1 - p.v);
      }
      InterpolateOptions options = {.scheme = loop ? Scheme::kLoop : Scheme::kCatmullClark};
      v1::InterpolateHeader header = MakeEvaluateHeader();
      header.set_scheme(scheme);
      if (normal) {
        options.constraints.normals = {{7, {1, 2, 3}}};
        v1::NormalConstraint* entry = header.mutable_constraints()->add_normals();
        entry->set_vertex(7);
        entry->mutable_normal()->set_x(1);
        entry->mutable_normal()->set_y(2);
        entry->mutable_normal()->set_z(3);
      }
      RawEvaluation call(server->InProcessChannel());
      const Answer answer =
          Ask(call, Joined(MakeEvaluateUpload(header, mesh), MakeBlocks(parameters, 700)));
      ASSERT_TRUE(call.Finish().ok()) << call.Finish();
      ExpectEqual(answer.samples, Expected(mesh, parameters, options));
      EXPECT_EQ(answer.summary->has_blend(), normal);
    }
  }
}

TEST(EvaluateTest, SummaryTellsOfJobAndAnswers) {
  const std::unique_ptr<Server> server = StartServer();
  const PolygonMesh mesh = MakeSphere(300);
  const std::vector<SurfaceParameter> parameters = SomeParameters(mesh, 100);
  v1::InterpolateHeader header = MakeEvaluateHeader();
  header.set_request_id("job-7");
  RawEvaluation call(server->InProcessChannel());
  const Answer answer =
      Ask(call, Joined(MakeEvaluateUpload(header, mesh), MakeBlocks(parameters, 50)));
  ASSERT_TRUE(answer.summary.has_value()) << call.Finish();
  EXPECT_EQ(answer.summary->request_id(), "job-7");
  EXPECT_EQ(answer.summary->input_vertices(), 300U);
  EXPECT_EQ(answer.summary->surface_vertices(), 0U);
  EXPECT_EQ(answer.summary->certificate().points_checked(), 300U);
  EXPECT_LE(answer.summary->certificate().max_error(), 1e-12);
  EXPECT_EQ(answer.summary->bytes_sent(), 100 * wire::kSampleBytes);
  EXPECT_GT(answer.summary->bytes_received(), 0U);
  std::vector<std::string> stages;
  for (const v1::StageTime& stage : answer.summary->stages()) stages.push_back(stage.stage());
  EXPECT_EQ(std::count(stages.begin(), stages.end(), "evaluate"), 1) << stages.size();
  EXPECT_EQ(std::count(stages.begin(), stages.end(), "solve"), 1);
}

TEST(EvaluateTest, MessagesAreBoundedByTileBytes) {
  const std::unique_ptr<Server> server = StartServer();
  const PolygonMesh mesh = MakeSphere(100);
  const std::vector<SurfaceParameter> parameters = SomeParameters(mesh, 30'000);
  v1::InterpolateHeader header = MakeEvaluateHeader();
  for (const std::uint32_t bytes : {0U, 4U << 10}) {
    header.mutable_output()->set_tile_bytes(bytes);
    RawEvaluation call(server->InProcessChannel());
    const Answer answer =
        Ask(call, Joined(MakeEvaluateUpload(header, mesh), MakeBlocks(parameters, 30'000)));
    EXPECT_EQ(answer.samples.points.size(), parameters.size()) << call.Finish();
    EXPECT_LE(answer.largest, bytes == 0 ? 512U << 10 : bytes);
    EXPECT_GT(answer.messages, 1U);
  }
}

TEST(EvaluateTest, NoParametersOrEmptyBlocksGiveTheSummaryAlone) {
  const std::unique_ptr<Server> server = StartServer();
  const std::vector<v1::EvaluateRequest> upload =
      MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100));
  for (const std::size_t blocks : {0, 1, 5}) {
    RawEvaluation call(server->InProcessChannel());
    const Answer answer =
        Ask(call, Joined(upload, std::vector<v1::EvaluateRequest>(blocks, MakeBlock({}))));
    EXPECT_TRUE(call.Finish().ok()) << call.Finish();
    EXPECT_EQ(answer.messages, 0U);
    EXPECT_TRUE(answer.summary.has_value());
  }
}

TEST(EvaluateTest, QuestionsMayFollowAnswers) {
  const std::unique_ptr<Server> server = StartServer();
  const PolygonMesh mesh = MakeSphere(100);
  const std::vector<SurfaceParameter> parameters = SomeParameters(mesh, 50);
  const wire::SampleArrays expected = Expected(mesh, parameters);
  RawEvaluation call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(MakeEvaluateUpload(MakeEvaluateHeader(), mesh)));
  wire::SampleArrays samples;
  for (const v1::EvaluateRequest& block : MakeBlocks(parameters, 1)) {
    ASSERT_TRUE(call.Write(block));
    std::optional<v1::EvaluateResponse> answer;
    do {
      answer = call.Read();
      ASSERT_TRUE(answer.has_value()) << call.Finish();
    } while (answer->positions().empty());
    ASSERT_TRUE(wire::DecodeSamples(*answer, &samples).ok());
  }
  call.WritesDone();
  EXPECT_TRUE(call.Finish().ok());
  ExpectEqual(samples, expected);
}

struct RefusalCase {
  std::string name;
  Reason reason;
  // Spoils header, chunk, block, block.
  std::function<void(std::vector<v1::EvaluateRequest>&)> spoil;
  std::string field = {};
};
void PrintTo(const RefusalCase& c, std::ostream* out) { *out << c.name; }

class EvaluateRefusalTest : public testing::TestWithParam<RefusalCase> {};

TEST_P(EvaluateRefusalTest, IsRefusedWithItsReasonAndField) {
  const std::unique_ptr<Server> server = StartServer();
  const PolygonMesh mesh = MakeSphere(100);
  const std::vector<SurfaceParameter> parameters = SomeParameters(mesh, 40);
  std::vector<v1::EvaluateRequest> requests =
      Joined(MakeEvaluateUpload(MakeEvaluateHeader(), mesh), MakeBlocks(parameters, 20));
  ASSERT_EQ(requests.size(), 4U);
  GetParam().spoil(requests);
  RawEvaluation call(server->InProcessChannel());
  Ask(call, requests);
  const absl::Status status = call.Finish();
  EXPECT_EQ(ReasonOf(status), GetParam().reason) << status;
  EXPECT_EQ(GetErrorDetail(status)->field, GetParam().field) << status;
  EXPECT_EQ(ErrorInfoOf(call.rich_status()).reason(), ReasonName(GetParam().reason));
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
}

using Requests = std::vector<v1::EvaluateRequest>;
v1::OutputOptions* Output(Requests& r) {
  return r[0].mutable_job()->mutable_header()->mutable_output();
}

std::vector<RefusalCase> Refusals() {
  constexpr Reason kMalformed = Reason::kMalformedRequest;
  return {
      {"Nothing", kMalformed, [](Requests& r) { r.clear(); }},
      {"EmptyMessageFirst", kMalformed, [](Requests& r) { r.insert(r.begin(), {{}}); }},
      {"ParametersFirst", kMalformed, [](Requests& r) { std::swap(r[0], r[2]); }},
      {"ParametersBeforeTheMesh", kMalformed, [](Requests& r) { std::swap(r[1], r[2]); }},
      {"EmptyMessageBeforeTheMesh", kMalformed, [](Requests& r) { r.insert(r.begin() + 1, {{}}); }},
      {"SecondHeaderBeforeTheMesh", kMalformed,
       [](Requests& r) { r.insert(r.begin() + 1, {r[0]}); }},
      {"SecondHeaderAfterTheMesh", kMalformed,
       [](Requests& r) { r.insert(r.begin() + 2, {r[0]}); }},
      {"ChunkAfterTheMesh", kMalformed, [](Requests& r) { r.push_back(r[1]); }},
      {"EmptyMessageBetweenParameters", kMalformed,
       [](Requests& r) { r.insert(r.begin() + 3, {{}}); }},
      {"MeshIsMissing", kMalformed, [](Requests& r) { r.resize(1); }},
      {"ArraysDoNotFit", kMalformed,
       [](Requests& r) { r[3].mutable_parameters()->mutable_u()->RemoveLast(); }, "parameters.u"},
      {"FaceOutOfRange", Reason::kIndexOutOfRange,
       [](Requests& r) { r[3].mutable_parameters()->set_faces(4, 1'000'000); },
       "parameters[24].face"},
      {"CornerOutOfRange", Reason::kIndexOutOfRange,
       [](Requests& r) { r[2].mutable_parameters()->set_corners(0, 9); }, "parameters[0].corner"},
      {"CoordinateOutOfRange", Reason::kInvalidOption,
       [](Requests& r) { r[3].mutable_parameters()->set_v(19, 1.5); }, "parameters[39].v"},
      {"Surface", Reason::kInvalidOption, [](Requests& r) { Output(r)->set_surface(true); },
       "output.surface"},
      {"ControlMesh", Reason::kInvalidOption,
       [](Requests& r) { Output(r)->set_control_mesh(true); }, "output.control_mesh"},
      {"QuantisedMesh", Reason::kInvalidOption,
       [](Requests& r) {
         r[0].mutable_job()->mutable_header()->mutable_mesh()->set_encoding(
             v1::MESH_ENCODING_DRACO_QUANTIZED);
       },
       "mesh.encoding"},
      {"LoopOfPolygons", Reason::kInvalidOption,
       [](Requests& r) { r[0].mutable_job()->mutable_header()->set_scheme(v1::SCHEME_LOOP); },
       "mesh.faces"},
  };
}
INSTANTIATE_TEST_SUITE_P(Calls, EvaluateRefusalTest, testing::ValuesIn(Refusals()),
                         [](const auto& test) { return test.param.name; });

TEST(EvaluateAdmissionTest, TheSurfaceThatIsKeptCountsAsMemory) {
  const PolygonMesh mesh = MakeSphere(20'000);
  ServerOptions options{.threads = 2};
  const std::vector<v1::EvaluateRequest> upload = MakeEvaluateUpload(MakeEvaluateHeader(), mesh);
  std::uint64_t bytes = 0;
  {
    const std::unique_ptr<Server> server = StartServer(options);
    RawEvaluation call(server->InProcessChannel());
    ASSERT_TRUE(call.Write(upload));
    const std::optional<v1::EvaluateResponse> accepted = call.Read();
    ASSERT_TRUE(accepted.has_value() && accepted->has_accepted()) << call.Finish();
    bytes = accepted->accepted().estimated_bytes();
  }
  options.limits.max_job_bytes = bytes - 1;
  const std::unique_ptr<Server> server = StartServer(options);
  RawEvaluation call(server->InProcessChannel());
  call.Write(upload.front());
  EXPECT_EQ(ReasonOf(call.Finish()), Reason::kLimitExceeded);
  EXPECT_EQ(GetErrorDetail(call.Finish())->limit, "max-job-bytes");
}

TEST(EvaluateAdmissionTest, AFullLaneRefusesIt) {
  const std::unique_ptr<Server> server = StartServer(OnePlace());
  RawCall running(server->InProcessChannel());
  ASSERT_TRUE(running.Write(MakeUpload(MakeEndlessHeader(), MakeSphere(20'000))));
  // Until its mesh has arrived it holds no place.
  for (std::string stage; stage != "solve";) {
    const std::optional<v1::InterpolateResponse> message = running.Read();
    ASSERT_TRUE(message.has_value()) << running.Finish();
    stage = message->progress().stage();
  }
  RawEvaluation call(server->InProcessChannel());
  call.Write(MakeEvaluateUpload(MakeEvaluateHeader(), MakeSphere(100)).front());
  EXPECT_EQ(ReasonOf(call.Finish()), Reason::kLimitExceeded);
  EXPECT_TRUE(HasRetryInfo(call.rich_status()));
}

TEST(EvaluateAdmissionTest, AClientThatAsksSlowlyHoldsNoWorker) {
  const std::unique_ptr<Server> server = StartServer(OnePlace());
  const PolygonMesh mesh = MakeSphere(100);
  RawEvaluation call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(MakeEvaluateUpload(MakeEvaluateHeader(), mesh)));
  EXPECT_TRUE(PlaceBecomesFree(server->InProcessChannel()));
  const std::vector<SurfaceParameter> parameters = SomeParameters(mesh, 10);
  const Answer answer = Ask(call, MakeBlocks(parameters, 10));
  EXPECT_TRUE(call.Finish().ok()) << call.Finish();
  ExpectEqual(answer.samples, Expected(mesh, parameters));
}

}  // namespace
}  // namespace limn
