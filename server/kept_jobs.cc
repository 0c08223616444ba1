// SPDX-License-Identifier: MIT
#include "server/kept_jobs.h"

#include <algorithm>
#include <vector>

#include "engine/base/error.h"

namespace limn {
namespace {

void StopAll(const std::vector<std::shared_ptr<BatchJob>>& jobs) {
  for (const auto& job : jobs) {
    (void)job->Stop(MakeError("the client did not come back for the job",
                              {.reason = Reason::kCancelled, .limit = "resume-seconds"}));
  }
}

}  // namespace

KeptJobs::Answer KeptJobs::Claim(const std::string& client, const std::string& id,
                                 const std::string& digest, std::shared_ptr<BatchJob>* job) {
  // Ended, and perhaps destroyed, without the mutex.
  std::vector<std::shared_ptr<BatchJob>> other;
  Answer answer = Answer::kNew;
  {
    const std::lock_guard lock(mutex_);
    const auto [at, inserted] = entries_.try_emplace({client, id});
    if (!inserted && at->second.job == nullptr) return Answer::kElsewhere;
    if (!inserted) {
      std::shared_ptr<BatchJob> found = std::exchange(at->second.job, nullptr);
      if (found->digest() == digest) {
        *job = std::move(found);
        answer = Answer::kTakenUp;
      } else {
        other.push_back(std::move(found));
      }
    }
  }
  StopAll(other);
  return answer;
}

void KeptJobs::Keep(std::shared_ptr<BatchJob> job, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const Key key(job->client(), job->id());
  entries_[key] = {.job = std::move(job), .since = now};
}

void KeptJobs::Forget(const BatchJob& job) {
  const std::lock_guard lock(mutex_);
  entries_.erase({job.client(), job.id()});
}

void KeptJobs::Expire(Clock::time_point now) {
  std::vector<std::shared_ptr<BatchJob>> expired;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(entries_, [&](auto& entry) {
      if (entry.second.job == nullptr) return false;
      if (now != Clock::time_point::max() && now - entry.second.since < time_) return false;
      expired.push_back(std::move(entry.second.job));
      return true;
    });
  }
  StopAll(expired);
}

std::size_t KeptJobs::waiting() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::count_if(
      entries_.begin(), entries_.end(), [](const auto& e) { return e.second.job != nullptr; }));
}

}  // namespace limn
