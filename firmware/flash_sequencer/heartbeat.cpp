#include "firmware/flash_sequencer/heartbeat.hpp"

#include <algorithm>
#include <ctime>

#include "common/flash_sequencer/protocol.hpp"
#include "firmware/linux/real_time.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

/// Of so many beats one is watched until it has left.
constexpr int kWatched = 4;

}  // namespace

void Heartbeat::beat() noexcept {
  flash_sequencer::Frame frame = flash_sequencer::to_frame(flash_sequencer::Request::beat);
  frame.number = next_;
  next_ = next_ == 255 ? kFirstNumber : static_cast<std::uint8_t>(next_ + 1);
  Sent& sent = sent_[frame.number - kFirstNumber];
  const std::int64_t size = sent_size(frame);
  const MonoTime before = clock_.now();
  sent.not_after_ns.store(0, std::memory_order_relaxed);
  sent.not_before_ns.store(to_ns(before + size * kByteTime), std::memory_order_release);
  if (!send(line_, frame) || frame.number % kWatched != 0) return;  // one that is lost is followed by others
  const auto left = line_.departure(size, before, clock_.now());
  // The answer comes later than this.
  if (left) sent.not_before_ns.store(to_ns(left->not_before), std::memory_order_relaxed);
  if (left) sent.not_after_ns.store(to_ns(left->not_after), std::memory_order_release);
}

std::optional<SerialLine::Departure> Heartbeat::departure(std::uint8_t number) const noexcept {
  if (number < kFirstNumber) return std::nullopt;
  const Sent& sent = sent_[number - kFirstNumber];
  const std::int64_t not_after_ns = sent.not_after_ns.load(std::memory_order_acquire);
  const std::int64_t not_before_ns = sent.not_before_ns.load(std::memory_order_acquire);
  if (not_before_ns == 0) return std::nullopt;
  return SerialLine::Departure{from_ns(not_before_ns),
                               not_after_ns == 0 ? MonoTime::max() : from_ns(not_after_ns)};
}

void Heartbeat::start(const std::atomic<std::int64_t>& loop_turned_ns, int priority) {
  thread_ = std::thread([this, &loop_turned_ns, priority] { run(loop_turned_ns, priority); });
}

void Heartbeat::stop() noexcept {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void Heartbeat::run(const std::atomic<std::int64_t>& loop_turned_ns, int priority) noexcept {
  become_real_time(priority);  // what is wrong with the rights is told of the loop's
  prefault_stack();
  for (MonoTime next = clock_.now(); !stop_; next = std::max(next + kEvery, clock_.now())) {
    const timespec until = to_timespec(next.time_since_epoch());
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    const std::int64_t turned_ns = loop_turned_ns.load(std::memory_order_relaxed);
    const bool hangs = turned_ns != 0 && clock_.now() - from_ns(turned_ns) > kLoopHangs;
    if (!hangs) beat();
  }
}

}  // namespace strobe::firmware
