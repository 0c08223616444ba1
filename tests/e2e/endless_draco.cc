// SPDX-License-Identifier: MIT
// Loaded before Draco's library: an encoder that never ends, as the real one does not for as long
// as anybody would wait, and that sees no cancel, as the real one does not.
#include <draco/compression/point_cloud/point_cloud_encoder.h>
#include <unistd.h>

namespace draco {

Status PointCloudEncoder::Encode(const EncoderOptions& /*options*/, EncoderBuffer* /*out*/) {
  for (;;) pause();
}

}  // namespace draco
