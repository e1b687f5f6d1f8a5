// How the programs' --help looks: 80 columns wide and short enough for a screen. Options that few people need
// are shown by --help-all alone. For program start; single-threaded.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace strobe::command_line {

/// Gives a program this look and its --help-all. Call it before subcommands are added: they take it over.
void set_help(CLI::App& program);

/// In a footer: what follows is shown by --help-all alone.
inline constexpr char kForExperts = '\f';

/// Leaves these options of a command out of --help. Throws CLI::OptionNotFound if it has no such option.
void for_experts(CLI::App& command, const std::vector<std::string>& options);

/// The text with each line broken at blanks so that none is longer than `width`, if its words allow; what continues
/// a line is indented like it. Lines that show a command to type, "Example: ..." and those indented below it, stay whole.
std::string wrapped(std::string_view text, std::size_t width);

}  // namespace strobe::command_line
