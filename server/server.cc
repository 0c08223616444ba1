// SPDX-License-Identifier: MIT
#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <climits>
#include <condition_variable>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "engine/base/heap.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "server/limn_service.h"
#include "server/listen_address.h"
#include "server/listener.h"
#include "server/machine_limits.h"
#include "server/metrics.h"
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
constexpr int kReflectionThreads = 16;
constexpr int kSecond = 1000;
// What stays with an idle process, and when the rest goes.
constexpr std::size_t kKeptHeap = std::size_t{64} << 20;
constexpr std::chrono::seconds kIdleBeforeTrim(2);
// Large jobs let small ones go first where processors are scarce.
constexpr int kBatchNiceness = 10;

absl::Status CheckOptions(const ServerOptions& options) {
  if (!options.listen.empty()) {
    const bool encrypted = !options.tls.certificate.empty();
    LIMN_RETURN_IF_ERROR(CheckListenAddress(options.listen, options.insecure || encrypted));
  }
  LIMN_RETURN_IF_ERROR(CheckTlsFiles(options.tls));
  if (!options.metrics_listen.empty()) {
    LIMN_RETURN_IF_ERROR(
        CheckListenAddress(options.metrics_listen, options.insecure, "metrics-listen"));
  }
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

int Milliseconds(std::uint64_t seconds) {
  return static_cast<int>(std::min<std::uint64_t>(seconds, std::uint64_t{INT_MAX} / kSecond)) *
         kSecond;
}

void SetChannelArguments(const ServerLimits& limits, grpc::ServerBuilder* builder) {
  builder->SetMaxReceiveMessageSize(static_cast<int>(limits.max_message_bytes));
  builder->AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                              static_cast<int>(limits.max_streams));
  builder->AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS,
                              Milliseconds(limits.connection_idle_seconds));
  // For who connects and says nothing.
  builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                              std::min(20 * kSecond, Milliseconds(limits.stall_seconds)));
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
    builder->AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS,
                                Milliseconds(limits.max_connection_age));
    if (limits.stream_seconds > 0) {
      builder->AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS,
                                  Milliseconds(limits.stream_seconds));
    }
  }
  // Compressed messages are refused: they hide their size, and meshes have codecs of their own.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
}

// A call whose message has arrived in part only is nothing that anybody but gRPC knows of, and
// nothing that a token has been asked of: what all of them hold together is gRPC's to bound. And
// each call of reflection has a thread of gRPC's.
void SetQuota(const ServerLimits& limits, grpc::ServerBuilder* builder) {
  grpc::ResourceQuota quota("limnd");
  quota.Resize(limits.max_network_bytes);
  quota.SetMaxThreads(kReflectionThreads);
  builder->SetResourceQuota(quota);
}

}  // namespace

struct Server::Impl {
  Impl(const ServerOptions& options, int threads)
      : core(options.limits, threads, options.listen.empty() ? 0 : kBatchNiceness,
             options.log != nullptr ? options.log : Log::Null()),
        service(core),
        tidy_heap(!options.listen.empty()) {}

  void Watch();
  void RefreshFiles();
  void WatchLanes();
  void Drop(std::vector<std::shared_ptr<BatchJob>> jobs);
  void TrimWhenIdle(Clock::time_point now);
  ServerSample Sample();
  absl::Status WarmUp();
  absl::Status Listen(const ServerOptions& options, grpc::ServerBuilder* builder);
  void SetServing(bool serving);
  void Shutdown(std::chrono::milliseconds patience);

  ServiceCore core;
  LimnService service;
  // Null: nothing is encrypted.
  std::unique_ptr<TlsIdentity> tls;
  // Before the server, which has to go first.
  std::unique_ptr<Listener> listener;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor;
  std::unique_ptr<grpc::Server> grpc_server;
  int metrics_port = 0;
  // Whether the process is a server and nothing else.
  const bool tidy_heap;
  Clock::time_point last_busy = Clock::now();
  // What was left of the process the last time.
  std::uint64_t trimmed_to = 0;
  // Interactive and batch, for the watching thread.
  std::array<bool, 2> lanes_live{true, true};
  std::atomic<bool> live{true};
  std::atomic<std::int64_t> certificate_expiry{0};

  std::mutex mutex;
  std::condition_variable stopping;
  bool stopped = false;
  std::thread watch;
  std::once_flag shutdown_once;
  bool idle = false;
};

