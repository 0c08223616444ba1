// SPDX-License-Identifier: MIT
#include "engine/constraints/blend.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/blend_joint.h"
#include "engine/constraints/blend_map.h"
#include "engine/constraints/blend_region.h"
#include "engine/constraints/certificate.h"
#include "engine/limit/evaluate.h"
#include "engine/limit/vertex_limit.h"

namespace limn {
namespace {

constexpr double kTolerance = 1e-10;
constexpr std::size_t kMostTogether = 65'536;
// Of a place; its ring is evaluated once for each point of it.
constexpr std::size_t kMostSupport = 4096;
// How much larger or smaller than the surface's own a derivative may be, and how far away a point
// in terms of the bounding box: beyond, rounding alone is more than the tolerance.
constexpr double kMostChange = 1e5;
constexpr std::size_t kTargetsPerChunk = 32;

absl::Status Refuse(const BlendTarget& target, std::string_view member, const std::string& message,
                    std::string_view remedy) {
  std::string field = absl::StrCat(target.path(), std::string(member));
  std::string text = absl::StrCat(field, ": ", message);
  return MakeError(text, {.reason = Reason::kInvalidOption,
                          .field = std::move(field),
                          .index = target.index,
                          .remedy = std::string(remedy)});
}

// The corner of T^0 at whose vertex, of T^0, half-edge h of T^2 begins.
SurfaceParameter AtHalfEdge(const PrimalSurface& surface, Index h) {
  if (surface.kind == RingKind::kTriangles) {
    const Index triangle = h / 3;
    return {.face = triangle / 16, .corner = triangle / 4 % 4};
  }
  const Index corner = h / 16;
  const auto after = std::upper_bound(surface.face_begin.begin(), surface.face_begin.end(), corner);
  const auto face = static_cast<Index>(after - surface.face_begin.begin() - 1);
  return {.face = face, .corner = corner - surface.face_begin[face]};
}

// A corner of T^0 at a vertex of it.
SurfaceParameter AtVertex(const PrimalSurface& surface, Index vertex) {
  return AtHalfEdge(surface, surface.mesh.vertex_half_edge()[vertex]);
}

// Ring 0.
BlendPlace PlaceOf(const PrimalSurface& surface, const SurfaceParameter& parameter) {
  PatchPlace place;
  const Index h = FindPatch(surface, parameter, &place);
  const auto sides = static_cast<Index>(place.sides());
  const Index first = h - h % sides;
  BlendPlace vertices;
  for (Index i = 0; i < sides; ++i) {
    vertices.push_back(surface.mesh.vertex()[first + (h % sides + i) % sides]);
  }
  const std::size_t at = place.CornerAt();
  if (at < sides) return {vertices[at]};
  return vertices;
}

class Blender {
 public:
  Blender(const Context& context, const BlendInput& input, PrimalSurface* surface)
      : context_(context),
        input_(input),
        surface_(*surface),
        targets_(input.targets),
        places_(surface->mesh, input.stays) {
    for (const BlendTarget& target : targets_) {
      places_.Add(PlaceOf(surface_, target.place));
      parameters_.push_back(target.place);
    }
  }

  absl::StatusOr<BlendReport> Run() {
    LIMN_ASSIGN_OR_RETURN(before_, Evaluate());
    LIMN_RETURN_IF_ERROR(FindMaps());
    LIMN_RETURN_IF_ERROR(FindRegions());
    FindGroups();
    LIMN_RETURN_IF_ERROR(NoteJointAims());
    LIMN_RETURN_IF_ERROR(MoveEach());
    for (JointProblem& problem : problems_) {
      LIMN_RETURN_IF_ERROR(MeetJointly(context_, problem, &surface_));
    }
    LIMN_RETURN_IF_ERROR(Verify());
    return std::move(report_);
  }

