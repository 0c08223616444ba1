// SPDX-License-Identifier: MIT
// Loaded before Draco's library: an encoder that never ends, as the real one does not for as long
// as anybody would wait, and that sees no cancel, as the real one does not.
#include <draco/compression/expert_encode.h>
#include <unistd.h>

namespace draco {

Status ExpertEncoder::EncodeToBuffer(EncoderBuffer* /*out_buffer*/) {
  for (;;) pause();
}

}  // namespace draco
