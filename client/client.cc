// SPDX-License-Identifier: MIT
#include "client/client.h"

#include <grpcpp/grpcpp.h>

#include <memory>
#include <utility>

#include "client/client_call.h"
#include "client/result_collector.h"
#include "client/retry.h"
#include "engine/base/error.h"
#include "limn/v1/limn.grpc.pb.h"
#include "proto/wire/status.h"

namespace limn {
namespace {

// One attempt. *stopped: whether on_progress gave up.
absl::StatusOr<JobResult> RunOnce(const Client& client, const v1::InterpolateHeader& header,
                                  const PolygonMesh& mesh,
                                  const Client::ProgressCallback& on_progress, bool* stopped) {
  LIMN_ASSIGN_OR_RETURN(ClientJob job, client.Submit(header, mesh));
  ResultCollector collector;
  while (std::optional<v1::InterpolateResponse> message = job.Next()) {
    if (message->has_progress() && on_progress && !on_progress(message->progress())) {
      *stopped = true;
      job.Cancel();
    }
    if (absl::Status status = collector.Add(*std::move(message)); !status.ok()) return status;
  }
  LIMN_RETURN_IF_ERROR(job.Finish());
  return collector.Finish();
}

}  // namespace

template class ClientCall<v1::InterpolateRequest, v1::InterpolateResponse>;

Client Client::Connect(const std::string& address, const ClientOptions& options) {
  absl::StatusOr<std::shared_ptr<grpc::Channel>> channel = MakeChannel(address, {});
  // What is no address of ours may be one of gRPC's, or fails with the first call.
  if (!channel.ok()) channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
  return Client(*std::move(channel), options);
}

absl::StatusOr<Client> Client::ConnectSecurely(const std::string& address,
                                               const ClientSecurity& security,
                                               ClientOptions options) {
  LIMN_ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel, MakeChannel(address, security));
  LIMN_ASSIGN_OR_RETURN(std::string authorization, ReadAuthorization(address, security));
  if (!authorization.empty()) {
    options.metadata.emplace_back("authorization", std::move(authorization));
  }
  return Client(std::move(channel), options);
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

absl::StatusOr<JobResult> Client::Run(const v1::InterpolateHeader& header, const PolygonMesh& mesh,
                                      const ProgressCallback& on_progress) const {
  bool stopped = false;
  Attempts attempts(options_, [&stopped] { return stopped; });
  while (true) {
    absl::StatusOr<JobResult> result =
        RunOnce(With(attempts.NextOptions()), header, mesh, on_progress, &stopped);
    if (result.ok() || stopped || !attempts.Again(result.status())) return result;
  }
}

absl::StatusOr<v1::GetServerInfoResponse> Client::GetServerInfo() const {
  LIMN_RETURN_IF_ERROR(CheckClientOptions(options_));
  grpc::ClientContext context;
  PrepareCall(options_, &context);
  v1::GetServerInfoResponse response;
  const grpc::Status status =
      v1::LimnService::NewStub(channel_)->GetServerInfo(&context, {}, &response);
  if (!status.ok()) return wire::FromGrpcStatus(status);
  return response;
}

}  // namespace limn
