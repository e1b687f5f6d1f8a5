#include "sim/gpiochip/edges.hpp"

#include <linux/gpio.h>
#include <sys/ioctl.h>

#include "sim/gpiochip/debounce.hpp"
#include "sim/gpiochip/ownership.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr int kDepthV1 = 16;

bool is_active(std::uint32_t config, unsigned level) {
  return (level != 0) != ((config & ConfigWord::kActiveLow) != 0);
}

bool is_wanted(std::uint32_t config, unsigned level) {
  const std::uint32_t edge = is_active(config, level) ? ConfigWord::kRising : ConfigWord::kFalling;
  return (config & ConfigWord::kRequested) != 0 && (config & edge) != 0;
}

void emit_v1(int fifo, std::uint32_t config, unsigned level, std::int64_t stamp_ns) {
  int queued = 0;
  if (fifo < 0 || sys::ioctl(fifo, FIONREAD, &queued) != 0) return;
  gpioevent_data event{};
  if (queued >= kDepthV1 * static_cast<int>(sizeof(event))) return;
  event.timestamp = static_cast<std::uint64_t>(stamp_ns);
  event.id = is_active(config, level) ? GPIOEVENT_EVENT_RISING_EDGE : GPIOEVENT_EVENT_FALLING_EDGE;
  sys::write(fifo, &event, sizeof(event));
}

/// As the kernel's linereq_put_event(). A read takes whole events, also this one of the oldest: nobody reads
/// between its bytes.
void put_dropping_oldest(int fifo, std::uint32_t depth, const gpio_v2_line_event& event) {
  int queued = 0;
  gpio_v2_line_event oldest;
  if (sys::ioctl(fifo, FIONREAD, &queued) != 0) return;
  if (queued >= static_cast<int>(depth * sizeof(event))) sys::read(fifo, &oldest, sizeof(oldest));
  // A FIFO for which the system grants few pages may be full before its depth.
  while (sys::write(fifo, &event, sizeof(event)) < 0 && sys::read(fifo, &oldest, sizeof(oldest)) > 0) {
  }
}

gpio_v2_line_event event_of(State& state, std::uint32_t line, unsigned level, std::int64_t stamp_ns) {
  gpio_v2_line_event event{};
  const std::uint32_t config = state.lines[line].config.load();
  const bool realtime = (config & ConfigWord::kRealtime) != 0;
  event.timestamp_ns =
      static_cast<std::uint64_t>(realtime ? stamp_ns + realtime_ns(state) - now_ns(state) : stamp_ns);
  event.id = is_active(config, level) ? GPIO_V2_LINE_EVENT_RISING_EDGE : GPIO_V2_LINE_EVENT_FALLING_EDGE;
  event.offset = line;
  return event;
}

void emit_v2(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t stamp_ns) {
  State& state = *folder.state;
  const std::uint32_t slot = ConfigWord::slot(state.lines[line].config.load());
  const EmitLock lock(folder.lock_fd, slot);
  // Looked at again: meanwhile the request may have ended and another one have its slot.
  const std::uint32_t config = state.lines[line].config.load();
  const bool same = (config & ConfigWord::kVersion2) != 0 && ConfigWord::slot(config) == slot;
  if (!lock.held() || !same || !is_wanted(config, level) || folder.requests[slot] < 0) return;
  Handle& request = state.handles[slot];
  gpio_v2_line_event event = event_of(state, line, level, stamp_ns);
  // Numbered first: an edge whose process is killed here is missing, and told so by its number.
  event.line_seqno = state.lines[line].seqno.fetch_add(1) + 1;
  event.seqno = request.count.load() == 1 ? event.line_seqno : request.seqno.fetch_add(1) + 1;
  put_dropping_oldest(folder.requests[slot], request.event_depth.load(), event);
}

}  // namespace

void emit_edge(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t stamp_ns) {
  const std::uint32_t config = folder.state->lines[line].config.load();
  if (is_debounced(*folder.state, line)) {
    emit_settled(folder, line, 1 - level, stamp_ns);  // before this edge
    return note_bounce(*folder.state, line, stamp_ns);
  }
  if (!is_wanted(config, level)) return;
  if ((config & ConfigWord::kVersion2) != 0) {
    emit_v2(folder, line, level, stamp_ns);
  } else {
    emit_v1(folder.events[line], config, level, stamp_ns);
  }
}

void emit_settled(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t now_ns) {
  Settled settled;
  if (!take_settled(*folder.state, line, level, now_ns, settled) || !settled.changed) return;
  if (is_wanted(folder.state->lines[line].config.load(), level))
    emit_v2(folder, line, level, settled.stamp_ns);
}

}  // namespace strobe::sim::gpio
