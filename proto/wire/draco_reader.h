// SPDX-License-Identifier: MIT
// Draco's decoder behind a fence: claims are checked before it allocates, attributes before their
// values are decoded, and the mesh before anybody indexes with what it says.
#pragma once

#include <draco/mesh/mesh.h>

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/mesh/polygon_mesh.h"
#include "proto/wire/draco_header.h"

namespace limn::wire {

// A decoded triangle mesh. Attributes beside POSITION, "original_id", "added_edges" and, if wanted,
// NORMAL may have been left without values. Edgebreaker meshes whose attributes share one decoder
// (Draco's speeds of 6 and above, with more than positions), and those with texture coordinates
// before a wanted attribute, are MALFORMED_ENCODING. All triangles name points that are there
// (checked; Draco's sequential decoder does not).
// CANCELLED and DEADLINE_EXCEEDED are seen between connectivity and attributes.
[[nodiscard]] absl::StatusOr<std::unique_ptr<draco::Mesh>> ReadDraco(const Context& context,
                                                                     std::string_view bytes,
                                                                     const DracoBounds& bounds);

// For each corner the number of the attribute's value. Errors: MALFORMED_ENCODING when a point has
// no value or the values' buffer is too short.
[[nodiscard]] absl::StatusOr<Buffer<Index>> CornerValues(const draco::Mesh& mesh,
                                                         const draco::PointAttribute& attribute);

// The attribute with this metadata "name"; nullptr without one.
[[nodiscard]] const draco::PointAttribute* NamedAttribute(const draco::Mesh& mesh,
                                                          const char* name);

// Whether the attribute has values of this kind.
[[nodiscard]] bool IsKind(const draco::PointAttribute& attribute, draco::DataType type,
                          int components);

}  // namespace limn::wire
