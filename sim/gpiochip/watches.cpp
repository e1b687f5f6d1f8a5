#include "sim/gpiochip/watches.hpp"

#include <errno.h>
#include <fcntl.h>
#include <sys/ioctl.h>

#include "sim/gpiochip/line_info.hpp"
#include "sim/gpiochip/ownership.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr int kDepth = 32;  // of the kernel's queue; a newer record is dropped

template <typename Record>
void put(int fifo, const Record& record) {
  int queued = 0;
  if (sys::ioctl(fifo, FIONREAD, &queued) != 0) return;
  if (queued < kDepth * static_cast<int>(sizeof(record))) sys::write(fifo, &record, sizeof(record));
}

void tell(int fifo, std::uint32_t version, const gpio_v2_line_info_changed& changed) {
  if (version == 2) return put(fifo, changed);
  gpioline_info_changed v1{};
  v1.info = to_v1(changed.info);
  v1.timestamp = changed.timestamp_ns;
  v1.event_type = changed.event_type;
  put(fifo, v1);
}

void tell_one(State& state, const char* folder, std::uint32_t watcher,
              const gpio_v2_line_info_changed& changed) {
  char path[kPathSize];
  if (!numbered_path(folder, kWatchPrefix, watcher, path)) return;
  const int fifo = sys::open(path, O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  if (fifo < 0) return;
  if (sys::is_locked(fifo, 0)) {
    tell(fifo, state.watchers[watcher].version.load(), changed);
  } else {
    state.watchers[watcher].lines.store(0);
  }
  sys::close(fifo);
}

}  // namespace

void tell_watchers(State& state, const char* folder, std::uint32_t line, std::uint32_t change) {
  if ((watched_lines(state) >> line & 1) == 0) return;
  gpio_v2_line_info_changed changed{};
  changed.info = info_of(state, line);
  changed.timestamp_ns = static_cast<std::uint64_t>(now_ns(state));
  changed.event_type = change;
  for (std::uint32_t watcher = 0; watcher < kMaxWatchers; ++watcher) {
    if ((state.watchers[watcher].lines.load() >> line & 1) != 0) tell_one(state, folder, watcher, changed);
  }
}

std::uint64_t watched_lines(const State& state) {
  std::uint64_t lines = 0;
  for (const Watcher& watcher : state.watchers) lines |= watcher.lines.load();
  return lines;
}

}  // namespace strobe::sim::gpio
