// What a program says of a command line that it cannot take: one line that names the command, what is wrong, the
// nearest thing that exists where something was mistyped, and whose help to read. Pure; allocates; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace strobe::command_line {

/// The name that was probably meant: one that differs by a letter or two left out, added, changed or swapped, or that
/// begins with what was typed. Letters of either case; leading dashes do not count.
std::optional<std::string> nearest(const std::string& typed, const std::vector<std::string>& names);

/// "strobe fire: no option --shot; did you mean --shots? (strobe fire --help)". `program` has thrown the error while it
/// parsed, and is named.
std::string complaint(const CLI::App& program, const CLI::ParseError& error);

}  // namespace strobe::command_line
