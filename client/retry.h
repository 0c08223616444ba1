// SPDX-License-Identifier: MIT
// Doing a job again whose server went away. A job changes nothing on a server, and the same job has
// the same answer everywhere, so that it may be done twice.
#pragma once

#include <functional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/client.h"

namespace limn {

// Whether another server, or the same one a little later, may well answer: UNAVAILABLE, or a call
// that broke off in a way that no server of this contract ends one (by a proxy whose server died,
// for instance). Thread-safe.
[[nodiscard]] bool ServerWentAway(const absl::Status& status);

// The error of an answer that ended well but early: what becomes of one whose server died behind a
// proxy. UNREACHABLE, which ServerWentAway is true of. Thread-safe.
[[nodiscard]] absl::Status AnswerBrokeOff();

// Counts attempts and time of one job.
class Attempts {
 public:
  // stop: asked often while waiting; true gives the job up. May be empty. cancel it from any
  // thread.
  explicit Attempts(const ClientOptions& options, std::function<bool()> stop = {});

  // Whether to try once more after this error: waits 0.1, 0.3, 0.9 s, and so on, a little more or
  // less by chance, up to 3 s. Not when the attempts or the time are used up.
  [[nodiscard]] bool Again(const absl::Status& status);
  // Whether no attempt comes after this one.
  bool last() const { return made_ + 1 >= most_; }
  // Options for the next attempt, with the time that is left as its deadline.
  ClientOptions NextOptions() const;

 private:
  double SecondsLeft() const;

  ClientOptions options_;
  std::function<bool()> stop_;
  int most_;
  int made_ = 0;
  double begin_;
};

}  // namespace limn
