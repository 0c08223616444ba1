// SPDX-License-Identifier: MIT
// Generated meshes made of quads in rows and columns: torus, grid, box and scaffold.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "engine/mesh/generate_remix.h"
#include "engine/mesh/generate_shapes.h"

namespace limn::generate {
namespace {

// A rectangle of rows x columns of vertices; `closed`: the last row and column are followed by the
// first again. `extra` more vertices go into the middle of that many faces.
struct GridLayout {
  Index rows = 0;
  Index columns = 0;
  std::uint64_t extra = 0;
  bool closed = false;

  Index cell_rows() const { return closed ? rows : rows - 1; }
  Index cell_columns() const { return closed ? columns : columns - 1; }
  std::uint64_t cells() const { return std::uint64_t{cell_rows()} * cell_columns(); }
  // The vertex at that place; both may be one too large where the grid is closed.
  Index at(Index row, Index column) const { return (row % rows) * columns + column % columns; }
};

// As many rows and columns as fit, about `aspect` times as many columns as rows, at least `least`
// of each.
GridLayout FitGrid(std::uint64_t vertices, Index least, double aspect) {
  GridLayout layout;
  const double wanted = std::sqrt(static_cast<double>(vertices) / aspect);
  layout.rows = std::max(least, static_cast<Index>(wanted));
  if (vertices / layout.rows < least) layout.rows = static_cast<Index>(vertices / least);
  layout.columns = static_cast<Index>(vertices / layout.rows);
  layout.extra = vertices - std::uint64_t{layout.rows} * layout.columns;
  return layout;
}

// Where the vertices of a grid lie, as row and column, with the extra ones at the end.
struct Place {
  double row;
  double column;
};

// Quads, some of them split by a diagonal, and the extra vertices' fans. `places` gets an entry
// per vertex.
PolygonMesh GridFaces(const GridLayout& layout, Random* random, Buffer<Place>* places) {
  PolygonMesh mesh;
  for (Index r = 0; r < layout.rows; ++r) {
    for (Index c = 0; c < layout.columns; ++c) {
      places->push_back({r + random->Between(-0.15, 0.15), c + random->Between(-0.15, 0.15)});
    }
  }
  // Every so many cells one gets a vertex in its middle; there are fewer extra ones than cells.
  std::uint64_t cell = 0;
  std::uint64_t placed = 0;
  for (Index r = 0; r < layout.cell_rows(); ++r) {
    for (Index c = 0; c < layout.cell_columns(); ++c, ++cell) {
      const std::array<Index, 4> quad = {layout.at(r, c), layout.at(r, c + 1),
                                         layout.at(r + 1, c + 1), layout.at(r + 1, c)};
      const std::uint64_t due = (cell + 1) * layout.extra / layout.cells();
      const double choice = random->Uniform();
      if (due > placed) {
        const auto middle = static_cast<Index>(places->size());
        places->push_back({r + 0.5, c + 0.5});
        for (std::size_t i = 0; i < 4; ++i) mesh.AddFace({quad[i], quad[(i + 1) % 4], middle});
        ++placed;
      } else if (choice < 0.1) {
        mesh.AddFace({quad[0], quad[1], quad[2]});
        mesh.AddFace({quad[2], quad[3], quad[0]});
      } else if (choice < 0.2) {
        mesh.AddFace({quad[1], quad[2], quad[3]});
        mesh.AddFace({quad[3], quad[0], quad[1]});
      } else {
        mesh.AddFace(quad);
      }
    }
  }
  return mesh;
}

void MergeSomeFaces(absl::Span<const Vec3> normals, Random* random, PolygonMesh* mesh) {
  // Two quads merge into a hexagon with two straight corners, which is flat enough to be fair.
  Remix remix(*mesh, normals, {.max_valence = 9, .max_arity = 8, .min_turn = -0.2});
  remix.MergeSome(mesh->face_count() / 6, random);
  remix.TakeFaces(mesh);
}

// Lengths that grow by about a factor of `growth` over all steps, each off by up to a quarter:
// n + 1 coordinates centred at 0.
Buffer<double> GradedSteps(Index n, double growth, Random* random) {
  Buffer<double> at(n + 1, 0);
  for (Index i = 0; i < n; ++i) {
    const double share = n == 1 ? 0 : static_cast<double>(i) / (n - 1);
    at[i + 1] = at[i] + (1 + (growth - 1) * share * share) * random->Between(0.75, 1.25);
  }
  const double middle = at[n] / 2;
  for (double& x : at) x -= middle;
  return at;
}

// Lengths that grow geometrically from both ends to the middle, each off by up to a tenth; the
// growth over half of n steps comes close to exp(4) for large n. n + 1 coordinates centred at 0.
Buffer<double> CrowdedSteps(Index n, Random* random) {
  Buffer<double> at(n + 1, 0);
  const double ratio = 1 + 8.0 / n;
  Buffer<double> length(n, 1);
  for (Index i = 1; i < n - n / 2; ++i) length[i] = length[i - 1] * ratio;
  for (Index i = n - n / 2; i < n; ++i) length[i] = length[n - 1 - i];
  for (Index i = 0; i < n; ++i) at[i + 1] = at[i] + length[i] * random->Between(0.9, 1.1);
  const double middle = at[n] / 2;
  for (double& x : at) x = (x - middle) / middle;
  return at;
}

// The surface of a box of x by y by z cells. Its vertices are numbered layer by layer: the whole
// bottom, the outlines of the layers between, the whole top.
struct Box {
  Index x = 1;
  Index y = 1;
  Index z = 1;

