#include "firmware/flash_sequencer/heartbeat.hpp"

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
  frame.number = static_cast<std::uint8_t>(kFirstNumber + beats_++ % (256 - kFirstNumber));
  Sent& sent = sent_[frame.number - kFirstNumber];
  const std::int64_t size = sent_size(frame);
  const MonoTime before = clock_.now();
  beaten_ns_ = to_ns(before);
  sent.not_after_ns.store(0, std::memory_order_relaxed);
  const bool counts = !line_tells_ || frame.number % kWatched == 0;
  sent.not_before_ns.store(counts ? to_ns(before + size * line_.pace().byte) : 0, std::memory_order_release);
  if (!send(line_, frame) || frame.number % kWatched != 0) return;  // one that is lost is followed by others
  const auto left = line_.departure(size, before, clock_.now());
  if (!left) return;
  // The answer comes later than this.
  line_tells_ = true;
  sent.not_before_ns.store(to_ns(left->not_before), std::memory_order_relaxed);
  sent.not_after_ns.store(to_ns(left->not_after), std::memory_order_release);
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

void Heartbeat::start(const std::atomic<std::int64_t>& loop_turned_ns, int priority, int loop_cpu) {
  const auto begin = [&](int cpu, Duration after) {
    return std::thread([this, &loop_turned_ns, priority, cpu, after] {
      // What is wrong with the rights is told of the loop's.
      pin_to_cpu(cpu);
      become_real_time(priority);
      prefault_stack();
      run(loop_turned_ns, after);
    });
  };
  threads_[0] = begin(-1, kEvery);
  if (loop_cpu >= 0) threads_[1] = begin(loop_cpu, kLate);
}

void Heartbeat::stop() noexcept {
  stop_ = true;
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
}

/// Beats so long after the newest beat, whosever that was.
void Heartbeat::run(const std::atomic<std::int64_t>& loop_turned_ns, Duration after) noexcept {
  while (!stop_) {
    const MonoTime now = clock_.now();
    const std::int64_t turned_ns = loop_turned_ns.load(std::memory_order_relaxed);
    const bool hangs = turned_ns != 0 && now - from_ns(turned_ns) > kLoopHangs;
    MonoTime next = from_ns(beaten_ns_.load()) + after;
    if (next <= now) {
      if (!hangs) beat();
      next = now + after;
    }
    const timespec until = to_timespec(next.time_since_epoch());
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  }
}

}  // namespace strobe::firmware
