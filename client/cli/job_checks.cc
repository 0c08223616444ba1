// SPDX-License-Identifier: MIT
// Which flags of a job go together.
#include "client/cli/job_checks.h"

#include "client/cli/flag_names.h"
#include "client/cli/message_file.h"
#include "engine/base/error.h"
#include "server/options_from_proto.h"

namespace limn::cli {

absl::Status CheckTogether(const JobOptions& options) {
  if (options.strict && options.scheme == "doo-sabin") {
    return MakeError("--strict: it belongs to Catmull-Clark and Loop surfaces",
                     {.reason = Reason::kInvalidOption,
                      .field = "solve.strict",
                      .remedy = "Leave it out or choose another scheme"});
  }
  if (options.quantization_bits && options.encoding != "draco-quantized") {
    return MakeError("--quantization-bits: they belong to --encoding draco-quantized",
                     {.reason = Reason::kInvalidOption,
                      .field = "output.quantization_bits",
                      .remedy = "Leave them out or choose that"});
  }
  const absl::Status status = JobSpecFromProto(MakeJobHeader(options, {.surface = false})).status();
  const auto detail = GetErrorDetail(status);
  // Anything else is for the server to say: it may be able to do more than this program.
  if (!detail || detail->reason != Reason::kInvalidOption) return absl::OkStatus();
  return WithMessage(status, MessageInFlags(status));
}

}  // namespace limn::cli