 private:
  // What the surface is at the targets now, relative to its origin.
  absl::StatusOr<std::vector<PatchSample>> Evaluate() {
    const std::size_t n = targets_.size();
    std::vector<Vec3> point(n);
    std::vector<Vec3> du(n);
    std::vector<Vec3> dv(n);
    std::vector<Vec3> normal(n);
    LIMN_RETURN_IF_ERROR(EvaluateSurface(context_, surface_, parameters_,
                                         {.points = absl::MakeSpan(point),
                                          .du = absl::MakeSpan(du),
                                          .dv = absl::MakeSpan(dv),
                                          .normals = absl::MakeSpan(normal)}));
    std::vector<PatchSample> samples(n);
    for (std::size_t i = 0; i < n; ++i) samples[i] = {point[i], du[i], dv[i], normal[i]};
    LIMN_RETURN_IF_ERROR(TakeVertexNormals(&samples));
    return samples;
  }

  // Those of tessellations: where surfaces meet at sharp edges, of all.
  absl::Status TakeVertexNormals(std::vector<PatchSample>* samples) {
    std::size_t end = 0;
    for (const BlendTarget& target : targets_) {
      if (target.vertex && target.normal) end = std::max<std::size_t>(end, *target.vertex + 1);
    }
    if (end == 0) return absl::OkStatus();
    Buffer<Vec3> points(end);
    Buffer<Vec3> normals(end);
    const SurfaceLevel level = {surface_.mesh, surface_.sharpness};
    const VertexLimits limits = {
        .points = absl::MakeSpan(points), .tangents = {}, .normals = absl::MakeSpan(normals)};
    LIMN_RETURN_IF_ERROR(surface_.kind == RingKind::kQuads
                             ? CatmullClarkLimits(context_, level, surface_.points, limits)
                             : LoopLimits(context_, level, surface_.points, limits));
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (targets_[i].vertex && targets_[i].normal) {
        (*samples)[i].normal = normals[*targets_[i].vertex];
      }
    }
    return absl::OkStatus();
  }

  absl::Status FindMaps() {
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      const std::optional<AffineMap> map = MapTo(targets_[i], before_[i]);
      if (!map.has_value()) {
        return Refuse(targets_[i], targets_[i].normal ? ".normal" : "",
                      "the surface has no tangent plane there",
                      "Ask for the point only, or move the constraint");
      }
      LIMN_RETURN_IF_ERROR(CheckSize(targets_[i], before_[i]));
      maps_.push_back(*map);
    }
    return absl::OkStatus();
  }

  absl::Status CheckSize(const BlendTarget& target, const PatchSample& now) const {
    // Written so that NaN is refused.
    if (target.point && !(Norm(*target.point - now.point) <= kMostChange * input_.scale)) {
      return Refuse(target, ".point", "it is too far from the surface",
                    absl::StrCat("It must be within ", kMostChange, " diagonals of the mesh"));
    }
    const auto check = [&](const char* member, const std::optional<Vec3>& wanted,
                           const Vec3& is) -> absl::Status {
      if (!wanted.has_value()) return absl::OkStatus();
      const double change = Norm(*wanted) / Norm(is);
      if (change <= kMostChange && change >= 1 / kMostChange) return absl::OkStatus();
      return Refuse(target, member,
                    absl::StrCat("its length is ", change, " times that of the surface's"),
                    absl::StrCat("It must be within a factor of ", kMostChange));
    };
    LIMN_RETURN_IF_ERROR(check(".derivative_u", target.du, now.du));
    return check(".derivative_v", target.dv, now.dv);
  }

