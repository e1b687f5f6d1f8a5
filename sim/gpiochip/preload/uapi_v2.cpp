#include "sim/gpiochip/preload/uapi_v2.hpp"

#include <errno.h>
#include <linux/gpio.h>
#include <string.h>

#include "sim/gpiochip/debounce.hpp"
#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/line_info.hpp"
#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/preload/lines.hpp"
#include "sim/gpiochip/preload/pins.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

std::uint64_t bit(std::uint32_t index) { return std::uint64_t{1} << index; }

int check_settable(const Handle& request, std::uint64_t mask) {
  State& state = *device().state;
  bool any = false;
  for (std::uint32_t i = 0; i < request.count.load(); ++i) {
    if ((mask & bit(i)) == 0) continue;
    any = true;
    if ((state.lines[request.lines[i].load()].config.load() & ConfigWord::kIsOut) == 0) return -EPERM;
  }
  return any ? 0 : -EINVAL;
}

/// The first watch of an open decides the version of its records.
int take_version(Watcher& watcher, std::uint32_t version) {
  std::uint32_t before = 0;
  const bool first = watcher.version.compare_exchange_strong(before, version);
  return first || before == version ? 0 : -EPERM;
}

int start_watch(std::uint32_t index, std::uint32_t line, std::uint32_t version) {
  State& state = *device().state;
  if (index >= kMaxWatchers) return -ENOMEM;
  Watcher& watcher = state.watchers[index];
  const int result = take_version(watcher, version);
  if (result != 0) return result;
  state.record_sizes.fetch_or(version == 2 ? RecordSizes::kInfoChanged : RecordSizes::kInfoChangedV1);
  return (watcher.lines.fetch_or(bit(line)) & bit(line)) != 0 ? -EBUSY : 0;
}

/// An answer that cannot be written back leaves no line watched.
template <typename Info>
int answer_watch(std::uint32_t watcher, std::uint32_t line, const Info& info, void* user) {
  const int result = sys::copy_out(user, &info, sizeof(info));
  if (result != 0) device().state->watchers[watcher].lines.fetch_and(~bit(line));
  return result;
}

/// Reads the question of line_info_v2() and watch_line().
int asked_line(const void* user, std::uint32_t& line) {
  gpio_v2_line_info info{};
  const int copied = sys::copy_in(&info, user, sizeof(info));
  if (copied != 0) return copied;
  for (const std::uint32_t word : info.padding)
    if (word != 0) return -EINVAL;
  line = info.offset;
  return line < device().state->line_count ? 0 : -EINVAL;
}

}  // namespace

int line_info_v2(void* user) {
  std::uint32_t line = 0;
  const int result = asked_line(user, line);
  if (result != 0) return result;
  reap_before_look(line);
  const gpio_v2_line_info info = info_of(*device().state, line);
  return sys::copy_out(user, &info, sizeof(info));
}

int get_line_values(std::uint32_t slot, void* user) {
  const State& state = *device().state;
  const Handle& request = state.handles[slot];
  if (!plausible(user)) return -EFAULT;
  gpio_v2_line_values values;
  memcpy(&values, user, sizeof(values));
  const std::uint32_t count = request.count.load();
  const std::uint64_t all = count == kMaxLines ? ~std::uint64_t{0} : bit(count) - 1;
  if ((values.mask & all) == 0) return -EINVAL;
  values.bits = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((values.mask & bit(i)) == 0) continue;
    const std::uint32_t line = request.lines[i].load();
    const unsigned level =
        is_debounced(state, line) ? debounced_level(state, line, now_ns(*device().state)) : level_of(state, line);
    if (physical(state.lines[line].config.load(), level) != 0) values.bits |= bit(i);
  }
  memcpy(user, &values, sizeof(values));
  return 0;
}

int set_line_values(std::uint32_t slot, const void* user) {
  State& state = *device().state;
  const Handle& request = state.handles[slot];
  if (!plausible(user)) return -EFAULT;
  gpio_v2_line_values values;
  memcpy(&values, user, sizeof(values));
  const int refused = check_settable(request, values.mask);
  if (refused != 0) return refused;
  const std::int64_t now = now_ns(*device().state);  // one instant: the lines of a call change together
  bool changed = false;
  for (std::uint32_t i = 0; i < request.count.load(); ++i) {
    if ((values.mask & bit(i)) == 0) continue;
    const std::uint32_t line = request.lines[i].load();
    const unsigned value = (values.bits & bit(i)) != 0 ? 1 : 0;
    const PinEdit edit = output_edit(state.lines[line].config.load(), value);
    changed |= change_line(state, line, edit, CauseCode::set, now);
  }
  if (changed) notify(state);
  return 0;
}

int watch_line(std::uint32_t watcher, void* user) {
  std::uint32_t line = 0;
  int result = asked_line(user, line);
  if (result != 0) return result;
  reap_before_look(line);
  result = start_watch(watcher, line, 2);
  return result != 0 ? result : answer_watch(watcher, line, info_of(*device().state, line), user);
}

int watch_line_v1(std::uint32_t watcher, void* user) {
  gpioline_info asked{};
  int result = sys::copy_in(&asked, user, sizeof(asked));
  if (result != 0) return result;
  const std::uint32_t line = asked.line_offset;
  if (line >= device().state->line_count) return -EINVAL;
  reap_before_look(line);
  result = start_watch(watcher, line, 1);
  return result != 0 ? result : answer_watch(watcher, line, to_v1(info_of(*device().state, line)), user);
}

int unwatch_line(std::uint32_t watcher, const void* user) {
  std::uint32_t line = 0;
  const int result = sys::copy_in(&line, user, sizeof(line));
  if (result != 0) return result;
  if (line >= device().state->line_count) return -EINVAL;
  if (watcher >= kMaxWatchers) return -EBUSY;
  return (device().state->watchers[watcher].lines.fetch_and(~bit(line)) & bit(line)) != 0 ? 0 : -EBUSY;
}

}  // namespace strobe::sim::gpio
