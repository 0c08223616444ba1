// SPDX-License-Identifier: MIT
// A cancel ends encoding and decoding of a mesh of a million vertices in time.
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

struct Stops {
  double whole = 0;
  // From the cancel to the end, ascending.
  std::vector<double> stops;
};

// Runs the work to its end, the second time with warm pages, and then cancels it at so many
// moments.
Stops CancelAtMoments(const std::function<absl::Status(const Context&)>& work) {
  constexpr int kMoments = 8;
  Stops result;
  for (int i = 0; i < 2; ++i) {
    const Clock::time_point start = Clock::now();
    EXPECT_TRUE(work(Context()).ok());
    result.whole = Seconds(Clock::now() - start).count();
  }
  for (int i = 0; i < kMoments; ++i) {
    const Context context;
    Clock::time_point cancelled;
    std::thread other([&] {
      std::this_thread::sleep_for(Seconds(result.whole * (i + 0.5) / kMoments));
      cancelled = Clock::now();
      context.Cancel();
    });
    const absl::Status status = work(context);
    const Clock::time_point end = Clock::now();
    other.join();
    if (status.ok()) continue;
    EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << status;
    result.stops.push_back(Seconds(end - cancelled).count());
    std::cout << "cancelled at " << 1e3 * result.whole * (i + 0.5) / kMoments << " of "
              << 1e3 * result.whole << " ms: " << 1e3 * result.stops.back() << " ms\n";
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

// Packed meshes take less than that as a whole. Work that others disturb may be late once.
TEST(WireCancelTest, LosslessDracoStopsWithinFiftyMilliseconds) {
  const PolygonMesh mesh = Sphere(1'000'000);
  constexpr v1::MeshEncoding kLossless = v1::MESH_ENCODING_DRACO;
  for (const Stops& found : {Encoding(mesh, kLossless), Decoding(mesh, kLossless)}) {
    ASSERT_GE(found.stops.size(), 3U);
    EXPECT_LT(found.stops[found.stops.size() - 2], 0.05 * oracle::kSlowdown);
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
