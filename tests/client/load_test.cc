// SPDX-License-Identifier: MIT
// The load generator: schedules, mixes, percentiles, promises, the knee, and jobs of every kind
// against a server.
#include <unistd.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/load/arrivals.h"
#include "client/load/generator.h"
#include "client/load/load_report.h"
#include "client/load/mix.h"
#include "client/load/process_probe.h"
#include "client/load/sweep.h"
#include "engine/base/error.h"
#include "server/server.h"

namespace limn::load {
namespace {

std::vector<double> Times(const ArrivalOptions& options) {
  absl::StatusOr<std::vector<double>> times = MakeArrivals(options);
  EXPECT_TRUE(times.ok()) << times.status();
  return *std::move(times);
}

void ExpectAscendingWithin(const std::vector<double>& times, double seconds) {
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
  for (const double t : times) {
    ASSERT_GE(t, 0);
    ASSERT_LT(t, seconds);
  }
}

TEST(ArrivalsTest, ConstantOnesAreEvenlyApart) {
  const std::vector<double> times =
      Times({.kind = ArrivalKind::kConstant, .rate = 8, .seconds = 4});
  ASSERT_EQ(times.size(), 32U);
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_DOUBLE_EQ(times[i], static_cast<double>(i) / 8);
  }
}

TEST(ArrivalsTest, PoissonOnesHaveExponentialGaps) {
  const std::vector<double> times =
      Times({.kind = ArrivalKind::kPoisson, .rate = 1000, .seconds = 100, .seed = 3});
  ExpectAscendingWithin(times, 100);
  // 100,000 within four standard deviations.
  EXPECT_NEAR(static_cast<double>(times.size()), 1e5, 4 * std::sqrt(1e5));
  double mean = 0;
  double longer_than_mean = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double gap = times[i] - times[i - 1];
    mean += gap / static_cast<double>(times.size() - 1);
    longer_than_mean += gap > 1e-3 ? 1 : 0;
  }
  EXPECT_NEAR(mean, 1e-3, 2e-5);
  EXPECT_NEAR(longer_than_mean / static_cast<double>(times.size()), std::exp(-1), 0.01);
  EXPECT_EQ(times, Times({.kind = ArrivalKind::kPoisson, .rate = 1000, .seconds = 100, .seed = 3}));
  EXPECT_NE(times, Times({.kind = ArrivalKind::kPoisson, .rate = 1000, .seconds = 100, .seed = 4}));
}

TEST(ArrivalsTest, BurstsComeAtOnceAndKeepTheRate) {
  const std::vector<double> times =
      Times({.kind = ArrivalKind::kBurst, .rate = 20, .seconds = 5, .burst = 10});
  ASSERT_EQ(times.size(), 100U);
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_DOUBLE_EQ(times[i], static_cast<double>(i / 10) * 0.5);
  }
}

TEST(ArrivalsTest, ARampRisesEvenlyToTheRate) {
  const std::vector<double> times = Times({.kind = ArrivalKind::kRamp, .rate = 100, .seconds = 10});
  ExpectAscendingWithin(times, 10);
  EXPECT_NEAR(static_cast<double>(times.size()), 500, 1);
  const auto before = std::lower_bound(times.begin(), times.end(), 5.0) - times.begin();
  EXPECT_NEAR(static_cast<double>(before), 125, 1);
}

TEST(ArrivalsTest, RefusesWhatMakesNoSense) {
  for (const ArrivalOptions& options :
       {ArrivalOptions{.rate = 0}, ArrivalOptions{.rate = -1}, ArrivalOptions{.rate = std::nan("")},
        ArrivalOptions{.seconds = 0}, ArrivalOptions{.seconds = INFINITY},
        ArrivalOptions{.burst = 0}, ArrivalOptions{.rate = 1e6, .seconds = 1e3}}) {
    const auto times = MakeArrivals(options);
    ASSERT_FALSE(times.ok());
    EXPECT_EQ(GetErrorDetail(times.status())->reason, Reason::kInvalidOption);
  }
  EXPECT_FALSE(ParseArrivalKind("poison").ok());
  for (const std::string& name : ArrivalKindNames()) EXPECT_TRUE(ParseArrivalKind(name).ok());
}

