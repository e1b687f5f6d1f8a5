// A message bus on the virtual clock that delays, loses, duplicates and reorders packets, independently for
// each receiver, as UDP multicast does. One thread's; allocates.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/soak/random.hpp"
#include "tests/soak/timeline.hpp"

namespace strobe::soak {

enum class Receiver { firmware, host, tablet, other_host, watcher };
inline constexpr std::size_t kReceivers = 5;

struct BusFaults {
  double loss = 0.0, duplication = 0.0, reordering = 0.0;
};

struct BusCounts {
  std::int64_t sent = 0;  ///< packets, times their receivers
  std::int64_t lost = 0, doubled = 0, reordered = 0;
};

class VirtualBus {
 public:
  struct Packet {
    std::string channel;
    std::vector<std::uint8_t> bytes;
    int in_flight = 0;
  };

  explicit VirtualBus(std::uint64_t seed) : random_(seed) {}

  void set_faults(const BusFaults& faults) { faults_ = faults; }
  void send(Receiver to, const std::string& channel, std::span<const std::uint8_t> bytes, MonoTime now);
  MonoTime next_due() const { return flights_.next(); }

  struct Delivery {
    MonoTime at;
    Receiver to = Receiver::host;
    Packet* packet = nullptr;  ///< until done() is called with this delivery
  };
  /// The first delivery; next_due() must not be in the far future.
  Delivery take();
  void done(const Delivery& delivery);

  const BusCounts& counts() const { return counts_; }

 private:
  struct Flight {
    Receiver to;
    std::uint32_t packet;
  };
  void fly(Receiver to, std::uint32_t packet, MonoTime now);
  std::uint32_t free_packet();

  Random random_;
  BusFaults faults_;
  BusCounts counts_;
  Timeline<Flight> flights_;
  std::vector<std::unique_ptr<Packet>> packets_;
  std::vector<std::uint32_t> free_;
  std::uint32_t taken_ = 0;
  std::array<MonoTime, kReceivers> newest_{};  ///< arrival of the latest packet in order
};

}  // namespace strobe::soak
