// SPDX-License-Identifier: MIT
#include "client/client.h"

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <limits>
#include <thread>
#include <utility>

#include "client/result_collector.h"
#include "engine/base/error.h"
#include "limn/v1/limn.grpc.pb.h"
#include "proto/wire/chunks.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/repair_mapping.h"
#include "proto/wire/status.h"
#include "proto/wire/tile_codec.h"

namespace limn {
namespace {

absl::Status CheckOptions(const ClientOptions& options) {
  if (options.chunk_bytes == 0 || options.chunk_bytes > wire::kMaxChunkBytes) {
    return MakeError("chunk_bytes is not in [1, 1 MiB]",
                     {.reason = Reason::kInvalidOption, .field = "chunk_bytes"});
  }
  if (!(options.deadline_seconds >= 0)) {
    return MakeError("deadline_seconds is negative or no number",
                     {.reason = Reason::kInvalidOption, .field = "deadline_seconds"});
  }
  return absl::OkStatus();
}

void SetDeadline(const ClientOptions& options, grpc::ClientContext* context) {
  // A century is as good as none, and fits the clock.
  constexpr double kLongest = 3e9;
  if (options.deadline_seconds <= 0 || options.deadline_seconds >= kLongest) return;
  context->set_deadline(std::chrono::system_clock::now() +
                        std::chrono::duration_cast<std::chrono::system_clock::duration>(
                            std::chrono::duration<double>(options.deadline_seconds)));
}

}  // namespace

struct ClientJob::Impl {
  using Stream = grpc::ClientReaderWriter<v1::InterpolateRequest, v1::InterpolateResponse>;

  ~Impl() {
    if (!finished) {
      context.TryCancel();
      (void)Finish();
    }
  }

  // Until all is sent or the call has ended; why it ended is for Finish to say.
  void Upload(const v1::InterpolateHeader& header, std::uint32_t chunk_bytes) {
    v1::InterpolateRequest request;
    *request.mutable_header() = header;
    bool ok = stream->Write(request);
    wire::ChunkReader chunks(mesh.bytes, chunk_bytes);
    while (ok && chunks.Next(request.mutable_chunk())) ok = stream->Write(request);
    if (ok) stream->WritesDone();
    std::string().swap(mesh.bytes);
  }

  absl::Status Finish() {
    if (finished) return status;
    finished = true;
    v1::InterpolateResponse dropped;
    while (!all_read && stream->Read(&dropped)) {
    }
    // The call has ended, so that a write that still waits fails now.
    uploader.join();
    status = wire::FromGrpcStatus(stream->Finish());
    return status;
  }

  grpc::ClientContext context;
  std::unique_ptr<v1::LimnService::Stub> stub;
  std::unique_ptr<Stream> stream;
  wire::EncodedMesh mesh;
  std::thread uploader;
  bool all_read = false;
  bool finished = false;
  absl::Status status;
};

ClientJob::ClientJob(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ClientJob::~ClientJob() = default;
ClientJob::ClientJob(ClientJob&&) noexcept = default;
ClientJob& ClientJob::operator=(ClientJob&&) noexcept = default;

std::optional<v1::InterpolateResponse> ClientJob::Next() {
  v1::InterpolateResponse message;
  if (impl_->all_read || impl_->finished) return std::nullopt;
  if (impl_->stream->Read(&message)) return message;
  impl_->all_read = true;
  return std::nullopt;
}

void ClientJob::Cancel() { impl_->context.TryCancel(); }

absl::Status ClientJob::Finish() { return impl_->Finish(); }

Client Client::Connect(const std::string& address, const ClientOptions& options) {
  grpc::ChannelArguments arguments;
  // A proxy from the environment would be asked for this very machine too.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return Client(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments),
                options);
}

Client::Client(std::shared_ptr<grpc::Channel> channel, const ClientOptions& options)
    : channel_(std::move(channel)), options_(options) {}

absl::StatusOr<ClientJob> Client::Submit(v1::InterpolateHeader header,
                                         const PolygonMesh& mesh) const {
  LIMN_RETURN_IF_ERROR(CheckOptions(options_));
  wire::MeshEncodeOptions encode;
  if (header.mesh().encoding() != v1::MESH_ENCODING_UNSPECIFIED) {
    encode.encoding = header.mesh().encoding();
  }
  if (encode.encoding == v1::MESH_ENCODING_DRACO_QUANTIZED &&
      header.output().quantization_bits() != 0) {
    encode.quantization_bits = static_cast<int>(header.output().quantization_bits());
  }
  encode.any_arity = header.output().repair();
  auto impl = std::make_unique<ClientJob::Impl>();
  // Nothing is finished before it has begun.
  impl->finished = true;
  LIMN_ASSIGN_OR_RETURN(impl->mesh, wire::EncodeMesh(Context{}, mesh, encode));
  *header.mutable_mesh() = impl->mesh.header;

  SetDeadline(options_, &impl->context);
  impl->stub = v1::LimnService::NewStub(channel_);
  impl->stream = impl->stub->Interpolate(&impl->context);
  impl->finished = false;
  impl->uploader = std::thread([raw = impl.get(), header = std::move(header),
                                bytes = options_.chunk_bytes] { raw->Upload(header, bytes); });
  return ClientJob(std::move(impl));
}

absl::StatusOr<JobResult> Client::Run(v1::InterpolateHeader header, const PolygonMesh& mesh,
                                      const ProgressCallback& on_progress) const {
  LIMN_ASSIGN_OR_RETURN(ClientJob job, Submit(std::move(header), mesh));
  ResultCollector collector;
  while (std::optional<v1::InterpolateResponse> message = job.Next()) {
    if (message->has_progress() && on_progress && !on_progress(message->progress())) job.Cancel();
    if (absl::Status status = collector.Add(*std::move(message)); !status.ok()) return status;
  }
  LIMN_RETURN_IF_ERROR(job.Finish());
  return collector.Finish();
}

absl::StatusOr<v1::GetServerInfoResponse> Client::GetServerInfo() const {
  LIMN_RETURN_IF_ERROR(CheckOptions(options_));
  grpc::ClientContext context;
  SetDeadline(options_, &context);
  v1::GetServerInfoResponse response;
  const grpc::Status status =
      v1::LimnService::NewStub(channel_)->GetServerInfo(&context, {}, &response);
  if (!status.ok()) return wire::FromGrpcStatus(status);
  return response;
}

}  // namespace limn
