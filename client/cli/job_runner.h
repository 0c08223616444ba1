// SPDX-License-Identifier: MIT
// Runs one job to its end, with a progress bar, and lets another thread stop it.
#pragma once

#include <functional>
#include <mutex>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/progress_bar.h"
#include "client/client.h"

namespace limn::cli {

// Carries the wish to stop from a signal's thread to the job, whenever it comes. Thread-safe.
class JobCanceller {
 public:
  // Cancels the job that runs, and any that starts later.
  void Cancel();
  bool cancelled() const;

  // What Cancel() calls from now on, under a lock; nothing for {}.
  void Attach(std::function<void()> cancel);

 private:
  mutable std::mutex mutex_;
  bool cancelled_ = false;
  std::function<void()> cancel_;
};

// A job's two halves.
struct JobInput {
  v1::InterpolateHeader header;
  PolygonMesh mesh;
};

// Submits, shows progress, puts the answer together. Errors: those of Client::Submit and of the
// server; CANCELLED after canceller->Cancel(); those of ResultCollector.
[[nodiscard]] absl::StatusOr<JobResult> RunJob(const Client& client, JobInput input,
                                               ProgressBar* bar, JobCanceller* canceller);

// The same for an evaluation. Errors: those of Client::SubmitEvaluation, of the server and of
// CollectEvaluation; CANCELLED after canceller->Cancel().
[[nodiscard]] absl::StatusOr<EvaluateResult> RunEvaluation(
    const Client& client, JobInput input, const std::vector<SurfaceParameter>& parameters,
    ProgressBar* bar, JobCanceller* canceller);

}  // namespace limn::cli
