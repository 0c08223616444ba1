// SPDX-License-Identifier: MIT
#include "client/load/generator.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <random>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/load/timers.h"
#include "engine/base/error.h"

namespace limn::load {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLate = 0.01;
constexpr std::chrono::milliseconds kProgressInterval(200);
constexpr std::chrono::seconds kPatience(5);

std::chrono::nanoseconds Seconds(double seconds) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(seconds));
}

// Sends jobs and counts what comes of them.
class Generator {
 public:
  Generator(const LoadOptions& options, Mix* mix, const std::atomic<bool>& stop,
            const std::function<void(std::uint64_t, std::uint64_t)>& progress)
      : options_(options), mix_(mix), stop_(stop), progress_(progress), random_(1) {}

  absl::Status Connect() {
    client_ = options_.client;
    LIMN_ASSIGN_OR_RETURN(std::string authorization,
                          ReadAuthorization(options_.server, options_.security));
    if (!authorization.empty()) {
      client_.metadata.emplace_back("authorization", std::move(authorization));
    }
    for (std::uint64_t i = 0; i < std::max<std::uint64_t>(options_.connections, 1); ++i) {
      LIMN_ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel,
                            MakeChannel(options_.server, options_.security, false));
      if (!channel->WaitForConnected(std::chrono::system_clock::now() + kPatience)) {
        return absl::UnavailableError(absl::StrCat("no connection to ", options_.server));
      }
      stubs_.push_back(v1::LimnService::NewStub(channel));
    }
    return absl::OkStatus();
  }

  void RunOpenLoop() {
    result_.offered = options_.arrivals.size();
    result_.sending_seconds = options_.seconds > 0
                                  ? options_.seconds
                                  : (options_.arrivals.empty() ? 0 : options_.arrivals.back());
    start_ = Clock::now();
    for (const double intended : options_.arrivals) {
      if (!SleepUntil(start_ + Seconds(intended))) break;
      if (Outstanding() >= options_.most_outstanding) {
        ++result_.dropped;
        continue;
      }
      if (Now() - intended > kLate) ++result_.late;
      Send(intended);
    }
  }

  void RunClosedLoop() {
    start_ = Clock::now();
    const Clock::time_point end = start_ + Seconds(options_.seconds);
    result_.sending_seconds = options_.seconds;
    while (!stop_ && Clock::now() < end) {
      {
        std::unique_lock lock(mutex_);
        const bool free = ended_.wait_for(lock, kProgressInterval,
                                          [this] { return running_.size() < options_.clients; });
        if (!free) {
          Report(lock);
          continue;
        }
      }
      ++result_.offered;
      Send(Now());
      std::unique_lock lock(mutex_);
      Report(lock);
    }
  }

  // Until all have ended.
  LoadResult Finish() {
    std::unique_lock lock(mutex_);
    while (!ended_.wait_for(lock, kProgressInterval, [this] { return running_.empty(); })) {
      if (stop_) {
        const auto running = running_;
        lock.unlock();
        for (const auto& [id, call] : running) {
          if (call != nullptr) call->Cancel();
        }
        lock.lock();
      }
      Report(lock);
    }
    result_.seconds = Now();
    return std::move(result_);
  }

 private:
  double Now() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  std::uint64_t Outstanding() {
    const std::lock_guard lock(mutex_);
    return running_.size();
  }

  // False: the test is to stop.
  bool SleepUntil(Clock::time_point time) {
    std::unique_lock lock(mutex_);
    while (!stop_ && Clock::now() < time) {
      // Not for the whole time: a wish to stop would have to wait.
      const Clock::time_point next = std::min(time, Clock::now() + kProgressInterval);
      ended_.wait_until(lock, next, [&] { return Clock::now() >= next; });
      Report(lock);
    }
    return !stop_;
  }

  // With the mutex held, which it gives back meanwhile.
  void Report(std::unique_lock<std::mutex>& lock) {
    const Clock::time_point now = Clock::now();
    if (!progress_ || now - last_report_ < kProgressInterval) return;
    last_report_ = now;
    const std::uint64_t sent = sent_;
    const std::uint64_t ended = result_.samples.size();
    lock.unlock();
    progress_(sent, ended);
    lock.lock();
  }

  void Send(double intended) {
    std::uint64_t id = 0;
    {
      const std::lock_guard lock(mutex_);
      id = sent_++;
      running_.emplace(id, nullptr);
    }
    const CallEnvironment environment = {.stub = stubs_[id % stubs_.size()].get(),
                                         .options = &client_,
                                         .timers = &timers_,
                                         .start = start_};
    std::shared_ptr<RunningCall> call =
        StartCall(environment, mix_->Next(), intended, std::chrono::milliseconds(random_() % 50),
                  [this, id](Sample sample) {
                    const std::lock_guard lock(mutex_);
                    result_.samples.push_back(std::move(sample));
                    running_.erase(id);
                    // With the mutex held: afterwards the generator may be gone.
                    ended_.notify_all();
                  });
    const std::lock_guard lock(mutex_);
    // It may have ended already.
    const auto found = running_.find(id);
    if (found != running_.end()) found->second = std::move(call);
  }

  const LoadOptions& options_;
  Mix* const mix_;
  const std::atomic<bool>& stop_;
  const std::function<void(std::uint64_t, std::uint64_t)>& progress_;
  std::mt19937_64 random_;
  ClientOptions client_;
  std::vector<std::unique_ptr<v1::LimnService::Stub>> stubs_;
  // Before the channels of the stubs.
  Timers timers_;
  Clock::time_point start_;

  std::mutex mutex_;
  std::condition_variable ended_;
  std::unordered_map<std::uint64_t, std::shared_ptr<RunningCall>> running_;
  std::uint64_t sent_ = 0;
  Clock::time_point last_report_;
  LoadResult result_;
};

}  // namespace

absl::StatusOr<LoadResult> RunLoad(
    const LoadOptions& options, Mix* mix, const std::atomic<bool>& stop,
    const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  Generator generator(options, mix, stop, progress);
  LIMN_RETURN_IF_ERROR(generator.Connect());
  if (options.clients > 0) {
    generator.RunClosedLoop();
  } else {
    generator.RunOpenLoop();
  }
  return generator.Finish();
}

}  // namespace limn::load
