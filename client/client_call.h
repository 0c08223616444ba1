// SPDX-License-Identifier: MIT
// The inside of ClientCall: one thread uploads while the caller reads.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/client.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/limn.grpc.pb.h"
#include "proto/wire/chunks.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/status.h"

namespace limn {

// Errors: INVALID_OPTION.
[[nodiscard]] absl::Status CheckClientOptions(const ClientOptions& options);
// Deadline and metadata.
void PrepareCall(const ClientOptions& options, grpc::ClientContext* context);

// An upload: a header with the counts of its mesh, and the mesh.
struct MeshUpload {
  v1::InterpolateHeader header;
  wire::EncodedMesh mesh;
  std::uint32_t chunk_bytes = 0;

  // Encodes as the header says.
  [[nodiscard]] static absl::StatusOr<MeshUpload> Make(v1::InterpolateHeader header,
                                                       const PolygonMesh& mesh,
                                                       const ClientOptions& options);

  // Calls write(message) for header and chunks until it is false; whether all were written.
  template <class Write>
  bool Send(const Write& write) {
    v1::InterpolateRequest request;
    *request.mutable_header() = header;
    bool ok = write(request);
    wire::ChunkReader chunks(mesh.bytes, chunk_bytes);
    while (ok && chunks.Next(request.mutable_chunk())) ok = write(request);
    std::string().swap(mesh.bytes);
    return ok;
  }
};

template <class Request, class Response>
struct ClientCall<Request, Response>::Impl {
  using Stream = grpc::ClientReaderWriter<Request, Response>;
  // Until all is sent or the call has ended; why it ended is for Finish to say. True: all is sent.
  using Upload = std::function<bool(Stream&)>;
  using Open = std::unique_ptr<Stream> (*)(v1::LimnService::Stub&, grpc::ClientContext*);

  Impl(const std::shared_ptr<grpc::Channel>& channel, const ClientOptions& options, Open open,
       Upload upload)
      : stub(v1::LimnService::NewStub(channel)) {
    PrepareCall(options, &context);
    stream = open(*stub, &context);
    uploader = std::thread([this, upload = std::move(upload)] {
      if (upload(*stream)) stream->WritesDone();
    });
  }

  ~Impl() {
    if (!finished) {
      context.TryCancel();
      (void)Finish();
    }
  }

  absl::Status Finish() {
    if (finished) return status;
    finished = true;
    Response dropped;
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
  std::thread uploader;
  bool all_read = false;
  bool finished = false;
  absl::Status status;
};

template <class Request, class Response>
ClientCall<Request, Response>::ClientCall(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
template <class Request, class Response>
ClientCall<Request, Response>::~ClientCall() = default;
template <class Request, class Response>
ClientCall<Request, Response>::ClientCall(ClientCall&&) noexcept = default;
template <class Request, class Response>
ClientCall<Request, Response>& ClientCall<Request, Response>::operator=(ClientCall&&) noexcept =
    default;

template <class Request, class Response>
std::optional<Response> ClientCall<Request, Response>::Next() {
  Response message;
  if (impl_->all_read || impl_->finished) return std::nullopt;
  if (impl_->stream->Read(&message)) return message;
  impl_->all_read = true;
  return std::nullopt;
}

template <class Request, class Response>
void ClientCall<Request, Response>::Cancel() {
  impl_->context.TryCancel();
}

template <class Request, class Response>
absl::Status ClientCall<Request, Response>::Finish() {
  return impl_->Finish();
}

}  // namespace limn
