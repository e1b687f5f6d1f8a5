#include "common/command_line/complaint.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

namespace strobe::command_line {
namespace {

/// Lower case, without leading dashes and a value after "=".
std::string bare(const std::string& typed) {
  const std::size_t first = std::min(typed.find_first_not_of('-'), typed.size());
  std::string name = typed.substr(first, typed.find('=', first) - first);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// Letters left out, added, changed, or swapped with their neighbour (optimal string alignment).
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> least(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        least[i][j] = i + j;
        continue;
      }
      least[i][j] = std::min(
          {least[i - 1][j] + 1, least[i][j - 1] + 1, least[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        least[i][j] = std::min(least[i][j], least[i - 2][j - 2] + 1);
    }
  }
  return least[a.size()][b.size()];
}

std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_group().empty()) names.push_back(command->get_name());
  return names;
}

std::string on_one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

std::string no_such(const std::string& kind, const std::string& typed,
                    const std::vector<std::string>& names) {
  const auto meant = nearest(typed, names);
  return "no " + kind + " " + typed + (meant ? "; did you mean " + *meant + "?" : "");
}

/// Of what was left over when the command took what it knows.
std::string left_over(const CLI::App& command, const std::vector<std::string>& rest) {
  for (const std::string& word : rest)
    if (word.size() > 1 && word[0] == '-')
      return no_such("option", word.substr(0, word.find('=')), options_of(command));
  const std::vector<std::string> commands = commands_of(command);
  return commands.empty() ? "\"" + rest[0] + "\" was not expected" : no_such("command", rest[0], commands);
}

/// "in range [1 - 9]", as CLI11 says since 2.4, in the words of 2.3: "in range 1 to 9".
std::string with_range_in_words(std::string text) {
  const std::string before = " in range [", between = " - ";
  const std::size_t from = text.find(before), dash = text.find(between, from), to = text.find(']', dash);
  if (from == std::string::npos || dash == std::string::npos || to == std::string::npos) return text;
  text.erase(to, 1);
  text.replace(dash, between.size(), " to ");
  return text.erase(from + before.size() - 1, 1);
}

/// The library's words, but for those that name its types.
std::string words_of(const CLI::ParseError& error) {
  const std::string what = with_range_in_words(error.what());
  if (what.empty()) return error.get_name();
  const bool short_of_values = dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr;
  const std::size_t colon = what.find(": ");
  if (short_of_values && colon != std::string::npos && what.ends_with("missing"))
    return what.substr(0, colon) + ": its value is missing";
  return what == "A subcommand is required" ? "which command?" : what;
}

}  // namespace

std::optional<std::string> nearest(const std::string& typed, const std::vector<std::string>& names) {
  const std::string wanted = bare(typed);
  if (wanted.empty()) return std::nullopt;
  const std::size_t most = std::clamp<std::size_t>(wanted.size() / 3, 1, 3);
  std::optional<std::string> best;
  std::size_t least = most + 1;
  for (const std::string& name : names) {
    const std::string known = bare(name);
    const bool begun = wanted.size() >= 3 && known.starts_with(wanted);
    const std::size_t distance = begun ? 1 : edits(wanted, known);
    if (distance >= least || distance >= known.size()) continue;
    least = distance;
    best = name;
  }
  return best;
}

std::string complaint(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App* command = &program;
  std::string name = program.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  std::vector<std::string> rest = command->remaining();
  if (rest.empty()) rest = program.remaining();
  rest.erase(std::find(rest.begin(), rest.end(), "--"), rest.end());  // another program's words
  const std::string why = rest.empty() ? words_of(error) : left_over(*command, rest);
  return on_one_line(name + ": " + why + " (" + name + " --help)");
}

}  // namespace strobe::command_line