class ReplayTest : public testing::Test {
 protected:
  absl::StatusOr<std::vector<double>> Read(const std::string& text) {
    std::ofstream(path_) << text;
    return ReadArrivals(path_);
  }
  ~ReplayTest() override { std::filesystem::remove(path_); }

  const std::string path_ =
      (std::filesystem::temp_directory_path() / absl::StrCat("limn-replay-", getpid())).string();
};

TEST_F(ReplayTest, TimesAreThoseOfTheFile) {
  const auto times = Read("# recorded\n0\n0.5\n\n 0.5\n1e1\n");
  ASSERT_TRUE(times.ok()) << times.status();
  EXPECT_EQ(*times, (std::vector<double>{0, 0.5, 0.5, 10}));
}

TEST_F(ReplayTest, BadLinesAreNamed) {
  for (const char* text : {"0\n-1\n", "0\nx\n", "1\n0.5\n", "0\nnan\n", "0\n1 2\n"}) {
    const auto times = Read(text);
    ASSERT_FALSE(times.ok()) << text;
    EXPECT_TRUE(absl::StrContains(times.status().message(), "line 2")) << times.status();
  }
  EXPECT_EQ(ReadArrivals("/nonexistent/file").status().code(), absl::StatusCode::kNotFound);
}

TEST(MixTest, SharesAreParsedAndKept) {
  const auto shares = ParseShares("small=3,hostile=1");
  ASSERT_TRUE(shares.ok()) << shares.status();
  absl::StatusOr<Mix> mix = Mix::Make({.shares = *shares, .small_vertices = 40, .seed = 5});
  ASSERT_TRUE(mix.ok()) << mix.status();
  int small = 0;
  constexpr int kJobs = 4000;
  for (int i = 0; i < kJobs; ++i) {
    const auto job = mix->Next();
    ASSERT_TRUE(job->kind == JobKind::kSmall || job->kind == JobKind::kHostile);
    small += job->kind == JobKind::kSmall ? 1 : 0;
  }
  EXPECT_NEAR(small, 3000, 4 * std::sqrt(kJobs * 0.75 * 0.25));
  for (const char* bad : {"", "small", "small=x", "small=-1", "tiny=1", "small=0", "small=1,,"}) {
    EXPECT_FALSE(ParseShares(bad).ok()) << bad;
  }
}

TEST(PercentilesTest, AreNearestRanks) {
  EXPECT_EQ(PercentilesOf({}).count, 0U);
  std::vector<double> values;
  for (int i = 1000; i >= 1; --i) values.push_back(i);
  const Percentiles p = PercentilesOf(values);
  EXPECT_EQ(p.count, 1000U);
  EXPECT_DOUBLE_EQ(p.mean, 500.5);
  EXPECT_EQ(p.p50, 500);
  EXPECT_EQ(p.p90, 900);
  EXPECT_EQ(p.p99, 990);
  EXPECT_EQ(p.p999, 999);
  EXPECT_EQ(p.max, 1000);
  const Percentiles one = PercentilesOf({7});
  EXPECT_EQ(one.p50, 7);
  EXPECT_EQ(one.p999, 7);
}

Sample Ended(JobKind kind, double intended, double ended, bool good) {
  return {.kind = kind,
          .intended = intended,
          .sent = intended + 1,
          .ended = ended,
          .outcome = good ? "OK" : "LIMIT_EXCEEDED",
          .good = good};
}

