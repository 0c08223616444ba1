// SPDX-License-Identifier: MIT
// One Evaluate call: finds the surface, then answers blocks of parameters. Knows nothing of gRPC.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/limit/evaluate.h"
#include "limn/v1/evaluate.pb.h"
#include "proto/wire/samples.h"
#include "server/job.h"
#include "server/options_from_proto.h"

namespace limn {

// First Decode, then Run, then NextMessage until it has no more, with input whenever NeedsInput.
// Not thread-safe, but each call may come from another thread.
class EvaluateJob {
 public:
  // spec: from EvaluateSpecFromProto.
  EvaluateJob(const JobSpec& spec, const Context& context);

  // As Job's.
  void AddStage(std::string_view stage, double milliseconds) { job_.AddStage(stage, milliseconds); }
  [[nodiscard]] absl::Status Decode(std::string encoded_mesh) {
    return job_.Decode(std::move(encoded_mesh));
  }
  [[nodiscard]] absl::Status Run();
  const JobSpec& spec() const { return job_.spec(); }
  const std::vector<StageTime>& stages() const { return job_.stages(); }
  // Bytes of samples until now.
  std::uint64_t bytes_sent() const { return first_ * wire::kSampleBytes; }
  std::uint32_t level() const { return job_.level(); }

  // Whether a message may come after the upload. Errors: MALFORMED_REQUEST for a second header,
  // chunks or nothing; those of wire::CheckParameters.
  [[nodiscard]] static absl::Status CheckInput(const v1::EvaluateRequest& request);

  // Whether all parameters have been answered and the end has not been told.
  bool NeedsInput() const { return next_ == block_size() && !ended_; }
  // Takes the next parameters; the message must have passed CheckInput. Only when NeedsInput.
  void AddInput(v1::EvaluateRequest request);
  // There are no more.
  void EndInput() { ended_ = true; }

  // Fills the next message of the answer: samples, in the end the summary. False: there is none
  // left. Not when NeedsInput. Errors: those of SurfaceEvaluator::Evaluate.
  [[nodiscard]] absl::StatusOr<bool> NextMessage(v1::EvaluateResponse* message);

 private:
  std::size_t block_size() const { return static_cast<std::size_t>(block_.faces_size()); }
  [[nodiscard]] absl::Status NextSamples(v1::EvaluateResponse* message);
  [[nodiscard]] absl::Status FillSummary(v1::Summary* summary);

  const Context context_;
  // Samples per message.
  const std::size_t batch_;
  Job job_;
  std::optional<LimitSurface> surface_;
  std::optional<SurfaceEvaluator> evaluator_;

  // The parameters to answer, from `next_` on.
  v1::ParameterBlock block_;
  std::size_t next_ = 0;
  // Number of the next answer among all.
  std::uint64_t first_ = 0;
  bool ended_ = false;
  bool summary_sent_ = false;
  wire::SampleArrays samples_;
  double milliseconds_ = 0;
};

}  // namespace limn