// Giving back large results takes long, so another thread does it.
void Server::Impl::Drop(std::vector<std::shared_ptr<BatchJob>> jobs) {
  if (!jobs.empty()) core.lanes.batch.delivery().Post([jobs = std::move(jobs)] {});
}

// Four times a second.
void Server::Impl::Watch() {
  std::unique_lock lock(mutex);
  while (!stopping.wait_for(lock, kStallCheckInterval, [this] { return stopped; })) {
    lock.unlock();
    const Clock::time_point now = Clock::now();
    core.streams.ForEach([now](OpenStream& stream) { stream.CheckStall(now); });
    // Nobody can come back to a server that stops.
    const bool draining = core.draining.load();
    Drop(draining ? service.kept_jobs().Clear() : service.kept_jobs().Expire(now));
    RefreshFiles();
    WatchLanes();
    TrimWhenIdle(now);
    lock.lock();
  }
}

// A worker that does not come back is lost until the process ends; a lane that has lost all of them
// will never run a job again.
void Server::Impl::WatchLanes() {
  const Clock::time_point since = Clock::now() - std::chrono::seconds(core.limits.stuck_seconds);
  bool all_live = true;
  for (std::size_t i = 0; i < lanes_live.size(); ++i) {
    const Lane& lane = i == 0 ? core.lanes.interactive : core.lanes.batch;
    const std::uint64_t stuck = lane.StuckJobs(since);
    const bool lane_live = stuck < lane.workers();
    all_live = all_live && lane_live;
    if (std::exchange(lanes_live[i], lane_live) == lane_live) continue;
    core.log->Error(LogLine(lane_live ? "lane_recovered" : "lane_stuck")
                        .Add("lane", lane.name())
                        .Add("stuck_jobs", stuck)
                        .Add("workers", lane.workers()));
  }
  if (live.exchange(all_live) == all_live) return;
  SetServing(all_live && !core.draining.load());
}

// The heap keeps what large jobs have given back, for the next one. When none comes, others may
// have the memory. Calls that are no jobs take memory too, of which only the process's size tells:
// a client can begin and drop thousands a second.
void Server::Impl::TrimWhenIdle(Clock::time_point now) {
  if (!tidy_heap) return;
  if (core.streams.size() > 0 || service.kept_jobs().waiting() > 0) last_busy = now;
  if (now - last_busy < kIdleBeforeTrim) return;
  last_busy = now;
  // What has gone back still counts as free in the heap's books, so that these do not tell whether
  // it is worth while again.
  if (ResidentBytes() < trimmed_to + kKeptHeap || !TrimHeap(kKeptHeap)) return;
  trimmed_to = ResidentBytes();
  core.log->Info(LogLine("memory_returned"));
}

ServerSample Server::Impl::Sample() {
  ServerSample sample{.draining = core.draining.load(),
                      .live = live.load(),
                      .streams = core.streams.size(),
                      .connections = listener != nullptr ? listener->Connections() : 0,
                      .uploads = core.admission.uploads(),
                      .reserved_bytes = core.admission.reserved_bytes()};
  if (tls != nullptr) sample.certificate_expiry = certificate_expiry.load();
  const Clock::time_point since = Clock::now() - std::chrono::seconds(core.limits.stuck_seconds);
  for (const Lane* lane : {&core.lanes.interactive, &core.lanes.batch}) {
    const Lane::Load load = lane->load();
    sample.lanes.push_back({.name = lane->name(),
                            .waiting = load.waiting,
                            .waiting_milliseconds = load.waiting_milliseconds,
                            .running = load.running,
                            .stuck = lane->StuckJobs(since)});
  }
  return sample;
}

// The first job of a process takes longer than those after it: pages of code and heap, threads.
absl::Status Server::Impl::WarmUp() {
  for (Lane* lane : {&core.lanes.interactive, &core.lanes.batch}) {
    LIMN_ASSIGN_OR_RETURN(Lane::Place place, lane->Reserve());
    std::promise<absl::Status> done;
    place.Post([&done] {
      done.set_value(Guarded("warming up", Reason::kInternal, []() -> absl::Status {
        LIMN_ASSIGN_OR_RETURN(const PolygonMesh mesh,
                              GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 500}));
        return Interpolate(Context{}, mesh, {.level = 2, .normals = true}).status();
      }));
    });
    LIMN_RETURN_IF_ERROR(done.get_future().get());
  }
  return absl::OkStatus();
}

