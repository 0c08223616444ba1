// SPDX-License-Identifier: MIT
// What JobReactor does with a stream's messages: the upload, and input after it.
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "server/job_reactor.h"
#include "server/stream_errors.h"

namespace limn {
template <class Rpc>
absl::Status JobReactor<Rpc>::TakeMessage() {
  const v1::InterpolateRequest* const part = Rpc::UploadPart(request_);
  switch (phase_) {
    case Phase::kHeader:
      if (part == nullptr || !part->has_header()) {
        return MalformedStream("the stream does not begin with a header", "Send the header first");
      }
      return TakeHeader(part->header());
    case Phase::kUpload:
      if (part != nullptr && part->has_header()) {
        return MalformedStream("there is a second header", "Use one stream per job");
      }
      if (part == nullptr || !part->has_chunk()) {
        return MalformedStream("there is a message without a chunk among those of the mesh",
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
    return MalformedStream("there is a message after the last chunk of the mesh",
                           "End the upload after the last chunk");
  }
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeHeader(const v1::InterpolateHeader& header) {
  auto message = std::make_unique<Response>();
  const absl::Status status = run_.TakeHeader(header, message->mutable_accepted());
  core_.metrics.CountAdmissionReject(status);
  LIMN_RETURN_IF_ERROR(status);
  phase_ = Phase::kUpload;
  watch_.BeginUpload(Clock::now());
  encoded_.push_back(std::move(message));
  TryWrite();
  return absl::OkStatus();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeChunk(const v1::MeshChunk& chunk) {
  watch_.Uploaded(chunk.data().size());
  LIMN_RETURN_IF_ERROR(run_.TakeChunk(chunk));
  return run_.upload_complete() ? Enqueue() : absl::OkStatus();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::EndOfRequests() {
  if (context_->IsCancelled()) return CallIsOver(deadline_);
  switch (phase_) {
    case Phase::kHeader:
      return MalformedStream("the stream ended before the header",
                             "Send a header and the mesh's chunks");
    case Phase::kUpload:
      return MalformedStream(absl::StrCat("the upload ended after ", run_.bytes_uploaded(), " of ",
                                          run_.bytes_expected(), " bytes of the mesh"),
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
absl::Status JobReactor<Rpc>::Enqueue() {
  // Before the job can run, which wants the mutex.
  const absl::Status status =
      run_.Enqueue([this](const ProgressEvent& event) { TakeProgress(event); },
                   [self = this->shared_from_this()] { self->RunJob(); });
  core_.metrics.CountAdmissionReject(status);
  LIMN_RETURN_IF_ERROR(status);
  phase_ = Phase::kQueued;
  watch_.EndUpload(Clock::now());
  return absl::OkStatus();
}

// All that job_reactor.cc calls.
template absl::Status JobReactor<InterpolateRpc>::TakeMessage();
template absl::Status JobReactor<InterpolateRpc>::EndOfRequests();
template absl::Status JobReactor<EvaluateRpc>::TakeMessage();
template absl::Status JobReactor<EvaluateRpc>::EndOfRequests();

}  // namespace limn
