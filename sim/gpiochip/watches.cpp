#include "sim/gpiochip/watches.hpp"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/ioctl.h>

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

struct FlagPair {
  std::uint64_t from;
  std::uint64_t to;
};

constexpr FlagPair kFromConfig[] = {
    {ConfigWord::kRequested, GPIO_V2_LINE_FLAG_USED},
    {ConfigWord::kKernelUsed, GPIO_V2_LINE_FLAG_USED},
    {ConfigWord::kActiveLow, GPIO_V2_LINE_FLAG_ACTIVE_LOW},
    {ConfigWord::kOpenDrain, GPIO_V2_LINE_FLAG_OPEN_DRAIN},
    {ConfigWord::kOpenSource, GPIO_V2_LINE_FLAG_OPEN_SOURCE},
    {ConfigWord::kPullUp, GPIO_V2_LINE_FLAG_BIAS_PULL_UP},
    {ConfigWord::kPullDown, GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN},
    {ConfigWord::kBiasDisable, GPIO_V2_LINE_FLAG_BIAS_DISABLED},
    {ConfigWord::kRealtime, GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME},
};
/// Shown for v2 requests only, as by the kernel.
constexpr FlagPair kEdges[] = {
    {ConfigWord::kRising, GPIO_V2_LINE_FLAG_EDGE_RISING},
    {ConfigWord::kFalling, GPIO_V2_LINE_FLAG_EDGE_FALLING},
};
constexpr FlagPair kToV1[] = {
    {GPIO_V2_LINE_FLAG_USED, GPIOLINE_FLAG_KERNEL},
    {GPIO_V2_LINE_FLAG_OUTPUT, GPIOLINE_FLAG_IS_OUT},
    {GPIO_V2_LINE_FLAG_ACTIVE_LOW, GPIOLINE_FLAG_ACTIVE_LOW},
    {GPIO_V2_LINE_FLAG_OPEN_DRAIN, GPIOLINE_FLAG_OPEN_DRAIN},
    {GPIO_V2_LINE_FLAG_OPEN_SOURCE, GPIOLINE_FLAG_OPEN_SOURCE},
    {GPIO_V2_LINE_FLAG_BIAS_PULL_UP, GPIOLINE_FLAG_BIAS_PULL_UP},
    {GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN, GPIOLINE_FLAG_BIAS_PULL_DOWN},
    {GPIO_V2_LINE_FLAG_BIAS_DISABLED, GPIOLINE_FLAG_BIAS_DISABLE},
};

template <std::size_t kCount>
std::uint64_t translated(std::uint64_t flags, const FlagPair (&table)[kCount]) {
  std::uint64_t result = 0;
  for (const FlagPair& pair : table)
    if ((flags & pair.from) != 0) result |= pair.to;
  return result;
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

gpio_v2_line_info info_of(const State& state, std::uint32_t line) {
  const Line& entry = state.lines[line];
  const std::uint32_t config = entry.config.load();
  gpio_v2_line_info info{};
  info.offset = line;
  memcpy(info.name, entry.name, sizeof(info.name));
  get_consumer(entry, info.consumer);
  info.flags = translated(config, kFromConfig) |
               ((config & ConfigWord::kIsOut) != 0 ? GPIO_V2_LINE_FLAG_OUTPUT : GPIO_V2_LINE_FLAG_INPUT);
  if ((config & ConfigWord::kVersion2) != 0) info.flags |= translated(config, kEdges);
  const std::uint32_t debounce_us = entry.debounce_us.load();
  if (debounce_us == 0) return info;
  info.num_attrs = 1;
  info.attrs[0].id = GPIO_V2_LINE_ATTR_ID_DEBOUNCE;
  info.attrs[0].debounce_period_us = debounce_us;
  return info;
}

gpioline_info to_v1(const gpio_v2_line_info& info) {
  gpioline_info v1{};
  v1.line_offset = info.offset;
  memcpy(v1.name, info.name, sizeof(v1.name));
  memcpy(v1.consumer, info.consumer, sizeof(v1.consumer));
  v1.flags = static_cast<std::uint32_t>(translated(info.flags, kToV1));
  return v1;
}

}  // namespace strobe::sim::gpio
