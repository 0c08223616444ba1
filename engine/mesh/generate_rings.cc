// SPDX-License-Identifier: MIT
// Generated meshes made of rings of vertices around an axis, zipped into triangles and remixed:
// irregular sphere, n-gons, hub, disk.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/types/span.h"
#include "engine/mesh/generate_remix.h"
#include "engine/mesh/generate_shapes.h"

namespace limn::generate {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Vertices of a ring as angles in turns, increasing, over one turn.
struct Ring {
  Index first = 0;  // number of its first vertex
  Buffer<double> turns;

  Index size() const { return static_cast<Index>(turns.size()); }
  Index vertex(Index i) const { return first + i % size(); }
  // Angle of the i-th vertex, 0 <= i <= size + 1, counting on past a full turn.
  double angle(Index i) const { return turns[i % size()] + (i < size() ? 0 : 1); }
};

Ring MakeRing(Index first, Index count, double jitter, Random* random) {
  Ring ring;
  ring.first = first;
  ring.turns.resize(count);
  const double shift = random->Uniform();
  for (Index i = 0; i < count; ++i) {
    ring.turns[i] = (i + shift + random->Between(-jitter, jitter)) / count;
  }
  return ring;
}

// Triangles between a ring and the one farther from the north pole, counter-clockwise from
// outside.
void Zip(const Ring& inner, const Ring& outer, PolygonMesh* mesh) {
  Index i = 0;
  Index j = 0;
  while (i < inner.size() || j < outer.size()) {
    const double inner_middle = inner.angle(i) + inner.angle(i + 1);
    const double outer_middle = outer.angle(j) + outer.angle(j + 1);
    const bool on_inner = j == outer.size() || (i < inner.size() && inner_middle < outer_middle);
    if (on_inner) {
      mesh->AddFace({inner.vertex(i), outer.vertex(j), inner.vertex(i + 1)});
      ++i;
    } else {
      mesh->AddFace({inner.vertex(i), outer.vertex(j), outer.vertex(j + 1)});
      ++j;
    }
  }
}

// How vertices are spread over rings: `sizes` as shares of `total`, at least 3 each, summing up to
// `total` exactly. Needs total >= 3 * shares.size().
Buffer<Index> Apportion(const Buffer<double>& shares, std::uint64_t total) {
  double sum = 0;
  for (const double share : shares) sum += share;
  const std::uint64_t free = total - 3 * shares.size();
  Buffer<Index> sizes(shares.size());
  // What is above three a ring follows the shares that are left when three are taken off.
  const double cut = 3 * sum / static_cast<double>(total);
  double above = 0;
  for (const double share : shares) above += std::max(0.0, share - cut);
  double before = 0;
  std::uint64_t given = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    before += std::max(0.0, shares[i] - cut);
    const double part = above > 0 ? before / above
                                  : static_cast<double>(i + 1) / static_cast<double>(shares.size());
    const std::uint64_t upto =
        i + 1 == shares.size()
            ? free
            : std::min(free, static_cast<std::uint64_t>(part * static_cast<double>(free) + 0.5));
    sizes[i] = static_cast<Index>(3 + upto - given);
    given = upto;
  }
  return sizes;
}

Vec3 OnSphere(double colatitude_turns, double turns) {
  const double sine = SinTurns(colatitude_turns);
  return {sine * CosTurns(turns), sine * SinTurns(turns), CosTurns(colatitude_turns)};
}

// A triangulated unit sphere: a vertex at the north pole, rings, and one at the south pole.
// `colatitudes` of the rings in turns; vertices leave theirs by up to `jitter` of the distance to
// the next ring.
struct RingLayout {
  Buffer<Index> sizes;
  Buffer<double> colatitudes;
  double jitter = 0;
};

PolygonMesh TriangulatedSphere(const RingLayout& layout, Random* random) {
  PolygonMesh mesh;
  mesh.positions.push_back({0, 0, 1});
  Ring previous;
  for (std::size_t r = 0; r < layout.sizes.size(); ++r) {
    const auto first = static_cast<Index>(mesh.vertex_count());
    Ring ring = MakeRing(first, layout.sizes[r], layout.jitter, random);
    const double here = layout.colatitudes[r];
    const double north = r == 0 ? 0 : layout.colatitudes[r - 1];
    const double south = r + 1 == layout.sizes.size() ? 0.5 : layout.colatitudes[r + 1];
    const double reach = layout.jitter * std::min(here - north, south - here);
    for (const double turns : ring.turns) {
      mesh.positions.push_back(OnSphere(here + random->Between(-reach, reach), turns));
    }
    if (r == 0) {
      for (Index i = 0; i < ring.size(); ++i) {
        mesh.AddFace({0, ring.vertex(i), ring.vertex(i + 1)});
      }
    } else {
      Zip(previous, ring, &mesh);
    }
    previous = std::move(ring);
  }
  const auto south_pole = static_cast<Index>(mesh.vertex_count());
  mesh.positions.push_back({0, 0, -1});
  for (Index i = 0; i < previous.size(); ++i) {
    mesh.AddFace({south_pole, previous.vertex(i + 1), previous.vertex(i)});
  }
  return mesh;
}

// Evenly spread vertices: rings as far apart as the height of an equilateral triangle whose area
// is that of one of the 2 * vertices triangles.
PolygonMesh EvenSphere(std::uint64_t vertices, Random* random) {
  const double edge = std::sqrt(8 * kPi / (std::sqrt(3.0) * static_cast<double>(vertices)));
  const double rows = kPi / (edge * std::sqrt(0.75));
  const auto most = static_cast<std::int64_t>((vertices - 2) / 3);
  const std::int64_t rings =
      std::clamp(static_cast<std::int64_t>(std::floor(rows + 0.5)) - 1, std::int64_t{1}, most);
  RingLayout layout;
  layout.jitter = 0.2;
  Buffer<double> shares;
  for (std::int64_t r = 1; r <= rings; ++r) {
    layout.colatitudes.push_back(0.5 * static_cast<double>(r) / static_cast<double>(rings + 1));
    shares.push_back(SinTurns(layout.colatitudes.back()));
  }
  layout.sizes = Apportion(shares, vertices - 2);
  return TriangulatedSphere(layout, random);
}