TEST(LoadReportTest, LatenciesCountFromTheIntendedTime) {
  LoadResult result = {.offered = 4, .dropped = 1, .sending_seconds = 2, .seconds = 4};
  result.samples = {Ended(JobKind::kSmall, 0, 2, true), Ended(JobKind::kLarge, 1, 4, true),
                    Ended(JobKind::kSmall, 1, 1.5, false)};
  const LoadReport report = MakeReport(result);
  EXPECT_EQ(report.latency.at("all").max, 3000);
  EXPECT_EQ(report.latency.at("small").count, 1U);
  EXPECT_EQ(report.latency.at("small").max, 2000);
  EXPECT_EQ(report.good, 2U);
  EXPECT_EQ(report.sent, 3U);
  EXPECT_EQ(report.offered_rate, 2);
  EXPECT_EQ(report.achieved_rate, 0.75);
  EXPECT_EQ(report.good_rate, 0.5);
  EXPECT_EQ(report.outcomes.at("small LIMIT_EXCEEDED"), 1U);
  EXPECT_TRUE(absl::StrContains(ReportText(report), "1 dropped"));
  EXPECT_TRUE(absl::StrContains(ReportJson(report), "\"good_rate\": 0.5"));
  const std::vector<std::string> lines = absl::StrSplit(SamplesCsv(result), '\n');
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_EQ(lines[1], "small,0.000000,1.000000,,,2.000000,OK,1,0,0");
}

TEST(ObjectivesTest, WhatIsNotKeptIsNamed) {
  LoadReport report = {.sent = 90, .dropped = 10, .good = 80, .good_rate = 40};
  report.latency["all"] = {.count = 80, .p50 = 5, .p99 = 50, .p999 = 70, .max = 90};
  report.first_tile["all"] = {.count = 80, .p99 = 20};
  const auto violations = [&](const char* text) {
    const auto objectives = ParseObjectives(text);
    EXPECT_TRUE(objectives.ok()) << objectives.status();
    return Violations(*objectives, report);
  };
  EXPECT_TRUE(
      violations("p50=5,p99=50,p99.9=70,max=90,first-tile-p99=20,errors=0.2,good-rate=40").empty());
  for (const char* broken : {"p50=4.9", "p99=49", "p99.9=69", "max=89", "first-tile-p99=19",
                             "errors=0.19", "good-rate=41", "last-tile-p50=1000"}) {
    EXPECT_EQ(violations(broken).size(), 1U) << broken;
  }
  for (const char* bad : {"", "p98=1", "p99", "p99=x", "errors=-1", "first-tile-errors=1"}) {
    EXPECT_FALSE(ParseObjectives(bad).ok()) << bad;
  }
}

// A server that bears 137 jobs per second and not one more.
absl::StatusOr<LoadReport> Bears137(double rate) {
  const bool borne = rate <= 137;
  LoadReport report = {.sending_seconds = 1, .seconds = 1, .offered = 1000, .good = 1000};
  report.good = borne ? 1000 : 500;
  return report;
}

TEST(SweepTest, FindsTheKneeOfAModel) {
  const auto result = FindKnee({.first_rate = 10, .bisections = 10}, Bears137);
  ASSERT_TRUE(result.ok());
  EXPECT_LE(result->knee, 137);
  EXPECT_GT(result->knee, 136.5);
  EXPECT_TRUE(absl::StrContains(SweepText(*result), "knee: 13"));
  const auto below = FindKnee({.first_rate = 500, .bisections = 2}, Bears137);
  EXPECT_LE(below->knee, 137);
  const auto none = FindKnee({.first_rate = 5000, .bisections = 1}, Bears137);
  EXPECT_EQ(none->knee, 0);
  EXPECT_EQ(
      FindKnee({},
               [](double) -> absl::StatusOr<LoadReport> { return absl::UnavailableError("gone"); })
          .status()
          .code(),
      absl::StatusCode::kUnavailable);
}

TEST(ProcessProbeTest, SeesMemoryAndTimeOfAProcess) {
  auto probe = ProcessProbe::Start(getpid());
  ASSERT_TRUE(probe.ok()) << probe.status();
  std::vector<char> memory(64 << 20, 1);
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(400);
  while (std::chrono::steady_clock::now() < until) memory[until.time_since_epoch().count() % 9]++;
  const ProcessUse use = (*probe)->Stop();
  EXPECT_GE(use.bytes_peak, use.bytes_before + (32 << 20));
  EXPECT_GT(use.bytes_after, 0U);
  EXPECT_GT(use.cpu_seconds, 0.02);
  EXPECT_EQ(ProcessProbe::Start(0x3fffffff).status().code(), absl::StatusCode::kNotFound);
}

