// SPDX-License-Identifier: MIT
// A server inside the test, and calls to it with messages made by hand.
#pragma once

#include <grpcpp/grpcpp.h>

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/client.h"
#include "engine/base/error.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/error_details.pb.h"
#include "limn/v1/limn.grpc.pb.h"
#include "server/server.h"

namespace limn {

// A closed mesh of irregular polygons.
PolygonMesh MakeSphere(std::uint64_t vertices, std::uint64_t seed = 1);

// A header that asks for everything, packed.
v1::InterpolateHeader MakeHeader(std::uint32_t level);

// The messages of a well-formed upload: header, then chunks.
std::vector<v1::InterpolateRequest> MakeUpload(v1::InterpolateHeader header,
                                               const PolygonMesh& mesh,
                                               std::size_t chunk_bytes = 64 << 10);

// A header that asks for nothing: for Evaluate.
v1::InterpolateHeader MakeEvaluateHeader();

// A header for a job that runs for minutes if nobody stops it.
v1::InterpolateHeader MakeEndlessHeader();

// One call whose messages the test makes.
template <class Request, class Response>
class RawStream {
 public:
  explicit RawStream(const std::shared_ptr<grpc::Channel>& channel,
                     std::chrono::milliseconds deadline = std::chrono::seconds(60));
  ~RawStream();

  // False: the call has ended.
  bool Write(const Request& request) { return stream_->Write(request); }
  bool Write(const std::vector<Request>& requests);
  void WritesDone() { stream_->WritesDone(); }
  std::optional<Response> Read();
  void Cancel() { context_.TryCancel(); }

  // Reads and drops the rest. Safe to call again.
  absl::Status Finish();
  // After Finish: the details that came along.
  v1::RichStatus rich_status();

 private:
  grpc::ClientContext context_;
  std::unique_ptr<v1::LimnService::Stub> stub_;
  std::unique_ptr<grpc::ClientReaderWriter<Request, Response>> stream_;
  std::optional<grpc::Status> status_;
};
using RawCall = RawStream<v1::InterpolateRequest, v1::InterpolateResponse>;
using RawEvaluation = RawStream<v1::EvaluateRequest, v1::EvaluateResponse>;
using RawBatch = RawStream<v1::BatchRequest, v1::BatchResponse>;

// The same upload, as Evaluate takes it.
std::vector<v1::EvaluateRequest> MakeEvaluateUpload(v1::InterpolateHeader header,
                                                    const PolygonMesh& mesh);

// Keeps the lines that a server logs.
class EventLog {
 public:
  EventLog();
  // For ServerOptions.
  const std::shared_ptr<Log>& log() const { return log_; }
  // The first line that holds the text; empty when none comes within some seconds.
  std::string WaitFor(const std::string& text) const;

 private:
  struct Lines;
  std::shared_ptr<Lines> lines_;
  std::shared_ptr<Log> log_;
};

// The reason of an error; kInternal's neighbour "nothing" is an ok status, which fails the test.
Reason ReasonOf(const absl::Status& status);

// The ErrorInfo of an error; empty when there is none.
v1::ErrorDetails ErrorInfoOf(const v1::RichStatus& status);
// Whether an error tells when to try again.
bool HasRetryInfo(const v1::RichStatus& status);

// One unary or one-message call with hand-made bytes.
struct RawAnswer {
  grpc::Status status;
  std::string bytes;
};
RawAnswer CallRaw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                  const std::string& request);

// "SERVING", "NOT_SERVING" or the error of grpc.health.v1.Health/Check.
std::string Health(const std::shared_ptr<grpc::Channel>& channel, const std::string& service = "");

// Starts a server with these options, in process; a failure fails the test.
std::unique_ptr<Server> StartServer(const ServerOptions& options = {.threads = 2});

// Whether a new job finds a place within some seconds.
bool PlaceBecomesFree(const std::shared_ptr<grpc::Channel>& channel);

}  // namespace limn
