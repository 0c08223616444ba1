// SPDX-License-Identifier: MIT
// Figs. 9 to 11 of Xu and Kondo: a golf club as a rough polyhedron, with a striking face of one
// piece.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/experiments/first_refined_mesh.h"
#include "tests/experiments/scene.h"
#include "tests/experiments/xu_kondo.h"

namespace limn::experiments {
namespace {

constexpr Index kColumns = 4;
constexpr Index kRows = 3;
// Outline of the sole, from heel to toe and from the striking face to the back, and the crown's
// heights over it.
constexpr std::array<std::array<double, kColumns>, kRows> kX = {
    {{-1.5, -0.6, 0.5, 1.5}, {-1.6, -0.65, 0.55, 1.75}, {-1.1, -0.5, 0.45, 1.1}}};
constexpr std::array<double, kRows> kY = {-1, 0.1, 1.2};
constexpr std::array<std::array<double, kColumns>, kRows> kZ = {
    {{0.95, 1.05, 1.05, 0.9}, {0.85, 0.95, 0.95, 0.8}, {0.5, 0.55, 0.55, 0.5}}};

// The sections of the shaft, over the crown's quad at the heel.
struct Section {
  Vec3 middle;
  double half;
};
constexpr std::array<Section, 3> kShaft = {
    {{{-1.2, -0.42, 1.5}, 0.2}, {{-1.55, -0.42, 2.6}, 0.17}, {{-2.2, -0.42, 4.6}, 0.17}}};

struct Club {
  PolygonMesh mesh;
  Index striking_face = 0;
  // Number of head's vertices: those after it are the shaft's.
  Index head = 0;
};

Club MakeClub() {
  Club club;
  PolygonMesh& mesh = club.mesh;
  for (const bool crown : {false, true}) {
    for (std::size_t j = 0; j < kRows; ++j) {
      for (std::size_t i = 0; i < kColumns; ++i) {
        mesh.positions.push_back({kX[j][i], kY[j], crown ? kZ[j][i] : 0});
      }
    }
  }
  club.head = static_cast<Index>(mesh.vertex_count());
  const auto sole = [](Index i, Index j) { return j * kColumns + i; };
  const auto crown = [&](Index i, Index j) { return kRows * kColumns + sole(i, j); };
  // One face of eight corners: the sole's edge and back along the crown's.
  mesh.AddFace({sole(0, 0), sole(1, 0), sole(2, 0), sole(3, 0), crown(3, 0), crown(2, 0),
                crown(1, 0), crown(0, 0)});
  for (Index j = 0; j + 1 < kRows; ++j) {
    for (Index i = 0; i + 1 < kColumns; ++i) {
      mesh.AddFace({sole(i, j), sole(i, j + 1), sole(i + 1, j + 1), sole(i + 1, j)});
      if (i == 0 && j == 0) continue;
      mesh.AddFace({crown(i, j), crown(i + 1, j), crown(i + 1, j + 1), crown(i, j + 1)});
    }
    mesh.AddFace({sole(0, j), crown(0, j), crown(0, j + 1), sole(0, j + 1)});
    mesh.AddFace({sole(3, j), sole(3, j + 1), crown(3, j + 1), crown(3, j)});
  }
  for (Index i = 0; i + 1 < kColumns; ++i) {
    mesh.AddFace({sole(i, 2), crown(i, 2), crown(i + 1, 2), sole(i + 1, 2)});
  }
  std::array<Index, 4> ring = {crown(0, 0), crown(1, 0), crown(1, 1), crown(0, 1)};
  for (const Section& section : kShaft) {
    const auto first = static_cast<Index>(mesh.vertex_count());
    const double h = section.half;
    for (const Vec3& corner : {Vec3{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}}) {
      mesh.positions.push_back(section.middle + corner);
    }
    for (Index i = 0; i < 4; ++i) {
      const Index next = (i + 1) % 4;
      mesh.AddFace({ring[i], ring[next], first + next, first + i});
    }
    ring = {first, first + 1, first + 2, first + 3};
  }
  mesh.AddFace(ring);
  return club;
}

// Sharp around the striking face and the sole, round at the shaft.
FeatureValues ClubValues(const Club& club, bool plane) {
  FeatureValues values = {.default_edge = 0.5, .default_vertex = 1};
  const auto sharp = [&](Index a, Index b, double value) {
    values.edges.push_back({a, b, std::nullopt, value});
  };
  const absl::Span<const Index> face = club.mesh.face(club.striking_face);
  for (std::size_t i = 0; i < face.size(); ++i) sharp(face[i], face[(i + 1) % face.size()], 0.1);
  for (const Index v : {face[0], face[3], face[4]})
    values.vertices.push_back({v, std::nullopt, 0.3});
  // The sole's edge at the toe and the back.
  const std::vector<Index> rim = {3, 7, 11, 10, 9, 8, 4, 0};
  for (std::size_t i = 0; i + 1 < rim.size(); ++i) sharp(rim[i], rim[i + 1], 0.2);
  if (plane) values.faces = {{club.striking_face, FaceKind::kPlane}};
  return values;
}

// How far the surface's vertices in a face are from the face's plane, which is upright.
double OffPlane(const Club& club, const InterpolateResult& result) {
  const std::size_t per_corner = std::size_t{1} << (2 * (result.surface.level - 1));
  const std::size_t first = club.mesh.face_begin[club.striking_face] * per_corner;
  const std::size_t last = club.mesh.face_begin[club.striking_face + 1] * per_corner;
  double most = 0;
  for (std::size_t c = 4 * first; c < 4 * last; ++c) {
    const Vec3& p = result.surface.positions[result.surface.face_vertices[c]];
    most = std::max(most, std::fabs(p.y - kY[0]));
  }
  return most;
}

}  // namespace

void RunClub(const Setup& setup, Report* report) {
  const Club club = MakeClub();
  const std::uint32_t level = setup.quick ? 3 : 5;
  const InterpolateResult plain = Plain(setup, club.mesh, level);
  const InterpolateResult shaped = Shape(setup, club.mesh, ClubValues(club, false), level);
  const InterpolateResult plane = Shape(setup, club.mesh, ClubValues(club, true), level);
  WriteScene(setup, "fig10a", club.mesh);
  WriteScene(setup, "fig10b", FirstRefinedMesh(std::get<DooSabinSurface>(*shaped.patches)));
  WriteScene(setup, "fig9e", plain.surface);
  WriteScene(setup, "fig10e", shaped.surface);
  WriteScene(setup, "fig11", plane.surface);
  WriteScene(setup, "row9",
             SideBySide({.surfaces = {plain.surface, shaped.surface, plane.surface},
                         .step = {4.3, 0, 0}}));
  report->Heading("Figs. 9 to 11: a club");
  report->Paragraph(absl::StrCat(
      "A rough polyhedron of ", club.mesh.vertex_count(), " vertices and ", club.mesh.face_count(),
      " faces; the striking face is one of them. Doo-Sabin alone rounds everything; feature values "
      "make its edges and those of the sole sharp; FFV 0 makes the striking face a plane."));
  report->Pictures(
      {{"fig10a.png", "9a, 10a: given"}, {"fig10b.png", "10b: divided by feature values"}});
  report->Pictures({{"fig9e.png", "9: Doo-Sabin alone"},
                    {"fig10e.png", "10: feature values"},
                    {"fig11.png", "11: with a plane face"}});
  std::vector<Report::Row> rows;
  for (const auto& [name, result] : {std::pair<std::string, const InterpolateResult&>{"9", plain},
                                     {"10", shaped},
                                     {"11", plane}}) {
    rows.push_back({name, absl::StrFormat("%.3f", VolumeOf(result.surface)),
                    Scientific(OffPlane(club, result))});
  }
  report->Paragraph("Volume, and largest distance of the striking face's part from its plane:");
  report->Table({"figure", "volume", "off the plane"}, rows);
  report->CheckAtMost("Club: the plane face's region is planar", OffPlane(club, plane), 1e-12);
  report->Check("Club: feature values come nearer to the polyhedron than Doo-Sabin alone",
                VolumeOf(shaped.surface) > VolumeOf(plain.surface) &&
                    OffPlane(club, shaped) < OffPlane(club, plain));
}

}  // namespace limn::experiments
