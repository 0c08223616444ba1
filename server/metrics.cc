// SPDX-License-Identifier: MIT
#include "server/metrics.h"

#include <dirent.h>
#include <prometheus/counter.h>
#include <prometheus/exposer.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>
#include <sys/resource.h>
#include <unistd.h>

#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "server/machine_limits.h"

namespace limn {
namespace {

namespace pm = prometheus;

// Seconds, from what one tile takes to what nobody waits for.
const pm::Histogram::BucketBoundaries& Buckets() {
  static const auto* const kBuckets = new pm::Histogram::BucketBoundaries{
      0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30, 60, 300};
  return *kBuckets;
}

pm::Labels Label(const char* name, std::string_view value) { return {{name, std::string(value)}}; }

double OpenDescriptors() {
  DIR* const directory = opendir("/proc/self/fd");
  if (directory == nullptr) return 0;
  double count = -3;  // ".", ".." and the directory's own
  while (readdir(directory) != nullptr) ++count;
  closedir(directory);
  return count;
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

struct Metrics::Impl final : pm::Collectable {
  template <class Builder>
  auto& Add(Builder builder, const char* name, const char* help) {
    return builder.Name(name).Help(help).Register(*registry);
  }
  pm::Family<pm::Gauge>& Gauge(const char* name, const char* help) {
    return Add(pm::BuildGauge(), name, help);
  }
  pm::Family<pm::Counter>& Counter(const char* name, const char* help) {
    return Add(pm::BuildCounter(), name, help);
  }
  pm::Family<pm::Histogram>& Histogram(const char* name, const char* help) {
    return Add(pm::BuildHistogram(), name, help);
  }

  void Sample() const;
  std::vector<pm::MetricFamily> Collect() const override {
    Sample();
    return registry->Collect();
  }

  const std::unique_ptr<pm::Registry> registry = std::make_unique<pm::Registry>();
  pm::Family<pm::Counter>& requests =
      Counter("limn_requests_total", "Calls that have ended, by rpc, status code and reason");
  pm::Family<pm::Counter>& admission_rejects = Counter(
      "limn_admission_rejects_total", "Jobs refused before they ran, by the limit that was met");
  pm::Family<pm::Counter>& decode_rejects =
      Counter("limn_decode_rejects_total", "Meshes that did not decode, by reason");
  pm::Family<pm::Histogram>& queue_wait =
      Histogram("limn_queue_wait_seconds", "Time from the end of an upload to the job's start");
  pm::Family<pm::Histogram>& stages =
      Histogram("limn_stage_duration_seconds", "Time of each stage of jobs that went well");
  pm::Histogram& first_tile =
      Histogram("limn_first_tile_seconds", "Time from a call's begin to its first tile")
          .Add({}, Buckets());
  pm::Histogram& cancel_to_stop =
      Histogram("limn_cancel_to_stop_seconds",
                "Time from a running job's end by cancel, deadline or error to its threads' being "
                "free")
          .Add({}, Buckets());
  pm::Gauge& inflight =
      Gauge("limn_inflight_bytes", "Bytes of answers that are made and not taken yet").Add({});
  pm::Counter& stalls =
      Counter("limn_stream_stall_seconds_total",
              "Time in which messages waited for their clients to take them, summed over streams")
          .Add({});

  pm::Gauge& draining = Gauge("limn_draining", "1 while the server takes no new jobs").Add({});
  pm::Gauge& live = Gauge("limn_live", "0 while a lane is stuck").Add({});
  pm::Gauge& streams = Gauge("limn_open_streams", "Calls that run a job").Add({});
  pm::Gauge& connections = Gauge("limn_connections", "Connections that are open").Add({});
  pm::Gauge& uploads = Gauge("limn_uploads", "Meshes that are arriving").Add({});
  pm::Gauge& reserved =
      Gauge("limn_reserved_bytes", "Memory set aside for jobs, by estimate").Add({});
  pm::Gauge& certificate_expiry = Gauge("limn_certificate_expiry_timestamp_seconds",
                                        "When the server's certificate expires; 0 without TLS")
                                      .Add({});
  pm::Family<pm::Gauge>& depth = Gauge("limn_queue_depth", "Jobs that wait, by lane");
  pm::Family<pm::Gauge>& depth_seconds =
      Gauge("limn_queue_cost_seconds", "Processor time that the waiting jobs may take, by lane");
  pm::Family<pm::Gauge>& running = Gauge("limn_running_jobs", "Jobs that are computed, by lane");
  pm::Family<pm::Gauge>& stuck =
      Gauge("limn_stuck_jobs", "Jobs that run on though told to stop stuck-seconds ago, by lane");
  pm::Gauge& resident =
      Gauge("process_resident_memory_bytes", "Resident memory of the process").Add({});
  pm::Gauge& descriptors = Gauge("process_open_fds", "Open file descriptors").Add({});
  // A counter by nature, but it is read and not counted.
  pm::Gauge& cpu = Gauge("process_cpu_seconds_total", "Processor time, user and system").Add({});

  std::function<ServerSample()> sampler;
  std::unique_ptr<pm::Exposer> exposer;
  // What the exposer holds weakly; owns nothing.
  std::shared_ptr<pm::Collectable> collectable{static_cast<pm::Collectable*>(this),
                                               [](pm::Collectable*) {}};
};

void Metrics::Impl::Sample() const {
  resident.Set(static_cast<double>(ResidentBytes()));
  descriptors.Set(OpenDescriptors());
  cpu.Set(CpuSeconds());
  if (!sampler) return;
  const ServerSample now = sampler();
  draining.Set(now.draining ? 1 : 0);
  live.Set(now.live ? 1 : 0);
  streams.Set(static_cast<double>(now.streams));
  connections.Set(static_cast<double>(now.connections));
  uploads.Set(static_cast<double>(now.uploads));
  reserved.Set(static_cast<double>(now.reserved_bytes));
  certificate_expiry.Set(static_cast<double>(now.certificate_expiry));
  for (const LaneSample& lane : now.lanes) {
    const pm::Labels label = Label("lane", lane.name);
    depth.Add(label).Set(static_cast<double>(lane.waiting));
    depth_seconds.Add(label).Set(static_cast<double>(lane.waiting_milliseconds) / 1000);
    running.Add(label).Set(static_cast<double>(lane.running));
    stuck.Add(label).Set(static_cast<double>(lane.stuck));
  }
}

Metrics::Metrics() : impl_(std::make_unique<Impl>()) {}

Metrics::~Metrics() { StopListening(); }

void Metrics::CountRequest(std::string_view method, const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  impl_->requests
      .Add({{"method", std::string(method)},
            {"code", absl::StatusCodeToString(status.code())},
            {"reason", detail.has_value() ? std::string(ReasonName(detail->reason)) : ""}})
      .Increment();
}

void Metrics::CountAdmissionReject(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail.has_value() || detail->reason != Reason::kLimitExceeded) return;
  impl_->admission_rejects.Add(Label("limit", detail->limit)).Increment();
}

void Metrics::CountDecodeReject(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail.has_value()) return;
  impl_->decode_rejects.Add(Label("reason", ReasonName(detail->reason))).Increment();
}

void Metrics::ObserveQueueWait(std::string_view lane, double seconds) {
  impl_->queue_wait.Add(Label("lane", lane), Buckets()).Observe(seconds);
}

void Metrics::ObserveStage(std::string_view stage, double seconds) {
  impl_->stages.Add(Label("stage", stage), Buckets()).Observe(seconds);
}

void Metrics::ObserveFirstTile(double seconds) { impl_->first_tile.Observe(seconds); }

void Metrics::ObserveCancelToStop(double seconds) { impl_->cancel_to_stop.Observe(seconds); }

void Metrics::AddStall(double seconds) { impl_->stalls.Increment(seconds); }

void Metrics::AddInflight(std::int64_t bytes) {
  impl_->inflight.Increment(static_cast<double>(bytes));
}

void Metrics::SetSampler(std::function<ServerSample()> sampler) {
  impl_->sampler = std::move(sampler);
}

std::string Metrics::Text() const { return pm::TextSerializer().Serialize(impl_->Collect()); }

absl::StatusOr<int> Metrics::Listen(const std::string& address) {
  try {
    impl_->exposer = std::make_unique<pm::Exposer>(
        std::vector<std::string>{"listening_ports", address, "num_threads", "2",
                                 "request_timeout_ms", "5000", "keep_alive_timeout_ms", "0"});
    impl_->exposer->RegisterCollectable(impl_->collectable);
    const std::vector<int> ports = impl_->exposer->GetListeningPorts();
    if (!ports.empty()) return ports.front();
  } catch (const std::exception&) {
    // Says nothing beyond what is said below.
  }
  return MakeError(absl::StrCat("cannot listen on ", address),
                   {.reason = Reason::kUnreachable,
                    .field = "metrics-listen",
                    .remedy = "Is the port taken? Port 0 picks a free one"});
}

void Metrics::StopListening() { impl_->exposer.reset(); }

}  // namespace limn
