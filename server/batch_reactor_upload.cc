// SPDX-License-Identifier: MIT
// What BatchReactor does with a stream's messages.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "server/batch_reactor.h"
#include "server/stream_errors.h"

namespace limn {
namespace {

constexpr std::size_t kLeastDigest = 16;
constexpr std::size_t kMostDigest = 64;
// With so many messages that nobody has taken nothing more is read.
constexpr std::size_t kMostUntaken = 64;

absl::Status CheckDigest(const std::string& digest) {
  if (digest.empty() || (digest.size() >= kLeastDigest && digest.size() <= kMostDigest)) {
    return absl::OkStatus();
  }
  return MalformedStream(absl::StrCat("digest: ", digest.size(), " bytes are not 16 to 64"),
                         "Send a SHA-256, or none", "digest");
}

bool IsForMemory(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  return detail.has_value() && detail->limit == "max-total-bytes";
}

}  // namespace

absl::Status BatchReactor::TakeMessage() {
  const std::string& id = request_.job_id();
  if (!IsRequestId(id)) {
    return MalformedStream("job_id: it is not of 1 to 128 visible ASCII characters",
                           "Give every job a name of its own", "job_id");
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
      return MalformedStream(absl::StrCat("there is an empty message for the job '", id, "'"),
                             "Send a header, chunks, `cancel` or `acknowledge`", "part");
  }
  watch_.Touch(Clock::now());
  if (waiting_ == Waiting::kNothing) return TakePart(std::move(request_));
  deferred_ = std::move(request_);
  return absl::OkStatus();
}

absl::Status BatchReactor::TakePart(v1::BatchRequest part) {
  if (part.request().has_chunk()) return TakeChunk(part);
  if (part.request().has_header()) return TakeHeader(std::move(part));
  return MalformedStream(
      absl::StrCat("there is an empty request for the job '", part.job_id(), "'"),
      "Send the header first, then chunks", "request");
}

absl::Status BatchReactor::TakeHeader(v1::BatchRequest part) {
  const std::string& id = part.job_id();
  if (jobs_.contains(id)) {
    return MalformedStream(absl::StrCat("job_id: the job '", id, "' is under way already"),
                           "Give every job a name of its own", "job_id");
  }
  if (const JobPointer job = EndUpload(); job != nullptr) {
    Fail(job, MalformedStream("the next job began before the mesh was complete",
                              "Send all chunks of a job before the next job's header", "job_id"));
  }
  // An id that is used again tells that the client has the answer.
  Acknowledge(id);
  last_id_ = id;
  drop_chunks_ = false;
  ++received_;
  if (const absl::Status status = CheckDigest(part.digest()); !status.ok()) {
    drop_chunks_ = true;
    SendError(id, caller_.request_id, status);
    return absl::OkStatus();
  }
  held_ = std::move(part);
  WaitFor(Waiting::kToBeAdmitted);
  return absl::OkStatus();
}

absl::Status BatchReactor::TakeChunk(const v1::BatchRequest& part) {
  if (part.job_id() == last_id_ && drop_chunks_) return absl::OkStatus();
  if (part.job_id() != last_id_ || uploading_ == nullptr) {
    return MalformedStream(absl::StrCat("there is a chunk of the job '", part.job_id(),
                                        "', whose header is not the last one or whose mesh is "
                                        "complete"),
                           "Send jobs one after the other, each with its header first", "job_id");
  }
  watch_.Uploaded(part.request().chunk().data().size());
  if (const absl::Status status = uploading_->TakeChunk(part.request().chunk()); !status.ok()) {
    Fail(EndUpload(), status);
  } else if (uploading_->upload_complete()) {
    WaitFor(Waiting::kForPlace);
  }
  return absl::OkStatus();
}

// Whatever still comes of the job is dropped.
BatchReactor::JobPointer BatchReactor::EndUpload() {
  watch_.PauseUpload(Clock::now());
  drop_chunks_ = drop_chunks_ || uploading_ != nullptr;
  return std::exchange(uploading_, nullptr);
}

void BatchReactor::Cancel(const std::string& id) {
  const absl::Status status =
      MakeError("the client cancelled the job", {.reason = Reason::kCancelled});
  if (waiting_ == Waiting::kToBeAdmitted && held_.job_id() == id) {
    waiting_ = Waiting::kNothing;
    drop_chunks_ = true;
    const JobPointer job = std::exchange(admitting_, nullptr);
    if (job != nullptr) return Fail(job, status);
    return SendError(id, caller_.request_id, status);
  }
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  const JobPointer job = found->second.job;
  if (uploading_ == job) {
    waiting_ = Waiting::kNothing;
    (void)EndUpload();
  }
  if (job->Stop(status)) Fail(job, status);
}

// Only what is complete: an answer that is on its way goes on.
void BatchReactor::Acknowledge(const std::string& id) {
  const auto found = std::find_if(answered_.begin(), answered_.end(),
                                  [&](const AnsweredJob& entry) { return entry.job->id() == id; });
  if (found == answered_.end()) return;
  kept_.Forget(*found->job);
  Drop(std::move(found->job));
  answered_.erase(found);
  try_again_ = true;
}

// An acknowledgement may stand behind the very part that waits for the memory.
bool BatchReactor::GiveUpAnAnswer(const absl::Status& for_want_of) {
  if (answered_.empty() || !IsForMemory(for_want_of)) return false;
  // Here and now, for its memory.
  kept_.Forget(*answered_.front().job);
  answered_.pop_front();
  return true;
}

void BatchReactor::EndOfRequests() {
  input_ended_ = true;
  // What waits for a place is complete, and what waits to be admitted is not yet known.
  if (uploading_ == nullptr || waiting_ == Waiting::kForPlace || deferred_.has_value()) return;
  const JobPointer job = EndUpload();
  Fail(job, MalformedStream(absl::StrCat("the upload ended after ", job->bytes_uploaded(), " of ",
                                         job->bytes_expected(), " bytes of the mesh"),
                            "Send all chunks of the mesh"));
}

void BatchReactor::WaitFor(Waiting what) {
  waiting_ = what;
  waiting_since_ = Clock::now();
  try_again_ = true;
  watch_.PauseUpload(waiting_since_);
}

// Goes on with what waits, if there may be room now, and reads the next message.
void BatchReactor::Advance() {
  if (end_.has_value() || finished_) return;
  const absl::Status status = Guarded("taking a job", Reason::kInternal, [this] { return GoOn(); });
  if (!status.ok()) return End(status);
  // A header may have been admitted after the client had closed its side.
  if (input_ended_) EndOfRequests();
  const bool too_far = deferred_.has_value() || outbox_.size() >= kMostUntaken;
  if (too_far || reading_ || input_ended_) return;
  if (uploading_ != nullptr && waiting_ == Waiting::kNothing) watch_.BeginUpload(Clock::now());
  reading_ = true;
  StartRead(&request_);
}

absl::Status BatchReactor::GoOn() {
  while (std::exchange(try_again_, false)) {
    if (waiting_ == Waiting::kToBeAdmitted && AdmitJob()) waiting_ = Waiting::kNothing;
    if (waiting_ == Waiting::kForPlace && PlaceJob()) waiting_ = Waiting::kNothing;
    if (waiting_ != Waiting::kNothing || !deferred_.has_value()) continue;
    LIMN_RETURN_IF_ERROR(TakePart(*std::exchange(deferred_, std::nullopt)));
    watch_.Touch(Clock::now());
  }
  return absl::OkStatus();
}

bool BatchReactor::WindowIsOpen() const {
  return !core_.draining.load() && jobs_.size() < core_.limits.batch_window;
}

// Whether room for it may come, so that it waits.
bool BatchReactor::MayTryAgain(const absl::Status& status) const {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  return detail.has_value() && detail->retryable &&
         Clock::now() - waiting_since_ < std::chrono::seconds(core_.limits.queue_seconds);
}

// False: the header has to wait.
bool BatchReactor::AdmitJob() {
  if (!WindowIsOpen()) {
    // That is for the client to see to; the server's patience begins afterwards.
    waiting_since_ = Clock::now();
    return false;
  }
  if (admitting_ == nullptr && TakeUpJob()) return true;
  if (admitting_ == nullptr) return false;
  v1::Accepted accepted;
  absl::Status status;
  do {
    status = admitting_->TakeHeader(held_.request().header(), &accepted);
  } while (MayTryAgain(status) && GiveUpAnAnswer(status));
  if (MayTryAgain(status)) return false;
  const JobPointer job = std::exchange(admitting_, nullptr);
  if (status.ok()) {
    SendAccepted(job->id(), accepted);
    AddJob(job);
    uploading_ = job;
  } else {
    core_.metrics.CountAdmissionReject(status);
    drop_chunks_ = true;
    Fail(job, status);
  }
  return true;
}

// True: nothing is left to be done, since the job was there already or cannot be had. Else a new
// one is made, unless another stream still has it.
bool BatchReactor::TakeUpJob() {
  JobPointer job;
  const std::string& digest = held_.digest();
  const auto answer =
      digest.empty() ? KeptJobs::Answer::kNew : kept_.Claim(caller_.client, last_id_, digest, &job);
  if (answer == KeptJobs::Answer::kNew) {
    admitting_ = std::make_shared<BatchJob>(core_, caller_, last_id_, digest);
    return false;
  }
  if (answer == KeptJobs::Answer::kElsewhere) {
    const absl::Status status =
        MakeError("job_id: another call of this client has this very job",
                  {.reason = Reason::kLimitExceeded,
                   .field = "job_id",
                   .remedy = "Try again when that call has ended, or use another id",
                   .limit = "resume-seconds",
                   .retryable = true});
    if (MayTryAgain(status)) return false;
    drop_chunks_ = true;
    SendError(last_id_, caller_.request_id, status);
    return true;
  }
  v1::Accepted accepted;
  accepted.set_request_id(job->request_id());
  accepted.set_server_version(LIMN_VERSION);
  accepted.set_lane(job->lane_name());
  accepted.set_resumed(true);
  drop_chunks_ = true;
  SendAccepted(last_id_, accepted);
  AddJob(job);
  Ready(job);
  return true;
}

// False: the upload is complete and has to wait.
bool BatchReactor::PlaceJob() {
  absl::Status status;
  do {
    status = uploading_->Enqueue();
  } while (MayTryAgain(status) && GiveUpAnAnswer(status));
  if (MayTryAgain(status)) return false;
  const JobPointer job = std::exchange(uploading_, nullptr);
  if (!status.ok()) {
    core_.metrics.CountAdmissionReject(status);
    drop_chunks_ = true;
    Fail(job, status);
  }
  return true;
}

}  // namespace limn
