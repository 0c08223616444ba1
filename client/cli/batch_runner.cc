// SPDX-License-Identifier: MIT
#include "client/cli/batch_runner.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/constraints_file.h"
#include "client/cli/exit_status.h"
#include "client/cli/flag_names.h"
#include "client/cli/message_file.h"
#include "client/cli/report.h"
#include "client/cli/solve_warning.h"
#include "client/cli/staged_files.h"
#include "client/io/mesh_reader.h"
#include "client/sha256.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

namespace fs = std::filesystem;
using State = BatchOutcome::State;

// Of header and input; faster than reading the mesh, so that done jobs are told soon. Empty: the
// file cannot be read, which reading the mesh will say better.
std::string DigestOf(const v1::InterpolateHeader& header, const std::string& input) {
  const auto close = [](std::FILE* file) { std::fclose(file); };
  const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(input.c_str(), "rbe"), close);
  if (file == nullptr) return "";
  Sha256 sha;
  const std::string bytes = DeterministicBytes(header);
  sha.Add(absl::StrCat(bytes.size(), " ")).Add(bytes);
  std::string block(std::size_t{1} << 20, '\0');
  while (const std::size_t got = std::fread(block.data(), 1, block.size(), file.get())) {
    sha.Add(std::string_view(block).substr(0, got));
  }
  return std::ferror(file.get()) != 0 ? "" : absl::BytesToHexString(sha.Finish());
}

std::vector<std::string> NamesOf(const OutputPaths& paths) {
  std::vector<std::string> names = FilesOf(paths);
  for (std::string& name : names) name = fs::path(name).filename().string();
  return names;
}

}  // namespace

std::string WireId(const std::string& id) {
  constexpr std::size_t kMostBytes = 128;
  const bool visible = std::all_of(id.begin(), id.end(), [](char c) {
    return absl::ascii_isgraph(static_cast<unsigned char>(c));
  });
  if (visible && !id.empty() && id.size() <= kMostBytes) return id;
  return "sha256-" + absl::BytesToHexString(Sha256().Add(id).Finish());
}

BatchRunner::BatchRunner(const std::vector<BatchEntry>& entries, const BatchOutputs& outputs,
                         BatchJournal* journal, ProgressBar* bar)
    : entries_(entries),
      outputs_(outputs),
      journal_(journal),
      bar_(bar),
      outcomes_(entries.size()),
      digests_(entries.size()) {
  for (std::size_t i = 0; i < entries.size(); ++i) index_of_[WireId(entries[i].id)] = i;
}

bool BatchRunner::IsDone(const BatchEntry& entry, const std::string& digest) const {
  const std::string* done = journal_->Find(entry.id);
  if (done == nullptr || digest.empty() || *done != digest) return false;
  const std::vector<std::string> files = FilesOf(OutputsOf(entry, outputs_));
  std::error_code error;
  return std::all_of(files.begin(), files.end(),
                     [&](const std::string& file) { return fs::is_regular_file(file, error); });
}

absl::StatusOr<v1::InterpolateHeader> BatchRunner::MakeHeader(const BatchEntry& entry) const {
  v1::InterpolateHeader header =
      MakeJobHeader(entry.options, {.surface = true, .control_mesh = outputs_.control_mesh});
  if (!entry.constraints.empty()) {
    LIMN_ASSIGN_OR_RETURN(*header.mutable_constraints(), ReadConstraintsFile(entry.constraints));
  }
  return header;
}

std::optional<BatchJob> BatchRunner::Next() {
  for (; next_ < entries_.size(); ++next_) {
    const BatchEntry& entry = entries_[next_];
    absl::StatusOr<v1::InterpolateHeader> header = MakeHeader(entry);
    BatchJob job = {.id = WireId(entry.id), .mesh = absl::UnknownError("not read")};
    if (!header.ok()) job.mesh = header.status();
    if (header.ok()) {
      std::string digest = DigestOf(*header, entry.input);
      const bool done = IsDone(entry, digest);
      const std::lock_guard lock(mutex_);
      if (done) {
        outcomes_[next_].state = State::kSkipped;
        ++counts_.skipped;
        continue;
      }
      digests_[next_] = std::move(digest);
    }
    ++next_;
    if (header.ok()) {
      job.header = *std::move(header);
      job.mesh = ReadMeshFile(entry.input);
    }
    return job;
  }
  return std::nullopt;
}

