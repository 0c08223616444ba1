// SPDX-License-Identifier: MIT
// The rpcs of limn.v1.LimnService, each handed on to who does the work.
#pragma once

#include "limn/v1/limn.grpc.pb.h"
#include "server/kept_jobs.h"
#include "server/service_core.h"

namespace limn {

class LimnService final : public v1::LimnService::CallbackService {
 public:
  // core must outlive it.
  explicit LimnService(ServiceCore& core) : core_(core), kept_(core.limits.resume_seconds) {}

  grpc::ServerBidiReactor<v1::InterpolateRequest, v1::InterpolateResponse>* Interpolate(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<v1::EvaluateRequest, v1::EvaluateResponse>* Evaluate(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* response) override;

  grpc::ServerBidiReactor<v1::BatchRequest, v1::BatchResponse>* Batch(
      grpc::CallbackServerContext* context) override;
  // Not built yet: UNIMPLEMENTED with its name.
  grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* Edit(
      grpc::CallbackServerContext* context) override;

  // The jobs that wait for their clients to come back.
  KeptJobs& kept_jobs() { return kept_; }

 private:
  ServiceCore& core_;
  KeptJobs kept_;
};

}  // namespace limn
