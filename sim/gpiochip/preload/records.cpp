#include "sim/gpiochip/preload/records.hpp"

#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>

#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr std::size_t kEvent = sizeof(gpioevent_data);
constexpr std::size_t kEventV2 = sizeof(gpio_v2_line_event);
constexpr std::size_t kChanged = sizeof(gpioline_info_changed);
constexpr std::size_t kChangedV2 = sizeof(gpio_v2_line_info_changed);
static_assert(kEvent == 16 && kEventV2 == 48 && kChanged == 104 && kChangedV2 == 288);

long whole_events(std::size_t size, std::size_t record) {
  return size < record ? -EINVAL : static_cast<long>(size - size % record);
}

/// The kernel looks at the size only once there is something to read.
long too_small_for_change(int fd) {
  const bool waits = (sys::control(fd, F_GETFL, 0) & O_NONBLOCK) == 0;
  const int ready = sys::readable(fd, waits);
  if (ready < 0) return ready;
  if (!present()) return -ENODEV;
  return ready == 0 ? -EAGAIN : -EINVAL;
}

long whole_changes(int fd, std::uint32_t watcher, std::size_t size) {
  const bool version2 = watcher < kMaxWatchers && device().state->watchers[watcher].version.load() == 2;
  if (size < (version2 ? kChangedV2 : kChanged)) return too_small_for_change(fd);
  if (version2) return static_cast<long>(size - size % kChangedV2);
  // After the first, the kernel wants room for a record of v2 for each of v1.
  const std::size_t more = size < kChanged + kChangedV2 ? 0 : (size - kChangedV2) / kChanged;
  return static_cast<long>((1 + more) * kChanged);
}

}  // namespace

bool is_whole_for_all(std::size_t size) {
  const State* state = device().state;
  if (state == nullptr) return true;
  if (size == 0 || size % kEvent != 0 || state->unplugged.load(std::memory_order_relaxed) != 0) return false;
  const std::uint32_t sizes = state->record_sizes.load(std::memory_order_relaxed);
  if ((sizes & RecordSizes::kEvent) != 0 && size % kEventV2 != 0) return false;
  if ((sizes & RecordSizes::kInfoChanged) != 0 && size % kChangedV2 != 0) return false;
  return (sizes & RecordSizes::kInfoChangedV1) == 0;
}

long whole_records(int fd, std::size_t size) {
  const Descriptor descriptor = describe(fd);
  // Of an unplugged device not even what was queued before.
  if (descriptor.kind != Kind::none && !present()) return -ENODEV;
  switch (descriptor.kind) {
    case Kind::event:
      return whole_events(size, kEvent);
    case Kind::request:
      return whole_events(size, kEventV2);
    case Kind::chip:
      return whole_changes(fd, descriptor.index, size);
    default:
      return static_cast<long>(size);
  }
}

}  // namespace strobe::sim::gpio