absl::Status BatchRunner::Write(const BatchEntry& entry, const JobResult& result) {
  StagedFiles files;
  LIMN_RETURN_IF_ERROR(WriteOutputs(OutputsOf(entry, outputs_), result, &files));
  return files.Commit();
}

absl::Status BatchRunner::Take(BatchResult result) {
  const std::size_t index = index_of_.at(result.id);
  BatchOutcome outcome = {.seconds = result.seconds, .tries = result.tries};
  // It is left to be done.
  if (result.result.status().code() == absl::StatusCode::kCancelled) return absl::OkStatus();
  LIMN_RETURN_IF_ERROR(result.result.ok() ? Succeed(index, *result.result, &outcome)
                                          : Fail(index, result.result.status(), &outcome));
  {
    const std::lock_guard lock(mutex_);
    ++(outcome.state == State::kSucceeded ? counts_.succeeded : counts_.failed);
    outcomes_[index] = std::move(outcome);
  }
  ShowTotals("");
  return absl::OkStatus();
}

absl::Status BatchRunner::Succeed(std::size_t index, const JobResult& result,
                                  BatchOutcome* outcome) {
  const BatchEntry& entry = entries_[index];
  const absl::Status written = Write(entry, result);
  // A surface that a format cannot hold is this job's affair, a disk that is full is everybody's.
  const auto detail = GetErrorDetail(written);
  if (!written.ok() && detail->reason != Reason::kInternal) return Fail(index, written, outcome);
  LIMN_RETURN_IF_ERROR(written);
  outcome->state = State::kSucceeded;
  outcome->given_vertices = result.summary.input_vertices();
  outcome->surface_vertices = result.summary.surface_vertices();
  const std::string warning = SolveWarning(result.summary.solve(), entry.options);
  if (!warning.empty()) {
    bar_->Clear();
    PrintError(absl::StrCat(entry.id, ": ", warning));
  }
  return journal_->Add({.id = entry.id,
                        .digest = DigestAt(index),
                        .status = "succeeded",
                        .files = NamesOf(OutputsOf(entry, outputs_))});
}

absl::Status BatchRunner::Fail(std::size_t index, const absl::Status& status,
                               BatchOutcome* outcome) {
  const BatchEntry& entry = entries_[index];
  const absl::Status named = NameConstraintsFile(status, entry.constraints);
  outcome->state = State::kFailed;
  outcome->reason = ReasonOf(named);
  outcome->message = MessageInFlags(named);
  bar_->Clear();
  PrintError(absl::StrCat(entry.id, ": ", outcome->message));
  return journal_->Add(
      {.id = entry.id, .digest = DigestAt(index), .status = "failed", .reason = outcome->reason});
}

void BatchRunner::Show(const std::string& id, const v1::Progress& progress) {
  ShowTotals(absl::StrFormat("; %s: %s %d %%", entries_[index_of_.at(id)].id, progress.stage(),
                             static_cast<int>(100 * progress.fraction())));
}

void BatchRunner::ShowTotals(const std::string& note) {
  const BatchCounts counts = [&] {
    const std::lock_guard lock(mutex_);
    return counts_;
  }();
  const std::uint64_t done = counts.succeeded + counts.failed + counts.skipped;
  const double part = static_cast<double>(done) / static_cast<double>(entries_.size());
  std::string text = absl::StrCat(WithCommas(done), " of ", WithCommas(entries_.size()), " jobs");
  if (counts.failed > 0) absl::StrAppend(&text, ", ", WithCommas(counts.failed), " failed");
  bar_->Show("batch", part, text + note);
}

std::string BatchRunner::DigestAt(std::size_t index) const {
  const std::lock_guard lock(mutex_);
  return digests_[index];
}

std::vector<BatchOutcome> BatchRunner::outcomes() const {
  const std::lock_guard lock(mutex_);
  return outcomes_;
}

}  // namespace limn::cli