  absl::Status FindRegions() {
    regions_.resize(targets_.size());
    std::atomic<std::uint64_t> points = 0;
    const auto find = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && points <= input_.most_points; ++i) {
        if (context_.stop_requested()) return;
        regions_[i] = targets_[i].region.empty() ? ChooseRegion(places_, i)
                                                 : GivenRegion(places_, i, targets_[i].region);
        points += regions_[i].vertices.size();
      }
    };
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, targets_.size(), kTargetsPerChunk, find));
    if (points > input_.most_points) {
      return MakeError(absl::StrCat("constraints on the surface would move more than ",
                                    input_.most_points, " control points"),
                       {.reason = Reason::kLimitExceeded,
                        .field = "constraints",
                        .remedy = "Ask for fewer near vertices of many faces, or give smaller "
                                  "regions"});
    }
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      if (regions_[i].touched.size() > kMostTouched) return TooClose(i, kMostTouched);
      if (!regions_[i].vertices.empty()) continue;
      return Refuse(targets_[i], ".region", "it is too small",
                    "Give all faces of the twice refined mesh within three rings of the place");
    }
    return absl::OkStatus();
  }

  // Places that have to be met together: those that a region touches, with the region's own.
  void FindGroups() {
    std::vector<std::size_t> parent(targets_.size());
    for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = i;
    const auto root = [&parent](std::size_t i) {
      while (parent[i] != i) i = parent[i] = parent[parent[i]];
      return i;
    };
    // Of vertices that stay, the target whose region touched each first.
    absl::flat_hash_map<std::size_t, std::size_t> staying;
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      for (const std::size_t j : regions_[i].touched) {
        const std::size_t other = j < targets_.size() ? j : staying.try_emplace(j, i).first->second;
        // The smaller one stays the root, so that groups come in the order of the targets.
        const auto [low, high] = std::minmax({root(i), root(other)});
        parent[high] = low;
      }
    }
    absl::flat_hash_map<std::size_t, std::size_t> group_of;
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      const std::size_t r = root(i);
      const auto [at, fresh] = group_of.try_emplace(r, groups_.size());
      if (fresh) groups_.emplace_back();
      groups_[at->second].push_back(i);
    }
    std::erase_if(groups_, [this](const std::vector<std::size_t>& group) {
      return group.size() == 1 && regions_[group[0]].touched.empty();
    });
  }

  // Before anything moves: what stays is where it is now.
  absl::Status NoteJointAims() {
    for (const std::vector<std::size_t>& group : groups_) {
      JointProblem problem;
      std::vector<std::size_t> members = group;
      for (const std::size_t i : group) {
        members.insert(members.end(), regions_[i].touched.begin(), regions_[i].touched.end());
      }
      std::sort(members.begin(), members.end());
      members.erase(std::unique(members.begin(), members.end()), members.end());
      if (members.size() > kMostTogether) return TooClose(group[0], kMostTogether);
      for (const std::size_t i : members) {
        LIMN_RETURN_IF_ERROR(AddAims(i, group[0], &problem));
      }
      absl::flat_hash_map<Index, std::size_t> known;
      for (const std::size_t i : group) {
        report_.together += 1;
        for (std::size_t j = 0; j < regions_[i].vertices.size(); ++j) {
          const auto [at, fresh] =
              known.try_emplace(regions_[i].vertices[j], problem.vertices.size());
          if (fresh) {
            problem.vertices.push_back(regions_[i].vertices[j]);
            problem.weights.push_back(regions_[i].weights[j]);
          } else {
            double& weight = problem.weights[at->second];
            weight = std::max(weight, regions_[i].weights[j]);
          }
        }
      }
      problems_.push_back(std::move(problem));
    }
    return absl::OkStatus();
  }

  absl::Status TooClose(std::size_t i, std::size_t most) const {
    return MakeError(absl::StrCat(targets_[i].path(), ": it is too close to more than ", most,
                                  " constraints and vertices"),
                     {.reason = Reason::kLimitExceeded,
                      .field = targets_[i].path(),
                      .index = targets_[i].index,
                      .remedy = "Ask for fewer, give a smaller region, or refine the mesh"});
  }

  // What place i has to be, now and after everything has moved. first: of the group, for messages.
  absl::Status AddAims(std::size_t i, std::size_t first, JointProblem* problem) const {
    LIMN_RETURN_IF_ERROR(context_.Check());
    JointAim aim = {.support = Support(surface_.mesh, places_.At(i))};
    if (aim.support.size() > kMostSupport) return TooClose(first, kMostSupport);
    if (i >= targets_.size()) {
      aim.place = AtVertex(surface_, places_.At(i)[0]);
      LIMN_ASSIGN_OR_RETURN(const PatchSample now, Sample(aim.place));
      aim.point = now.point;
      problem->aims.push_back(std::move(aim));
      return absl::OkStatus();
    }
    const BlendTarget& target = targets_[i];
    const Matrix3& linear = maps_[i].linear;
    aim.point = maps_[i].to;
    aim.has_du = target.du.has_value() || target.normal.has_value();
    aim.has_dv = target.dv.has_value() || target.normal.has_value();
    std::vector<SurfaceParameter> places = {target.place};
    // Where surfaces meet at what is sharp, all of them turn.
    if (target.vertex && target.normal && IsSharp(*target.vertex)) {
      places = CornersAround(*target.vertex);
    }
    for (const SurfaceParameter& place : places) {
      LIMN_ASSIGN_OR_RETURN(const PatchSample now, Sample(place));
      aim.place = place;
      aim.du = linear * now.du;
      aim.dv = linear * now.dv;
      problem->aims.push_back(aim);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<PatchSample> Sample(const SurfaceParameter& place) const {
    PatchSample sample;
    LIMN_RETURN_IF_ERROR(EvaluateSurface(context_, surface_, absl::MakeConstSpan(&place, 1),
                                         SurfaceSamples{.points = absl::MakeSpan(&sample.point, 1),
                                                        .du = absl::MakeSpan(&sample.du, 1),
                                                        .dv = absl::MakeSpan(&sample.dv, 1)}));
    return sample;
  }

  template <class Visit>
  void VisitHalfEdges(Index vertex, const Visit& visit) const {
    WithWalk(surface_.mesh, [&](const auto& walk) {
      VisitFan(walk, surface_.mesh.twin(), surface_.mesh.vertex_half_edge()[vertex], visit);
    });
  }

  // Whether an edge inside the mesh is sharp there.
  bool IsSharp(Index vertex) const {
    if (!surface_.sharpness.creased()) return false;
    bool sharp = false;
    VisitHalfEdges(vertex, [&](Index h) {
      const bool inside = surface_.mesh.twin()[h] != kNoIndex;
      sharp = sharp || (inside && surface_.sharpness.edge[surface_.mesh.edge()[h]] > 0);
    });
    return sharp;
  }

  std::vector<SurfaceParameter> CornersAround(Index vertex) const {
    std::vector<SurfaceParameter> corners;
    VisitHalfEdges(vertex, [&](Index h) { corners.push_back(AtHalfEdge(surface_, h)); });
    return corners;
  }

  // Each constraint's own movement. Where several reach, and not all of their weights fit into 1,
  // they are averaged.
  absl::Status MoveEach() {
    std::vector<std::tuple<Index, std::uint32_t, double>> moves;
    std::size_t count = 0;
    for (const BlendRegion& region : regions_) count += region.vertices.size();
    moves.reserve(count);
    for (std::size_t i = 0; i < regions_.size(); ++i) {
      if (i % kTargetsPerChunk == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      for (std::size_t j = 0; j < regions_[i].vertices.size(); ++j) {
        moves.emplace_back(regions_[i].vertices[j], static_cast<std::uint32_t>(i),
                           regions_[i].weights[j]);
      }
    }
    std::sort(moves.begin(), moves.end());
    for (std::size_t i = 0; i < moves.size();) {
      const Index v = std::get<0>(moves[i]);
      const Vec3 point = surface_.points[v];
      Vec3 move = {0, 0, 0};
      double sum = 0;
      for (; i < moves.size() && std::get<0>(moves[i]) == v; ++i) {
        const auto& [vertex, target, weight] = moves[i];
        move += weight * maps_[target].Move(point);
        sum += weight;
      }
      surface_.points[v] = point + (sum > 1 ? 1 / sum : 1) * move;
      report_.moved.push_back(v);
    }
    return absl::OkStatus();
  }

  absl::Status Verify() {
    LIMN_ASSIGN_OR_RETURN(const std::vector<PatchSample> now, Evaluate());
    report_.constraints = targets_.size();
    for (std::size_t i = 0; i < targets_.size(); ++i) {
      const BlendTarget& target = targets_[i];
      const double point = Norm(now[i].point - maps_[i].to);
      const double normal = target.normal ? AngleBetweenLines(now[i].normal, *target.normal) : 0;
      double derivative = 0;
      if (target.du) derivative = Norm(now[i].du - *target.du) / Norm(*target.du);
      if (target.dv) {
        derivative = std::max(derivative, Norm(now[i].dv - *target.dv) / Norm(*target.dv));
      }
      // Written so that NaN is refused.
      if (!(point <= kTolerance * input_.scale && normal <= kTolerance &&
            derivative <= kTolerance)) {
        return Contradiction(i);
      }
      report_.max_point_error = std::max(report_.max_point_error, point);
      report_.max_normal_deviation = std::max(report_.max_normal_deviation, normal);
      report_.max_derivative_error = std::max(report_.max_derivative_error, derivative);
    }
    return VerifyStaying();
  }

  absl::Status VerifyStaying() {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      for (const JointAim& aim : problems_[g].aims) {
        LIMN_ASSIGN_OR_RETURN(const PatchSample now, Sample(aim.place));
        if (!(Norm(now.point - aim.point) <= kTolerance * input_.scale)) {
          return Contradiction(groups_[g][0]);
        }
      }
    }
    return absl::OkStatus();
  }

  // That target i is not met.
  absl::Status Contradiction(std::size_t i) const {
    std::size_t other = i;
    for (const std::size_t j : regions_[i].touched) {
      if (other == i || (j < targets_.size() && other >= targets_.size())) other = j;
    }
    for (std::size_t k = 0; other == i && k < targets_.size(); ++k) {
      const std::vector<std::size_t>& touched = regions_[k].touched;
      if (std::binary_search(touched.begin(), touched.end(), i)) other = k;
    }
    if (other == i) {
      return Refuse(targets_[i], "", "the surface is too irregular there to meet it",
                    "Move the constraint");
    }
    const std::string name = other < targets_.size()
                                 ? targets_[other].path()
                                 : absl::StrCat("vertex ", other - targets_.size());
    return Refuse(targets_[i], "", absl::StrCat("it cannot be met together with ", name),
                  "Leave one of them out, or move them apart");
  }

  const Context& context_;
  const BlendInput& input_;
  PrimalSurface& surface_;
  const absl::Span<const BlendTarget> targets_;
  BlendPlaces places_;
  std::vector<SurfaceParameter> parameters_;
  std::vector<PatchSample> before_;
  std::vector<AffineMap> maps_;
  std::vector<BlendRegion> regions_;
  std::vector<std::vector<std::size_t>> groups_;
  std::vector<JointProblem> problems_;
  BlendReport report_;
};

}  // namespace

