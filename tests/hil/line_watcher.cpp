#include "tests/hil/line_watcher.hpp"

#include <stdexcept>
#include <vector>

namespace strobe::hil {
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
  const MonoTime end = from_ns(testing::monotonic_now_ns() + std::chrono::nanoseconds(limit).count());
  std::vector<sim::Change> changes;
  while (testing::monotonic_now_ns() < to_ns(end)) {
    changes.clear();
    chip_.wait_changes(cursor_, end, changes);
    for (const sim::Change& change : changes)
      if (change.line == wanted && change.level == level && --n == 0) return to_ns(change.time);
  }
  return 0;
}

void LineWatcher::unplug() { chip_.unplug(); }

void LineWatcher::drive(const std::string& line, int level) {
  chip_.drive(number(line), level, from_ns(testing::monotonic_now_ns()));
}

void LineWatcher::open_wire(const std::string& line) {
  chip_.open_wire(number(line), from_ns(testing::monotonic_now_ns()));
}

sim::LineState LineWatcher::state(const std::string& line) const { return chip_.state(number(line)); }

}  // namespace strobe::hil