  std::uint64_t vertices() const {
    return 2 * (std::uint64_t{x} * y + std::uint64_t{y} * z + std::uint64_t{z} * x) + 2;
  }
  Index outline() const { return 2 * (x + y); }
  // Column and row of a place on the outline, counter-clockwise seen from above.
  std::array<Index, 2> OutlinePlace(Index k) const {
    if (k < x) return {k, 0};
    if (k < x + y) return {x, k - x};
    if (k < 2 * x + y) return {2 * x + y - k, y};
    return {0, outline() - k};
  }
  Index InRectangle(Index column, Index row) const { return row * (x + 1) + column; }
  Index OnTop(Index column, Index row) const {
    return (x + 1) * (y + 1) + (z - 1) * outline() + InRectangle(column, row);
  }
  // Vertex at a place of the outline, in any layer.
  Index OnSide(Index layer, Index k) const {
    k %= outline();
    const auto [column, row] = OutlinePlace(k);
    if (layer == 0) return InRectangle(column, row);
    if (layer == z) return OnTop(column, row);
    return (x + 1) * (y + 1) + (layer - 1) * outline() + k;
  }
};

// The box with the most vertices up to the wanted number, among those with a square base that are
// about as high as wide.
Box FitBox(std::uint64_t vertices) {
  const auto cube = static_cast<Index>(std::sqrt(static_cast<double>(vertices - 2) / 6));
  Box best;
  for (Index side = std::max<Index>(1, cube - cube / 8); side <= cube + cube / 8 + 1; ++side) {
    const std::uint64_t caps = 2 * std::uint64_t{side} * side + 2;
    if (caps + 4 * std::uint64_t{side} > vertices) continue;
    const Box box = {side, side, static_cast<Index>((vertices - caps) / (4 * std::uint64_t{side}))};
    if (box.vertices() > best.vertices()) best = box;
  }
  return best;
}

void AddBoxFaces(const Box& box, PolygonMesh* mesh) {
  for (Index row = 0; row < box.y; ++row) {
    for (Index column = 0; column < box.x; ++column) {
      mesh->AddFace({box.InRectangle(column, row), box.InRectangle(column, row + 1),
                     box.InRectangle(column + 1, row + 1), box.InRectangle(column + 1, row)});
    }
  }
  for (Index layer = 0; layer < box.z; ++layer) {
    for (Index k = 0; k < box.outline(); ++k) {
      mesh->AddFace({box.OnSide(layer, k), box.OnSide(layer, k + 1), box.OnSide(layer + 1, k + 1),
                     box.OnSide(layer + 1, k)});
    }
  }
  for (Index row = 0; row < box.y; ++row) {
    for (Index column = 0; column < box.x; ++column) {
      mesh->AddFace({box.OnTop(column, row), box.OnTop(column + 1, row),
                     box.OnTop(column + 1, row + 1), box.OnTop(column, row + 1)});
    }
  }
}

PolygonMesh BoxOfGridLines(const Box& box, absl::Span<const double> x, absl::Span<const double> y,
                           absl::Span<const double> z) {
  PolygonMesh mesh;
  for (Index layer = 0; layer <= box.z; ++layer) {
    if (layer == 0 || layer == box.z) {
      for (const double row : y) {
        for (const double column : x) mesh.positions.push_back({column, row, z[layer]});
      }
      continue;
    }
    for (Index k = 0; k < box.outline(); ++k) {
      const auto [column, row] = box.OutlinePlace(k);
      mesh.positions.push_back({x[column], y[row], z[layer]});
    }
  }
  AddBoxFaces(box, &mesh);
  return mesh;
}

// A lattice of nodes, filled row by row and layer by layer, in a cube of `side` nodes a side.
struct Lattice {
  std::uint64_t nodes = 0;
  std::uint64_t side = 1;

