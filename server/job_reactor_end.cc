// SPDX-License-Identifier: MIT
// What JobReactor does about time, and at the end: stalls, limits of time, counting and logging.
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "server/job_reactor.h"
#include "server/stream_errors.h"

namespace limn {

template <class Rpc>
void JobReactor<Rpc>::CheckStall(Clock::time_point now) {
  const Lock lock(mutex_);
  if (done_) return;
  // Progress that came too soon after the last one, and was not followed by more.
  TryWrite();
  const bool upload = phase_ == Phase::kUpload && !end_.has_value();
  const bool header = phase_ == Phase::kHeader && !end_.has_value();
  const bool writing = writing_ != nullptr || finished_;
  absl::Status status = watch_.Check(now, {.for_reader = writing && !upload,
                                           .for_message = header || upload || WaitsForInput(),
                                           .for_upload = upload});
  if (status.ok() && !end_.has_value()) status = CheckTimes(now);
  if (status.ok()) return;
  End(status);
  // An orderly end would not get through to a reader that takes nothing.
  if (writing) context_->TryCancel();
}

// What the server's own limits say of the time that the call takes.
template <class Rpc>
absl::Status JobReactor<Rpc>::CheckTimes(Clock::time_point now) const {
  const std::uint64_t stream = core_.limits.stream_seconds;
  if (stream > 0 && now - start_ >= std::chrono::seconds(stream)) return StreamTookTooLong(stream);
  return phase_ == Phase::kQueued ? run_.CheckQueueTime(now) : absl::OkStatus();
}

template <class Rpc>
void JobReactor<Rpc>::OnDone() {
  {
    const Lock lock(mutex_);
    done_ = true;
    // A job that still runs, or is still encoded, is not to be looked at.
    run_.LogEnd(end_.value_or(absl::UnknownError("ended without a reason")),
                phase_ != Phase::kRunning && !encoding_);
  }
  core_.streams.Remove(this);
  std::shared_ptr<JobReactor> self = std::move(self_);
  // Giving back a large result takes long, so another thread does it; but not what was never
  // admitted, of which a client can make thousands a second.
  if (run_.lane() != nullptr) delivery().Post([self = std::move(self)] {});
}

template void JobReactor<InterpolateRpc>::CheckStall(Clock::time_point now);
template void JobReactor<InterpolateRpc>::OnDone();
template void JobReactor<EvaluateRpc>::CheckStall(Clock::time_point now);
template void JobReactor<EvaluateRpc>::OnDone();

}  // namespace limn