// Pulls the points of a unit sphere in and out, so that the shape stays star-shaped.
void MakeBumpy(Random* random, PolygonMesh* mesh) {
  const Waves waves(random, 1.2);
  const Waves details(random, 4);
  for (Vec3& p : mesh->positions) p *= 1 + 0.5 * waves.At(p) + 0.05 * details.At(p);
}

Vec3 ToSphere(const Vec3& point) { return NormalizedOrZero(point); }
Vec3 ToPlane(const Vec3& point) { return {point.x, point.y, 0}; }

}  // namespace

PolygonMesh IrregularSphere(std::uint64_t vertices, Random* random) {
  PolygonMesh mesh = EvenSphere(vertices, random);
  Remix remix(mesh, mesh.positions, {.max_valence = 9, .max_arity = 8});
  remix.FlipSome(0.5, random);
  remix.Smooth(ToSphere, &mesh);
  remix.MergeSome(static_cast<std::size_t>(vertices), random);
  remix.TakeFaces(&mesh);
  MakeBumpy(random, &mesh);
  return mesh;
}

// The dual of an irregular triangulation: a vertex per triangle, a face per vertex.
PolygonMesh Ngons(std::uint64_t vertices, Random* random) {
  PolygonMesh triangles = EvenSphere(vertices / 2 + 2, random);
  Remix remix(triangles, triangles.positions, {.max_valence = 12});
  remix.FlipSome(1, random);
  remix.FlipSome(0.5, random);
  remix.Smooth(ToSphere, &triangles);
  PolygonMesh mesh;
  Buffer<Index> face;
  for (const Index corner : remix.FirstCorners()) {
    face.clear();
    remix.ForEachFaceAround(corner, [&](Index f) { face.push_back(f); });
    mesh.AddFace(face);
  }
  mesh.positions.resize(triangles.face_count(), Vec3{0, 0, 0});
  for (Index corner = 0; corner < triangles.corner_count(); ++corner) {
    mesh.positions[remix.face_of(corner)] += triangles.positions[remix.vertex_of(corner)];
  }
  for (Vec3& p : mesh.positions) p = NormalizedOrZero(p);
  MakeBumpy(random, &mesh);
  return mesh;
}

// A cap of thin triangles around the first vertex; below its rim, rings that halve.
PolygonMesh Hub(std::uint64_t vertices, Random* random) {
  const std::uint64_t spokes = std::min(vertices / 2, vertices - 5);
  RingLayout layout;
  layout.jitter = 0.15;
  layout.sizes.push_back(static_cast<Index>(spokes));
  std::uint64_t left = vertices - 2 - spokes;
  while (left > 8) {
    layout.sizes.push_back(static_cast<Index>(left / 2));
    left -= left / 2;
  }
  layout.sizes.push_back(static_cast<Index>(left));
  const std::size_t rings = layout.sizes.size();
  for (std::size_t r = 0; r < rings; ++r) {
    layout.colatitudes.push_back(0.2 + 0.3 * static_cast<double>(r) / static_cast<double>(rings));
  }
  return TriangulatedSphere(layout, random);
}

PolygonMesh Disk(std::uint64_t vertices, Random* random) {
  const double edge = std::sqrt(2 * kPi / (std::sqrt(3.0) * static_cast<double>(vertices)));
  const auto most = static_cast<std::int64_t>((vertices - 1) / 3);
  const std::int64_t rings =
      std::clamp(static_cast<std::int64_t>(std::floor(1 / (edge * std::sqrt(0.75)) + 0.5)),
                 std::int64_t{1}, most);
  Buffer<double> shares;
  for (std::int64_t r = 1; r <= rings; ++r) shares.push_back(static_cast<double>(r));
  const Buffer<Index> sizes = Apportion(shares, vertices - 1);
  PolygonMesh mesh;
  mesh.positions.push_back({0, 0, 0});
  Ring previous;
  for (std::size_t r = 0; r < sizes.size(); ++r) {
    const auto first = static_cast<Index>(mesh.vertex_count());
    Ring ring = MakeRing(first, sizes[r], 0.2, random);
    for (const double turns : ring.turns) {
      const double reach = r + 1 == sizes.size() ? 0 : 0.2;
      const double radius = (static_cast<double>(r + 1) + random->Between(-reach, reach)) /
                            static_cast<double>(rings);
      mesh.positions.push_back({radius * CosTurns(turns), radius * SinTurns(turns), 0});
    }
    for (Index i = 0; r == 0 && i < ring.size(); ++i) {
      mesh.AddFace({0, ring.vertex(i), ring.vertex(i + 1)});
    }
    if (r > 0) Zip(previous, ring, &mesh);
    previous = std::move(ring);
  }
  const Buffer<Vec3> normals(mesh.vertex_count(), Vec3{0, 0, 1});
  Remix remix(mesh, normals, {.max_valence = 9, .max_arity = 8});
  remix.FlipSome(0.5, random);
  remix.Smooth(ToPlane, &mesh);
  remix.MergeSome(static_cast<std::size_t>(vertices), random);
  remix.TakeFaces(&mesh);
  const Waves waves(random, 1);
  for (Vec3& p : mesh.positions) p.z = 0.3 * waves.At(p);
  return mesh;
}

}  // namespace limn::generate
