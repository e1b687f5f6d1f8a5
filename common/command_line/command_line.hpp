// How the programs' command lines look. --help is 80 columns wide and short enough for a screen; options that
// few people need are shown by --help-all alone. A command line that cannot be taken gets one line that names
// the command, what is wrong, the nearest thing that exists where something was mistyped, and whose help to
// read. For program start; single-threaded; allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace strobe::command_line {

/// Gives a program this look and its --help-all. Call it before subcommands are added: they take it over.
void set_help(CLI::App& program);

/// In a footer: what follows is shown by --help-all alone.
inline constexpr char kForExperts = '\f';

/// Leaves these options of a command out of --help. Throws CLI::OptionNotFound if it has no such option.
void for_experts(CLI::App& command, const std::vector<std::string>& options);

/// The text with each line broken at blanks so that none is longer than `width`, if its words allow; what
/// continues a line is indented like it. Lines that show a command to type, "Example: ..." and those indented
/// below it, stay whole.
std::string wrapped(std::string_view text, std::size_t width);

/// "strobe fire: no option --shot; did you mean --shots? (strobe fire --help)". `program` has thrown the
/// error while it parsed, and is named.
std::string complaint(const CLI::App& program, const CLI::ParseError& error);

}  // namespace strobe::command_line
