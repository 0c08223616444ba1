// SPDX-License-Identifier: MIT
#include "client/client.h"

#include <grpcpp/grpcpp.h>

#include <limits>
#include <memory>
#include <utility>

#include "client/client_call.h"
#include "engine/base/error.h"
#include "limn/v1/limn.grpc.pb.h"
#include "proto/wire/chunks.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/status.h"
#include "proto/wire/tile_codec.h"

namespace limn {
namespace {

absl::Status BadAnswer(std::string_view message) {
  return MakeError(message, {.reason = Reason::kMalformedRequest,
                             .remedy = "Is this a server of another version?"});
}

// Puts an answer together.
class ResultCollector {
 public:
  ResultCollector()
      : surface_(std::numeric_limits<Index>::max(), std::numeric_limits<Index>::max()) {}

  absl::Status Add(const v1::InterpolateResponse& message) {
    if (message.has_control_mesh()) return AddControlMesh(message.control_mesh());
    if (message.has_tile()) {
      has_surface_ = true;
      return surface_.Add(message.tile());
    }
    if (message.has_summary()) {
      has_summary_ = true;
      result_.summary = message.summary();
    }
    return absl::OkStatus();
  }

  absl::StatusOr<JobResult> Finish() {
    if (!has_summary_) return BadAnswer("the answer has no summary");
    if (control_bytes_.has_value() && !control_bytes_->complete()) {
      return BadAnswer("the answer's control mesh is not complete");
    }
    if (has_surface_) {
      LIMN_ASSIGN_OR_RETURN(result_.surface, surface_.Finish());
      result_.surface.level = result_.summary.level();
      if (result_.surface.vertex_count() != result_.summary.surface_vertices()) {
        return BadAnswer("the answer's surface is not complete");
      }
    }
    return std::move(result_);
  }

 private:
  absl::Status AddControlMesh(const v1::ControlMeshPart& part) {
    if (part.has_header()) {
      LIMN_RETURN_IF_ERROR(wire::CheckHeader(Limits{}, part.header()));
      control_header_ = part.header();
      control_bytes_.emplace(part.header().byte_count());
      return absl::OkStatus();
    }
    if (!control_bytes_.has_value()) return BadAnswer("the answer's control mesh has no header");
    LIMN_RETURN_IF_ERROR(control_bytes_->Add(part.chunk()));
    if (!control_bytes_->complete()) return absl::OkStatus();
    LIMN_ASSIGN_OR_RETURN(result_.control_mesh, wire::DecodeMesh(Context{}, control_header_,
                                                                 control_bytes_->TakeBytes()));
    return absl::OkStatus();
  }

  JobResult result_;
  v1::MeshHeader control_header_;
  std::optional<wire::ChunkAssembler> control_bytes_;
  wire::SurfaceAssembler surface_;
  bool has_surface_ = false;
  bool has_summary_ = false;
};

}  // namespace

template class ClientCall<v1::InterpolateRequest, v1::InterpolateResponse>;

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
  LIMN_ASSIGN_OR_RETURN(MeshUpload made, MeshUpload::Make(std::move(header), mesh, options_));
  const auto upload = std::make_shared<MeshUpload>(std::move(made));
  return ClientJob(std::make_unique<ClientJob::Impl>(
      channel_, options_,
      [](v1::LimnService::Stub& stub, grpc::ClientContext* context) {
        return stub.Interpolate(context);
      },
      [upload](ClientJob::Impl::Stream& stream) {
        return upload->Send([&](const v1::InterpolateRequest& part) { return stream.Write(part); });
      }));
}

absl::StatusOr<JobResult> Client::Run(v1::InterpolateHeader header, const PolygonMesh& mesh,
                                      const ProgressCallback& on_progress) const {
  LIMN_ASSIGN_OR_RETURN(ClientJob job, Submit(std::move(header), mesh));
  ResultCollector collector;
  while (const std::optional<v1::InterpolateResponse> message = job.Next()) {
    if (message->has_progress() && on_progress && !on_progress(message->progress())) job.Cancel();
    if (absl::Status status = collector.Add(*message); !status.ok()) return status;
  }
  LIMN_RETURN_IF_ERROR(job.Finish());
  return collector.Finish();
}

absl::StatusOr<v1::GetServerInfoResponse> Client::GetServerInfo() const {
  LIMN_RETURN_IF_ERROR(CheckClientOptions(options_));
  grpc::ClientContext context;
  SetDeadline(options_, &context);
  v1::GetServerInfoResponse response;
  const grpc::Status status =
      v1::LimnService::NewStub(channel_)->GetServerInfo(&context, {}, &response);
  if (!status.ok()) return wire::FromGrpcStatus(status);
  return response;
}

}  // namespace limn
