// SPDX-License-Identifier: MIT
#include "client/batch_job.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/sha256.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kMostIdBytes = 128;

absl::Status CheckId(std::string_view id) {
  const bool visible = std::all_of(id.begin(), id.end(), [](char c) {
    return absl::ascii_isgraph(static_cast<unsigned char>(c));
  });
  if (visible && !id.empty() && id.size() <= kMostIdBytes) return absl::OkStatus();
  return MakeError(absl::StrCat("'", std::string(id), "' is no id of a job"),
                   {.reason = Reason::kInvalidOption,
                    .field = "job_id",
                    .remedy = "Use 1 to 128 visible ASCII characters"});
}

}  // namespace

absl::StatusOr<std::shared_ptr<OpenJob>> MakeOpenJob(BatchJob job, const ClientOptions& options,
                                                     std::string_view batch_name) {
  LIMN_RETURN_IF_ERROR(CheckId(job.id));
  LIMN_RETURN_IF_ERROR(job.mesh.status());
  if (job.header.request_id().empty()) job.header.set_request_id(job.id);
  auto open = std::make_shared<OpenJob>();
  LIMN_ASSIGN_OR_RETURN(open->upload, MeshUpload::Make(std::move(job.header), *job.mesh, options));
  open->id = std::move(job.id);
  open->digest = JobDigest(batch_name, open->upload);
  return open;
}

std::string JobDigest(std::string_view batch_name, const MeshUpload& upload) {
  Sha256 sha;
  // Lengths first, so that no two jobs give the same bytes.
  sha.Add(absl::StrCat(batch_name.size(), " ")).Add(batch_name);
  const std::string header = DeterministicBytes(upload.header);
  sha.Add(absl::StrCat(header.size(), " ")).Add(header);
  sha.Add(upload.mesh.bytes);
  return sha.Finish();
}

}  // namespace limn
