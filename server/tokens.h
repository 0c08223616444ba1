// SPDX-License-Identifier: MIT
// Bearer tokens (RFC 6750): who may call.
#pragma once

#include <ctime>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace limn {

// The tokens of a file: one a line, each a TOKEN or a NAME and a TOKEN with blanks between them.
// Empty lines and lines that begin with '#' are skipped. A token is 16 to 512 visible ASCII
// characters. Thread-safe.
class Tokens {
 public:
  // Errors: INVALID_OPTION naming "token-file", with the line; never a token. A file without any
  // token is an error.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Tokens>> Load(const std::string& path);

  // Reads the file again if it has changed. After an error, those of Load, the old tokens hold.
  // True: there are new tokens.
  [[nodiscard]] absl::StatusOr<bool> Refresh();

  // The client whose token this is, by name or as "token-N" by its place in the file; nothing for
  // any other text. authorization: the value of the "authorization" metadata, "Bearer TOKEN". Takes
  // the same time whichever token comes how near to which: all are compared, to their ends.
  [[nodiscard]] std::optional<std::string> ClientOf(std::string_view authorization) const;

 private:
  struct Entry {
    std::string client;
    std::string token;
  };
  // What tells a changed file: also of one that was renamed into its place.
  struct Stamp {
    timespec modified{};
    ino_t inode = 0;
    off_t size = -1;
    bool operator==(const Stamp& other) const;
  };
  explicit Tokens(std::string path) : path_(std::move(path)) {}
  [[nodiscard]] static Stamp StampOf(const std::string& path);
  [[nodiscard]] absl::StatusOr<std::vector<Entry>> Read() const;

  const std::string path_;
  mutable std::mutex mutex_;
  Stamp stamp_;
  std::vector<Entry> entries_;
};

// Whether the two are equal; takes a time that depends on the length of `secret` only.
[[nodiscard]] bool SameSecret(std::string_view given, std::string_view secret);

}  // namespace limn