// What is listened on; connections are taken from Listener::Start on.
absl::Status Server::Impl::Listen(const ServerOptions& options, grpc::ServerBuilder* builder) {
  if (options.listen.empty()) return absl::OkStatus();
  SetQuota(options.limits, builder);
  LIMN_ASSIGN_OR_RETURN(listener, Listener::Bind(options.listen, options.limits.max_connections));
  using Type = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  acceptor = builder->experimental().AddExternalConnectionAcceptor(
      Type::FROM_FD, tls == nullptr ? grpc::InsecureServerCredentials() : tls->Credentials());
  return absl::OkStatus();
}

void Server::Impl::RefreshFiles() {
  const auto report = [this](const absl::StatusOr<bool>& changed, const std::string& what) {
    if (!changed.ok()) {
      core.log->Error(
          LogLine(what + "_not_read").Add("message", std::string(changed.status().message())));
    } else if (*changed) {
      core.log->Info(LogLine(what + "_read"));
    }
  };
  if (core.tokens != nullptr) report(core.tokens->Refresh(), "tokens");
  if (tls != nullptr) {
    report(tls->Refresh(), "certificates");
    certificate_expiry.store(tls->expiry());
  }
}

void Server::Impl::SetServing(bool serving) {
  grpc::HealthCheckServiceInterface* health = grpc_server->GetHealthCheckService();
  if (health == nullptr) return;
  health->SetServingStatus(serving);
  health->SetServingStatus(v1::LimnService::service_full_name(), serving);
  // Not to be restarted because it drains.
  health->SetServingStatus("liveness", live.load());
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
  if (listener != nullptr) listener->Stop();
  // What is still open then is cancelled by gRPC, which every stream answers at once.
  grpc_server->Shutdown(std::chrono::system_clock::now() + kLastCalls);
  grpc_server->Wait();
  {
    const std::lock_guard lock(mutex);
    stopped = true;
  }
  stopping.notify_all();
  watch.join();
  Drop(service.kept_jobs().Clear());
  core.metrics.StopListening();
  idle = core.StopUntil(Clock::now() + kLastWork);
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options) {
  LIMN_RETURN_IF_ERROR(CheckOptions(options));
  const int threads = options.threads == 0 ? CpuLimit() : options.threads;
  auto impl = std::make_unique<Impl>(options, threads);

  if (!options.token_file.empty()) {
    LIMN_ASSIGN_OR_RETURN(impl->core.tokens, Tokens::Load(options.token_file));
  }

  if (!options.tls.certificate.empty()) {
    LIMN_ASSIGN_OR_RETURN(impl->tls, TlsIdentity::Load(options.tls));
    impl->certificate_expiry.store(impl->tls->expiry());
  }
  // Those inside a program may as well take their first job cold.
  if (!options.listen.empty()) LIMN_RETURN_IF_ERROR(impl->WarmUp());

  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  builder.RegisterService(&impl->service);
  SetChannelArguments(options.limits, &builder);
  LIMN_RETURN_IF_ERROR(impl->Listen(options, &builder));
  impl->grpc_server = builder.BuildAndStart();
  if (impl->grpc_server == nullptr) {
    return MakeError("gRPC does not start", {.reason = Reason::kInternal});
  }
  impl->core.metrics.SetSampler([raw = impl.get()] { return raw->Sample(); });
  if (!options.metrics_listen.empty()) {
    LIMN_ASSIGN_OR_RETURN(impl->metrics_port, impl->core.metrics.Listen(options.metrics_listen));
  }
  impl->SetServing(true);
  if (impl->listener != nullptr) {
    impl->listener->Start([raw = impl.get()](int listener, int fd) {
      grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
      connection.listener_fd = listener;
      connection.fd = fd;
      raw->acceptor->HandleNewConnection(&connection);
    });
  }
  impl->watch = std::thread([raw = impl.get()] { raw->Watch(); });
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() { Shutdown(std::chrono::milliseconds(0)); }

int Server::port() const { return impl_->listener != nullptr ? impl_->listener->port() : 0; }

int Server::metrics_port() const { return impl_->metrics_port; }

std::string Server::MetricsText() const { return impl_->core.metrics.Text(); }

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
