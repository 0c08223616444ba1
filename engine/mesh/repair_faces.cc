// SPDX-License-Identifier: MIT
// Faces that visit a vertex twice, and the table of all sides.
#include <algorithm>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"

namespace limn::repair {
namespace {

// Walks the corners of one face after the other.
class FaceCleaner {
 public:
  FaceCleaner(const PolygonMesh& mesh, bool mend, Patchwork* out, RepairReport* report)
      : mesh_(mesh), mend_(mend), out_(*out), report_(*report), place_(mesh.vertex_count(), 0) {
    // No polygon that is cut off has fewer than three corners, so these never grow.
    const std::size_t faces = std::max(mesh.face_count(), mesh.corner_count() / 3);
    out_.corner_vertex.reserve(mesh.corner_count());
    out_.face_begin.reserve(faces + 1);
    out_.original_face.reserve(faces);
    out_.state.reserve(faces);
    out_.face_begin.push_back(0);
  }

  void Clean(std::size_t f) {
    const std::size_t corners_before = out_.corner_count();
    const std::size_t faces_before = out_.face_count();
    const absl::Span<const Index> face = mesh_.face(f);
    path_.clear();
    for (const Index v : face) {
      // place_[v] is up to date when v is on the path; otherwise it points anywhere.
      const Index at = place_[v];
      if (at < path_.size() && path_[at] == v) {
        Emit(absl::MakeConstSpan(path_).subspan(at), f);
        path_.resize(at + 1);
      } else {
        place_[v] = static_cast<Index>(path_.size());
        path_.push_back(v);
      }
    }
    Emit(path_, f);
    const bool whole = out_.face_count() == faces_before + 1 &&
                       out_.corner_count() == corners_before + face.size();
    if (whole) return;
    if (mend_) {
      ++(out_.face_count() == faces_before ? report_.degenerate_faces_removed
                                           : report_.faces_mended);
    } else {
      SetAside(face, f, faces_before);
    }
  }

 private:
  void Emit(absl::Span<const Index> polygon, std::size_t f) {
    if (polygon.size() >= 3) Append(polygon, f, FaceState::kLive);
  }

  void SetAside(absl::Span<const Index> face, std::size_t f, std::size_t faces_before) {
    out_.corner_vertex.resize(out_.face_begin[faces_before]);
    out_.face_begin.resize(faces_before + 1);
    out_.original_face.resize(faces_before);
    out_.state.resize(faces_before);
    Append(face, f, FaceState::kAside);
  }

  void Append(absl::Span<const Index> polygon, std::size_t f, FaceState state) {
    out_.corner_vertex.insert(out_.corner_vertex.end(), polygon.begin(), polygon.end());
    out_.face_begin.push_back(static_cast<Index>(out_.corner_count()));
    out_.original_face.push_back(static_cast<Index>(f));
    out_.state.push_back(state);
  }

  const PolygonMesh& mesh_;
  const bool mend_;
  Patchwork& out_;
  RepairReport& report_;
  // What was walked and not yet cut off, and where each vertex is on it.
  Buffer<Index> path_;
  Buffer<Index> place_;
};

}  // namespace

absl::Status CleanFaces(const Context& context, const PolygonMesh& mesh, bool mend,
                        Patchwork* patchwork, RepairReport* report) {
  {
    FaceCleaner cleaner(mesh, mend, patchwork, report);
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context, mesh.face_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t f = begin; f < end; ++f) cleaner.Clean(f);
        }));
  }
  Patchwork& p = *patchwork;
  p.turned.assign(p.face_count(), 0);
  p.component.assign(p.face_count(), kNoIndex);
  p.corner_face.resize(p.corner_count());
  p.mate.assign(p.corner_count(), kNoIndex);
  return ParallelFor(context, p.face_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      std::fill(p.corner_face.begin() + p.face_begin[f],
                p.corner_face.begin() + p.face_begin[f + 1], static_cast<Index>(f));
    }
  });
}

absl::Status EdgeTable::Fill(const Context& context, std::size_t vertices,
                             const Patchwork& patchwork) {
  const Patchwork& p = patchwork;
  begin_.assign(vertices + 1, 0);
  const auto for_each_side = [&](const auto& visit) {
    return ForInOrder(context, p.face_count(), [&](std::size_t first, std::size_t last) {
      for (std::size_t f = first; f < last; ++f) {
        if (!p.live(f)) continue;
        for (Index c = p.face_begin[f]; c < p.face_begin[f + 1]; ++c) visit(c);
      }
    });
  };
  LIMN_RETURN_IF_ERROR(for_each_side([&](Index c) { ++begin_[p.Low(c)]; }));
  LIMN_RETURN_IF_ERROR(ParallelExclusiveSum(context, absl::MakeSpan(begin_)));
  entry_.resize(begin_.back());
  {
    Buffer<Index> cursor(begin_);
    LIMN_RETURN_IF_ERROR(for_each_side(
        [&](Index c) { entry_[cursor[p.Low(c)]++] = {.high = p.High(c), .side = c}; }));
  }
  return ParallelFor(context, vertices, [&](std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v) {
      std::sort(entry_.begin() + begin_[v], entry_.begin() + begin_[v + 1],
                [](const Entry& a, const Entry& b) {
                  return std::pair(a.high, a.side) < std::pair(b.high, b.side);
                });
    }
  });
}

}  // namespace limn::repair
