// SPDX-License-Identifier: MIT
#include "client/cli/batch_journal.h"

#include <fcntl.h>
#include <google/protobuf/struct.pb.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/json_object.h"
#include "client/cli/message_file.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

constexpr const char* kVersion = "1";

absl::Status Invalid(const std::string& path, std::string_view what, const std::string& remedy) {
  return MakeError(absl::StrCat(path, ": ", std::string(what)),
                   {.reason = Reason::kInvalidOption, .field = "resume", .remedy = remedy});
}

std::string TextOf(const google::protobuf::Struct& object, const std::string& name) {
  const auto found = object.fields().find(name);
  return found == object.fields().end() ? std::string() : found->second.string_value();
}

std::string MakeName() {
  std::random_device random;
  return absl::StrFormat("%08x%08x", random(), random());
}

}  // namespace

std::string BatchJournal::PathIn(const std::string& folder) {
  return (std::filesystem::path(folder) / "limn-batch.jsonl").string();
}

BatchJournal::BatchJournal(std::string path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {}

BatchJournal::~BatchJournal() { close(descriptor_); }

absl::StatusOr<std::unique_ptr<BatchJournal>> BatchJournal::Open(const std::string& folder,
                                                                 bool resume) {
  std::string path = PathIn(folder);
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0) return absl::ErrnoToStatus(errno, absl::StrCat("cannot write ", path));
  std::unique_ptr<BatchJournal> journal(new BatchJournal(path, descriptor));
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return Invalid(path, "another batch is writing there",
                   "Wait for it, or give -o another folder");
  }
  LIMN_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path));
  // Before any job has ended there is nothing to lose.
  if (text.find('\n') + 1 < text.size() && !resume) {
    return Invalid(path, "a batch was begun here",
                   "Go on with it by --resume, or remove that file to begin anew");
  }
  LIMN_RETURN_IF_ERROR(journal->Read(text));
  if (journal->name_.empty()) LIMN_RETURN_IF_ERROR(journal->Begin());
  return journal;
}

absl::Status BatchJournal::Begin() {
  name_ = MakeName();
  return Write(JsonObject().Add("limnBatch", std::string_view(kVersion)).Add("name", name_).Line());
}

absl::Status BatchJournal::Read(const std::string& text) {
  std::size_t number = 0;
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    LIMN_RETURN_IF_ERROR(ReadLine(text.substr(begin, end - begin), ++number));
    begin = end + 1;
  }
  // The end of a line that was never finished.
  if (begin == text.size() || ftruncate(descriptor_, static_cast<off_t>(begin)) == 0) {
    return absl::OkStatus();
  }
  return absl::ErrnoToStatus(errno, absl::StrCat("cannot write ", path_));
}

absl::Status BatchJournal::ReadLine(const std::string& line, std::size_t number) {
  const std::string place = absl::StrCat(path_, ":", number);
  const std::string remedy = "Remove the journal to begin anew";
  google::protobuf::Struct object;
  LIMN_RETURN_IF_ERROR(
      ParseMessage(line, {.path = place, .field = "resume", .remedy = remedy}, &object));
  if (number == 1) {
    name_ = TextOf(object, "name");
    if (TextOf(object, "limnBatch") == kVersion && !name_.empty()) return absl::OkStatus();
    return MakeError(absl::StrCat(place, ": it is no journal of this version's"),
                     {.reason = Reason::kMalformedFile, .field = "resume", .remedy = remedy});
  }
  const std::string id = TextOf(object, "id");
  if (TextOf(object, "status") == "succeeded") {
    done_[id] = TextOf(object, "digest");
  } else {
    done_.erase(id);
  }
  return absl::OkStatus();
}

const std::string* BatchJournal::Find(const std::string& id) const {
  const auto found = done_.find(id);
  return found == done_.end() ? nullptr : &found->second;
}

absl::Status BatchJournal::Add(const Record& record) {
  JsonObject line;
  line.Add("id", record.id).Add("digest", record.digest).Add("status", record.status);
  if (!record.reason.empty()) line.Add("reason", record.reason);
  if (!record.files.empty()) line.Add("files", record.files);
  return Write(line.Line());
}

// In one piece, so that no reader sees a half.
absl::Status BatchJournal::Write(const std::string& line) {
  const std::string text = line + "\n";
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t got = write(descriptor_, text.data() + written, text.size() - written);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return absl::ErrnoToStatus(errno, absl::StrCat("cannot write ", path_));
    written += static_cast<std::size_t>(got);
  }
  return absl::OkStatus();
}

}  // namespace limn::cli
