// SPDX-License-Identifier: MIT
// Mesh files to PolygonMesh: OBJ, OFF, PLY (text and both binary forms), STL (text and binary).
//
// The files are parsed here and not by OpenMesh 9, whose readers neither keep the input nor survive
// it. All four parse coordinates into float32 before an importer sees them, so 17 digits become 8;
// beyond float32's range the OBJ reader drops the vertex and thereby shifts every later index. The
// OBJ and STL readers drop faces with repeated vertices. The OFF reader takes counts and indices
// from uninitialised memory after a comment or "nan" and accepts truncated files. Counts in OFF and
// PLY are allocated unseen: bad_alloc from a few bytes. For meshes that are in OpenMesh already see
// engine/mesh/openmesh.h.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// Reads the file; the format is that of its extension, in lower or upper case. Coordinates are the
// doubles nearest to their decimals, so 17 digits come through. Everything in the file comes out,
// in its order: faces of fewer than three corners, repeated and isolated vertices and NaN too, for
// HalfEdgeMesh::Build and ValidatePositions to refuse by name, or DescribeMesh to list. Exceptions:
// - STL has no shared vertices: corners with equal coordinates become one vertex, numbered by
//   first occurrence.
// - Attributes (normals, colours, texture coordinates) and other elements (lines, points, groups)
//   are left out.
//
// Errors: NotFound when there is no such file, another code of the system when it cannot be read;
// INVALID_OPTION for an unknown extension; MALFORMED_FILE with the file's name, the line (text)
// or the offset (binary) and what is wrong there, also for counts that do not fit the file's size;
// INDEX_OUT_OF_RANGE with the face; EMPTY_MESH when there are no faces; LIMIT_EXCEEDED from 2^32
// vertices or corners; OUT_OF_MEMORY.
//
// Cost: about 0.5 us a vertex of OBJ; memory is the file's size and the mesh. Thread-safe.
[[nodiscard]] absl::StatusOr<PolygonMesh> ReadMeshFile(const std::string& path);

}  // namespace limn
