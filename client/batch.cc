// SPDX-License-Identifier: MIT
// The streams of a batch, one after the other.
#include "client/batch.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <utility>

#include "client/batch_ledger.h"
#include "client/batch_reporter.h"
#include "client/batch_stream.h"
#include "client/client_call.h"
#include "client/retry.h"
#include "engine/base/error.h"
#include "limn/v1/limn.grpc.pb.h"
#include "proto/wire/status.h"

namespace limn {
namespace {

// Of a server that does not say.
constexpr std::uint32_t kDefaultWindow = 16;
constexpr std::uint64_t kDefaultMessageBytes = std::uint64_t{2} << 20;

std::uint64_t LimitOf(const v1::GetServerInfoResponse& info, std::string_view name,
                      std::uint64_t otherwise) {
  for (const v1::Limit& limit : info.limits()) {
    if (limit.name() == name) return limit.value();
  }
  return otherwise;
}

// Whether another stream may do better than the one that ended like this.
bool MayPass(const grpc::Status& end) {
  const absl::Status status = wire::FromGrpcStatus(end);
  if (status.ok() || ServerWentAway(status)) return true;
  const auto detail = GetErrorDetail(status);
  const std::string limit = detail.has_value() ? detail->limit : "";
  return (detail.has_value() && detail->retryable) || limit == "stream-seconds" ||
         limit == "stall-seconds" || limit == "min-bytes-per-second";
}

// Of a stream that ended before all jobs were answered.
absl::Status ErrorOf(const grpc::Status& end) {
  return end.ok() ? AnswerBrokeOff() : wire::FromGrpcStatus(end);
}

absl::Status CheckBatch(const BatchCallbacks& callbacks, const BatchOptions& options) {
  const auto invalid = [](std::string_view what, std::string_view field) {
    return MakeError(what, {.reason = Reason::kInvalidOption, .field = std::string(field)});
  };
  if (!callbacks.next) return invalid("there is no source of jobs", "next");
  if (!callbacks.on_result) return invalid("nobody takes the results", "on_result");
  if (options.max_tries < 1) return invalid("max_tries is less than 1", "max_tries");
  const auto zero = std::chrono::milliseconds::zero();
  if (options.first_pause < zero || options.longest_pause < zero) {
    return invalid("a pause is negative", "first_pause");
  }
  return absl::OkStatus();
}

}  // namespace

struct ClientBatch::Impl {
  Impl(const Client& client, BatchOptions given)
      : channel(client.channel()), client_options(client.options()), options(std::move(given)) {}

  absl::Status Run(const BatchCallbacks& callbacks);
  absl::StatusOr<v1::GetServerInfoResponse> Ask();
  absl::Status RunStreams(BatchSender* sender, BatchReporter* reporter);
  grpc::Status RunStream(BatchSender* sender, BatchReporter* reporter, bool* further);
  void Watch(BatchLedger* jobs);
  void Cancel();
  // The call that Watch and Cancel may cancel; null: none.
  void SetCall(grpc::ClientContext* context);
  void CancelCall();

  std::shared_ptr<grpc::Channel> channel;
  ClientOptions client_options;
  BatchOptions options;

