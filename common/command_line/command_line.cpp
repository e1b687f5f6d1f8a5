#include "common/command_line/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <sstream>

#include "common/config/nearest.hpp"

namespace strobe::command_line {
namespace {

constexpr const char* kExperts = "Options that few need";
constexpr std::size_t kWidth = 80;
constexpr std::size_t kNames = 26;  // columns for options' names

/// "INT:INT in [1 - 9]" and the like, as a person would say it.
std::string value_words(const std::string& type, bool all) {
  const std::size_t colon = type.find(':');
  const std::string limits = colon == std::string::npos ? "" : type.substr(colon + 1);
  if (!limits.empty() && limits[0] == '{') return limits;
  const std::string kind = type.substr(0, colon);
  const std::string plain = kind == "INT" || kind == "UINT" ? "N" : kind == "FLOAT" ? "NUMBER" : kind;
  const std::size_t range = limits.find('[');
  return all && range != std::string::npos ? plain + " " + limits.substr(range) : plain;
}

/// A name, and what it means beside it; below it, where the name is too long.
std::string entry(const std::string& name, const std::string& meaning, std::size_t column) {
  std::string text = "  " + name;
  std::istringstream lines(wrapped(meaning, kWidth - column));
  bool first = text.size() < column;
  for (std::string line; std::getline(lines, line); first = false) {
    if (!first) text += "\n";
    text += std::string(first ? column - text.size() : column, ' ') + line;
  }
  return text + "\n";
}

class ScreenFormatter final : public CLI::Formatter {
 public:
  ScreenFormatter() {
    column_width(kNames);
    label("SUBCOMMAND", "COMMAND");
    label("Positionals", "Arguments");
  }

  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    all_ = mode != CLI::AppFormatMode::Normal;
    std::string help = Formatter::make_help(app, name, mode);
    for (std::size_t at; (at = help.find("\n\n\n")) != help.npos;) help.erase(at, 1);
    return help;
  }
  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    if (group == kExperts && !all_) return "";
    return Formatter::make_group(group, is_positional, options);
  }
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    return entry(make_option_name(option, is_positional) + make_option_opts(option), make_option_desc(option),
                 kNames);
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0) return "";
    std::string words = " " + value_words(option->get_type_name(), all_);
    if (option->get_expected_max() > 1) words += " ...";
    return words;
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    const std::string standard = option->get_default_str();
    return option->get_description() + (option->get_required() ? " (required)" : "") +
           (standard.empty() || standard == "\"\"" ? "" : " (default " + standard + ")");
  }
  std::string make_subcommand(const CLI::App* command) const override {
    constexpr std::size_t kCommands = 14;
    return entry(command->get_name(), command->get_description(), kCommands);
  }
  std::string make_description(const CLI::App* app) const override {
    return wrapped(Formatter::make_description(app), kWidth);
  }
  std::string make_footer(const CLI::App* app) const override {
    const std::string footer = app->get_footer();
    const std::size_t end = footer.find(kForExperts);
    if (end == footer.npos) return wrapped(footer, kWidth) + "\n";
    return wrapped(footer.substr(0, end), kWidth) +
           (all_ ? wrapped(footer.substr(end + 1), kWidth) + "\n" : "");
  }

 private:
  mutable bool all_ = false;  // while a help is made
};

/// Appends one line, broken.
void append_wrapped(std::string& text, std::string_view line, std::size_t width) {
  if (line.size() <= width) {
    text.append(line);
    return;
  }
  const std::size_t margin = std::min(line.find_first_not_of(' '), line.size());
  std::istringstream words{std::string(line)};
  std::size_t column = 0;
  for (std::string word; words >> word; column += word.size()) {
    if (column > 0 && column + 1 + word.size() > width) {
      text += '\n';
      column = 0;
    }
    const std::size_t blanks = column == 0 ? margin : 1;
    text.append(blanks, ' ').append(word);
    column += blanks;
  }
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
  return "no " + kind + " " + typed + config::did_you_mean(typed, names);
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
std::string with_plain_range(std::string text) {
  const std::string before = " in range [", between = " - ";
  const std::size_t from = text.find(before), dash = text.find(between, from), to = text.find(']', dash);
  if (from == std::string::npos || dash == std::string::npos || to == std::string::npos) return text;
  text.erase(to, 1);
  text.replace(dash, between.size(), " to ");
  return text.erase(from + before.size() - 1, 1);
}

/// The library's words, but for those that name its types.
std::string plain_text(const CLI::ParseError& error) {
  const std::string what = with_plain_range(error.what());
  if (what.empty()) return error.get_name();
  const bool short_of_values = dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr;
  const std::size_t colon = what.find(": ");
  if (short_of_values && colon != std::string::npos && what.ends_with("missing"))
    return what.substr(0, colon) + ": its value is missing";
  return what == "A subcommand is required" ? "which command?" : what;
}

}  // namespace

std::string wrapped(std::string_view text, std::size_t width) {
  std::string broken;
  bool to_type = false;
  while (true) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    to_type = line.substr(0, 7) == "Example" || (to_type && line.substr(0, 1) == " ");
    if (to_type) {
      broken.append(line);
    } else {
      append_wrapped(broken, line, width);
    }
    if (end == text.size()) return broken;
    broken += '\n';
    text.remove_prefix(end + 1);
  }
}

void set_help(CLI::App& program) {
  program.formatter(std::make_shared<ScreenFormatter>());
  program.group("Commands");  // as which its commands are listed
  program.set_help_flag("-h,--help", "print this and end");
  program.set_help_all_flag("--help-all", "likewise, with options that few need");
}

void for_experts(CLI::App& command, const std::vector<std::string>& options) {
  for (const std::string& name : options) command.get_option(name)->group(kExperts);
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
  const std::string why = rest.empty() ? plain_text(error) : left_over(*command, rest);
  return on_one_line(name + ": " + why + " (" + name + " --help)");
}

}  // namespace strobe::command_line
