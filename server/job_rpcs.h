// SPDX-License-Identifier: MIT
// What the rpcs that run a job differ in, for JobReactor and JobRun: their messages, and their
// jobs.
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "limn/v1/evaluate.pb.h"
#include "limn/v1/interpolate.pb.h"
#include "server/evaluate_job.h"
#include "server/job.h"
#include "server/options_from_proto.h"

namespace limn {

// Header and chunks up, control mesh and surface down.
struct InterpolateRpc {
  using Request = v1::InterpolateRequest;
  using Response = v1::InterpolateResponse;
  using Job = ::limn::Job;
  static constexpr const char* kName = "Interpolate";
  // Whether messages follow the upload.
  static constexpr bool kTakesInput = false;

  // The message as a part of an upload; null when it is none.
  static const v1::InterpolateRequest* UploadPart(const Request& request) { return &request; }
  static absl::StatusOr<JobSpec> Spec(const v1::InterpolateHeader& header) {
    return JobSpecFromProto(header);
  }
};

// One of a batch's jobs; its messages are those of an Interpolate job.
struct BatchJobRpc : InterpolateRpc {
  static constexpr const char* kName = "BatchJob";
};

// Header and chunks up, then parameters; samples down.
struct EvaluateRpc {
  using Request = v1::EvaluateRequest;
  using Response = v1::EvaluateResponse;
  using Job = EvaluateJob;
  static constexpr const char* kName = "Evaluate";
  static constexpr bool kTakesInput = true;

  static const v1::InterpolateRequest* UploadPart(const Request& request) {
    return request.has_job() ? &request.job() : nullptr;
  }
  static absl::StatusOr<JobSpec> Spec(const v1::InterpolateHeader& header) {
    return EvaluateSpecFromProto(header);
  }
};

}  // namespace limn
