// SPDX-License-Identifier: MIT
#include "client/load/mix.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "engine/base/error.h"
#include "engine/mesh/generate.h"
#include "proto/wire/chunks.h"
#include "proto/wire/mesh_codec.h"

namespace limn::load {
namespace {

constexpr std::array<absl::string_view, kJobKinds> kNames = {"small", "large", "hostile", "slow",
                                                             "cancelled"};
// Different meshes of a kind, so that nothing is answered from a cache that a real load had not.
constexpr int kVariants = 4;

absl::Status Invalid(std::string_view message) {
  return MakeError(message, {.reason = Reason::kInvalidOption,
                             .field = "mix",
                             .remedy = "Write it as small=90,large=10; kinds are small, large, "
                                       "hostile, slow and cancelled"});
}

absl::StatusOr<PreparedJob> Prepare(JobKind kind, PolygonMesh mesh, std::uint32_t level) {
  v1::InterpolateRequest first;
  v1::InterpolateHeader* header = first.mutable_header();
  header->mutable_surface()->set_level(level);
  header->mutable_output()->set_surface(true);
  header->mutable_output()->set_normals(true);
  header->mutable_output()->set_omit_connectivity(true);
  LIMN_ASSIGN_OR_RETURN(const wire::EncodedMesh encoded, wire::EncodeMesh(Context{}, mesh, {}));
  *header->mutable_mesh() = encoded.header;
  PreparedJob job = {.kind = kind, .vertices = mesh.vertex_count()};
  job.messages.push_back(std::move(first));
  wire::ChunkReader chunks(encoded.bytes, wire::kMaxChunkBytes);
  for (v1::InterpolateRequest part; chunks.Next(part.mutable_chunk());) {
    job.messages.push_back(part);
  }
  return job;
}

absl::StatusOr<PreparedJob> PrepareGenerated(JobKind kind, std::uint64_t vertices,
                                             std::uint32_t level, std::uint64_t seed) {
  LIMN_ASSIGN_OR_RETURN(PolygonMesh mesh, GenerateMesh({.vertices = vertices, .seed = seed}));
  return Prepare(kind, std::move(mesh), level);
}

// What a server must refuse, each at another place: the header, the decoder, the mesh.
absl::StatusOr<PreparedJob> PrepareHostile(int variant, std::uint64_t vertices,
                                           std::uint64_t seed) {
  LIMN_ASSIGN_OR_RETURN(PolygonMesh mesh, GenerateMesh({.vertices = vertices, .seed = seed}));
  if (variant == 0) mesh.positions[0].x = std::numeric_limits<double>::quiet_NaN();
  if (variant == 1) mesh.corner_vertex[1] = mesh.corner_vertex[0];
  LIMN_ASSIGN_OR_RETURN(PreparedJob job, Prepare(JobKind::kHostile, std::move(mesh), 1));
  v1::InterpolateHeader* header = job.messages[0].mutable_header();
  if (variant == 2) header->mutable_mesh()->set_vertex_count(100'000'000);
  if (variant == 3) {
    // Draco by its claim, noise by its bytes.
    std::mt19937_64 random(seed);
    std::string noise(256, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    header->mutable_mesh()->set_encoding(v1::MESH_ENCODING_DRACO);
    header->mutable_mesh()->set_byte_count(noise.size());
    v1::MeshChunk chunk;
    wire::ChunkReader reader(noise, wire::kMaxChunkBytes);
    reader.Next(&chunk);
    job.messages.resize(1);
    *job.messages.emplace_back().mutable_chunk() = std::move(chunk);
  }
  return job;
}

}  // namespace

absl::string_view JobKindName(JobKind kind) { return kNames[static_cast<std::size_t>(kind)]; }

absl::StatusOr<std::array<double, kJobKinds>> ParseShares(absl::string_view text) {
  std::array<double, kJobKinds> shares = {};
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    const std::pair<absl::string_view, absl::string_view> pair = absl::StrSplit(part, '=');
    const auto found = std::find(kNames.begin(), kNames.end(), pair.first);
    double share = 0;
    if (found == kNames.end()) {
      return Invalid(absl::StrCat("there are no jobs '", pair.first, "'"));
    }
    if (!absl::SimpleAtod(pair.second, &share) || !(share >= 0 && share <= 1e9)) {
      return Invalid(absl::StrCat("'", part, "' has no share from 0 on"));
    }
    shares[static_cast<std::size_t>(found - kNames.begin())] = share;
  }
  if (std::accumulate(shares.begin(), shares.end(), 0.0) <= 0) {
    return Invalid("all shares are 0");
  }
  return shares;
}

absl::StatusOr<Mix> Mix::Make(const MixOptions& options) {
  Mix mix(options);
  for (std::size_t k = 0; k < kJobKinds; ++k) {
    if (options.shares[k] <= 0) continue;
    const JobKind kind = static_cast<JobKind>(k);
    const bool large = kind == JobKind::kLarge || kind == JobKind::kCancelled;
    const std::uint64_t vertices = large ? options.large_vertices : options.small_vertices;
    const std::uint32_t level =
        (large ? options.large_level : options.small_level) + (kind == JobKind::kSlow ? 2 : 0);
    for (int i = 0; i < kVariants; ++i) {
      const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
      absl::StatusOr<PreparedJob> job = kind == JobKind::kHostile
                                            ? PrepareHostile(i, vertices, seed)
                                            : PrepareGenerated(kind, vertices, level, seed);
      if (!job.ok()) return job.status();
      mix.jobs_[k].push_back(std::make_shared<const PreparedJob>(*std::move(job)));
    }
  }
  return mix;
}

std::shared_ptr<const PreparedJob> Mix::Next() {
  const double total = std::accumulate(options_.shares.begin(), options_.shares.end(), 0.0);
  double left = static_cast<double>(random_() >> 11U) * 0x1p-53 * total;
  std::size_t kind = 0;
  for (std::size_t k = 0; k < kJobKinds; ++k) {
    if (options_.shares[k] <= 0) continue;
    // The last one with a share takes what rounding leaves.
    kind = k;
    left -= options_.shares[k];
    if (left < 0) break;
  }
  return jobs_[kind][turn_[kind]++ % jobs_[kind].size()];
}

}  // namespace limn::load
