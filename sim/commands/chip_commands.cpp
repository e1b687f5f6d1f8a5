#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/messages/parsed_json.hpp"
#include "sim/commands/commands.hpp"
#include "sim/gpiochip/chip.hpp"
#include "sim/live/rig_runner.hpp"

namespace strobe::sim {

namespace {

constexpr Duration kLook = milliseconds(50);  // how soon the chip's end is noticed

/// LINE=NUMBER, LINE a name or an offset.
struct LineNumber {
  std::uint32_t line = 0;
  int number = 0;
};

bool whole_number(const std::string& text, auto& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

/// `text` is what was given, for errors.
Result<std::uint32_t> find_line(const Chip& chip, const std::string& line, const std::string& text) {
  std::uint32_t offset = 0;
  if (whole_number(line, offset)) {
    if (offset < chip.line_count()) return offset;
    return fail("\"" + text + "\": the chip has no line " + line);
  }
  const auto named = chip.line_named(line);
  if (!named) return fail("\"" + text + "\": " + named.error().message);
  return *named;
}

Result<LineNumber> parse(const Chip& chip, const std::string& text, int least, int most, const char* wanted) {
  const std::size_t equals = text.find('=');
  LineNumber parsed;
  if (equals == std::string::npos || !whole_number(text.substr(equals + 1), parsed.number) ||
      parsed.number < least || parsed.number > most) {
    return fail("\"" + text + "\": must be " + wanted);
  }
  const auto line = find_line(chip, text.substr(0, equals), text);
  if (!line) return tl::unexpected(line.error());
  parsed.line = *line;
  return parsed;
}

/// False if the chip ended before the line had risen so often.
bool wait_for_rises(Chip& chip, const LineNumber& rises) {
  ChangeCursor cursor = chip.cursor_now();
  std::vector<Change> changes;
  for (int left = rises.number; left > 0 && !chip.unplugged();) {
    changes.clear();
    chip.wait_changes(cursor, chip.now() + kLook, changes);
    for (const Change& change : changes) left -= change.line == rises.line && change.level == 1 ? 1 : 0;
  }
  return !chip.unplugged();
}

/// `after` is LINE=N, or empty. Returns the exit status of a command that cannot go on; nullopt: it is time.
std::optional<int> wait_until(Chip& chip, const std::string& after) {
  if (after.empty()) return std::nullopt;
  const auto rises = parse(chip, after, 1, 1'000'000, "LINE=N, N from 1 to 1000000");
  if (!rises) return report_error("--after " + rises.error().message, 2);
  if (!wait_for_rises(chip, *rises)) return report_error("the rig ended before --after " + after, 1);
  return std::nullopt;
}

std::string name_of(std::size_t line) {
  return line < kLineNames.size() ? std::string(kLineNames[line]) : std::string();
}

constexpr int kOpen = -1;

/// LINE=open is kOpen.
Result<LineNumber> parse_drive(const Chip& chip, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || text.substr(equals + 1) != "open")
    return parse(chip, text, 0, 1, "LINE=0, LINE=1 or LINE=open");
  const auto line = find_line(chip, text.substr(0, equals), text);
  if (!line) return tl::unexpected(line.error());
  return LineNumber{*line, kOpen};
}

}  // namespace

int drive_command(const std::string& chip_dir, const std::vector<std::string>& drives,
                  const std::string& after) {
  auto chip = Chip::attach(chip_dir);
  if (!chip) return report_error(chip.error().message, 2);
  std::vector<LineNumber> wanted;
  for (const std::string& text : drives) {
    const auto drive = parse_drive(*chip, text);
    if (!drive) return report_error(drive.error().message, 2);
    if (chip->state(drive->line).is_output)
      return report_error("\"" + text + "\": the line is an output of " + chip->state(drive->line).consumer,
                          1);
    wanted.push_back(*drive);
  }
  if (const auto ended = wait_until(*chip, after)) return *ended;
  for (const LineNumber& drive : wanted) {
    if (drive.number == kOpen) {
      chip->open_wire(drive.line, chip->now());
    } else {
      chip->drive(drive.line, drive.number, chip->now());
    }
  }
  return 0;
}

int unplug_command(const std::string& chip_dir, const std::string& after) {
  auto chip = Chip::attach(chip_dir);
  if (!chip) return report_error(chip.error().message, 2);
  if (const auto ended = wait_until(*chip, after)) return *ended;
  chip->unplug();
  return 0;
}

int clock_command(const std::string& chip_dir, const ClockOptions& options, const std::string& after) {
  if (options.suspend_s == 0.0 && options.step_s == 0.0)
    return report_error("clock: --suspend or --step is missing", 2);
  auto chip = Chip::attach(chip_dir);
  if (!chip) return report_error(chip.error().message, 2);
  if (const auto ended = wait_until(*chip, after)) return *ended;
  if (chip->set_clocks(from_seconds(options.suspend_s), from_seconds(options.step_s))) return 0;
  return report_error(
      "the rig runs by this computer's clock (--time real): start it with strobe-sim run --time wall or "
      "--time fast",
      1);
}

int lines_command(const std::string& chip_dir, bool json) {
  const auto chip = Chip::attach(chip_dir);
  if (!chip) return report_error(chip.error().message, 2);
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
      fmt::print("{}\n", messages::json_text(line));
    } else {
      fmt::print("{:>3}  {:<9} {:<6} {}  {}\n", i, name_of(i), direction, state.level,
                 state.requested ? state.consumer : "-");
    }
  }
  return 0;
}

}  // namespace strobe::sim
