// SPDX-License-Identifier: MIT
#include "server/limits.h"

#include <algorithm>
#include <array>
#include <limits>

#include "proto/wire/chunks.h"

namespace limn {
namespace {

// Indices are 32 bits wide, so no mesh can have more.
constexpr std::uint64_t kMostElements = std::numeric_limits<std::uint32_t>::max() - 1;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 50;
// A chunk and its offset; a smaller message size would refuse well-formed uploads.
constexpr std::uint64_t kLeastMessageBytes = wire::kMaxChunkBytes + 4096;
constexpr std::uint64_t kDay = 86'400;
constexpr std::uint64_t kMostMilliseconds = 1000 * 365 * kDay;

constexpr std::array kTable = {
    LimitEntry{"max-vertices", &ServerLimits::max_vertices, "vertices", "Vertices of a job's mesh",
               1, kMostElements},
    LimitEntry{"max-corners", &ServerLimits::max_corners, "corners",
               "Corners of a job's mesh: the sum of the arities of its faces", 3, kMostElements},
    LimitEntry{"max-level", &ServerLimits::max_level, "refinements",
               "Level of a job's tessellation", 0, kMaxLevel},
    LimitEntry{"max-mesh-bytes", &ServerLimits::max_mesh_bytes, "bytes",
               "Bytes of a job's encoded mesh", 1, kMostBytes},
    LimitEntry{"max-job-bytes", &ServerLimits::max_job_bytes, "bytes",
               "Memory that one job may need, as estimated before it starts", 1, kMostBytes},
    LimitEntry{"max-total-bytes", &ServerLimits::max_total_bytes, "bytes",
               "Memory that all jobs on the server may need together, by the same estimate", 1,
               kMostBytes},
    LimitEntry{
        "interactive-milliseconds", &ServerLimits::interactive_milliseconds, "milliseconds",
        "Processor time, as estimated, of jobs that go to the interactive lane; others go to "
        "the batch lane",
        0, kMostMilliseconds},
    LimitEntry{"workers", &ServerLimits::workers, "jobs",
               "Jobs of each lane that are computed at a time", 1, 1024},
    LimitEntry{"queue-length", &ServerLimits::queue_length, "jobs",
               "Jobs of each lane that wait beside them; the next one is refused", 0, 1'000'000},
    LimitEntry{"queue-bytes", &ServerLimits::queue_bytes, "bytes",
               "Memory that the waiting jobs of each lane may need, as estimated", 1, kMostBytes},
    LimitEntry{"queue-milliseconds", &ServerLimits::queue_milliseconds, "milliseconds",
               "Processor time that the waiting jobs of each lane may take, as estimated", 1,
               kMostMilliseconds},
    LimitEntry{"queue-seconds", &ServerLimits::queue_seconds, "seconds",
               "Time that a job waits at the most; after half of it, it goes before all others", 1,
               kDay},
    LimitEntry{"max-uploads", &ServerLimits::max_uploads, "jobs",
               "Jobs whose meshes arrive at a time; the next one is refused", 1, 1'000'000},
    LimitEntry{"max-connections", &ServerLimits::max_connections, "connections",
               "Connections at a time; the next one is closed", 1, 1'000'000},
    LimitEntry{"max-streams", &ServerLimits::max_streams, "streams",
               "Calls at a time on one connection", 1, 100'000},
    LimitEntry{"max-message-bytes", &ServerLimits::max_message_bytes, "bytes",
               "Bytes of one message to the server; a job's constraints travel in one",
               kLeastMessageBytes, std::uint64_t{64} << 20},
    LimitEntry{"max-network-bytes", &ServerLimits::max_network_bytes, "bytes",
               "Memory for messages that arrive and for the calls they belong to; above it, calls "
               "are ended, whichever they are",
               std::uint64_t{64} << 20, kMostBytes},
    LimitEntry{
        "stall-seconds", &ServerLimits::stall_seconds, "seconds",
        "Time without progress of an upload or an answer, or without parameters, after which a "
        "call is ended",
        1, kDay},
    LimitEntry{"min-bytes-per-second", &ServerLimits::min_bytes_per_second, "bytes/s",
               "What a client has to send of an upload, or take of an answer, on average over "
               "stall-seconds; 0 is no demand",
               0, std::uint64_t{1} << 40},
    LimitEntry{"stream-seconds", &ServerLimits::stream_seconds, "seconds",
               "Time that a call may take in all; 0 is any", 0, 365 * kDay},
    LimitEntry{"batch-window", &ServerLimits::batch_window, "jobs",
               "Jobs of one Batch call that are held at a time; its next one is read when one of "
               "them has been answered",
               1, 10'000},
    LimitEntry{"resume-seconds", &ServerLimits::resume_seconds, "seconds",
               "Time that the jobs of a broken Batch call are kept for the client to come back", 0,
               kDay},
    LimitEntry{"connection-idle-seconds", &ServerLimits::connection_idle_seconds, "seconds",
               "Time without a call after which a connection is ended", 1, 365 * kDay},
    LimitEntry{
        "stuck-seconds", &ServerLimits::stuck_seconds, "seconds",
        "Time that a job may run on after it was told to stop; longer, and its worker counts "
        "as stuck: a lane without others fails the health service \"liveness\"",
        1, kDay},
    LimitEntry{"drain-seconds", &ServerLimits::drain_seconds, "seconds",
               "Time that jobs have to finish after SIGTERM or SIGINT", 0, kDay},
    LimitEntry{
        "max-connection-age", &ServerLimits::max_connection_age, "seconds",
        "Age at which a connection is asked to end, so that balancers can move clients, after "
        "which its calls have stream-seconds; 0 is never",
        0, 365 * kDay},
};

}  // namespace

absl::Span<const LimitEntry> LimitTable() { return kTable; }

Limits EngineLimits(const ServerLimits& limits) {
  return {.max_vertices = limits.max_vertices,
          .max_corners = limits.max_corners,
          .max_level = static_cast<std::uint32_t>(limits.max_level),
          .max_bytes = std::min(limits.max_job_bytes, limits.max_total_bytes)};
}

}  // namespace limn