  std::mutex mutex;
  std::condition_variable changed;
  grpc::ClientContext* call = nullptr;
  BatchLedger* ledger = nullptr;
  bool cancelled = false;
  bool over = false;
};

void ClientBatch::Impl::SetCall(grpc::ClientContext* context) {
  const std::lock_guard lock(mutex);
  call = context;
}

void ClientBatch::Impl::CancelCall() {
  const std::lock_guard lock(mutex);
  if (call != nullptr) call->TryCancel();
}

void ClientBatch::Impl::Cancel() {
  const std::lock_guard lock(mutex);
  cancelled = true;
  if (ledger != nullptr) {
    ledger->EndAll(MakeError("the batch was cancelled", {.reason = Reason::kCancelled}));
  } else if (call != nullptr) {
    call->TryCancel();
  }
}

absl::StatusOr<v1::GetServerInfoResponse> ClientBatch::Impl::Ask() {
  grpc::ClientContext context;
  PrepareCall(client_options, &context);
  SetCall(&context);
  v1::GetServerInfoResponse info;
  const grpc::Status status = v1::LimnService::NewStub(channel)->GetServerInfo(&context, {}, &info);
  SetCall(nullptr);
  if (!status.ok()) return wire::FromGrpcStatus(status);
  return info;
}

absl::Status ClientBatch::Impl::Run(const BatchCallbacks& callbacks) {
  LIMN_RETURN_IF_ERROR(CheckBatch(callbacks, options));
  LIMN_RETURN_IF_ERROR(CheckClientOptions(client_options));
  LIMN_ASSIGN_OR_RETURN(const v1::GetServerInfoResponse info, Ask());
  const std::uint64_t window = LimitOf(info, "batch-window", kDefaultWindow);
  const std::uint64_t most = std::clamp<std::uint64_t>(window, 1, 1U << 20);
  options.window = options.window == 0 ? static_cast<std::uint32_t>(most)
                                       : std::min(options.window, static_cast<std::uint32_t>(most));

  BatchLedger jobs(options);
  BatchReporter reporter(callbacks, &jobs);
  const std::uint64_t message = LimitOf(info, "max-message-bytes", kDefaultMessageBytes);
  BatchSender sender({callbacks, client_options, options.name, message}, &jobs, &reporter);
  bool cancelled_before = false;
  {
    const std::lock_guard lock(mutex);
    ledger = &jobs;
    cancelled_before = cancelled;
  }
  if (cancelled_before) Cancel();
  std::thread watch([&] { Watch(&jobs); });
  const absl::Status status = RunStreams(&sender, &reporter);
  // Watch need not wait any longer.
  jobs.EndAll(status.ok() ? absl::CancelledError() : status);
  for (const auto& job : jobs.TakeAll()) {
    reporter.Report(*job, job->end.ok() ? status : job->end, false);
  }
  {
    const std::lock_guard lock(mutex);
    ledger = nullptr;
    over = true;
    changed.notify_all();
  }
  watch.join();
  return status;
}

absl::Status ClientBatch::Impl::RunStreams(BatchSender* sender, BatchReporter* reporter) {
  std::minstd_rand random(std::random_device{}());
  std::uint32_t failures = 0;
  for (;;) {
    if (absl::Status end = ledger->end(); !end.ok()) return end;
    bool further = false;
    const grpc::Status end = RunStream(sender, reporter, &further);
    if (ledger->Done()) return ledger->end();
    for (const auto& job : ledger->BreakStream(ErrorOf(end))) {
      reporter->Report(*job, job->end, false);
    }
    failures = further ? 0 : failures + 1;
    if (ledger->Done() || !ledger->end().ok()) return ledger->end();
    if (!MayPass(end) || failures >= options.max_tries) return ErrorOf(end);
    // Clients that lost the same server do not all come back at once.
    const double part = std::uniform_real_distribution<>(0.5, 1)(random);
    const auto pause = std::chrono::duration_cast<BatchClock::duration>(
        ledger->Pause(std::max(failures, 1U)) * part);
    if (ledger->WaitForEnd(BatchClock::now() + pause)) return ledger->end();
  }
}

grpc::Status ClientBatch::Impl::RunStream(BatchSender* sender, BatchReporter* reporter,
                                          bool* further) {
  grpc::ClientContext context;
  // The deadline is a job's, and Watch keeps it.
  ClientOptions call_options = client_options;
  call_options.deadline_seconds = 0;
  PrepareCall(call_options, &context);
  const std::unique_ptr<v1::LimnService::Stub> stub = v1::LimnService::NewStub(channel);
  const std::unique_ptr<BatchRpc> stream = stub->Batch(&context);
  SetCall(&context);
  ledger->OpenStream();
  std::thread sending([&] { sender->Run(stream.get()); });
  *further = ReadBatchAnswers(stream.get(), ledger, reporter);
  ledger->CloseStream();
  sending.join();
  const grpc::Status end = stream->Finish();
  SetCall(nullptr);
  return end;
}

// Keeps the jobs' deadlines, and ends a call that does not end by itself.
void ClientBatch::Impl::Watch(BatchLedger* jobs) {
  const std::chrono::duration<double> deadline(client_options.deadline_seconds);
  const bool limited = deadline.count() > 0 && deadline < std::chrono::hours(24 * 366);
  const auto late = MakeError("the job took longer than its deadline allows",
                              {.reason = Reason::kDeadlineExceeded});
  const auto look = limited ? std::chrono::milliseconds(50) : std::chrono::hours(1);
  while (!jobs->WaitForEnd(BatchClock::now() + look)) {
    if (!limited) continue;
    const auto before =
        BatchClock::now() - std::chrono::duration_cast<BatchClock::duration>(deadline);
    if (jobs->EndOverdue(before, late)) CancelCall();
  }
  std::unique_lock lock(mutex);
  while (!changed.wait_for(lock, BatchLedger::kGrace, [this] { return over; })) {
    if (call != nullptr) call->TryCancel();
  }
}

ClientBatch::ClientBatch(const Client& client, BatchOptions options)
    : impl_(std::make_unique<Impl>(client, std::move(options))) {}
ClientBatch::~ClientBatch() = default;

absl::Status ClientBatch::Run(const BatchCallbacks& callbacks) { return impl_->Run(callbacks); }

void ClientBatch::Cancel() { impl_->Cancel(); }

}  // namespace limn
