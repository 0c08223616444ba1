// SPDX-License-Identifier: MIT
// Every limit of the server in one table, which the flags, --help and GetServerInfo are made from.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/types/span.h"
#include "engine/base/context.h"

namespace limn {

// The values; the initialisers are the defaults.
struct ServerLimits {
  std::uint64_t max_vertices = 16'000'000;
  std::uint64_t max_corners = 64'000'000;
  std::uint64_t max_level = 8;
  std::uint64_t max_mesh_bytes = std::uint64_t{2} << 30;
  std::uint64_t max_job_bytes = std::uint64_t{8} << 30;
  std::uint64_t max_total_bytes = std::uint64_t{16} << 30;
  std::uint64_t interactive_milliseconds = 100;
  std::uint64_t workers = 2;
  std::uint64_t queue_length = 64;
  std::uint64_t queue_bytes = std::uint64_t{8} << 30;
  std::uint64_t queue_milliseconds = 600'000;
  std::uint64_t queue_seconds = 60;
  // Twice max_streams, so that one connection cannot take them all.
  std::uint64_t max_uploads = 128;
  std::uint64_t max_connections = 1000;
  std::uint64_t max_streams = 64;
  std::uint64_t max_message_bytes = std::uint64_t{2} << 20;
  // Some times what max_uploads messages take.
  std::uint64_t max_network_bytes = std::uint64_t{1} << 30;
  std::uint64_t stall_seconds = 60;
  std::uint64_t min_bytes_per_second = std::uint64_t{32} << 10;
  std::uint64_t stream_seconds = 3600;
  std::uint64_t batch_window = 16;
  std::uint64_t resume_seconds = 60;
  std::uint64_t connection_idle_seconds = 600;
  std::uint64_t stuck_seconds = 30;
  std::uint64_t drain_seconds = 30;
  std::uint64_t max_connection_age = 3600;
};

// A row of the table.
struct LimitEntry {
  // As flags ("--" before it), errors and GetServerInfo call it.
  std::string_view name;
  std::uint64_t ServerLimits::*value;
  std::string_view unit;
  // What it limits, one sentence without a full stop.
  std::string_view description;
  // Smallest and largest value that makes sense, inclusive.
  std::uint64_t least;
  std::uint64_t most;
};

// The whole table, in the order of --help.
[[nodiscard]] absl::Span<const LimitEntry> LimitTable();

// The engine's part of the limits. No job may need more than all together.
[[nodiscard]] Limits EngineLimits(const ServerLimits& limits);

}  // namespace limn
