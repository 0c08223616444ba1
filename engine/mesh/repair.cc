// SPDX-License-Identifier: MIT
// The steps in their order, and the result.
#include "engine/mesh/repair.h"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"
#include "engine/mesh/validate.h"

namespace limn {
namespace {

class Repairer {
 public:
  Repairer(const Context& context, const PolygonMesh& input, const RepairOptions& options)
      : context_(context), input_(input), options_(options) {}

  absl::StatusOr<RepairedMesh> Run() {
    BoundingBox box;
    Report(0);
    LIMN_RETURN_IF_ERROR(ValidatePositions(context_, input_.positions, &box));
    LIMN_RETURN_IF_ERROR(ValidateIndices(context_, input_));
    LIMN_RETURN_IF_ERROR(
        repair::CleanFaces(context_, input_, options_.degenerate_faces, &patchwork_, &report()));
    Report(0.2);
    LIMN_RETURN_IF_ERROR(GlueFaces());
    Report(0.7);
    LIMN_RETURN_IF_ERROR(Finish());
    return std::move(result_);
  }

 private:
  RepairReport& report() { return result_.report; }
  void Report(double fraction) const { context_.Report({.stage = "repair", .fraction = fraction}); }

  // Steps 2 to 5, up to the vertices.
  absl::Status GlueFaces() {
    repair::EdgeList crowded;
    repair::EdgeList cut;
    {
      repair::EdgeTable edges;
      LIMN_RETURN_IF_ERROR(edges.Fill(context_, input_.vertex_count(), patchwork_));
      Report(0.4);
      if (options_.repeated_faces) {
        LIMN_RETURN_IF_ERROR(
            repair::RemoveRepeatedFaces(context_, edges, options_.folds, &patchwork_, &report()));
      }
      LIMN_RETURN_IF_ERROR(repair::GlueEdges(context_, edges, &patchwork_, &crowded));
    }
    Report(0.5);
    LIMN_RETURN_IF_ERROR(
        repair::OrientFaces(context_, options_.orientation, &patchwork_, &cut, &report()));
    if (!options_.non_manifold) return absl::OkStatus();
    report().edges_split = crowded.size();
    LIMN_RETURN_IF_ERROR(repair::PairCrowdedEdges(context_, crowded, &patchwork_));
    return repair::SplitOffFaces(context_, std::array{&crowded, &cut}, &patchwork_, &report());
  }

  absl::Status Finish() {
    LIMN_ASSIGN_OR_RETURN(
        repair::VertexNumbers numbers,
        repair::NumberVertices(context_, input_.vertex_count(), options_, &patchwork_, &report()));
    result_.original_vertex = std::move(numbers.original_vertex);
    result_.kept_vertices = numbers.kept;
    LIMN_RETURN_IF_ERROR(FillPositions());
    LIMN_RETURN_IF_ERROR(FillFaces(numbers.corner_vertex));
    if (result_.mesh.face_count() > 0) return absl::OkStatus();
    return MakeError(absl::StrCat("repair leaves no face: ", report().degenerate_faces_removed,
                                  " faces have fewer than three different corners"),
                     {.reason = Reason::kEmptyMesh,
                      .field = "mesh.faces",
                      .remedy = "Give a mesh of at least one face of three different corners"});
  }

  absl::Status FillPositions() {
    const Buffer<Index>& original = result_.original_vertex;
    result_.mesh.positions.resize(original.size());
    return ParallelFor(context_, original.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        result_.mesh.positions[v] = input_.positions[original[v]];
      }
    });
  }

  absl::Status FillFaces(const Buffer<Index>& corner_vertex) {
    const repair::Patchwork& p = patchwork_;
    PolygonMesh& mesh = result_.mesh;
    mesh.face_begin.reserve(p.face_count() + 1);
    mesh.face_begin.push_back(0);
    mesh.corner_vertex.reserve(p.corner_count());
    result_.original_face.reserve(p.face_count());
    return ForInOrder(context_, p.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        if (p.state[f] == repair::FaceState::kRemoved) continue;
        const auto first = corner_vertex.begin() + p.face_begin[f];
        mesh.corner_vertex.insert(mesh.corner_vertex.end(), first,
                                  corner_vertex.begin() + p.face_begin[f + 1]);
        if (p.turned[f] != 0) {
          std::reverse(mesh.corner_vertex.begin() + mesh.face_begin.back() + 1,
                       mesh.corner_vertex.end());
        }
        mesh.face_begin.push_back(static_cast<Index>(mesh.corner_count()));
        result_.original_face.push_back(p.original_face[f]);
      }
    });
  }

  const Context& context_;
  const PolygonMesh& input_;
  const RepairOptions& options_;
  repair::Patchwork patchwork_;
  RepairedMesh result_;
};

}  // namespace

absl::StatusOr<RepairedMesh> Repair(const Context& context, const PolygonMesh& mesh,
                                    const RepairOptions& options) {
  try {
    return Repairer(context, mesh, options).Run();
  } catch (const std::bad_alloc&) {
    return MakeError(
        "the system has no more memory for the repair",
        {.reason = Reason::kOutOfMemory, .remedy = "Send a smaller mesh or try again later"});
  }
}

bool RepairMends(Reason reason) {
  switch (reason) {
    case Reason::kFaceTooSmall:
    case Reason::kRepeatedVertex:
    case Reason::kIsolatedVertex:
    case Reason::kNonManifoldEdge:
    case Reason::kInconsistentOrientation:
    case Reason::kNonManifoldVertex:
      return true;
    default:
      return false;
  }
}

Buffer<Index> RepairedVertices(const RepairedMesh& repaired,
                               absl::Span<const Index> input_vertices) {
  const auto begin = repaired.original_vertex.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(repaired.kept_vertices);
  Buffer<Index> found(input_vertices.size());
  for (std::size_t i = 0; i < input_vertices.size(); ++i) {
    const auto at = std::lower_bound(begin, end, input_vertices[i]);
    const bool kept = at != end && *at == input_vertices[i];
    found[i] = kept ? static_cast<Index>(at - begin) : kNoIndex;
  }
  return found;
}

}  // namespace limn
