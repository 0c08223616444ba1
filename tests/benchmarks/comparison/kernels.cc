// SPDX-License-Identifier: MIT
#include "tests/benchmarks/comparison/kernels.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "engine/base/parallel.h"
#include "engine/limit/doo_sabin_limit.h"
#include "engine/limit/vertex_limit.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "engine/mesh/validate.h"
#include "engine/refine/catmull_clark_refine.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/loop_refine.h"
#include "engine/solve/solve.h"
#include "tests/benchmarks/comparison/measure.h"

namespace limn::comparison {
namespace {

constexpr int kRounds = 11;
constexpr std::uint32_t kSweeps = 32;

void OrThrow(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(std::string(status.message()));
}
template <class T>
T OrThrow(absl::StatusOr<T> value) {
  OrThrow(value.status());
  return *std::move(value);
}

// Three arrays, together several times as large as the cache.
class Stream {
 public:
  Stream() : a_(kSize, 1.0), b_(kSize, 2.0), c_(kSize, 0.5) {}

  void Copy() {
    OrThrow(ParallelFor(context_, kSize, kChunk, [this](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) a_[i] = b_[i];
    }));
  }
  void Triad() {
    OrThrow(ParallelFor(context_, kSize, kChunk, [this](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) a_[i] = b_[i] + 3.0 * c_[i];
    }));
  }
  static constexpr double kCopyBytes = 16.0 * (1 << 24);
  static constexpr double kTriadBytes = 24.0 * (1 << 24);

 private:
  static constexpr std::size_t kSize = 1 << 24;
  static constexpr std::size_t kChunk = 1 << 16;
  const Context context_;
  Buffer<double> a_;
  Buffer<double> b_;
  Buffer<double> c_;
};

struct Sizes {
  explicit Sizes(const HalfEdgeMesh& mesh)
      : n(static_cast<double>(mesh.vertex_count())),
        e(static_cast<double>(mesh.edge_count())),
        f(static_cast<double>(mesh.face_count())),
        c(static_cast<double>(mesh.half_edge_count())) {}
  // Vertices, edges, faces, corners.
  double n, e, f, c;
};

struct Kernel {
  std::string name;
  double bytes = 0;
  std::function<void()> run;
  // Runs of the kernel in one call of run.
  double count = 1;
};

// A point has 24 bytes, an index 4. Each array counts once for each pass that has to stream it.
class PolygonKernels {
 public:
  explicit PolygonKernels(std::uint64_t vertices)
      : given_(MakeMesh(Meshes::kPolygons, vertices)),
        mesh_(OrThrow(HalfEdgeMesh::Build(context_, given_))),
        split_(OrThrow(SplitIntoQuads(context_, mesh_))),
        fans_(OrThrow(FindExtraordinaryFans(context_, mesh_))),
        control_(given_.positions),
        first_(mesh_.half_edge_count()),
        second_(split_.half_edge_count()),
        points_(split_.vertex_count(), Vec3{0, 0, 0}),
        limits_(split_.vertex_count() + split_.edge_count() + split_.face_count(), Vec3{0, 0, 0}),
        normals_(limits_.size(), Vec3{0, 0, 0}) {
    OrThrow(ValidatePositions(context_, given_.positions, &box_));
    for (const Kernel& kernel : Kernels()) kernel.run();
  }

  std::vector<Kernel> Kernels() {
    const Sizes t0(mesh_);
    const Sizes t1(split_);
    const double next = t1.n + t1.e + t1.f;
    return {
        {"Chebyshev sweep", 8 * t0.c + (24 + 24 + 24 + 24 + 48) * t0.n + 48 * t0.f,
         [this] { Sweep(kSweeps); }, kSweeps},
        {"Doo-Sabin first refinement", 4 * t0.c + 4 * t0.f + 24 * t0.n + 24 * t0.c,
         [this] { OrThrow(FirstRefinement(context_, mesh_, control_, absl::MakeSpan(first_))); }},
        {"Doo-Sabin refinement", (24 + 4 + 4 + 96) * t0.c + 4 * t0.f + 4 * t0.n,
         [this] {
           OrThrow(RefineDooSabin(context_, {.mesh = mesh_, .fans = fans_, .k = 1}, first_,
                                  absl::MakeSpan(second_)));
         }},
        {"Doo-Sabin limit, normals", (24 + 4) * t1.c + 4 * t1.n + 4 * t1.e + 48 * next,
         [this] {
           OrThrow(DooSabinLimit(
               context_, {.mesh = split_, .fans = fans_, .k = 2}, second_,
               {.points = absl::MakeSpan(limits_), .normals = absl::MakeSpan(normals_)}));
         }},
        {"quad split", 12 * t0.c + 12 * t1.c + 4 * t1.e + 4 * t1.n,
         [this] { split_ = OrThrow(SplitIntoQuads(context_, mesh_)); }},
        {"Catmull-Clark refinement", 8 * t0.c + 4 * (t0.n + t0.e + t0.f) + 24 * t0.n + 24 * t1.n,
         [this] {
           OrThrow(RefineCatmullClark(context_, {mesh_, sharpness_}, given_.positions,
                                      absl::MakeSpan(points_)));
         }},
        {"Catmull-Clark limit, normals", 8 * t1.c + 4 * t1.n + (24 + 48) * t1.n, [this] {
           const auto out = absl::MakeSpan(limits_).first(points_.size());
           const auto normals = absl::MakeSpan(normals_).first(points_.size());
           OrThrow(CatmullClarkLimits(context_, {split_, sharpness_}, points_, {out, {}, normals}));
         }}};
  }
  // The time of a solve without sweeps has to be taken off.
  void Sweep(std::uint32_t sweeps) {
    OrThrow(Solve(context_,
                  {.mesh = mesh_,
                   .stencil = stencil_,
                   .points = given_.positions,
                   .scale = box_.diagonal()},
                  {.tolerance = 0, .max_sweeps = sweeps}, absl::MakeSpan(control_))
                .status());
  }