  std::array<std::uint64_t, 3> Place(std::uint64_t node) const {
    return {node % side, node / side % side, node / (side * side)};
  }
  // The next node along an axis, or `nodes` if there is none.
  std::uint64_t After(std::uint64_t node, std::size_t axis) const {
    const std::uint64_t step = axis == 0 ? 1 : axis == 1 ? side : side * side;
    if (Place(node)[axis] + 1 >= side) return nodes;
    return std::min(node + step, nodes);
  }
  bool HasBefore(std::uint64_t node, std::size_t axis) const { return Place(node)[axis] > 0; }
};

// The i-th corner of a node's side across `axis`, counter-clockwise seen from the axis' far end.
// Corner numbers have a bit per axis: 1 on the far side.
Index SideCorner(std::size_t axis, bool far, Index i) {
  const Index second = i == 1 || i == 2 ? 1 : 0;
  const Index third = i >= 2 ? 1 : 0;
  return (far ? 1U : 0U) << axis | second << (axis + 1) % 3 | third << (axis + 2) % 3;
}

// Closes a node's sides without a bar and adds the bars to the nodes after it.
void AddNodeFaces(const Lattice& lattice, std::uint64_t node, PolygonMesh* mesh) {
  const auto here = static_cast<Index>(8 * node);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!lattice.HasBefore(node, axis)) {
      mesh->AddFace({here + SideCorner(axis, false, 3), here + SideCorner(axis, false, 2),
                     here + SideCorner(axis, false, 1), here + SideCorner(axis, false, 0)});
    }
    const std::uint64_t after = lattice.After(node, axis);
    if (after == lattice.nodes) {
      mesh->AddFace({here + SideCorner(axis, true, 0), here + SideCorner(axis, true, 1),
                     here + SideCorner(axis, true, 2), here + SideCorner(axis, true, 3)});
      continue;
    }
    const auto there = static_cast<Index>(8 * after);
    for (Index i = 0; i < 4; ++i) {
      const Index j = (i + 1) % 4;
      mesh->AddFace({here + SideCorner(axis, true, i), here + SideCorner(axis, true, j),
                     there + SideCorner(axis, false, j), there + SideCorner(axis, false, i)});
    }
  }
}

}  // namespace

PolygonMesh Torus(std::uint64_t vertices, Random* random) {
  GridLayout layout = FitGrid(vertices, 3, 2.5);
  layout.closed = true;
  Buffer<Place> places;
  PolygonMesh mesh = GridFaces(layout, random, &places);
  Buffer<Vec3> normals;
  for (const Place& place : places) {
    const double around = place.row / layout.rows;
    const double along = place.column / layout.columns;
    const Vec3 spoke = {CosTurns(along), SinTurns(along), 0};
    normals.push_back(CosTurns(around) * spoke + SinTurns(around) * Vec3{0, 0, 1});
    mesh.positions.push_back(spoke + 0.4 * normals.back());
  }
  MergeSomeFaces(normals, random, &mesh);
  return mesh;
}

PolygonMesh Grid(std::uint64_t vertices, Random* random) {
  const GridLayout layout = FitGrid(vertices, 2, 1.5);
  Buffer<Place> places;
  PolygonMesh mesh = GridFaces(layout, random, &places);
  const Waves waves(random, 1);
  const double scale = 1.0 / layout.rows;
  for (const Place& place : places) {
    mesh.positions.push_back({place.column * scale, place.row * scale, 0});
  }
  const Buffer<Vec3> normals(mesh.vertex_count(), Vec3{0, 0, 1});
  MergeSomeFaces(normals, random, &mesh);
  for (Vec3& p : mesh.positions) p.z = 0.2 * waves.At(p);
  return mesh;
}

PolygonMesh Cube(std::uint64_t vertices, Random* random) {
  const Box box = FitBox(vertices);
  const Buffer<double> x = GradedSteps(box.x, 4, random);
  const Buffer<double> y = GradedSteps(box.y, 4, random);
  const Buffer<double> z = GradedSteps(box.z, 4, random);
  return BoxOfGridLines(box, x, y, z);
}

PolygonMesh GradedBox(std::uint64_t vertices, Random* random) {
  const Box box = FitBox(vertices);
  const Buffer<double> x = CrowdedSteps(box.x, random);
  const Buffer<double> y = CrowdedSteps(box.y, random);
  const Buffer<double> z = CrowdedSteps(box.z, random);
  return BoxOfGridLines(box, x, y, z);
}

PolygonMesh HighGenus(std::uint64_t vertices, Random* random) {
  Lattice lattice;
  lattice.nodes = vertices / 8;
  while (lattice.side * lattice.side * lattice.side < lattice.nodes) ++lattice.side;
  PolygonMesh mesh;
  for (std::uint64_t node = 0; node < lattice.nodes; ++node) {
    const auto [i, j, k] = lattice.Place(node);
    const Vec3 centre =
        Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)} +
        0.08 * Vec3{random->Between(-1, 1), random->Between(-1, 1), random->Between(-1, 1)};
    const double half = random->Between(0.15, 0.3);
    for (unsigned corner = 0; corner < 8; ++corner) {
      mesh.positions.push_back(centre + half * Vec3{(corner & 1U) != 0 ? 1.0 : -1.0,
                                                    (corner & 2U) != 0 ? 1.0 : -1.0,
                                                    (corner & 4U) != 0 ? 1.0 : -1.0});
    }
  }
  for (std::uint64_t node = 0; node < lattice.nodes; ++node) AddNodeFaces(lattice, node, &mesh);
  return mesh;
}

}  // namespace limn::generate
