// SPDX-License-Identifier: MIT
// Writing beside the target and renaming, on POSIX calls.
#include "client/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn::io {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

absl::Status SystemError(const std::string& target) {
  return absl::ErrnoToStatus(errno, absl::StrCat("cannot write ", target));
}

absl::Status NotRegular(const std::string& target) {
  return MakeError(
      absl::StrCat(target, " exists and is not a regular file"),
      {.reason = Reason::kInvalidOption, .field = "output", .remedy = "Give the name of a file"});
}

// Where the file is to go when `path` is a link.
std::string FollowLink(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_symlink(path, error)) return path;
  const std::filesystem::path target = std::filesystem::weakly_canonical(path, error);
  return error ? path : target.string();
}

std::string PartialName(const std::string& target) {
  static std::atomic<unsigned> counter{0};
  std::filesystem::path name(target);
  name.replace_filename(absl::StrCat(".limn-", getpid(), "-", counter.fetch_add(1), ".part"));
  return name.string();
}

}  // namespace

absl::StatusOr<std::unique_ptr<OutputFile>> OutputFile::Create(const std::string& path) {
  const std::string target = FollowLink(path);
  struct stat old = {};
  const bool exists = stat(target.c_str(), &old) == 0;
  if (exists && !S_ISREG(old.st_mode)) return NotRegular(target);
  if (exists && access(target.c_str(), W_OK) != 0) return SystemError(target);
  while (true) {
    const std::string partial = PartialName(target);
    const int descriptor = open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno == EEXIST) continue;  // left behind by a killed process
    if (descriptor < 0) return SystemError(target);
    // Where permissions cannot be copied, those of a new file have to do.
    if (exists) (void)fchmod(descriptor, old.st_mode & 07777);
    return std::unique_ptr<OutputFile>(new OutputFile(target, partial, descriptor));
  }
}

OutputFile::OutputFile(std::string target, std::string partial, int descriptor)
    : target_(std::move(target)),
      partial_(std::move(partial)),
      descriptor_(descriptor),
      buffer_(kBufferBytes) {}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (!partial_.empty()) unlink(partial_.c_str());
}

void OutputFile::Append(std::string_view bytes) {
  if (bytes.size() > buffer_.size() - used_) Flush();
  if (bytes.size() > buffer_.size()) {
    Write(bytes);
    return;
  }
  std::copy(bytes.begin(), bytes.end(), buffer_.data() + used_);
  used_ += bytes.size();
}

void OutputFile::Flush() {
  Write({buffer_.data(), used_});
  used_ = 0;
}

void OutputFile::Write(std::string_view bytes) {
  while (status_.ok() && !bytes.empty()) {
    const ssize_t done = write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) {
      status_ = SystemError(target_);
      return;
    }
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
}

absl::Status OutputFile::Commit() {
  Flush();
  // Some file systems report a full disk or quota only here.
  if (close(std::exchange(descriptor_, -1)) != 0 && status_.ok()) status_ = SystemError(target_);
  LIMN_RETURN_IF_ERROR(status_);
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) return SystemError(target_);
  partial_.clear();
  return absl::OkStatus();
}

}  // namespace limn::io
