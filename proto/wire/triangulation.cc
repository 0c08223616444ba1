// SPDX-License-Identifier: MIT
// See triangulation.h. Fans, and joining of marked triangles; the search for triangles is in
// triangulation_search.cc.
#include "proto/wire/triangulation.h"

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/edge_table.h"

namespace limn::wire {
namespace {

absl::Status Malformed(const std::string& message) {
  return MakeError(message, {.reason = Reason::kMalformedEncoding, .field = "faces"});
}

// Between two looks at whether to stop.
constexpr std::size_t kStride = std::size_t{1} << 16;

absl::Status CheckAt(const Context& context, std::size_t step) {
  return step % kStride == 0 ? context.Check() : absl::OkStatus();
}

// Half-edge h of the triangles runs from corner h to the next corner of its triangle.
std::size_t NextCorner(std::size_t h) { return h % 3 == 2 ? h - 2 : h + 1; }

// The half-edges of added edges, paired; kNoIndex for all others.
absl::StatusOr<Buffer<Index>> PairAddedEdges(const Context& context,
                                             absl::Span<const Index> triangles,
                                             absl::Span<const std::uint8_t> added) {
  std::size_t marks = 0;
  for (const std::uint8_t mark : added) marks += mark != 0;
  EdgeTable table(marks);
  Buffer<Index> pair(triangles.size(), kNoIndex);
  for (std::size_t c = 0; c < added.size(); ++c) {
    LIMN_RETURN_IF_ERROR(CheckAt(context, c));
    if (added[c] == 0) continue;
    const std::size_t h = NextCorner(c);
    const Index number = static_cast<Index>(h);
    // Under the key that the half-edge on the other side has.
    if (*table.FindOrInsert(triangles[NextCorner(h)], triangles[h], number) != number) {
      return Malformed("two added edges join the same vertices in the same direction");
    }
  }
  std::size_t paired = 0;
  for (std::size_t h = 0; h < triangles.size(); ++h) {
    LIMN_RETURN_IF_ERROR(CheckAt(context, h));
    const Index* other = table.Find(triangles[h], triangles[NextCorner(h)]);
    if (other == nullptr) continue;
    const auto taken = [&](std::size_t a, std::size_t b) {
      return pair[a] != kNoIndex && pair[a] != b;
    };
    if (taken(h, *other) || taken(*other, h)) {
      return Malformed("an added edge has more than two triangles");
    }
    pair[h] = *other;
    pair[*other] = static_cast<Index>(h);
    ++paired;
  }
  if (paired < marks) return Malformed("an added edge has one triangle only");
  return pair;
}

}  // namespace

Buffer<Index> FanTriangles(const PolygonView& faces) {
  Buffer<Index> triangles(3 * faces.triangle_count());
  Index* out = triangles.data();
  for (std::size_t f = 0; f < faces.face_count(); ++f) {
    const absl::Span<const Index> face = faces.face(f);
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      *out++ = face[0];
      *out++ = face[i];
      *out++ = face[i + 1];
    }
  }
  return triangles;
}

absl::StatusOr<Polygons> PolygonsFromFans(absl::Span<const Index> triangles,
                                          absl::Span<const Index> arities) {
  std::uint64_t corners = 0;
  for (std::size_t f = 0; f < arities.size(); ++f) {
    if (arities[f] < 3) return Malformed(absl::StrCat("face ", f, " has arity ", arities[f]));
    corners += arities[f];
  }
  if (corners - 2 * arities.size() != triangles.size() / 3) {
    return Malformed(absl::StrCat("the arities ask for ", corners - 2 * arities.size(),
                                  " triangles, but there are ", triangles.size() / 3));
  }
  Polygons polygons;
  polygons.face_begin.resize(arities.size() + 1);
  polygons.corner_vertex.resize(corners);
  const Index* in = triangles.data();
  Index* out = polygons.corner_vertex.data();
  for (std::size_t f = 0; f < arities.size(); ++f) {
    polygons.face_begin[f] = static_cast<Index>(out - polygons.corner_vertex.data());
    const Index first = in[0];
    *out++ = first;
    *out++ = in[1];
    for (Index i = 2; i < arities[f]; ++i, in += 3) {
      if (in[0] != first || in[1] != out[-1]) {
        return Malformed(absl::StrCat("the triangles of face ", f, " are not a fan"));
      }
      *out++ = in[2];
    }
  }
  polygons.face_begin.back() = static_cast<Index>(corners);
  return polygons;
}

// A polygon of t triangles that hang together over t - 1 edges has t + 2 sides, and walking round
// it crosses each of its added edges twice. When this holds for every walk, and all crossings
// together are all added edges twice, then no triangle is left out and no polygon has a hole.
absl::StatusOr<Polygons> JoinMarked(const Context& context, absl::Span<const Index> triangles,
                                    absl::Span<const std::uint8_t> added) {
  LIMN_ASSIGN_OR_RETURN(const Buffer<Index> pair, PairAddedEdges(context, triangles, added));
  Polygons polygons;
  polygons.face_begin.reserve(triangles.size() / 3 + 1);
  polygons.corner_vertex.reserve(triangles.size());
  polygons.face_begin.push_back(0);
  Buffer<std::uint8_t> visited(triangles.size(), 0);
  std::size_t open_crossings = 0;
  for (const Index other : pair) open_crossings += other != kNoIndex;
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    LIMN_RETURN_IF_ERROR(CheckAt(context, start));
    if (visited[start] != 0 || pair[start] != kNoIndex) continue;
    std::size_t crossings = 0;
    std::size_t h = start;
    do {
      visited[h] = 1;
      polygons.corner_vertex.push_back(triangles[h]);
      for (h = NextCorner(h); pair[h] != kNoIndex; h = NextCorner(pair[h])) ++crossings;
    } while (h != start);
    const std::size_t sides = polygons.corner_vertex.size() - polygons.face_begin.back();
    if (2 * sides != crossings + 6) return Malformed("added edges leave a face with a hole");
    open_crossings -= crossings;
    polygons.face_begin.push_back(static_cast<Index>(polygons.corner_vertex.size()));
  }
  if (open_crossings != 0) return Malformed("added edges leave triangles without a face");
  return polygons;
}

}  // namespace limn::wire
