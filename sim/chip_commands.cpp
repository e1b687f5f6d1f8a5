#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "sim/command_line.hpp"
#include "sim/commands.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/runner.hpp"

namespace strobe::sim {

namespace {

struct LineLevel {
  std::uint32_t line = 0;
  int level = 0;
};

Result<LineLevel> parse_drive(const Chip& chip, const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string level = equals == std::string::npos ? "" : text.substr(equals + 1);
  if (level != "0" && level != "1") return fail("\"" + text + "\": LINE=0 or LINE=1 is wanted");
  const std::string line = text.substr(0, equals);
  std::uint32_t offset = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), offset);
  if (error == std::errc{} && end == line.data() + line.size()) {
    if (offset >= chip.line_count()) return fail("\"" + text + "\": the chip has no line " + line);
  } else {
    const auto named = chip.line_named(line);
    if (!named) return fail("\"" + text + "\": " + named.error().message);
    offset = *named;
  }
  return LineLevel{offset, level == "1" ? 1 : 0};
}

std::string name_of(std::size_t line) {
  return line < kLineNames.size() ? std::string(kLineNames[line]) : std::string();
}

}  // namespace

int drive_command(const std::string& chip_dir, const std::vector<std::string>& drives) {
  auto chip = Chip::attach(chip_dir);
  if (!chip) return complain(chip.error().message, 2);
  std::vector<LineLevel> wanted;
  for (const std::string& text : drives) {
    const auto drive = parse_drive(*chip, text);
    if (!drive) return complain(drive.error().message, 2);
    if (chip->state(drive->line).is_output)
      return complain("\"" + text + "\": the line is an output of " + chip->state(drive->line).consumer, 1);
    wanted.push_back(*drive);
  }
  for (const LineLevel& drive : wanted) chip->drive(drive.line, drive.level, monotonic_now());
  return 0;
}

int lines_command(const std::string& chip_dir, bool json) {
  const auto chip = Chip::attach(chip_dir);
  if (!chip) return complain(chip.error().message, 2);
  for (std::uint32_t i = 0; i < chip->line_count(); ++i) {
    const LineState state = chip->state(i);
    const char* direction = state.is_output ? "output" : "input";
    if (json) {
      const nlohmann::json line = {{"line", i},
                                   {"name", name_of(i)},
                                   {"direction", direction},
                                   {"level", state.level},
                                   {"requested", state.requested},
                                   {"consumer", state.consumer}};
      fmt::print("{}\n", line.dump());
    } else {
      fmt::print("{:>3}  {:<9} {:<6} {}  {}\n", i, name_of(i), direction, state.level,
                 state.requested ? state.consumer : "-");
    }
  }
  return 0;
}

}  // namespace strobe::sim
