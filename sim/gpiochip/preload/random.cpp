// What a program draws of the system, where a run is to repeat to the byte (TimeKeeper::Repeatable): the same
// numbers each time, others in each program.
#include <sys/random.h>

#include <atomic>
#include <cstring>

#include "sim/gpiochip/preload/device.hpp"
#include "sim/gpiochip/preload/next.hpp"

namespace gpio = strobe::sim::gpio;

namespace {

/// Null: what is drawn is not fixed.
gpio::RigTime* fixed() {
  gpio::State* state = gpio::device().state;
  return state != nullptr && state->time.seed != 0 ? &state->time : nullptr;
}

std::uint64_t draw(gpio::RigTime& time) {
  static const std::uint64_t stream = time.streams.fetch_add(1);
  static std::atomic<std::uint64_t> draws{0};
  std::uint64_t z = (time.seed << 40) + (stream << 20) + draws.fetch_add(1);
  z = (z + 1) * 0x9e3779b97f4a7c15ULL;  // splitmix64
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

void fill(gpio::RigTime& time, void* data, size_t size) {
  auto* bytes = static_cast<unsigned char*>(data);
  for (size_t at = 0; at < size; at += sizeof(std::uint64_t)) {
    const std::uint64_t drawn = draw(time);
    memcpy(bytes + at, &drawn, size - at < sizeof(drawn) ? size - at : sizeof(drawn));
  }
}

}  // namespace

STROBE_EXPORT ssize_t getrandom(void* data, size_t size, unsigned flags) {
  if (gpio::RigTime* time = fixed()) {
    fill(*time, data, size);
    return static_cast<ssize_t>(size);
  }
  static auto* const native = gpio::next<ssize_t(void*, size_t, unsigned)>("getrandom");
  return native(data, size, flags);
}

STROBE_EXPORT int getentropy(void* data, size_t size) {
  if (gpio::RigTime* time = fixed()) {
    fill(*time, data, size);
    return 0;
  }
  static auto* const native = gpio::next<int(void*, size_t)>("getentropy");
  return native(data, size);
}

// std::random_device asks the processor; the library's own function for it is what can be replaced.
STROBE_EXPORT unsigned random_device_value(void* device) __asm__("_ZNSt13random_device9_M_getvalEv");
STROBE_EXPORT unsigned random_device_value(void* device) {
  if (gpio::RigTime* time = fixed()) return static_cast<unsigned>(draw(*time));
  static auto* const native = gpio::next<unsigned(void*)>("_ZNSt13random_device9_M_getvalEv");
  return native(device);
}
