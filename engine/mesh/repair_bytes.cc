// SPDX-License-Identifier: MIT
// The arrays that Repair holds at a time, step by step, for the worst mesh of a size: every edge
// has more than two faces and every corner becomes a vertex.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"
#include "engine/mesh/repair.h"

namespace limn {
namespace {

// More than can be told.
constexpr double kMost = 1.8e19;

// Counts and bytes are doubles: they cannot overflow, and their last bits do not matter.
double Bytes(double count, double size) { return BufferBytes(count * size); }
double Indices(double count) { return Bytes(count, sizeof(Index)); }
// Of an array whose length is not known before it is full: it may be twice as long, and while it
// moves its first half is there too.
double Growing(double count, double size) { return Bytes(2 * count, size) + Bytes(count, size); }

}  // namespace

std::uint64_t EstimateRepairBytes(std::uint64_t vertices, std::uint64_t faces,
                                  std::uint64_t corners) {
  const auto v = static_cast<double>(vertices);
  const auto c = static_cast<double>(corners);
  // A face may fall into several.
  const double f = std::max(static_cast<double>(faces), c / 3);
  constexpr double kPair = sizeof(std::pair<Index, Index>);

  // Patchwork: vertex, face and mate per corner; begin, original, state, turned, component per
  // face.
  const double patchwork = 3 * Indices(c) + 3 * Indices(f + 1) + 2 * Bytes(f, 1);
  const double components = Growing(f, sizeof(Index));
  const double cleaning = Indices(v) + Growing(std::min(v, c), sizeof(Index));
  const double table = Bytes(c, kPair) + Indices(v + 1);
  // The sides of crowded edges and where each edge begins.
  const double crowded = Growing(c, sizeof(Index)) + Growing(c / 3, sizeof(Index));
  const double repeats = 2 * Indices(f) + Bytes(c, 1) + 2 * Bytes(f, 1) + Growing(f, sizeof(Index));
  const double gluing = table + std::max({Indices(v + 1), repeats, crowded});
  // Numbers of crowded sides, edges, arcs, arcs to close, sides of an edge.
  const double pairing =
      3 * Indices(c) + Bytes(2 * c, sizeof(std::uint64_t)) + Growing(c, sizeof(std::uint64_t));
  const double splitting =
      Indices(c) + Growing(c, 3 * sizeof(Index)) + 2 * Growing(c, sizeof(Index));
  const double oriented = components + std::max(Indices(f), crowded + std::max(pairing, splitting));
  const double numbers = Indices(c) + Indices(v + c);
  const double numbering = numbers + Indices(c) + 3 * Indices(v) + Growing(c, kPair);
  const double result = Bytes(v + c, sizeof(Vec3)) + Indices(c) + 2 * Indices(f + 1);

  double peak = patchwork + std::max({cleaning, gluing, oriented, components + numbering,
                                      components + numbers + result});
  // Lists of blocks.
  peak += peak / 64 + 4096;
  return peak >= kMost ? std::numeric_limits<std::uint64_t>::max()
                       : static_cast<std::uint64_t>(peak);
}

}  // namespace limn
