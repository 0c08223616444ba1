// SPDX-License-Identifier: MIT
#include "server/log.h"

#include <spdlog/async.h>
#include <spdlog/async_logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kQueuedLines = 8192;
// For the last lines, when the log ends.
constexpr std::chrono::seconds kLastLines(2);

bool IsPlain(std::string_view value) {
  if (value.empty()) return false;
  for (const char c : value) {
    if (!absl::ascii_isalnum(static_cast<unsigned char>(c)) &&
        std::string_view("-_.:/+@[]").find(c) == std::string_view::npos) {
      return false;
    }
  }
  return true;
}

std::string Escaped(std::string_view text) {
  return absl::Utf8SafeCHexEscape({text.data(), text.size()});
}

// Writes to the descriptor itself: a thread that stood still inside stdio would hold the lock of
// stderr, for which the end of the process waits. Only the logger's one thread calls it.
class StderrSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  // Whether this many flushes have been done, within the time.
  bool WaitForFlushes(std::uint64_t count, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return flushed_.wait_for(lock, patience, [&] { return flushes_ >= count; });
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    std::string_view rest(line.data(), line.size());
    while (!rest.empty()) {
      const ssize_t written = write(STDERR_FILENO, rest.data(), rest.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return;
      rest.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void flush_() override {
    const std::lock_guard lock(mutex_);
    ++flushes_;
    flushed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable flushed_;
  std::uint64_t flushes_ = 0;
};

}  // namespace

LogLine::LogLine(std::string_view event) { Add("event", event); }

LogLine& LogLine::Add(std::string_view key, std::string_view value) {
  if (!text_.empty()) text_ += ' ';
  text_.append(key).append("=");
  if (IsPlain(value)) {
    text_ += value;
  } else {
    text_ += '"' + Escaped(value) + '"';
  }
  return *this;
}

LogLine& LogLine::Add(std::string_view key, std::uint64_t value) {
  return Add(key, std::string_view(absl::StrCat(value)));
}

LogLine& LogLine::Add(std::string_view key, double value) {
  return Add(key, std::string_view(absl::StrFormat("%.3f", value)));
}

struct Log::Impl {
  std::function<void(std::string_view)> function;
  // The thread pool outlives the logger, which only holds it weakly.
  std::shared_ptr<spdlog::details::thread_pool> threads;
  std::shared_ptr<StderrSink> sink;
  std::shared_ptr<spdlog::logger> logger;
  std::atomic<std::uint64_t> flushes{0};
  // See ~Log.
  Impl* left_before = nullptr;
};

Log::Log(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Log::~Log() {
  if (Flush(kLastLines)) return;
  // The thread of a reader that stands still cannot be joined; it ends with the process. What it
  // needs is left in a list, where a leak checker finds it: its report would wait for that reader.
  static std::atomic<Impl*> left{nullptr};
  Impl* const self = impl_.release();
  self->left_before = left.exchange(self);
}

bool Log::Flush(std::chrono::milliseconds patience) {
  if (impl_->logger == nullptr) return true;
  const std::uint64_t flush = ++impl_->flushes;
  impl_->logger->flush();
  return impl_->sink->WaitForFlushes(flush, patience);
}

absl::StatusOr<std::shared_ptr<Log>> Log::ToStderr(std::string_view level) {
  const spdlog::level::level_enum parsed = spdlog::level::from_str(std::string(level));
  if (parsed == spdlog::level::off && level != "off") {
    return MakeError(absl::StrCat("there is no log level \"", Escaped(level), "\""),
                     {.reason = Reason::kInvalidOption,
                      .field = "log-level",
                      .remedy = "Use debug, info, warning, error or off"});
  }
  auto impl = std::make_unique<Impl>();
  impl->threads = std::make_shared<spdlog::details::thread_pool>(kQueuedLines, 1);
  impl->sink = std::make_shared<StderrSink>();
  impl->logger = std::make_shared<spdlog::async_logger>(
      "limnd", impl->sink, impl->threads, spdlog::async_overflow_policy::overrun_oldest);
  impl->logger->set_level(parsed);
  impl->logger->set_formatter(std::make_unique<spdlog::pattern_formatter>(
      "time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v", spdlog::pattern_time_type::utc));
  return std::shared_ptr<Log>(new Log(std::move(impl)));
}

std::shared_ptr<Log> Log::ToFunction(std::function<void(std::string_view)> function) {
  auto impl = std::make_unique<Impl>();
  impl->function = std::move(function);
  return std::shared_ptr<Log>(new Log(std::move(impl)));
}

std::shared_ptr<Log> Log::Null() { return std::shared_ptr<Log>(new Log(std::make_unique<Impl>())); }

void Log::Write(int level, const LogLine& line) {
  if (impl_->function) impl_->function(line.text());
  if (impl_->logger == nullptr) return;
  impl_->logger->log(static_cast<spdlog::level::level_enum>(level), std::string_view(line.text()));
}

void Log::Debug(const LogLine& line) { Write(spdlog::level::debug, line); }
void Log::Info(const LogLine& line) { Write(spdlog::level::info, line); }
void Log::Warning(const LogLine& line) { Write(spdlog::level::warn, line); }
void Log::Error(const LogLine& line) { Write(spdlog::level::err, line); }

}  // namespace limn
