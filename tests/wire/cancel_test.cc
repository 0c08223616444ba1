// SPDX-License-Identifier: MIT
// A cancel ends encoding and decoding of a mesh of a million vertices in time.
#include <pthread.h>
#include <time.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <thread>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/generate.h"
#include "proto/wire/mesh_codec.h"
#include "tests/oracle/slowdown.h"

namespace limn::wire {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

PolygonMesh Sphere(std::size_t vertices) {
  return *GenerateMesh(
      {.kind = MeshKind::kIrregularSphere, .vertices = vertices / oracle::kSlowdown});
}

// Processor time of the thread that works, which other work on the machine does not count for.
class WorkClock {
 public:
  WorkClock() { EXPECT_EQ(pthread_getcpuclockid(pthread_self(), &clock_), 0); }
  double Now() const {
    timespec time{};
    EXPECT_EQ(clock_gettime(clock_, &time), 0);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

 private:
  clockid_t clock_{};
};

struct Stops {
  // Of the thread's processor time.
  double whole = 0;
  // From the cancel to the end, likewise, ascending.
  std::vector<double> stops;
};

// Runs the work to its end, the second time with warm pages, and then cancels it at so many
// moments.
Stops CancelAtMoments(const std::function<absl::Status(const Context&)>& work) {
  constexpr int kMoments = 8;
  const WorkClock clock;
  Stops result;
  double seconds = 0;
  for (int i = 0; i < 2; ++i) {
    const Clock::time_point start = Clock::now();
    const double work_start = clock.Now();
    EXPECT_TRUE(work(Context()).ok());
    seconds = Seconds(Clock::now() - start).count();
    result.whole = clock.Now() - work_start;
  }
  for (int i = 0; i < kMoments; ++i) {
    const Context context;
    double cancelled = 0;
    std::thread other([&] {
      std::this_thread::sleep_for(Seconds(seconds * (i + 0.5) / kMoments));
      cancelled = clock.Now();
      context.Cancel();
    });
    const absl::Status status = work(context);
    const double end = clock.Now();
    other.join();
    if (status.ok()) continue;
    EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << status;
    result.stops.push_back(end - cancelled);
    std::cout << "cancelled at " << 1e3 * seconds * (i + 0.5) / kMoments << " of " << 1e3 * seconds
              << " ms: " << 1e3 * result.stops.back() << " ms\n";
  }
  std::sort(result.stops.begin(), result.stops.end());
  return result;
}

Stops Encoding(const PolygonMesh& mesh, v1::MeshEncoding encoding) {
  return CancelAtMoments([&](const Context& context) {
    return EncodeMesh(context, mesh, {.encoding = encoding}).status();
  });
}

Stops Decoding(const PolygonMesh& mesh, v1::MeshEncoding encoding) {
  const EncodedMesh encoded = *EncodeMesh(Context(), mesh, {.encoding = encoding});
  return CancelAtMoments([&](const Context& context) {
    return DecodeMesh(context, encoded.header, encoded.bytes).status();
  });
}

// Packed meshes take less than that as a whole. 42 ms at the most where nothing else runs; others
// that use the memory make it more.
TEST(WireCancelTest, LosslessDracoStopsWithinATenthOfASecond) {
  const PolygonMesh mesh = Sphere(1'000'000);
  constexpr v1::MeshEncoding kLossless = v1::MESH_ENCODING_DRACO;
  for (const Stops& found : {Encoding(mesh, kLossless), Decoding(mesh, kLossless)}) {
    ASSERT_GE(found.stops.size(), 3U);
    EXPECT_LT(found.stops[found.stops.size() - 2], 0.1 * oracle::kSlowdown);
  }
}

// Draco's own parts are not interrupted, but none of them is most of the work.
TEST(WireCancelTest, QuantisedEncodingsStopBetweenDracosParts) {
  const PolygonMesh mesh = Sphere(200'000);
  constexpr v1::MeshEncoding kQuantized = v1::MESH_ENCODING_DRACO_QUANTIZED;
  for (const Stops& found : {Encoding(mesh, kQuantized), Decoding(mesh, kQuantized)}) {
    ASSERT_GE(found.stops.size(), 3U);
    EXPECT_LT(found.stops[found.stops.size() - 2], 0.75 * found.whole);
  }
}

}  // namespace
}  // namespace limn::wire
