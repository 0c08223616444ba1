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
  const int what = errno;
  const std::filesystem::path folder = std::filesystem::path(target).parent_path();
  std::error_code error;
  if (what == ENOENT && !folder.empty() && !std::filesystem::exists(folder, error)) {
    return absl::NotFoundError(
        absl::StrCat("cannot write ", target, ": the folder ", folder.string(), " does not exist"));
  }
  errno = what;
  return absl::ErrnoToStatus(errno, absl::StrCat("cannot write ", target));
}

absl::Status NotRegular(const std::string& target) {
  return MakeError(
      absl::StrCat(target, " exists and is not a regular file"),
      {.reason = Reason::kInvalidOption, .field = "output", .remedy = "Give the name of a file"});
}

// Where the file is to go when `path` is a link, also one to what does not exist yet.
std::string FollowLink(const std::string& path) {
  namespace fs = std::filesystem;
  constexpr int kMostLinks = 40;
  fs::path target = path;
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(target, error); ++i) {
    const fs::path next = fs::read_symlink(target, error);
    if (error) return path;
    target = next.is_absolute() ? next : target.parent_path() / next;
  }
  return target.string();
}

// A name beside the target that this process has not used yet.
std::string NameBeside(const std::string& target, const std::string& extension) {
  static std::atomic<unsigned> counter{0};
  std::filesystem::path name(target);
  name.replace_filename(absl::StrCat(".limn-", getpid(), "-", counter.fetch_add(1), extension));
  return name.string();
}

}  // namespace

absl::StatusOr<std::unique_ptr<OutputFile>> OutputFile::Create(const std::string& path,
                                                               std::function<bool()> stop) {
  const std::string target = FollowLink(path);
  struct stat old = {};
  const bool exists = stat(target.c_str(), &old) == 0;
  if (exists && !S_ISREG(old.st_mode)) return NotRegular(target);
  if (exists && access(target.c_str(), W_OK) != 0) return SystemError(target);
  while (true) {
    const std::string partial = NameBeside(target, ".part");
    const int descriptor = open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno == EEXIST) continue;  // left behind by a killed process
    if (descriptor < 0) return SystemError(target);
    // Where permissions cannot be copied, those of a new file have to do.
    if (exists) (void)fchmod(descriptor, old.st_mode & 07777);
    std::unique_ptr<OutputFile> file(new OutputFile(target, partial, descriptor));
    file->stop_ = std::move(stop);
    return file;
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
  if (!older_.empty()) unlink(older_.c_str());
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
  if (status_.ok() && stop_ && stop_()) {
    status_ = MakeError("writing was interrupted", {.reason = Reason::kCancelled});
  }
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
  LIMN_RETURN_IF_ERROR(Close());
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) return SystemError(target_);
  partial_.clear();
  return absl::OkStatus();
}

absl::Status OutputFile::Close() {
  if (descriptor_ < 0) return status_;
  Flush();
  // Some file systems report a full disk or quota only here.
  if (close(std::exchange(descriptor_, -1)) != 0 && status_.ok()) status_ = SystemError(target_);
  return status_;
}

absl::Status OutputFile::Place() {
  LIMN_RETURN_IF_ERROR(KeepOlder());
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) {
    absl::Status status = SystemError(target_);
    Undo();
    return status;
  }
  partial_.clear();
  placed_ = true;
  return absl::OkStatus();
}

// A second name where the file system has hard links, so that the target is never missing; else the
// file moves aside.
absl::Status OutputFile::KeepOlder() {
  struct stat old = {};
  if (lstat(target_.c_str(), &old) != 0) return absl::OkStatus();
  // Something else has taken the place since the file was created.
  if (!S_ISREG(old.st_mode)) return NotRegular(target_);
  while (true) {
    const std::string name = NameBeside(target_, ".older");
    if (link(target_.c_str(), name.c_str()) == 0) {
      older_ = name;
      return absl::OkStatus();
    }
    if (errno == EEXIST) continue;
    if (access(name.c_str(), F_OK) == 0) continue;
    if (std::rename(target_.c_str(), name.c_str()) != 0) return SystemError(target_);
    older_ = name;
    return absl::OkStatus();
  }
}

void OutputFile::Undo() {
  if (!older_.empty()) {
    if (std::rename(older_.c_str(), target_.c_str()) == 0) older_.clear();
  } else if (placed_) {
    unlink(target_.c_str());
  }
  placed_ = false;
}

}  // namespace limn::io
