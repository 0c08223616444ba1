// SPDX-License-Identifier: MIT
// Meshes and limit surfaces to files: OBJ, OFF, PLY, STL, and binary glTF (.glb) for surfaces.
//
// OBJ, OFF, PLY and STL are written here and not by OpenMesh, whose writers take a mesh that its
// own data structure accepts: a broken mesh could not be written, a tessellation only after
// conversion. The glTF container is written by tinygltf.
//
// A file is written under another name beside the target and renamed at the end: at every moment
// the target is the old file or the complete new one, also when the disk fills up or the program
// is killed (then a file .limn-*.part may stay behind). Links are followed; permissions of an
// existing target are kept.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "engine/limit/tessellation.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

namespace io {
class OutputFile;
}

// What is to be written; surfaces have more formats.
enum class OutputKind { kMesh, kSurface };

// Whether a file of this name can be written: tells before the work what the Write functions would
// tell after it. Makes and removes an empty file in the target's folder.
// Errors: INVALID_OPTION for an extension that the kind does not have (the message lists those it
// has) or a target that is not a regular file; NotFound, PermissionDenied or another code of the
// system.
[[nodiscard]] absl::Status CheckWritable(const std::string& path, OutputKind kind);

// Writes the mesh in the format of the extension (in lower or upper case). Any PolygonMesh whose
// indices are in range, valid or not.
// - .obj, .off: text; the shortest decimals (up to 17 digits) that read back to the same doubles.
// - .ply: binary, little-endian, double coordinates; bit for bit.
// - .stl: binary, float32, triangulated (quads by their shorter diagonal, others as fans).
//
// Errors: as CheckWritable, ResourceExhausted when the disk is full; INDEX_OUT_OF_RANGE;
// NON_FINITE_COORDINATE and COORDINATE_TOO_LARGE where the format is float32; LIMIT_EXCEEDED for
// sizes that the format cannot count; OUT_OF_MEMORY. The target is unchanged then.
//
// Cost: 0.5 us a vertex of OBJ; memory only for .glb (the file's size). Thread-safe for different
// targets.
[[nodiscard]] absl::Status WriteMeshFile(const std::string& path, const PolygonMesh& mesh);

// Likewise for a tessellated surface. Its normals, where it has any, go into .obj (vn, as decimals
// of float32), .ply (float nx, ny, nz) and .glb. .glb: float32 coordinates relative to the centre
// of the bounding box, which is the node's translation, so that nothing is lost far from the
// origin; uint32 triangles as for .stl; normals of (0, 0, 0) become (0, 0, 1), as glTF demands unit
// length.
[[nodiscard]] absl::Status WriteSurfaceFile(const std::string& path, const Tessellation& surface);

// The same into a file that the caller has created under this path and commits: see
// client/io/output_file.h.
[[nodiscard]] absl::Status WriteMeshTo(const std::string& path, const PolygonMesh& mesh,
                                       io::OutputFile* file);
[[nodiscard]] absl::Status WriteSurfaceTo(const std::string& path, const Tessellation& surface,
                                          io::OutputFile* file);

}  // namespace limn
