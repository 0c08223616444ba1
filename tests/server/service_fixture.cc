// SPDX-License-Identifier: MIT
#include "tests/server/service_fixture.h"

#include <grpcpp/generic/generic_stub.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "engine/mesh/generate.h"
#include "proto/wire/chunks.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/status.h"

namespace limn {

PolygonMesh MakeSphere(std::uint64_t vertices, std::uint64_t seed) {
  absl::StatusOr<PolygonMesh> mesh =
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices, .seed = seed});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

v1::InterpolateHeader MakeHeader(std::uint32_t level) {
  v1::InterpolateHeader header;
  header.set_scheme(v1::SCHEME_DOO_SABIN);
  header.mutable_surface()->set_level(level);
  header.mutable_output()->set_control_mesh(true);
  header.mutable_output()->set_surface(true);
  header.mutable_output()->set_normals(true);
  return header;
}

v1::InterpolateHeader MakeEvaluateHeader() {
  v1::InterpolateHeader header = MakeHeader(0);
  header.clear_output();
  return header;
}

v1::InterpolateHeader MakeEndlessHeader() {
  v1::InterpolateHeader header = MakeHeader(1);
  header.mutable_solve()->set_tolerance(0);
  header.mutable_solve()->set_max_sweeps(10'000);
  header.mutable_solve()->set_method(v1::SolveOptions::METHOD_GAUSS_SEIDEL);
  return header;
}

std::vector<v1::InterpolateRequest> MakeUpload(v1::InterpolateHeader header,
                                               const PolygonMesh& mesh, std::size_t chunk_bytes) {
  wire::MeshEncodeOptions options;
  if (header.mesh().encoding() != v1::MESH_ENCODING_UNSPECIFIED) {
    options.encoding = header.mesh().encoding();
  }
  const absl::StatusOr<wire::EncodedMesh> encoded = wire::EncodeMesh(Context{}, mesh, options);
  EXPECT_TRUE(encoded.ok()) << encoded.status();
  *header.mutable_mesh() = encoded->header;
  std::vector<v1::InterpolateRequest> upload(1);
  *upload[0].mutable_header() = std::move(header);
  wire::ChunkReader chunks(encoded->bytes, chunk_bytes);
  v1::InterpolateRequest request;
  while (chunks.Next(request.mutable_chunk())) upload.push_back(request);
  return upload;
}

std::vector<v1::EvaluateRequest> MakeEvaluateUpload(v1::InterpolateHeader header,
                                                    const PolygonMesh& mesh) {
  std::vector<v1::EvaluateRequest> upload;
  for (v1::InterpolateRequest& part : MakeUpload(std::move(header), mesh)) {
    *upload.emplace_back().mutable_job() = std::move(part);
  }
  return upload;
}

namespace {

auto Open(v1::LimnService::Stub& stub, grpc::ClientContext* context, v1::InterpolateRequest*) {
  return stub.Interpolate(context);
}
auto Open(v1::LimnService::Stub& stub, grpc::ClientContext* context, v1::EvaluateRequest*) {
  return stub.Evaluate(context);
}
auto Open(v1::LimnService::Stub& stub, grpc::ClientContext* context, v1::BatchRequest*) {
  return stub.Batch(context);
}

}  // namespace

template <class Request, class Response>
RawStream<Request, Response>::RawStream(const std::shared_ptr<grpc::Channel>& channel,
                                        std::chrono::milliseconds deadline)
    : stub_(v1::LimnService::NewStub(channel)) {
  context_.set_deadline(std::chrono::system_clock::now() + deadline);
  stream_ = Open(*stub_, &context_, static_cast<Request*>(nullptr));
}

template <class Request, class Response>
RawStream<Request, Response>::~RawStream() {
  context_.TryCancel();
  (void)Finish();
}

template <class Request, class Response>
bool RawStream<Request, Response>::Write(const std::vector<Request>& requests) {
  for (const Request& request : requests) {
    if (!Write(request)) return false;
  }
  return true;
}

template <class Request, class Response>
std::optional<Response> RawStream<Request, Response>::Read() {
  Response response;
  if (!stream_->Read(&response)) return std::nullopt;
  return response;
}

template <class Request, class Response>
absl::Status RawStream<Request, Response>::Finish() {
  if (!status_.has_value()) {
    while (Read().has_value()) {
    }
    status_ = stream_->Finish();
  }
  return wire::FromGrpcStatus(*status_);
}

template <class Request, class Response>
v1::RichStatus RawStream<Request, Response>::rich_status() {
  v1::RichStatus rich;
  EXPECT_TRUE(rich.ParseFromString(status_->error_details()));
  return rich;
}

template class RawStream<v1::InterpolateRequest, v1::InterpolateResponse>;
template class RawStream<v1::EvaluateRequest, v1::EvaluateResponse>;
template class RawStream<v1::BatchRequest, v1::BatchResponse>;

struct EventLog::Lines {
  std::mutex mutex;
  std::vector<std::string> text;
};

EventLog::EventLog()
    : lines_(std::make_shared<Lines>()),
      log_(Log::ToFunction([lines = lines_](std::string_view line) {
        const std::lock_guard lock(lines->mutex);
        lines->text.emplace_back(line);
      })) {}

std::string EventLog::WaitFor(const std::string& text) const {
  for (int attempt = 0; attempt < 500; ++attempt) {
    {
      const std::lock_guard lock(lines_->mutex);
      for (const std::string& line : lines_->text) {
        if (line.find(text) != std::string::npos) return line;
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return "";
}

Reason ReasonOf(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  EXPECT_TRUE(detail.has_value()) << "there is no error";
  return detail.has_value() ? detail->reason : Reason::kInternal;
}

v1::ErrorDetails ErrorInfoOf(const v1::RichStatus& status) {
  v1::ErrorDetails info;
  for (const google::protobuf::Any& any : status.details()) {
    if (any.type_url() == "type.googleapis.com/google.rpc.ErrorInfo") {
      EXPECT_TRUE(info.ParseFromString(any.value()));
    }
  }
  return info;
}

bool HasRetryInfo(const v1::RichStatus& status) {
  for (const google::protobuf::Any& any : status.details()) {
    if (any.type_url() == "type.googleapis.com/google.rpc.RetryInfo") return true;
  }
  return false;
}

RawAnswer CallRaw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                  const std::string& request) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
  grpc::CompletionQueue queue;
  const grpc::Slice slice(request);
  const grpc::ByteBuffer buffer(&slice, 1);
  const auto next = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  auto call = stub.PrepareCall(&context, method, &queue);
  call->StartCall(nullptr);
  next();
  call->WriteLast(buffer, grpc::WriteOptions(), nullptr);
  next();
  RawAnswer answer;
  grpc::ByteBuffer received;
  call->Read(&received, nullptr);
  if (next()) {
    std::vector<grpc::Slice> slices;
    EXPECT_TRUE(received.Dump(&slices).ok());
    for (const grpc::Slice& part : slices) {
      answer.bytes.append(reinterpret_cast<const char*>(part.begin()), part.size());
    }
  }
  call->Finish(&answer.status, nullptr);
  next();
  return answer;
}

std::string Health(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  // HealthCheckRequest{service = 1}; HealthCheckResponse{status = 1}.
  std::string request;
  if (!service.empty()) {
    request = std::string("\x0a") + static_cast<char>(service.size()) + service;
  }
  const RawAnswer answer = CallRaw(channel, "/grpc.health.v1.Health/Check", request);
  if (!answer.status.ok()) return answer.status.error_message();
  if (answer.bytes == std::string("\x08\x01")) return "SERVING";
  if (answer.bytes == std::string("\x08\x02")) return "NOT_SERVING";
  return "another answer";
}

std::unique_ptr<Server> StartServer(const ServerOptions& options) {
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  EXPECT_TRUE(server.ok()) << server.status();
  return *std::move(server);
}

bool PlaceBecomesFree(const std::shared_ptr<grpc::Channel>& channel) {
  const std::vector<v1::InterpolateRequest> upload = MakeUpload(MakeHeader(0), MakeSphere(32));
  for (int attempt = 0; attempt < 200; ++attempt) {
    RawCall call(channel);
    call.Write(upload);
    call.WritesDone();
    if (call.Finish().ok()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  return false;
}

}  // namespace limn
