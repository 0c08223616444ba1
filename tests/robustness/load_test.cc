// SPDX-License-Identifier: MIT
// The real server under load: small jobs beside large ones, thousands of cancels, a soak.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <iostream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/robustness/harness.h"

namespace limn::robustness {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Runs jobs one after the other on its own connection until it is told to stop.
class Runner {
 public:
  Runner(const Subject& subject, v1::InterpolateHeader header, PolygonMesh mesh)
      : client_(subject.Connect()), header_(std::move(header)), mesh_(std::move(mesh)) {
    thread_ = std::thread([this] {
      while (!stop_) {
        const absl::StatusOr<JobResult> result = client_.Run(header_, mesh_);
        EXPECT_TRUE(result.ok()) << result.status();
        ++done_;
      }
    });
  }
  ~Runner() {
    stop_ = true;
    thread_.join();
  }
  int done() const { return done_; }

 private:
  const Client client_;
  const v1::InterpolateHeader header_;
  const PolygonMesh mesh_;
  std::atomic<bool> stop_ = false;
  std::atomic<int> done_ = 0;
  std::thread thread_;
};

std::vector<double> SmallJobTimes(const Subject& subject, int count) {
  const Client client(subject.Connect());
  const PolygonMesh mesh = MakeSphere(2000);
  v1::InterpolateHeader header = MakeHeader(1);
  std::vector<double> seconds;
  for (int i = 0; i < count; ++i) {
    const Clock::time_point start = Clock::now();
    const absl::StatusOr<JobResult> result = client.Run(header, mesh);
    EXPECT_TRUE(result.ok()) << result.status();
    seconds.push_back(SecondsSince(start));
  }
  return seconds;
}

// Large jobs whose work is the server's, not the client's and not the transport's, which share the
// processors: many sweeps over a mesh that is soon sent, and nothing back but the summary.
v1::InterpolateHeader LargeHeader() {
  v1::InterpolateHeader header = MakeHeader(0);
  header.clear_output();
  header.mutable_solve()->set_tolerance(0);
  header.mutable_solve()->set_max_sweeps(600);
  return header;
}

// What becomes of small jobs, 20 a second, beside clients that always have large ones.
struct Mix {
  std::vector<double> small_seconds;
  double large_jobs_per_second = 0;
};

Mix RunMix(const Subject& subject, double seconds) {
  const PolygonMesh mesh = MakeSphere(60'000);
  std::vector<std::unique_ptr<Runner>> runners;
  for (int i = 0; i < 4; ++i) {
    runners.push_back(std::make_unique<Runner>(subject, LargeHeader(), mesh));
  }
  EXPECT_TRUE(subject.WaitForMetric("limn_running_jobs{lane=\"batch\"}", 2));
  const auto done = [&] {
    int sum = 0;
    for (const auto& runner : runners) sum += runner->done();
    return sum;
  };
  Mix mix;
  const int before = done();
  const Clock::time_point start = Clock::now();
  while (SecondsSince(start) < seconds) {
    const std::vector<double> one = SmallJobTimes(subject, 1);
    mix.small_seconds.push_back(one.front());
    std::this_thread::sleep_for(std::chrono::duration<double>(0.05 - one.front()));
  }
  mix.large_jobs_per_second = (done() - before) / SecondsSince(start);
  return mix;
}

void Report(const char* name, const std::vector<double>& seconds) {
  std::cout << name << ": p50 " << Quantile(seconds, 0.5) * 1e3 << " ms, p99 "
            << Quantile(seconds, 0.99) * 1e3 << " ms\n";
}

TEST(LoadTest, SmallJobsBesideLargeOnesTakeAtMostThreeTimesAsLongAsAlone) {
  const double seconds = Full() ? 60 : 4;
  std::vector<double> alone;
  Mix two_lanes;
  {
    const Subject subject;
    (void)SmallJobTimes(subject, 20);
    alone = SmallJobTimes(subject, Full() ? 1000 : 100);
    two_lanes = RunMix(subject, seconds);
  }
  const Subject one({"--interactive-milliseconds", "0"});
  const Mix one_lane = RunMix(one, seconds);
  Report("alone", alone);
  Report("beside large jobs", two_lanes.small_seconds);
  Report("beside large jobs in one lane", one_lane.small_seconds);
  std::cout << "large jobs a second: " << two_lanes.large_jobs_per_second << ", in one lane "
            << one_lane.large_jobs_per_second << "\n";
  // What one lane is without the other.
  EXPECT_LT(5 * Quantile(two_lanes.small_seconds, 0.5), Quantile(one_lane.small_seconds, 0.5));
  // The promise itself, where the processors are this test's alone and there are jobs enough to
  // count.
  if (!Full()) return;
  EXPECT_LT(Quantile(two_lanes.small_seconds, 0.99), 3 * Quantile(alone, 0.99));
  EXPECT_GT(two_lanes.large_jobs_per_second, 0.9 * one_lane.large_jobs_per_second);
}

TEST(LoadTest, ThousandsOfCancelledJobsLeaveAServerThatWorks) {
  const Subject subject;
  const int count = Full() ? 10'000 : 1000;
  const unsigned seed = 20;
  SCOPED_TRACE(seed);
  const std::vector<v1::InterpolateRequest> upload = MakeUpload(MakeHeader(2), MakeSphere(500));
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      std::mt19937 random(seed + t);
      const auto channel = subject.Connect();
      for (int job = 0; job < count / 4; ++job) {
        RawCall call(channel);
        const std::size_t sent = random() % (upload.size() + 1);
        call.Write({upload.begin(), upload.begin() + static_cast<long>(sent)});
        for (unsigned read = random() % 4; sent == upload.size() && read > 0; --read) call.Read();
        call.Cancel();
        const absl::StatusCode code = call.Finish().code();
        // Refusals of what comes too fast are answers too.
        EXPECT_TRUE(code == absl::StatusCode::kCancelled || code == absl::StatusCode::kOk ||
                    code == absl::StatusCode::kResourceExhausted)
            << call.Finish();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(subject.WaitUntilIdle()) << subject.Metrics();
  EXPECT_TRUE(subject.SmallJob().ok());
}

TEST(LoadTest, MemoryComesBackAfterALargeJob) {
  Subject subject;
  ASSERT_TRUE(subject.SmallJob().ok());
  const double before = subject.Metric("process_resident_memory_bytes");
  double most = 0;
  {
    std::atomic<bool> done = false;
    std::thread watch([&] {
      while (!done) most = std::max(most, subject.Metric("process_resident_memory_bytes"));
    });
    RawCall call(subject.Connect(), std::chrono::minutes(5));
    EXPECT_TRUE(call.Write(MakeUpload(MakeHeader(2), MakeSphere(Full() ? 1'000'000 : 100'000))));
    EXPECT_TRUE(call.Finish().ok()) << call.Finish();
    done = true;
    watch.join();
  }
  EXPECT_GT(most, before + 100e6);
  double after = 0;
  EXPECT_TRUE(e2e::WaitUntil(20, [&] {
    after = subject.Metric("process_resident_memory_bytes");
    return after < before + 64e6;
  })) << after;
  // Once, not for ever.
  std::this_thread::sleep_for(std::chrono::seconds(3));
  const std::string log = subject.server().Log();
  EXPECT_NE(log.find("memory_returned"), std::string::npos);
  EXPECT_EQ(log.find("memory_returned"), log.rfind("memory_returned"));
  std::cout << "resident MiB: " << before / (1 << 20) << " before, " << most / (1 << 20)
            << " at the most, " << after / (1 << 20) << " after\n";
}

// Least squares, per second.
double Slope(const std::vector<std::pair<double, double>>& points) {
  double x = 0;
  double y = 0;
  double xx = 0;
  double xy = 0;
  for (const auto& [px, py] : points) {
    x += px;
    y += py;
    xx += px * px;
    xy += px * py;
  }
  const auto n = static_cast<double>(points.size());
  return (n * xy - x * y) / (n * xx - x * x);
}

TEST(LoadTest, ASoakGrowsNeitherMemoryNorDescriptors) {
  const Subject subject;
  const double warm_up = Full() ? 60 : 3;
  const double duration = Full() ? 600 : 6;
  std::atomic<bool> stop = false;
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      std::mt19937 random(t);
      while (!stop) {
        // New connections, all sizes and levels, some bad, some cancelled.
        const Client client(subject.Connect());
        for (int i = 0; i < 5 && !stop; ++i) {
          const PolygonMesh mesh = MakeSphere(100 + random() % 3000, random());
          v1::InterpolateHeader header = MakeHeader(random() % 3);
          if (random() % 5 == 0) header.mutable_surface()->set_level(99);
          const bool cancel = random() % 5 == 0;
          (void)client.Run(header, mesh, [cancel](const v1::Progress&) { return !cancel; });
        }
      }
    });
  }
  const Clock::time_point start = Clock::now();
  std::vector<std::pair<double, double>> resident;
  double least_descriptors = 1e9;
  double most_descriptors = 0;
  while (SecondsSince(start) < warm_up + duration) {
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
    if (SecondsSince(start) < warm_up) continue;
    resident.emplace_back(SecondsSince(start), subject.Metric("process_resident_memory_bytes"));
    const double descriptors = subject.Metric("process_open_fds");
    least_descriptors = std::min(least_descriptors, descriptors);
    most_descriptors = std::max(most_descriptors, descriptors);
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(subject.WaitUntilIdle());
  const double mib_per_minute = Slope(resident) * 60 / (1 << 20);
  std::cout << "resident " << resident.front().second / (1 << 20) << " to "
            << resident.back().second / (1 << 20) << " MiB, " << mib_per_minute
            << " MiB a minute; descriptors " << least_descriptors << " to " << most_descriptors
            << "; jobs: " << subject.Metric("limn_queue_wait_seconds_count{lane=\"interactive\"}")
            << "\n";
  // In the short form noise weighs more.
  EXPECT_LT(mib_per_minute, Full() ? 1 : 200);
  EXPECT_LT(most_descriptors - least_descriptors, 20);
}

}  // namespace
}  // namespace limn::robustness