class LoadTest : public testing::Test {
 protected:
  void SetUp() override {
    auto server = Server::Start({.listen = "127.0.0.1:0", .threads = 2});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    options_.server = absl::StrCat("127.0.0.1:", server_->port());
    options_.connections = 2;
  }

  LoadResult Run(const MixOptions& jobs) {
    absl::StatusOr<Mix> mix = Mix::Make(jobs);
    EXPECT_TRUE(mix.ok()) << mix.status();
    absl::StatusOr<LoadResult> result = RunLoad(options_, &*mix, stop_);
    EXPECT_TRUE(result.ok()) << result.status();
    return *std::move(result);
  }

  std::unique_ptr<Server> server_;
  LoadOptions options_;
  std::atomic<bool> stop_ = false;
};

TEST_F(LoadTest, EveryKindOfJobEndsAsItIsTo) {
  options_.arrivals = Times({.kind = ArrivalKind::kConstant, .rate = 60, .seconds = 1});
  const LoadResult result = Run(
      {.shares = {2, 1, 2, 1, 2}, .small_vertices = 60, .large_vertices = 2000, .large_level = 3});
  ASSERT_EQ(result.samples.size(), 60U);
  EXPECT_EQ(result.dropped, 0U);
  std::set<JobKind> kinds;
  for (const Sample& sample : result.samples) {
    kinds.insert(sample.kind);
    EXPECT_TRUE(sample.good) << JobKindName(sample.kind) << " " << sample.outcome;
    EXPECT_GE(sample.sent, sample.intended);
    EXPECT_GE(sample.ended, sample.sent);
    if (sample.outcome != "OK") continue;
    EXPECT_GE(sample.first_tile, sample.sent);
    EXPECT_GE(sample.last_tile, sample.first_tile);
    EXPECT_GE(sample.ended, sample.last_tile);
    EXPECT_FALSE(sample.stages.empty());
    EXPECT_GT(sample.bytes_received, 0U);
    EXPECT_GT(sample.bytes_sent, 0U);
    // Accepted, tiles and summary, a tenth of a second after each other.
    if (sample.kind == JobKind::kSlow) {
      EXPECT_GE(sample.ended - sample.sent, 0.2);
    }
  }
  EXPECT_EQ(kinds.size(), kJobKinds);
}

TEST_F(LoadTest, AClosedLoopHasSoManyJobsUnderWayAndNoMore) {
  options_.clients = 3;
  options_.seconds = 0.5;
  const LoadResult result = Run({.small_vertices = 60});
  EXPECT_GT(result.samples.size(), 3U);
  EXPECT_EQ(result.offered, result.samples.size());
  std::vector<std::pair<double, int>> changes;
  for (const Sample& sample : result.samples) {
    changes.emplace_back(sample.sent, 1);
    changes.emplace_back(sample.ended, -1);
  }
  std::sort(changes.begin(), changes.end());
  int running = 0;
  for (const auto& [time, change] : changes) ASSERT_LE(running += change, 3);
}

TEST_F(LoadTest, WhatIsAboveTheMostOutstandingIsDropped) {
  options_.arrivals = std::vector<double>(50, 0.0);
  options_.most_outstanding = 2;
  const LoadResult result = Run({.shares = {0, 1, 0, 0, 0}, .large_vertices = 20'000});
  EXPECT_GT(result.dropped, 0U);
  EXPECT_EQ(result.dropped + result.samples.size(), 50U);
  EXPECT_EQ(result.offered, 50U);
}

TEST_F(LoadTest, AWishToStopEndsIt) {
  options_.arrivals = Times({.kind = ArrivalKind::kConstant, .rate = 100, .seconds = 1000});
  std::thread stopper([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    stop_ = true;
  });
  const LoadResult result = Run({.small_vertices = 60});
  stopper.join();
  EXPECT_LT(result.samples.size(), 10'000U);
}

TEST_F(LoadTest, AServerThatIsNotThereIsToldOfAtOnce) {
  options_.server = "127.0.0.1:1";
  options_.arrivals = {0};
  absl::StatusOr<Mix> mix = Mix::Make({.small_vertices = 60});
  ASSERT_TRUE(mix.ok());
  EXPECT_EQ(RunLoad(options_, &*mix, stop_).status().code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace limn::load
