// SPDX-License-Identifier: MIT
// What is wrong with a command line that cannot be understood.
#include "client/cli/usage.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace limn::cli {
namespace {

// Letters to change, insert, remove or swap with a neighbour: optimal string alignment.
std::size_t Distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

std::string DidYouMean(std::string_view word, const std::vector<std::string>& known) {
  const std::optional<std::string> near = NearestWord(word, known);
  return near.has_value() ? absl::StrCat("; did you mean ", *near, "?") : "";
}

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::string UnknownFlag(const CLI::App& command, std::string_view word) {
  const std::string flag(word.substr(0, word.find('=')));
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  return absl::StrCat("there is no flag ", flag, DidYouMean(flag, known));
}

}  // namespace

std::optional<std::string> NearestWord(std::string_view word,
                                       const std::vector<std::string>& known) {
  // A word of any length costs no more than one that is too long to be any of these.
  constexpr std::size_t kLongest = 40;
  constexpr std::size_t kShortestBeginning = 4;
  if (word.size() > kLongest) return std::nullopt;
  std::optional<std::string> nearest;
  std::size_t best = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const bool begins = word.size() >= kShortestBeginning && candidate.starts_with(word);
    const std::size_t distance = begins ? 0 : Distance(word, candidate);
    if (distance >= best || distance >= word.size()) continue;
    best = distance;
    nearest = candidate;
  }
  return nearest;
}

std::string ExplainUsageError(const CLI::App& app, const CLI::ParseError& error) {
  // Their name is that of the command.
  const int code = error.get_exit_code();
  const bool extras = code == static_cast<int>(CLI::ExitCodes::ExtrasError);
  const bool required = code == static_cast<int>(CLI::ExitCodes::RequiredError);
  const auto chosen = app.get_subcommands();
  const std::vector<std::string> words = app.remaining(true);
  if (!extras && !required) return error.what();
  for (const std::string& word : words) {
    if (word.size() < 2 || word[0] != '-') continue;
    return UnknownFlag(chosen.empty() ? app : *chosen.front(), word);
  }
  const std::string commands = absl::StrJoin(CommandNames(app), ", ");
  if (chosen.empty() && words.empty()) return "a command is missing; there are " + commands;
  if (chosen.empty()) {
    return absl::StrCat("there is no command ", words[0], DidYouMean(words[0], CommandNames(app)),
                        "; there are ", commands);
  }
  if (!extras) return error.what();
  return absl::StrCat(
      words.size() > 1 ? "there are arguments too many: " : "there is an argument too many: ",
      absl::StrJoin(words, " "));
}

}  // namespace limn::cli