 private:
  const Context context_;
  const PolygonMesh given_;
  const HalfEdgeMesh mesh_;
  HalfEdgeMesh split_;
  const ExtraordinaryFans fans_;
  const LimitStencil stencil_ = DooSabinModifiedStencil();
  const Sharpness sharpness_;
  Buffer<Vec3> control_;
  Buffer<Vec3> first_;
  Buffer<Vec3> second_;
  Buffer<Vec3> points_;
  Buffer<Vec3> limits_;
  Buffer<Vec3> normals_;
  BoundingBox box_;
};

class TriangleKernels {
 public:
  explicit TriangleKernels(std::uint64_t vertices)
      : given_(MakeMesh(Meshes::kTriangles, vertices)),
        mesh_(OrThrow(HalfEdgeMesh::Build(context_, given_))),
        split_(OrThrow(SplitIntoTriangles(context_, mesh_))),
        points_(split_.vertex_count(), Vec3{0, 0, 0}),
        limits_(points_),
        normals_(points_) {
    for (const Kernel& kernel : Kernels()) kernel.run();
  }
  std::vector<Kernel> Kernels() {
    const Sizes t0(mesh_);
    const Sizes t1(split_);
    return {{"Loop refinement", 8 * t0.c + 4 * t0.n + 4 * t0.e + 24 * t0.n + 24 * t1.n,
             [this] {
               OrThrow(RefineLoop(context_, {mesh_, sharpness_}, given_.positions,
                                  absl::MakeSpan(points_)));
             }},
            {"Loop limit, normals", 8 * t1.c + 4 * t1.n + (24 + 48) * t1.n, [this] {
               OrThrow(LoopLimits(context_, {split_, sharpness_}, points_,
                                  {absl::MakeSpan(limits_), {}, absl::MakeSpan(normals_)}));
             }}};
  }

 private:
  const Context context_;
  const PolygonMesh given_;
  const HalfEdgeMesh mesh_;
  const HalfEdgeMesh split_;
  const Sharpness sharpness_;
  Buffer<Vec3> points_;
  Buffer<Vec3> limits_;
  Buffer<Vec3> normals_;
};

double Time(const std::function<void()>& work) {
  const double begin = Now().clock;
  work();
  return Now().clock - begin;
}

// Writes lines "THREADS COPY TRIAD" of bandwidths and "THREADS SECONDS OVER_BOUND" of kernels.
void TakeTurns(PolygonKernels& polygons, const std::vector<Kernel>& kernels, std::FILE* out) {
  Stream stream;
  for (const int threads : {1, 2}) {
    ThreadArena arena(threads);
    std::vector<double> copy;
    std::vector<double> triad;
    std::vector<std::vector<double>> seconds(kernels.size());
    arena.Execute([&] {
      stream.Copy();
      for (int round = 0; round < kRounds; ++round) {
        copy.push_back(Stream::kCopyBytes / Time([&] { stream.Copy(); }));
        triad.push_back(Stream::kTriadBytes / Time([&] { stream.Triad(); }));
        for (std::size_t i = 0; i < kernels.size(); ++i) {
          double time = Time(kernels[i].run);
          if (kernels[i].count > 1) time -= Time([&] { polygons.Sweep(0); });
          seconds[i].push_back(time / kernels[i].count);
        }
      }
    });
    const double best = std::max(Median(copy), Median(triad));
    std::fprintf(out, "%d %.17g %.17g\n", threads, Median(copy), Median(triad));
    for (std::size_t i = 0; i < kernels.size(); ++i) {
      const double time = Median(seconds[i]);
      std::fprintf(out, "%.17g %.17g %.17g %s\n", time, kernels[i].bytes,
                   time * best / kernels[i].bytes, kernels[i].name.c_str());
    }
    std::fprintf(out, "0 0 0\n");
  }
}

}  // namespace

KernelReport MeasureKernels(std::uint64_t vertices) {
  const std::string text = InChild([&](std::FILE* out) {
    PolygonKernels polygons(vertices);
    TriangleKernels triangles(vertices);
    std::vector<Kernel> kernels = polygons.Kernels();
    for (Kernel& kernel : triangles.Kernels()) kernels.push_back(std::move(kernel));
    TakeTurns(polygons, kernels, out);
  });
  KernelReport report;
  std::istringstream lines(text);
  for (Bandwidth bandwidth; lines >> bandwidth.threads >> bandwidth.copy >> bandwidth.triad;) {
    report.bandwidth.push_back(bandwidth);
    KernelOutcome kernel;
    kernel.threads = bandwidth.threads;
    kernel.vertices = vertices;
    while (lines >> kernel.seconds >> kernel.bytes >> kernel.over_bound && kernel.seconds > 0) {
      std::getline(lines >> std::ws, kernel.name);
      report.kernels.push_back(kernel);
    }
  }
  return report;
}

}  // namespace limn::comparison
