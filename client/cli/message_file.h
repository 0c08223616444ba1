// SPDX-License-Identifier: MIT
// Text files, and messages of the contract in their JSON mapping.
#pragma once

#include <google/protobuf/message.h>

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace limn::cli {

// All of a file, all of standard input. Errors: those of the system, naming the file;
// MALFORMED_FILE for more than 256 MiB.
[[nodiscard]] absl::StatusOr<std::string> ReadTextFile(const std::string& path);
[[nodiscard]] absl::StatusOr<std::string> ReadStandardInput();

// The same error with its detail and another message.
[[nodiscard]] absl::Status WithMessage(const absl::Status& status, const std::string& message);
// The same with its message between these.
[[nodiscard]] absl::Status Surrounded(const std::string& before, const absl::Status& status,
                                      const std::string& after = "");

struct MessageFile {
  // As errors call it.
  std::string path;
  // What the file holds, for errors, such as "constraints".
  std::string field;
  // What the paths of its fields begin with in errors: where the message is within another.
  std::string prefix = "";
  // What errors say that the file has to be. Empty: the JSON of the message.
  std::string remedy = "";
};

// Fills the message from its JSON mapping. Errors: MALFORMED_FILE, whose message begins with the
// file's name and, where there is one, the field's path: what is no JSON, unknown fields, values of
// the wrong type or out of their type's range, names that are none of an enumeration's.
[[nodiscard]] absl::Status ParseMessage(const std::string& json, const MessageFile& file,
                                        google::protobuf::Message* message);

}  // namespace limn::cli
