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
#include "engine/limit/certificate.h"
#include "engine/limit/evaluate.h"
#include "engine/limit/vertex_limit.h"

namespace limn {
namespace {

constexpr double kTolerance = 1e-10;
constexpr std::size_t kMostTogether = 256;
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

// The face of a vertex of T^0 in which it is the first corner.
SurfaceParameter AtVertex(const PrimalSurface& surface, Index vertex) {
  const Index h = surface.mesh.vertex_half_edge()[vertex];
  if (surface.kind == RingKind::kTriangles) {
    const Index triangle = h / 3;
    return {.face = triangle / 16, .corner = triangle / 4 % 4};
  }
  const Index corner = h / 16;
  const auto after = std::upper_bound(surface.face_begin.begin(), surface.face_begin.end(), corner);
  const auto face = static_cast<Index>(after - surface.face_begin.begin() - 1);
  return {.face = face, .corner = corner - surface.face_begin[face]};
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
      maps_.push_back(*map);
    }
    return absl::OkStatus();
  }

  absl::Status FindRegions() {
    regions_.resize(targets_.size());
    std::atomic<std::uint64_t> points = 0;
    const auto find = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && points <= input_.most_points; ++i) {
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
      if (members.size() > kMostTogether) {
        return MakeError(absl::StrCat(targets_[group[0]].path(), ": ", members.size(),
                                      " constraints and vertices are too close to each other"),
                         {.reason = Reason::kLimitExceeded,
                          .field = targets_[group[0]].path(),
                          .index = targets_[group[0]].index,
                          .remedy = absl::StrCat("At most ", kMostTogether,
                                                 " can be met together: ask for fewer, or refine "
                                                 "the mesh")});
      }
      for (const std::size_t i : members) {
        LIMN_ASSIGN_OR_RETURN(JointAim aim, AimOf(i));
        problem.aims.push_back(std::move(aim));
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

  absl::StatusOr<JointAim> AimOf(std::size_t i) const {
    JointAim aim = {.support = Support(surface_.mesh, places_.At(i))};
    if (i >= targets_.size()) {
      aim.place = AtVertex(surface_, places_.At(i)[0]);
      LIMN_RETURN_IF_ERROR(
          EvaluateSurface(context_, surface_, absl::MakeConstSpan(&aim.place, 1),
                          SurfaceSamples{.points = absl::MakeSpan(&aim.point, 1)}));
      return aim;
    }
    const BlendTarget& target = targets_[i];
    aim.place = target.place;
    aim.point = maps_[i].to;
    aim.has_du = target.du.has_value() || target.normal.has_value();
    aim.has_dv = target.dv.has_value() || target.normal.has_value();
    aim.du = maps_[i].linear * before_[i].du;
    aim.dv = maps_[i].linear * before_[i].dv;
    return aim;
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
        Vec3 point;
        LIMN_RETURN_IF_ERROR(EvaluateSurface(context_, surface_, absl::MakeConstSpan(&aim.place, 1),
                                             SurfaceSamples{.points = absl::MakeSpan(&point, 1)}));
        if (!(Norm(point - aim.point) <= kTolerance * input_.scale)) {
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
