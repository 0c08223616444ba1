// SPDX-License-Identifier: MIT
#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <algorithm>
#include <climits>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "server/limn_service.h"
#include "server/listen_address.h"
#include "server/machine_limits.h"
#include "server/service_core.h"

namespace limn {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMostThreads = 1024;
constexpr std::chrono::milliseconds kStallCheckInterval(250);
// For the errors of ended streams to leave, before connections are cut.
constexpr std::chrono::seconds kFarewell(2);
// For short calls that are under way.
constexpr std::chrono::milliseconds kLastCalls(500);
// For work of ended streams to see that it is to stop.
constexpr std::chrono::seconds kLastWork(2);
constexpr int kSecond = 1000;

absl::Status CheckOptions(const ServerOptions& options) {
  if (!options.listen.empty()) {
    const bool encrypted = !options.tls.certificate.empty();
    LIMN_RETURN_IF_ERROR(CheckListenAddress(options.listen, options.insecure || encrypted));
  }
  LIMN_RETURN_IF_ERROR(CheckTlsFiles(options.tls));
  if (options.threads < 0 || options.threads > kMostThreads) {
    return MakeError(
        absl::StrCat("threads: ", options.threads, " is not in [0, ", kMostThreads, "]"),
        {.reason = Reason::kInvalidOption, .field = "threads"});
  }
  for (const LimitEntry& entry : LimitTable()) {
    const std::uint64_t value = options.limits.*entry.value;
    if (value < entry.least || value > entry.most) {
      return MakeError(absl::StrCat(std::string(entry.name), ": ", value, " is not in [",
                                    entry.least, ", ", entry.most, "]"),
                       {.reason = Reason::kInvalidOption, .field = std::string(entry.name)});
    }
  }
  return absl::OkStatus();
}

void SetChannelArguments(const ServerLimits& limits, grpc::ServerBuilder* builder) {
  builder->SetMaxReceiveMessageSize(static_cast<int>(limits.max_message_bytes));
  builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                              static_cast<int>(limits.max_streams));
  // Two servers on one port would share the connections in silence.
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  // Probing grows the windows to megabytes per stream, which nobody has admitted; a fixed window
  // bounds what slow readers and fast writers cost.
  builder->AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 256 << 10);
  // Finds clients that vanished without a word; ends connections of those that ping without end.
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 60 * kSecond);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20 * kSecond);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10 * kSecond);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MAX_PING_STRIKES, 3);
  if (limits.max_connection_age > 0) {
    const std::uint64_t age =
        std::min<std::uint64_t>(limits.max_connection_age, std::uint64_t{INT_MAX} / kSecond);
    builder->AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS, static_cast<int>(age) * kSecond);
  }
  // Compressed messages are refused: they hide their size, and meshes have codecs of their own.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
}

}  // namespace

struct Server::Impl {
  Impl(const ServerLimits& limits, int threads, std::shared_ptr<Log> log)
      : core(limits, threads, std::move(log)), service(core) {}

  void Watch();
  void RefreshTokens();
  void SetServing(bool serving);
  void Shutdown(std::chrono::milliseconds patience);

  ServiceCore core;
  LimnService service;
  int port = 0;
  std::unique_ptr<grpc::Server> grpc_server;

  std::mutex mutex;
  std::condition_variable stopping;
  bool stopped = false;
  std::thread watch;
  std::once_flag shutdown_once;
  bool idle = false;
};

// Four times a second.
void Server::Impl::Watch() {
  std::unique_lock lock(mutex);
  while (!stopping.wait_for(lock, kStallCheckInterval, [this] { return stopped; })) {
    lock.unlock();
    const Clock::time_point now = Clock::now();
    core.streams.ForEach([now](OpenStream& stream) { stream.CheckStall(now); });
    RefreshTokens();
    lock.lock();
  }
}

void Server::Impl::RefreshTokens() {
  if (core.tokens == nullptr) return;
  const absl::StatusOr<bool> changed = core.tokens->Refresh();
  if (!changed.ok()) {
    core.log->Error(
        LogLine("tokens_not_read").Add("message", std::string(changed.status().message())));
  } else if (*changed) {
    core.log->Info(LogLine("tokens_read"));
  }
}

void Server::Impl::SetServing(bool serving) {
  grpc::HealthCheckServiceInterface* health = grpc_server->GetHealthCheckService();
  if (health == nullptr) return;
  health->SetServingStatus(serving);
  health->SetServingStatus(v1::LimnService::service_full_name(), serving);
}

void Server::Impl::Shutdown(std::chrono::milliseconds patience) {
  core.draining.store(true);
  SetServing(false);
  if (!core.streams.WaitUntilEmpty(Clock::now() + patience)) {
    core.log->Warning(LogLine("jobs_ended").Add("count", std::uint64_t{core.streams.size()}));
    const absl::Status status = MakeError(
        "the server is stopping and could not wait for the job",
        {.reason = Reason::kShuttingDown, .remedy = "Try another server, or again later"});
    core.streams.ForEach([&](OpenStream& stream) { stream.Stop(status); });
    (void)core.streams.WaitUntilEmpty(Clock::now() + kFarewell);
  }
  // What is still open then is cancelled by gRPC, which every stream answers at once.
  grpc_server->Shutdown(std::chrono::system_clock::now() + kLastCalls);
  grpc_server->Wait();
  {
    const std::lock_guard lock(mutex);
    stopped = true;
  }
  stopping.notify_all();
  watch.join();
  idle = core.StopUntil(Clock::now() + kLastWork);
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options) {
  LIMN_RETURN_IF_ERROR(CheckOptions(options));
  const int threads = options.threads == 0 ? CpuLimit() : options.threads;
  auto impl = std::make_unique<Impl>(options.limits, threads,
                                     options.log != nullptr ? options.log : Log::Null());

  if (!options.token_file.empty()) {
    LIMN_ASSIGN_OR_RETURN(impl->core.tokens, Tokens::Load(options.token_file));
  }

  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  builder.RegisterService(&impl->service);
  SetChannelArguments(options.limits, &builder);
  if (!options.listen.empty()) {
    builder.AddListeningPort(options.listen,
                             options.tls.certificate.empty() ? grpc::InsecureServerCredentials()
                                                             : MakeTlsCredentials(options.tls),
                             &impl->port);
  }
  impl->grpc_server = builder.BuildAndStart();
  if (impl->grpc_server == nullptr || (!options.listen.empty() && impl->port == 0)) {
    return MakeError(absl::StrCat("cannot listen on ", options.listen),
                     {.reason = Reason::kUnreachable,
                      .field = "listen",
                      .remedy = "Is the port taken? Port 0 picks a free one"});
  }
  impl->SetServing(true);
  impl->watch = std::thread([raw = impl.get()] { raw->Watch(); });
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() { Shutdown(std::chrono::milliseconds(0)); }

int Server::port() const { return impl_->port; }

int Server::threads() const { return impl_->core.threads; }

std::shared_ptr<grpc::Channel> Server::InProcessChannel() {
  return impl_->grpc_server->InProcessChannel(grpc::ChannelArguments());
}

void Server::Drain() {
  impl_->core.draining.store(true);
  impl_->SetServing(false);
}

bool Server::Shutdown(std::chrono::milliseconds patience) {
  std::call_once(impl_->shutdown_once, [&] { impl_->Shutdown(patience); });
  return impl_->idle;
}

}  // namespace limn
