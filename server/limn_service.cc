// SPDX-License-Identifier: MIT
#include "server/limn_service.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/status.h"
#include "server/batch_reactor.h"
#include "server/caller.h"
#include "server/job_reactor.h"
#include "server/job_rpcs.h"
#include "server/server_info.h"

namespace limn {
namespace {

// Answers a stream with an error, whatever it carries.
template <class Request, class Response>
class RefusingReactor final : public grpc::ServerBidiReactor<Request, Response> {
 public:
  explicit RefusingReactor(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

absl::Status NotBuilt(const std::string& rpc) {
  return MakeError(absl::StrCat("the rpc ", rpc, " is not implemented yet"),
                   {.reason = Reason::kUnimplemented,
                    .field = rpc,
                    .remedy = "GetServerInfo lists the rpcs that are"});
}

// What a call without a stream of its own answers: that it is not authorized, or `answer`.
grpc::Status Answer(ServiceCore& core, grpc::CallbackServerContext* context, const char* rpc,
                    const absl::Status& answer) {
  const Caller caller = IdentifyCaller(*context, core.tokens.get());
  context->AddTrailingMetadata(kRequestIdKey, caller.request_id);
  core.metrics.CountRequest(rpc, caller.authorized.ok() ? answer : caller.authorized);
  return wire::ToGrpcStatus(caller.authorized.ok() ? answer : caller.authorized, caller.request_id);
}

}  // namespace

grpc::ServerBidiReactor<v1::InterpolateRequest, v1::InterpolateResponse>* LimnService::Interpolate(
    grpc::CallbackServerContext* context) {
  return JobReactor<InterpolateRpc>::Create(core_, context);
}

grpc::ServerUnaryReactor* LimnService::GetServerInfo(grpc::CallbackServerContext* context,
                                                     const v1::GetServerInfoRequest* /*request*/,
                                                     v1::GetServerInfoResponse* response) {
  const grpc::Status status = Answer(core_, context, "GetServerInfo", absl::OkStatus());
  if (status.ok()) *response = MakeServerInfo(core_.limits, core_.threads);
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

grpc::ServerBidiReactor<v1::BatchRequest, v1::BatchResponse>* LimnService::Batch(
    grpc::CallbackServerContext* context) {
  return BatchReactor::Create(core_, kept_, context);
}

grpc::ServerBidiReactor<v1::EvaluateRequest, v1::EvaluateResponse>* LimnService::Evaluate(
    grpc::CallbackServerContext* context) {
  return JobReactor<EvaluateRpc>::Create(core_, context);
}

grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* LimnService::Edit(
    grpc::CallbackServerContext* context) {
  return new RefusingReactor<v1::EditRequest, v1::EditResponse>(
      Answer(core_, context, "Edit", NotBuilt("Edit")));
}

}  // namespace limn
