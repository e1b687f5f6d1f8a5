// Parts of the lab that its sources share: small ports, and the trace.
#pragma once

#include <fmt/format.h>

#include "tests/soak/lab.hpp"

namespace strobe::soak {

/// Reading this clock takes no time: its thread is not the one that the lab runs.
class Lab::PublisherClock final : public firmware::Clock {
 public:
  explicit PublisherClock(const Lab& lab) : lab_(lab) {}
  MonoTime now() noexcept override { return lab_.time_; }
  MonoTime spin_until(MonoTime instant) noexcept override { return std::max(lab_.time_, instant); }

 private:
  const Lab& lab_;
};

class Lab::PublisherWake final : public firmware::Wake {
 public:
  explicit PublisherWake(Lab& lab) : lab_(lab) {}
  bool wake() noexcept override {
    lab_.schedule_changed_ = true;
    lab_.publisher_due_ = std::min(lab_.publisher_due_, lab_.time_ + lab_.publisher_latency_);
    return true;
  }

 private:
  Lab& lab_;
};

class Lab::LoopWake final : public firmware::Wake {
 public:
  explicit LoopWake(Lab& lab) : lab_(lab) {}
  bool wake() noexcept override {
    lab_.woken_ = true;
    return true;
  }

 private:
  Lab& lab_;
};

template <typename... Args>
void Lab::trace(const char* format, const Args&... args) {
  if (settings_.trace == nullptr) return;
  fmt::print(settings_.trace, "{} {}\n", trace_time(), fmt::format(fmt::runtime(format), args...));
}

}  // namespace strobe::soak
