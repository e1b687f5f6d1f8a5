#include "tests/hil/line_changes.hpp"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "tests/support/json_lines.hpp"

namespace strobe::hil {
namespace {

std::vector<LineChange> read_changes(const std::filesystem::path& csv) {
  const testing::CsvTable table = testing::read_csv(csv);
  const std::size_t time = table.column("time_ns"), name = table.column("name");
  const std::size_t level = table.column("level"), cause = table.column("cause");
  std::vector<LineChange> changes;
  for (const auto& row : table.rows)
    changes.push_back({std::stoll(row.at(time)), row.at(name), std::stoi(row.at(level)), row.at(cause)});
  return changes;
}

}  // namespace

LineChanges::LineChanges(const std::filesystem::path& csv) : LineChanges(read_changes(csv)) {}

LineChanges::LineChanges(std::vector<LineChange> changes) : changes_(std::move(changes)) {
  std::stable_sort(changes_.begin(), changes_.end(),
                   [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; });
}

int LineChanges::rises(const std::string& line, std::int64_t from_ns, std::int64_t to_ns) const {
  int count = 0, level = 0;
  for (const LineChange& change : changes_) {
    if (change.line != line) continue;
    if (level == 0 && change.level == 1 && change.time_ns >= from_ns && change.time_ns <= to_ns) ++count;
    level = change.level;
  }
  return count;
}

int LineChanges::level_at(const std::string& line, std::int64_t time_ns) const {
  int level = 0;
  for (const LineChange& change : changes_)
    if (change.line == line && change.time_ns <= time_ns) level = change.level;
  return level;
}

std::int64_t LineChanges::outputs_safe_from(std::int64_t from_ns) const {
  std::int64_t safe = from_ns;
  for (const std::string& line : kOutputs) {
    if (level_at(line, INT64_MAX) != 0) return INT64_MAX;
    int level = 0;
    for (const LineChange& change : changes_) {
      if (change.line != line) continue;
      if (level != 0 && change.level == 0) safe = std::max(safe, change.time_ns);
      level = change.level;
    }
  }
  return safe;
}

std::int64_t LineChanges::inactive_from(std::int64_t from_ns, std::int64_t to_ns) const {
  std::int64_t inactive = from_ns;
  for (const std::string& line : kOutputs) {
    if (level_at(line, to_ns) != 0) return INT64_MAX;
    int level = 0;
    for (const LineChange& change : changes_) {
      if (change.line != line || change.time_ns > to_ns) continue;
      if (level != 0 && change.level == 0) inactive = std::max(inactive, change.time_ns);
      level = change.level;
    }
  }
  return inactive;
}

namespace {

sim::Chip attached(const std::filesystem::path& dir) {
  Result<sim::Chip> chip = sim::Chip::attach(dir);
  if (!chip) throw std::runtime_error(chip.error().message);
  return std::move(*chip);
}

}  // namespace

LineWatcher::LineWatcher(const std::filesystem::path& chip_dir)
    : chip_(attached(chip_dir)), cursor_(chip_.cursor_now()) {}

std::uint32_t LineWatcher::number(const std::string& line) const {
  const Result<std::uint32_t> found = chip_.line_named(line);
  if (!found) throw std::runtime_error(found.error().message);
  return *found;
}

std::int64_t LineWatcher::wait_for(const std::string& line, int level, std::chrono::milliseconds limit) {
  return wait_for_nth(line, level, 1, limit);
}

std::int64_t LineWatcher::wait_for(const std::string& line, int level, testing::Process& command) {
  for (bool ended = false; !ended;) {
    ended = !command.running();  // once more after its end: the change may have come just before
    const std::int64_t time = wait_for(line, level, std::chrono::milliseconds(50));
    if (time != 0) return time;
  }
  return 0;
}

std::int64_t LineWatcher::wait_for_nth(const std::string& line, int level, int n,
                                       std::chrono::milliseconds limit) {
  const std::uint32_t wanted = number(line);
  const MonoTime end = chip_.now() + limit;
  std::vector<sim::Change> changes;
  while (chip_.now() < end) {
    changes.clear();
    chip_.wait_changes(cursor_, end, changes);
    for (const sim::Change& change : changes)
      if (change.line == wanted && change.level == level && --n == 0) return to_ns(change.time);
  }
  return 0;
}

bool LineWatcher::wait_until(const std::function<bool()>& condition, std::chrono::milliseconds limit) const {
  // A program that never sleeps, as a fault may leave it, keeps the rig's time from going on.
  constexpr std::int64_t kStandsStill = 30'000 * kMs;
  const MonoTime end = chip_.now() + limit;
  MonoTime before = chip_.now();
  for (std::int64_t went_on = testing::monotonic_now_ns();;) {
    const MonoTime now = chip_.now();
    if (now != before) went_on = testing::monotonic_now_ns();
    before = now;
    if (condition()) return true;
    if (now >= end || testing::monotonic_now_ns() - went_on > kStandsStill) return false;
    testing::sleep_for(std::chrono::milliseconds(5));
  }
}

void LineWatcher::unplug() { chip_.unplug(); }

void LineWatcher::drive(const std::string& line, int level) {
  chip_.drive(number(line), level, chip_.now());
}

void LineWatcher::open_wire(const std::string& line) {
  chip_.open_wire(number(line), chip_.now());
}

sim::LineState LineWatcher::state(const std::string& line) const { return chip_.state(number(line)); }

}  // namespace strobe::hil
