#include "sim/gpiochip/preload/lines.hpp"

#include <errno.h>

#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

std::uint32_t lowest_unused_slot(const State& state) {
  std::uint64_t used = 0;
  for (std::uint32_t line = 0; line < state.line_count; ++line) {
    const std::uint32_t config = state.lines[line].config.load();
    const bool in_slot = (config & ConfigWord::kEvents) == 0 && (config & ConfigWord::kRequested) != 0;
    if (in_slot) used |= std::uint64_t{1} << ConfigWord::slot(config);
  }
  std::uint32_t slot = 0;
  while (slot < state.line_count && (used >> slot & 1) != 0) ++slot;
  return slot;
}

}  // namespace

void configure_line(State& state, std::uint32_t line, const LineSetting& setting, std::uint32_t owner,
                    std::int64_t now_ns) {
  std::atomic<std::uint32_t>& word = state.lines[line].config;
  const bool version2 = (owner & ConfigWord::kVersion2) != 0;
  // uAPI v1 knows no clocks, and leaves what it finds.
  const std::uint32_t kept = ConfigWord::kIsOut | (version2 ? 0 : ConfigWord::kRealtime);
  std::uint32_t config = (word.load() & kept) | owner | setting.flags;
  if (setting.direction == Direction::output) config |= ConfigWord::kIsOut;
  if (setting.direction == Direction::input) config &= ~ConfigWord::kIsOut;
  word.store(config);
  if (state.bias == Bias::set) change_line(state, line, pull_edit(setting.flags), Cause::request, now_ns);
  if (setting.direction == Direction::output) {
    change_line(state, line, output_edit(config, setting.value), Cause::request, now_ns);
  } else if (setting.direction == Direction::input) {
    change_line(state, line, float_edit(), Cause::request, now_ns);
  }
}

int check_bias(const State& state, std::uint32_t flags) {
  constexpr std::uint32_t kAny = ConfigWord::kPullUp | ConfigWord::kPullDown | ConfigWord::kBiasDisable;
  return state.bias == Bias::refused && (flags & kAny) != 0 ? -EINVAL : 0;
}

int check_free(State& state, const ChipLock& lock, std::uint32_t line) {
  reap_line_locked(state, device().folder, lock, line);
  const std::uint32_t config = state.lines[line].config.load();
  return (config & (ConfigWord::kRequested | ConfigWord::kKernelUsed)) != 0 ? -EBUSY : 0;
}

void name_owner(State& state, std::uint32_t line, const char* consumer) {
  // The kernel shows "?" for an owner without a name.
  set_consumer(state.lines[line], consumer[0] != '\0' ? consumer : "?");
}

int free_slot(State& state, const ChipLock& lock, std::uint32_t& slot) {
  slot = lowest_unused_slot(state);
  if (slot < state.line_count) return 0;
  for (std::uint32_t line = 0; line < state.line_count; ++line) {
    reap_line_locked(state, device().folder, lock, line);
  }
  slot = lowest_unused_slot(state);
  return slot < state.line_count ? 0 : -EBUSY;
}

void reap_before_look(std::uint32_t line) {
  State& state = *device().state;
  if ((state.lines[line].config.load() & ConfigWord::kRequested) == 0) return;
  const sys::NoSignals quiet;
  const ChipLock lock(device().folder);
  if (lock.error() == 0) reap_line_locked(state, device().folder, lock, line);
}

void drain(int fd) {
  char rest[4096];
  while (sys::read(fd, rest, sizeof(rest)) > 0) {
  }
}

int finish_request(State& state, int result, int fd, int& given) {
  notify(state);
  if (result != 0) {
    sys::close(fd);
  } else {
    given = fd;
  }
  return result;
}

}  // namespace strobe::sim::gpio
