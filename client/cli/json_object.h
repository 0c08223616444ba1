// SPDX-License-Identifier: MIT
// Writes small JSON objects, members in the order in which they are added.
#pragma once

#include <array>
#include <concepts>
#include <string>
#include <string_view>
#include <vector>

namespace limn::cli {

class JsonObject {
 public:
  template <std::integral Number>
  requires(!std::same_as<Number, bool>) JsonObject& Add(std::string_view name, Number value) {
    return AddRaw(name, std::to_string(value));
  }
  template <std::same_as<bool> Bool>
  JsonObject& Add(std::string_view name, Bool value) {
    return AddRaw(name, value ? "true" : "false");
  }
  JsonObject& Add(std::string_view name, std::string_view value);
  JsonObject& Add(std::string_view name, const std::vector<std::string>& values);
  // Numbers that JSON does not know, such as NaN, become null.
  JsonObject& AddNumber(std::string_view name, double value);
  JsonObject& Add(std::string_view name, const std::array<double, 3>& value);
  JsonObject& Add(std::string_view name, const JsonObject& value);
  JsonObject& Add(std::string_view name, const std::vector<JsonObject>& values);

  // Indented, without a line feed at the end.
  std::string Text() const;
  // In one line, if no member is an object or a list of them.
  std::string Line() const;

 private:
  struct Member {
    std::string name;
    std::string value;
  };
  JsonObject& AddRaw(std::string_view name, std::string value);

  std::vector<Member> members_;
};

}  // namespace limn::cli
