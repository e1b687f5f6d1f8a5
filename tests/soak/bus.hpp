// Seeded draws of the virtual lab: one stream per run, so that a seed repeats it on any machine.
// SplitMix64. Plain value; one thread's.
#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <memory>
#include <queue>
#include <span>
#include <string>
#include <vector>

#include "common/units/time.hpp"
#include "sim/random/draws.hpp"

namespace strobe::soak {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    const std::uint64_t drawn = sim::hash64(state_);
    state_ += sim::kSplitMixStep;
    return drawn;
  }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in the logarithm; both positive.
  double log_uniform(double low, double high) { return low * std::pow(high / low, uniform()); }
  bool chance(double probability) { return uniform() < probability; }
  /// Uniform in low ... high, both included.
  int integer(int low, int high) {
    return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1));
  }
  Duration between(Duration low, Duration high) {
    return nanoseconds(low.count() + std::llround(uniform() * static_cast<double>((high - low).count())));
  }
  /// A positive random number, for ids and tokens.
  std::int64_t id() { return static_cast<std::int64_t>(bits() >> 1) | 1; }

 private:
  std::uint64_t state_;
};

/// Independent streams from one seed.
constexpr std::uint64_t mixed(std::uint64_t seed, std::uint64_t stream) {
  return sim::hash64(seed * sim::kSplitMixStep + stream * 0xd1b54a32d192ed03U + 0x632be59bd9b4e019U -
                     sim::kSplitMixStep);
}

// Queue of what is scheduled on the virtual clock, in order of time; items of one instant keep their order.
// One thread's; allocates.

inline constexpr MonoTime kFarFuture = MonoTime::max();

template <typename Item>
class Timeline {
 public:
  struct Entry {
    MonoTime at;
    std::uint64_t order = 0;
    Item item{};
  };

  void schedule(MonoTime at, Item item) { heap_.push({at, ++order_, std::move(item)}); }
  MonoTime next() const { return heap_.empty() ? kFarFuture : heap_.top().at; }
  bool empty() const { return heap_.empty(); }
  Entry take() {
    assert(!heap_.empty());
    Entry first = heap_.top();
    heap_.pop();
    return first;
  }

 private:
  struct Later {
    bool operator()(const Entry& a, const Entry& b) const {
      return a.at != b.at ? a.at > b.at : a.order > b.order;
    }
  };
  std::priority_queue<Entry, std::vector<Entry>, Later> heap_;
  std::uint64_t order_ = 0;
};

// A message bus on the virtual clock that delays, loses, duplicates and reorders packets, independently for
// each receiver, as UDP multicast does. One thread's; allocates.

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
