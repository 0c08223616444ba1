// SPDX-License-Identifier: MIT
#include "server/kept_jobs.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "engine/base/error.h"

namespace limn {
KeptJobs::Answer KeptJobs::Claim(const std::string& client, const std::string& id,
                                 const std::string& digest, std::shared_ptr<BatchJob>* job) {
  // Destroyed without the mutex.
  std::shared_ptr<BatchJob> failed;
  const std::lock_guard lock(mutex_);
  const auto [at, inserted] = entries_.try_emplace({client, id, digest});
  if (inserted) return Answer::kNew;
  Entry& entry = at->second;
  if (entry.job == nullptr) return Answer::kElsewhere;
  if (!entry.job->error().ok()) {
    failed = std::exchange(entry.job, nullptr);
    return Answer::kNew;
  }
  entry.before += Clock::now() - entry.since;
  *job = std::exchange(entry.job, nullptr);
  return Answer::kTakenUp;
}

void KeptJobs::Keep(std::shared_ptr<BatchJob> job, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[Key(job->client(), job->id(), job->digest())];
  entry.job = std::move(job);
  entry.since = now;
}

void KeptJobs::Forget(const BatchJob& job) {
  const std::lock_guard lock(mutex_);
  entries_.erase({job.client(), job.id(), job.digest()});
}

std::vector<std::shared_ptr<BatchJob>> KeptJobs::Expire(Clock::time_point now) {
  std::vector<std::shared_ptr<BatchJob>> expired;
  {
    const std::lock_guard lock(mutex_);
    for (auto at = entries_.begin(); at != entries_.end();) {
      Entry& entry = at->second;
      const bool all = now == Clock::time_point::max();
      const bool over =
          entry.job != nullptr && (all || entry.before + (now - entry.since) >= time_);
      if (over) expired.push_back(std::move(entry.job));
      at = over ? entries_.erase(at) : std::next(at);
    }
  }
  for (const auto& job : expired) {
    (void)job->Stop(MakeError("the client did not come back for the job",
                              {.reason = Reason::kCancelled,
                               .remedy = "Take jobs up again within resume-seconds",
                               .limit = "resume-seconds"}));
  }
  return expired;
}

std::size_t KeptJobs::waiting() const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::count_if(
      entries_.begin(), entries_.end(), [](const auto& e) { return e.second.job != nullptr; }));
}

}  // namespace limn