std::uint64_t MostBlendPoints(std::uint64_t vertices, std::uint64_t half_edges,
                              const Constraints& constraints) {
  // Rings below r of a vertex of valence n have n r (r - 1) + 1 points.
  constexpr double kSixRings = 31;
  constexpr double kThreeRings = 7;
  const double valence =
      std::max(6.0, static_cast<double>(half_edges) /
                        static_cast<double>(std::max<std::uint64_t>(1, vertices)));
  const double at_vertex = constraints.interpolate.has_value() ? kSixRings : kThreeRings;
  double rings = at_vertex * static_cast<double>(constraints.normals.size());
  double given = 0;
  for (const SurfaceConstraint& constraint : constraints.surface_points) {
    if (constraint.region.empty()) {
      rings += kSixRings;
    } else {
      given += 4 * static_cast<double>(constraint.region.size());
    }
  }
  return static_cast<std::uint64_t>(valence * rings + given + 8 * static_cast<double>(half_edges));
}

absl::StatusOr<BlendReport> Blend(const Context& context, const BlendInput& input,
                                  PrimalSurface* surface) {
  // Relative to the origin, where the points have all their bits.
  const Vec3 origin = std::exchange(surface->origin, Vec3{0, 0, 0});
  std::vector<BlendTarget> targets(input.targets.begin(), input.targets.end());
  for (BlendTarget& target : targets) {
    if (target.point.has_value()) *target.point -= origin;
  }
  BlendInput moved = input;
  moved.targets = targets;
  absl::StatusOr<BlendReport> report = Blender(context, moved, surface).Run();
  surface->origin = origin;
  return report;
}

}  // namespace limn
