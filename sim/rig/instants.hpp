// A few instants without a heap: the flashes of one pulse. Plain values, thread-safe.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>

#include "common/units/time.hpp"

namespace strobe::sim {

class Instants {
 public:
  /// Two lamps, each of which may by a fault flash twice.
  static constexpr std::size_t kMax = 4;

  Instants() = default;
  explicit Instants(MonoTime only) { push_back(only); }

  void push_back(MonoTime time) {
    assert(size_ < kMax);
    times_[size_++] = time;
  }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  MonoTime& operator[](std::size_t i) { return times_[i]; }
  const MonoTime& operator[](std::size_t i) const { return times_[i]; }
  const MonoTime& back() const { return times_[size_ - 1]; }
  MonoTime* begin() { return times_.data(); }
  MonoTime* end() { return times_.data() + size_; }
  const MonoTime* begin() const { return times_.data(); }
  const MonoTime* end() const { return times_.data() + size_; }
  bool operator==(const Instants&) const = default;

 private:
  std::array<MonoTime, kMax> times_{};
  std::size_t size_ = 0;
};

}  // namespace strobe::sim
