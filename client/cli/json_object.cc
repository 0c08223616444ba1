// SPDX-License-Identifier: MIT
// Writes small JSON objects, members in the order in which they are added.
#include "client/cli/json_object.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"

namespace limn::cli {
namespace {

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += absl::StrFormat("\\u%04x", static_cast<unsigned>(byte));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string NumberText(double value) {
  return std::isfinite(value) ? absl::StrFormat("%.17g", value) : "null";
}

// Moves the lines after the first further in.
std::string Deeper(const std::string& text) {
  std::string deeper;
  for (const char c : text) {
    deeper += c;
    if (c == '\n') deeper += "  ";
  }
  return deeper;
}

}  // namespace

JsonObject& JsonObject::AddRaw(std::string_view name, std::string value) {
  members_.push_back({Quoted(name), std::move(value)});
  return *this;
}

JsonObject& JsonObject::Add(std::string_view name, std::string_view value) {
  return AddRaw(name, Quoted(value));
}

JsonObject& JsonObject::Add(std::string_view name, const std::vector<std::string>& values) {
  std::string text = "[";
  for (const std::string& value : values) text += (text.size() == 1 ? "" : ", ") + Quoted(value);
  return AddRaw(name, text + "]");
}

JsonObject& JsonObject::AddNumber(std::string_view name, double value) {
  return AddRaw(name, NumberText(value));
}

JsonObject& JsonObject::Add(std::string_view name, const std::array<double, 3>& value) {
  return AddRaw(name, "[" + NumberText(value[0]) + ", " + NumberText(value[1]) + ", " +
                          NumberText(value[2]) + "]");
}

JsonObject& JsonObject::Add(std::string_view name, const JsonObject& value) {
  return AddRaw(name, Deeper(value.Text()));
}

JsonObject& JsonObject::Add(std::string_view name, const std::vector<JsonObject>& values) {
  std::string text = "[";
  for (const JsonObject& value : values) {
    text += text.size() == 1 ? "\n  " : ",\n  ";
    text += Deeper(value.Text());
  }
  return AddRaw(name, Deeper(text + (values.empty() ? "]" : "\n]")));
}

std::string JsonObject::Line() const {
  std::string text = "{";
  for (const Member& member : members_) {
    text += text.size() == 1 ? "" : ", ";
    text += member.name + ": " + member.value;
  }
  return text + "}";
}

std::string JsonObject::Text() const {
  if (members_.empty()) return "{}";
  std::string text = "{";
  for (const Member& member : members_) {
    text += text.size() == 1 ? "\n  " : ",\n  ";
    text += member.name + ": " + member.value;
  }
  return text + "\n}";
}

}  // namespace limn::cli
