// SPDX-License-Identifier: MIT
// What planning and encoding of tiles both ask of their options.
#pragma once

#include "absl/status/status.h"
#include "limn/v1/mesh.pb.h"
#include "proto/wire/tile_codec.h"

namespace limn::wire {

bool IsDracoTile(v1::MeshEncoding encoding);

// Errors: INVALID_OPTION, naming the option.
[[nodiscard]] absl::Status CheckTileOptions(const TileOptions& options);

}  // namespace limn::wire
