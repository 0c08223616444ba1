// SPDX-License-Identifier: MIT
// The jobs of a load test: kinds of clients in given shares, and what each of them sends.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "limn/v1/interpolate.pb.h"

namespace limn::load {

// What the client of a job is like.
enum class JobKind {
  kSmall,
  kLarge,
  // Sends what has to be refused: wrong faces, claims of 1e8 vertices, nonsense, in turn.
  kHostile,
  // Asks as kSmall at a higher level and takes a message of the answer in a tenth of a second.
  kSlow,
  // Asks as kLarge and cancels after a random part of 50 ms.
  kCancelled,
};
inline constexpr std::size_t kJobKinds = 5;
absl::string_view JobKindName(JobKind kind);

struct MixOptions {
  // Share of each kind, by JobKind; at least one above 0.
  std::array<double, kJobKinds> shares = {1, 0, 0, 0, 0};
  // Vertices and levels of the small and the large jobs' meshes.
  std::uint64_t small_vertices = 562;
  std::uint64_t large_vertices = 11540;
  std::uint32_t small_level = 1;
  std::uint32_t large_level = 1;
  // Of the meshes, and of the choice of kinds.
  std::uint64_t seed = 1;
};

// "small=90,large=10" into shares. Errors: INVALID_OPTION naming what is not understood.
[[nodiscard]] absl::StatusOr<std::array<double, kJobKinds>> ParseShares(absl::string_view text);

// A job as it is sent: header and chunks. Made once and shared.
struct PreparedJob {
  JobKind kind = JobKind::kSmall;
  std::vector<v1::InterpolateRequest> messages;
  std::uint64_t vertices = 0;
};

// Thread-safe but for Next.
class Mix {
 public:
  // Encodes the meshes. Errors: those of GenerateMesh.
  [[nodiscard]] static absl::StatusOr<Mix> Make(const MixOptions& options);

  // The next job, by the shares.
  std::shared_ptr<const PreparedJob> Next();

 private:
  explicit Mix(const MixOptions& options) : options_(options), random_(options.seed) {}

  MixOptions options_;
  std::mt19937_64 random_;
  // Of each kind one or more, which take turns.
  std::array<std::vector<std::shared_ptr<const PreparedJob>>, kJobKinds> jobs_;
  std::array<std::size_t, kJobKinds> turn_ = {};
};

}  // namespace limn::load
