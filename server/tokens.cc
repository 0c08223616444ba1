// SPDX-License-Identifier: MIT
#include "server/tokens.h"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kLeastToken = 16;
constexpr std::size_t kMostToken = 512;

absl::Status Invalid(std::string_view message, std::string_view remedy) {
  return MakeError(
      message,
      {.reason = Reason::kInvalidOption, .field = "token-file", .remedy = std::string(remedy)});
}

bool IsToken(std::string_view text) {
  return text.size() >= kLeastToken && text.size() <= kMostToken &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return absl::ascii_isgraph(static_cast<unsigned char>(c)); });
}

}  // namespace

bool SameSecret(std::string_view given, std::string_view secret) {
  // Volatile: a compiler must not turn this into a comparison that ends at the first difference.
  volatile unsigned char difference = given.size() == secret.size() ? 0 : 1;
  for (std::size_t i = 0; i < secret.size(); ++i) {
    const char c = given.empty() ? '\0' : given[i % given.size()];
    difference = static_cast<unsigned char>(difference | (c ^ secret[i]));
  }
  return difference == 0;
}

bool Tokens::Stamp::operator==(const Stamp& other) const {
  return modified.tv_sec == other.modified.tv_sec && modified.tv_nsec == other.modified.tv_nsec &&
         inode == other.inode && size == other.size;
}

Tokens::Stamp Tokens::StampOf(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  return {status.st_mtim, status.st_ino, status.st_size};
}

absl::StatusOr<std::unique_ptr<Tokens>> Tokens::Load(const std::string& path) {
  std::unique_ptr<Tokens> tokens(new Tokens(path));
  LIMN_RETURN_IF_ERROR(tokens->Refresh().status());
  return tokens;
}

absl::StatusOr<bool> Tokens::Refresh() {
  const Stamp stamp = StampOf(path_);
  {
    const std::lock_guard lock(mutex_);
    if (!entries_.empty() && stamp == stamp_) return false;
    // Also after a failure: it is reported once.
    stamp_ = stamp;
  }
  LIMN_ASSIGN_OR_RETURN(std::vector<Entry> entries, Read());
  const std::lock_guard lock(mutex_);
  entries_ = std::move(entries);
  return true;
}

absl::StatusOr<std::vector<Tokens::Entry>> Tokens::Read() const {
  std::ifstream file(path_);
  if (!file) return Invalid(absl::StrCat(path_, " cannot be read"), "Name a file with tokens");
  std::vector<Entry> entries;
  std::size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const std::vector<std::string> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty() || words[0][0] == '#') continue;
    if (words.size() > 2 || !IsToken(words.back())) {
      return Invalid(absl::StrCat("line ", number, " of ", path_, " is no token"),
                     "Write TOKEN or NAME TOKEN, the token of 16 to 512 visible characters");
    }
    const std::string name =
        words.size() == 2 ? words[0] : absl::StrCat("token-", entries.size() + 1);
    entries.push_back({name, words.back()});
  }
  if (entries.empty()) {
    return Invalid(absl::StrCat(path_, " holds no token"), "Write one a line");
  }
  return entries;
}

std::optional<std::string> Tokens::ClientOf(std::string_view authorization) const {
  constexpr std::string_view kScheme = "bearer ";
  if (!absl::StartsWithIgnoreCase({authorization.data(), authorization.size()},
                                  {kScheme.data(), kScheme.size()})) {
    return std::nullopt;
  }
  const std::string_view given = authorization.substr(kScheme.size());
  const std::lock_guard lock(mutex_);
  const Entry* found = nullptr;
  for (const Entry& entry : entries_) {
    if (SameSecret(given, entry.token)) found = &entry;
  }
  if (found == nullptr) return std::nullopt;
  return found->client;
}

}  // namespace limn
