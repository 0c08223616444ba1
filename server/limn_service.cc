// SPDX-License-Identifier: MIT
#include "server/limn_service.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/status.h"
#include "server/job_reactor.h"
#include "server/job_rpcs.h"
#include "server/server_info.h"

namespace limn {
namespace {

// Answers a stream with an error, whatever it carries.
template <class Request, class Response>
class RefusingReactor final : public grpc::ServerBidiReactor<Request, Response> {
 public:
  explicit RefusingReactor(const absl::Status& status) { this->Finish(wire::ToGrpcStatus(status)); }
  void OnDone() override { delete this; }
};

absl::Status NotBuilt(const std::string& rpc) {
  return MakeError(absl::StrCat("the rpc ", rpc, " is not implemented yet"),
                   {.reason = Reason::kUnimplemented,
                    .field = rpc,
                    .remedy = "GetServerInfo lists the rpcs that are"});
}

}  // namespace

grpc::ServerBidiReactor<v1::InterpolateRequest, v1::InterpolateResponse>* LimnService::Interpolate(
    grpc::CallbackServerContext* context) {
  return JobReactor<InterpolateRpc>::Create(core_, context);
}

grpc::ServerUnaryReactor* LimnService::GetServerInfo(grpc::CallbackServerContext* context,
                                                     const v1::GetServerInfoRequest* /*request*/,
                                                     v1::GetServerInfoResponse* response) {
  *response = MakeServerInfo(core_.limits, core_.threads);
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerBidiReactor<v1::BatchRequest, v1::BatchResponse>* LimnService::Batch(
    grpc::CallbackServerContext* /*context*/) {
  return new RefusingReactor<v1::BatchRequest, v1::BatchResponse>(NotBuilt("Batch"));
}

grpc::ServerBidiReactor<v1::EvaluateRequest, v1::EvaluateResponse>* LimnService::Evaluate(
    grpc::CallbackServerContext* context) {
  return JobReactor<EvaluateRpc>::Create(core_, context);
}

grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* LimnService::Edit(
    grpc::CallbackServerContext* /*context*/) {
  return new RefusingReactor<v1::EditRequest, v1::EditResponse>(NotBuilt("Edit"));
}

}  // namespace limn
