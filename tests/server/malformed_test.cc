// SPDX-License-Identifier: MIT
// Uploads whose messages are out of order, missing, contradictory or damaged.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "tests/server/service_fixture.h"

namespace limn {
namespace {

using Upload = std::vector<v1::InterpolateRequest>;

struct MalformedCase {
  std::string name;
  // Spoils a header with three chunks.
  std::function<void(Upload&)> spoil;
  Reason reason = Reason::kMalformedRequest;
};

void PrintTo(const MalformedCase& c, std::ostream* out) { *out << c.name; }

class MalformedTest : public testing::TestWithParam<MalformedCase> {};

TEST_P(MalformedTest, IsRefusedWithItsReason) {
  const std::unique_ptr<Server> server = StartServer();
  const PolygonMesh mesh = MakeSphere(100);
  Upload upload = MakeUpload(MakeHeader(1), mesh, 2000);
  ASSERT_GE(upload.size(), 3U);
  GetParam().spoil(upload);
  RawCall call(server->InProcessChannel());
  call.Write(upload);
  call.WritesDone();
  const absl::Status status = call.Finish();
  EXPECT_EQ(ReasonOf(status), GetParam().reason) << status;
  EXPECT_FALSE(status.message().empty());
  EXPECT_EQ(ErrorInfoOf(call.rich_status()).domain(), "limn");
  EXPECT_EQ(ErrorInfoOf(call.rich_status()).reason(), ReasonName(GetParam().reason));
}

std::vector<MalformedCase> Cases() {
  return {
      {"Nothing", [](Upload& u) { u.clear(); }},
      {"EmptyMessageFirst", [](Upload& u) { u.insert(u.begin(), v1::InterpolateRequest()); }},
      {"ChunkFirst", [](Upload& u) { u.erase(u.begin()); }},
      {"SecondHeader", [](Upload& u) { u.insert(u.begin() + 1, u[0]); }},
      {"EmptyMessageBetween", [](Upload& u) { u.insert(u.begin() + 2, v1::InterpolateRequest()); }},
      {"HeaderOnly", [](Upload& u) { u.resize(1); }},
      {"LastChunkMissing", [](Upload& u) { u.pop_back(); }},
      {"ChunkMissing", [](Upload& u) { u.erase(u.begin() + 1); }},
      {"ChunkTwice", [](Upload& u) { u.insert(u.begin() + 1, u[1]); }},
      {"ChunksSwapped", [](Upload& u) { std::swap(u[1], u[2]); }},
      {"EmptyChunk", [](Upload& u) { u[1].mutable_chunk()->clear_data(); }},
      {"LastTooEarly", [](Upload& u) { u[1].mutable_chunk()->set_last(true); }},
      {"MoreThanAnnounced",
       [](Upload& u) { u.back().mutable_chunk()->mutable_data()->append("x"); }},
      {"ByteFlipped", [](Upload& u) { (*u[1].mutable_chunk()->mutable_data())[5] ^= 1; },
       Reason::kChecksumMismatch},
      {"WrongChecksum", [](Upload& u) { u.back().mutable_chunk()->set_xxh3(1); },
       Reason::kChecksumMismatch},
      {"CountsDoNotFit",
       [](Upload& u) { u[0].mutable_header()->mutable_mesh()->set_corner_count(4000); }},
      {"NoVertices", [](Upload& u) { u[0].mutable_header()->mutable_mesh()->set_vertex_count(0); }},
  };
}

INSTANTIATE_TEST_SUITE_P(Uploads, MalformedTest, testing::ValuesIn(Cases()),
                         [](const auto& test) { return test.param.name; });

TEST(UploadTest, AMessageAfterTheLastChunkIsRefused) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  Upload upload = MakeUpload(MakeEndlessHeader(), MakeSphere(20'000));
  upload.push_back(upload.back());
  call.Write(upload);
  EXPECT_EQ(ReasonOf(call.Finish()), Reason::kMalformedRequest);
}

TEST(UploadTest, AnUploadWithoutAnEndOfItsStreamIsEnough) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  ASSERT_TRUE(call.Write(MakeUpload(MakeHeader(1), MakeSphere(100))));
  EXPECT_TRUE(call.Finish().ok()) << call.Finish();
}

TEST(UploadTest, AMessageLargerThanTheLimitEndsTheCall) {
  const std::unique_ptr<Server> server = StartServer();
  RawCall call(server->InProcessChannel());
  v1::InterpolateRequest request;
  request.mutable_chunk()->set_data(std::string(3 << 20, 'x'));
  call.Write(request);
  EXPECT_EQ(call.Finish().code(), absl::StatusCode::kResourceExhausted);
}

TEST(UploadTest, CompressedMessagesAreRefused) {
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 1});
  const auto channel = grpc::CreateChannel("127.0.0.1:" + std::to_string(server->port()),
                                           grpc::InsecureChannelCredentials());
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  const auto stub = v1::LimnService::NewStub(channel);
  const auto stream = stub->Interpolate(&context);
  v1::InterpolateRequest request;
  *request.mutable_header() = MakeHeader(1);
  request.mutable_header()->set_request_id(std::string(100, 'a'));
  stream->Write(request);
  stream->WritesDone();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNIMPLEMENTED);
}

}  // namespace
}  // namespace limn
