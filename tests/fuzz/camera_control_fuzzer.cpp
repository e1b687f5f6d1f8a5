// Whoever is on the network may send the simulated camera anything: a row of datagrams, each after its length in a
// byte. It answers as the standard says or not at all, whatever came before.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sim/gev/device.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace strobe;
  using namespace strobe::sim::gev;
  using fuzz::require;
  constexpr Endpoint kSender{0x7f000001, 1000};
  DeviceSettings settings;
  settings.width = 640;
  settings.height = 480;
  settings.description = "<xml/>";
  MonoTime now{};
  Device device(settings, now);
  std::span<const std::uint8_t> left(data, size);
  while (!left.empty()) {
    const std::size_t length = std::min<std::size_t>(left[0], left.size() - 1);
    const auto answer = device.answer(left.subspan(1, length), kSender, now);
    left = left.subspan(1 + length);
    if (answer) {
      require(answer->size() >= 8 && answer->size() <= 8 + 540);
      require(number_at(*answer, 4, 2) == answer->size() - 8);
    }
    now += milliseconds(1);
    device.check_heartbeat(now);
    const std::uint32_t packet_size = device.word(bootstrap::kPacketSize);
    require(packet_size >= 576 && packet_size <= 9000);
    const double exposure_us = device.number(camera::kExposureTime);
    require(exposure_us >= 1.0 && exposure_us <= kMaxExposure_us);
    const auto destination = device.stream_destination();
    require(!destination || destination->address >> 24 == 127);
    for (const PacketRange& range : device.take_resend_requests()) require(range.first <= range.last);
  }
  return 0;
}
