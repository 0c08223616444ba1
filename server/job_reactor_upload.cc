// SPDX-License-Identifier: MIT
// What JobReactor does with a stream's messages: the upload, and input after it.
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "server/job_reactor.h"

namespace limn {
namespace {

using Milliseconds = std::chrono::duration<double, std::milli>;

absl::Status Malformed(std::string_view message, std::string_view remedy) {
  return MakeError(message, {.reason = Reason::kMalformedRequest, .remedy = std::string(remedy)});
}

}  // namespace

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeMessage() {
  const v1::InterpolateRequest* const part = Rpc::UploadPart(request_);
  switch (phase_) {
    case Phase::kHeader:
      if (part == nullptr || !part->has_header()) {
        return Malformed("the stream does not begin with a header", "Send the header first");
      }
      return TakeHeader(part->header());
    case Phase::kUpload:
      if (part != nullptr && part->has_header()) {
        return Malformed("there is a second header", "Use one stream per job");
      }
      if (part == nullptr || !part->has_chunk()) {
        return Malformed("there is a message without a chunk among those of the mesh",
                         "Send chunks after the header, to the last of the mesh");
      }
      return TakeChunk(part->chunk());
    case Phase::kQueued:
    case Phase::kRunning:
    case Phase::kDelivering:
      break;
  }
  return TakeInput();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeInput() {
  if constexpr (Rpc::kTakesInput) {
    LIMN_RETURN_IF_ERROR(Rpc::Job::CheckInput(request_));
    input_ = std::move(request_);
    return absl::OkStatus();
  } else {
    return Malformed("there is a message after the last chunk of the mesh",
                     "End the upload after the last chunk");
  }
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeHeader(const v1::InterpolateHeader& header) {
  LIMN_ASSIGN_OR_RETURN(spec_, Rpc::Spec(header));
  if (spec_.request_id.empty()) spec_.request_id = request_id_;
  request_id_ = spec_.request_id;
  FitFinestLevel(EngineLimits(core_.limits), &spec_);
  absl::StatusOr<Admission::Ticket> ticket = core_.admission.Admit(spec_, caller_.client);
  core_.metrics.CountAdmissionReject(ticket.status());
  LIMN_ASSIGN_OR_RETURN(ticket_, std::move(ticket));
  upload_.emplace(spec_.mesh.byte_count());
  phase_ = Phase::kUpload;
  phase_start_ = Clock::now();
  watch_.BeginUpload(phase_start_);

  auto message = std::make_unique<Response>();
  v1::Accepted* accepted = message->mutable_accepted();
  accepted->set_request_id(request_id_);
  accepted->set_server_version(LIMN_VERSION);
  accepted->set_estimated_bytes(ticket_.estimate);
  accepted->set_queue_position(static_cast<std::uint32_t>(ticket_.position));
  accepted->set_lane(ticket_.lane->name());
  accepted->set_estimated_milliseconds(ticket_.request.milliseconds);
  encoded_.push_back(std::move(message));
  TryWrite();
  return absl::OkStatus();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeChunk(const v1::MeshChunk& chunk) {
  watch_.Uploaded(chunk.data().size());
  LIMN_RETURN_IF_ERROR(upload_->Add(chunk));
  return upload_->complete() ? Enqueue() : absl::OkStatus();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::EndOfRequests() {
  if (context_->IsCancelled()) return CancelledStatus();
  switch (phase_) {
    case Phase::kHeader:
      return Malformed("the stream ended before the header", "Send a header and the mesh's chunks");
    case Phase::kUpload:
      return Malformed(absl::StrCat("the upload ended after ", upload_->bytes().size(), " of ",
                                    spec_.mesh.byte_count(), " bytes of the mesh"),
                       "Send all chunks and set `last` on the last one");
    case Phase::kQueued:
    case Phase::kRunning:
    case Phase::kDelivering:
      break;
  }
  input_ended_ = true;
  return absl::OkStatus();
}

template <class Rpc>
Context JobReactor<Rpc>::MakeContext() {
  Context context(EngineLimits(core_.limits));
  if (deadline_.has_value()) context.set_deadline(*deadline_);
  stop_ = context;
  context.set_progress([this](const ProgressEvent& event) { TakeProgress(event); });
  return context;
}

template <class Rpc>
absl::Status JobReactor<Rpc>::Enqueue() {
  absl::Status status = core_.admission.Enqueue(&ticket_);
  core_.metrics.CountAdmissionReject(status);
  LIMN_RETURN_IF_ERROR(status);
  const Clock::time_point now = Clock::now();
  job_ = std::make_unique<typename Rpc::Job>(spec_, MakeContext());
  job_->AddStage("receive", Milliseconds(now - phase_start_).count());
  phase_start_ = now;
  phase_ = Phase::kQueued;
  watch_.EndUpload(now);
  ticket_.place.Post([self = this->shared_from_this()] { self->RunJob(); });
  return absl::OkStatus();
}

// All that job_reactor.cc calls.
template absl::Status JobReactor<InterpolateRpc>::TakeMessage();
template absl::Status JobReactor<InterpolateRpc>::EndOfRequests();
template absl::Status JobReactor<EvaluateRpc>::TakeMessage();
template absl::Status JobReactor<EvaluateRpc>::EndOfRequests();

}  // namespace limn
