// SPDX-License-Identifier: MIT
#include "server/log.h"

#include <spdlog/async.h>
#include <spdlog/async_logger.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kQueuedLines = 8192;

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
  // The thread pool outlives the logger, which only holds it weakly.
  std::shared_ptr<spdlog::details::thread_pool> threads;
  std::shared_ptr<spdlog::logger> logger;
};

Log::Log(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Log::~Log() {
  if (impl_->logger != nullptr) impl_->logger->flush();
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
  impl->logger = std::make_shared<spdlog::async_logger>(
      "limnd", std::make_shared<spdlog::sinks::stderr_sink_mt>(), impl->threads,
      spdlog::async_overflow_policy::overrun_oldest);
  impl->logger->set_level(parsed);
  impl->logger->flush_on(spdlog::level::info);
  impl->logger->set_formatter(std::make_unique<spdlog::pattern_formatter>(
      "time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v", spdlog::pattern_time_type::utc));
  return std::shared_ptr<Log>(new Log(std::move(impl)));
}

std::shared_ptr<Log> Log::Null() { return std::shared_ptr<Log>(new Log(std::make_unique<Impl>())); }

void Log::Debug(const LogLine& line) {
  if (impl_->logger != nullptr) impl_->logger->debug(std::string_view(line.text()));
}
void Log::Info(const LogLine& line) {
  if (impl_->logger != nullptr) impl_->logger->info(std::string_view(line.text()));
}
void Log::Warning(const LogLine& line) {
  if (impl_->logger != nullptr) impl_->logger->warn(std::string_view(line.text()));
}
void Log::Error(const LogLine& line) {
  if (impl_->logger != nullptr) impl_->logger->error(std::string_view(line.text()));
}

}  // namespace limn
