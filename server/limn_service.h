// SPDX-License-Identifier: MIT
// The rpcs of limn.v1.LimnService, each handed on to who does the work.
#pragma once

#include "limn/v1/limn.grpc.pb.h"
#include "server/service_core.h"

namespace limn {

class LimnService final : public v1::LimnService::CallbackService {
 public:
  // core must outlive it.
  explicit LimnService(ServiceCore& core) : core_(core) {}

  grpc::ServerBidiReactor<v1::InterpolateRequest, v1::InterpolateResponse>* Interpolate(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<v1::EvaluateRequest, v1::EvaluateResponse>* Evaluate(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* response) override;

  // Not built yet: UNIMPLEMENTED with their names.
  grpc::ServerBidiReactor<v1::BatchRequest, v1::BatchResponse>* Batch(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* Edit(
      grpc::CallbackServerContext* context) override;

 private:
  ServiceCore& core_;
};

}  // namespace limn
