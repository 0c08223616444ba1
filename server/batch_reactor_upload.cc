// SPDX-License-Identifier: MIT
// What BatchReactor does with a stream's messages.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "server/batch_reactor.h"

namespace limn {
namespace {

constexpr std::size_t kMostDigest = 64;

absl::Status Malformed(std::string_view message, std::string_view remedy) {
  return MakeError(message, {.reason = Reason::kMalformedRequest, .remedy = std::string(remedy)});
}

}  // namespace

absl::Status BatchReactor::TakeMessage() {
  const std::string& id = request_.job_id();
  if (!IsRequestId(id)) {
    return Malformed("job_id is not of 1 to 128 visible ASCII characters",
                     "Give every job a name of its own");
  }
  switch (request_.part_case()) {
    case v1::BatchRequest::kCancel:
      Cancel(id);
      return absl::OkStatus();
    case v1::BatchRequest::kAcknowledge:
      Acknowledge(id);
      return absl::OkStatus();
    case v1::BatchRequest::kRequest:
      break;
    case v1::BatchRequest::PART_NOT_SET:
      return Malformed(absl::StrCat("there is an empty message for the job '", id, "'"),
                       "Send a header, chunks, `cancel` or `acknowledge`");
  }
  if (request_.request().has_chunk()) return TakeChunk(request_.request().chunk());
  if (!request_.request().has_header()) {
    return Malformed(absl::StrCat("there is an empty request for the job '", id, "'"),
                     "Send the header first, then chunks");
  }
  if (jobs_.contains(id)) {
    return Malformed(absl::StrCat("the job '", id, "' is under way already"),
                     "Give every job a name of its own");
  }
  TakeHeader();
  return absl::OkStatus();
}

void BatchReactor::TakeHeader() {
  if (uploading_ != nullptr) {
    Fail(std::exchange(uploading_, nullptr),
         Malformed("the next job began before the mesh was complete",
                   "Send all chunks of a job before the next job's header"));
  }
  last_id_ = request_.job_id();
  // An id that is used again tells that the client has the answer.
  Acknowledge(last_id_);
  ++received_;
  WaitFor(Waiting::kToBeAdmitted);
}

absl::Status BatchReactor::TakeChunk(const v1::MeshChunk& chunk) {
  if (request_.job_id() != last_id_) {
    return Malformed(absl::StrCat("there is a chunk of the job '", request_.job_id(),
                                  "', whose header is not the last one"),
                     "Send jobs one after the other, each with its header first");
  }
  // What has failed, or was there already, needs none.
  if (uploading_ == nullptr) return absl::OkStatus();
  watch_.Uploaded(chunk.data().size());
  if (const absl::Status status = uploading_->TakeChunk(chunk); !status.ok()) {
    Fail(std::exchange(uploading_, nullptr), status);
  } else if (uploading_->upload_complete()) {
    WaitFor(Waiting::kForPlace);
  }
  return absl::OkStatus();
}

void BatchReactor::Cancel(const std::string& id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  const JobPointer job = found->second;
  if (uploading_ == job) uploading_ = nullptr;
  const absl::Status status =
      MakeError("the client cancelled the job", {.reason = Reason::kCancelled});
  if (job->Stop(status)) Fail(job, status);
}

// Only what is complete: an answer that is on its way goes on.
void BatchReactor::Acknowledge(const std::string& id) {
  const auto found = std::find_if(answered_.begin(), answered_.end(),
                                  [&](const JobPointer& job) { return job->id() == id; });
  if (found == answered_.end()) return;
  kept_.Forget(**found);
  answered_.erase(found);
}

// An acknowledgement may stand behind the very message that waits for room.
bool BatchReactor::GiveUpAnAnswer() {
  if (answered_.empty()) return false;
  kept_.Forget(*answered_.front());
  answered_.pop_front();
  return true;
}

void BatchReactor::EndOfRequests() {
  input_ended_ = true;
  if (uploading_ == nullptr) return;
  Fail(std::exchange(uploading_, nullptr),
       Malformed("the stream ended before the mesh was complete", "Send all chunks of the mesh"));
}

void BatchReactor::WaitFor(Waiting what) {
  waiting_ = what;
  waiting_since_ = Clock::now();
  watch_.EndUpload(waiting_since_);
}

// Goes on with the last message, if it waits and there is room now, and reads the next one.
void BatchReactor::Advance() {
  if (end_.has_value() || finished_) return;
  if (waiting_ == Waiting::kToBeAdmitted && AdmitJob()) waiting_ = Waiting::kNothing;
  if (waiting_ == Waiting::kForPlace && PlaceJob()) waiting_ = Waiting::kNothing;
  if (waiting_ != Waiting::kNothing || reading_ || input_ended_) return;
  const Clock::time_point now = Clock::now();
  watch_.Touch(now);
  if (uploading_ != nullptr) watch_.BeginUpload(now);
  reading_ = true;
  StartRead(&request_);
}

// Whether room for it may come, so that it waits.
bool BatchReactor::MayTryAgain(const absl::Status& status) const {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  return detail.has_value() && detail->retryable &&
         Clock::now() - waiting_since_ < std::chrono::seconds(core_.limits.queue_seconds);
}

// False: the header has to wait.
bool BatchReactor::AdmitJob() {
  if (core_.draining.load() || jobs_.size() >= core_.limits.batch_window) return false;
  if (request_.digest().size() > kMostDigest) {
    SendError(last_id_, Malformed("digest is longer than 64 bytes", "Send a SHA-256, or none"));
    return true;
  }
  if (admitting_ == nullptr && TakeUpJob()) return true;
  if (admitting_ == nullptr) return false;

  auto message = std::make_unique<v1::BatchResponse>();
  message->set_job_id(last_id_);
  absl::Status status;
  do {
    status = admitting_->TakeHeader(request_.request().header(),
                                    message->mutable_response()->mutable_accepted());
  } while (MayTryAgain(status) && GiveUpAnAnswer());
  if (MayTryAgain(status)) return false;
  const JobPointer job = std::exchange(admitting_, nullptr);
  if (status.ok()) {
    outbox_.push_back(std::move(message));
    AddJob(job);
    uploading_ = job;
  } else {
    core_.metrics.CountAdmissionReject(status);
    Fail(job, status);
  }
  return true;
}

// True: the job was there already. Else it is made, unless another stream still has it.
bool BatchReactor::TakeUpJob() {
  JobPointer job;
  const auto answer = request_.digest().empty()
                          ? KeptJobs::Answer::kNew
                          : kept_.Claim(caller_.client, last_id_, request_.digest(), &job);
  if (answer == KeptJobs::Answer::kNew) {
    admitting_ = std::make_shared<BatchJob>(core_, caller_, last_id_, request_.digest());
  }
  if (answer != KeptJobs::Answer::kTakenUp) return false;
  auto message = std::make_unique<v1::BatchResponse>();
  message->set_job_id(last_id_);
  v1::Accepted* accepted = message->mutable_response()->mutable_accepted();
  accepted->set_request_id(job->request_id());
  accepted->set_server_version(LIMN_VERSION);
  accepted->set_resumed(true);
  outbox_.push_back(std::move(message));
  AddJob(job);
  Ready(job);
  return true;
}

// False: the upload is complete and has to wait.
bool BatchReactor::PlaceJob() {
  // Cancelled meanwhile.
  if (uploading_ == nullptr) return true;
  absl::Status status;
  do {
    status = uploading_->Enqueue();
  } while (MayTryAgain(status) && GiveUpAnAnswer());
  if (MayTryAgain(status)) return false;
  const JobPointer job = std::exchange(uploading_, nullptr);
  if (!status.ok()) {
    core_.metrics.CountAdmissionReject(status);
    Fail(job, status);
  }
  return true;
}

}  // namespace limn
