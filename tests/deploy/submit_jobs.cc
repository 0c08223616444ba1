// SPDX-License-Identifier: MIT
// Many jobs over one connection, as a program that uses the client library sends them.
//
//   submit_jobs SERVERS MESH JOBS PARALLEL LEVEL [ATTEMPTS [packed|draco|draco-quantized]]
//
// Prints a line per job that has ended, "SECONDS_SINCE_BEGIN LATENCY ok|ERROR", then
// "jobs=N failed=N digests=N seconds=S": digests counts the different answers (1: all the same
// bits).
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "client/client.h"
#include "client/io/mesh_reader.h"

namespace {

using Clock = std::chrono::steady_clock;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// FNV-1a over the bits of all points.
template <class Points>
void Digest(const Points& points, std::uint64_t* digest) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(points.data());
  for (std::size_t i = 0; i < points.size() * sizeof(points[0]); ++i) {
    *digest = (*digest ^ bytes[i]) * 1099511628211U;
  }
}

struct Tally {
  std::mutex mutex;
  int failed = 0;
  std::set<std::uint64_t> digests;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) {
    std::fputs("usage: submit_jobs SERVERS MESH JOBS PARALLEL LEVEL [ATTEMPTS]\n", stderr);
    return 2;
  }
  const absl::StatusOr<limn::PolygonMesh> mesh = limn::ReadMeshFile(argv[2]);
  if (!mesh.ok()) {
    std::fprintf(stderr, "submit_jobs: %s\n", std::string(mesh.status().message()).c_str());
    return 1;
  }
  const int jobs = std::atoi(argv[3]);
  limn::v1::InterpolateHeader header;
  header.mutable_surface()->set_level(static_cast<std::uint32_t>(std::atoi(argv[5])));
  header.mutable_output()->set_surface(true);
  limn::ClientOptions options;
  if (argc > 7) {
    const std::string_view name = argv[7];
    header.mutable_mesh()->set_encoding(name == "draco" ? limn::v1::MESH_ENCODING_DRACO
                                        : name == "draco-quantized"
                                            ? limn::v1::MESH_ENCODING_DRACO_QUANTIZED
                                            : limn::v1::MESH_ENCODING_PACKED);
    header.mutable_output()->set_encoding(header.mesh().encoding());
  }
  if (argc > 6) options.attempts = std::atoi(argv[6]);
  const limn::Client client = limn::Client::Connect(argv[1], options);

  std::atomic<int> next = 0;
  Tally tally;
  const Clock::time_point begin = Clock::now();
  const auto work = [&] {
    while (next++ < jobs) {
      const Clock::time_point start = Clock::now();
      const absl::StatusOr<limn::JobResult> result = client.Run(header, *mesh);
      const Clock::time_point end = Clock::now();
      std::uint64_t digest = 14695981039346656037U;
      if (result.ok()) Digest(result->surface.positions, &digest);
      const std::lock_guard lock(tally.mutex);
      if (result.ok()) {
        tally.digests.insert(digest);
      } else {
        ++tally.failed;
      }
      std::printf("%.3f %.4f %s\n", Seconds(end - begin), Seconds(end - start),
                  result.ok() ? "ok" : result.status().ToString().c_str());
      std::fflush(stdout);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < std::max(1, std::atoi(argv[4])); ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  std::printf("jobs=%d failed=%d digests=%zu seconds=%.3f\n", jobs, tally.failed,
              tally.digests.size(), Seconds(Clock::now() - begin));
  return tally.failed == 0 ? 0 : 3;
}
