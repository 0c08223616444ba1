// SPDX-License-Identifier: MIT
// Runs one job to its end, with a progress bar, and lets another thread stop it.
#include "client/cli/job_runner.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_format.h"
#include "client/cli/report.h"
#include "client/result_collector.h"
#include "client/retry.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

void ShowProgress(const v1::Progress& progress, ProgressBar* bar) {
  std::string note;
  if (progress.sweep() > 0) {
    note = absl::StrFormat("sweep %u, largest move %.1e", progress.sweep(), progress.residual());
  }
  bar->Show(progress.stage(), progress.fraction(), note);
}

// One attempt: the mesh is kept only if there may be another.
template <class Result>
using Attempt = std::function<absl::StatusOr<Result>(const Client& client, bool last)>;

template <class Result>
absl::StatusOr<Result> WithAttempts(const Client& client, const JobCanceller& canceller,
                                    const Attempt<Result>& attempt) {
  Attempts attempts(client.options(), [&canceller] { return canceller.cancelled(); });
  while (true) {
    absl::StatusOr<Result> result = attempt(client.With(attempts.NextOptions()), attempts.last());
    if (result.ok() || canceller.cancelled() || !attempts.Again(result.status())) return result;
  }
}

absl::StatusOr<JobResult> CollectJob(ClientJob* job, ProgressBar* bar) {
  ResultCollector answer;
  std::uint64_t received = 0;
  while (std::optional<v1::InterpolateResponse> message = job->Next()) {
    if (message->has_progress()) {
      ShowProgress(message->progress(), bar);
    } else if (message->has_tile()) {
      received += message->tile().vertex_count();
      bar->Show("collect", ProgressBar::kUnknown, WithCommas(received) + " vertices");
    }
    LIMN_RETURN_IF_ERROR(answer.Add(*std::move(message)));
  }
  LIMN_RETURN_IF_ERROR(job->Finish());
  return answer.Finish();
}

}  // namespace

void JobCanceller::Cancel() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  if (cancel_) cancel_();
}

bool JobCanceller::cancelled() const {
  const std::lock_guard lock(mutex_);
  return cancelled_;
}

void JobCanceller::Attach(std::function<void()> cancel) {
  const std::lock_guard lock(mutex_);
  cancel_ = std::move(cancel);
  if (cancel_ && cancelled_) cancel_();
}

absl::StatusOr<JobResult> RunJob(const Client& client, JobInput input, ProgressBar* bar,
                                 JobCanceller* canceller) {
  return WithAttempts<JobResult>(
      client, *canceller, [&](const Client& once, bool last) -> absl::StatusOr<JobResult> {
        bar->Show("send", 0);
        LIMN_ASSIGN_OR_RETURN(ClientJob job, once.Submit(input.header, input.mesh));
        canceller->Attach([&job] { job.Cancel(); });
        const absl::Cleanup detach = [canceller] { canceller->Attach({}); };
        if (last) input.mesh = PolygonMesh{};
        return CollectJob(&job, bar);
      });
}

absl::StatusOr<EvaluateResult> RunEvaluation(const Client& client, JobInput input,
                                             const std::vector<SurfaceParameter>& parameters,
                                             ProgressBar* bar, JobCanceller* canceller) {
  return WithAttempts<EvaluateResult>(
      client, *canceller, [&](const Client& once, bool last) -> absl::StatusOr<EvaluateResult> {
        bar->Show("send", 0);
        LIMN_ASSIGN_OR_RETURN(ClientEvaluation call,
                              once.SubmitEvaluation(input.header, input.mesh, parameters));
        canceller->Attach([&call] { call.Cancel(); });
        const absl::Cleanup detach = [canceller] { canceller->Attach({}); };
        if (last) input.mesh = PolygonMesh{};
        return CollectEvaluation(&call, parameters.size(), [bar](const v1::Progress& progress) {
          ShowProgress(progress, bar);
          return true;
        });
      });
}

}  // namespace limn::cli
