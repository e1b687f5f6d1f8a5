#include "firmware/rp1_pio/local_sequencer.hpp"

#include <poll.h>

#include <algorithm>

#include "firmware/linux/real_time.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

using flash_sequencer::kTick_ns;
using flash_sequencer::Phase;

/// The controller wants to be turned at least every millisecond while something is armed; else the watchers
/// and whoever asks want to know that it lives.
constexpr Duration kActiveTurn = microseconds(800);
constexpr Duration kIdleTurn = milliseconds(4);

/// Of stamps; what is within one cannot be told apart.
MonoTime whole_ticks(MonoTime time) { return from_ns(to_ns(time) / kTick_ns * kTick_ns); }

}  // namespace

MessageQueue::MessageQueue() {
  for (std::size_t i = 0; i < kPlaces; ++i) places_[i].turn.store(i, std::memory_order_relaxed);
}

bool MessageQueue::push(std::span<const std::uint8_t> bytes, MonoTime written) noexcept {
  if (bytes.size() > kMaxBytes) return false;
  std::size_t at = end_.load(std::memory_order_relaxed);
  for (;;) {
    const std::size_t turn = places_[at % kPlaces].turn.load(std::memory_order_acquire);
    if (turn == at && end_.compare_exchange_weak(at, at + 1, std::memory_order_relaxed)) break;
    if (turn < at) return false;  // its message of the round before was not taken
    if (turn > at) at = end_.load(std::memory_order_relaxed);
  }
  Place& place = places_[at % kPlaces];
  std::copy(bytes.begin(), bytes.end(), place.message.bytes.begin());
  place.message.size = bytes.size();
  place.message.written = written;
  place.turn.store(at + 1, std::memory_order_release);
  return true;
}

const MessageQueue::Message* MessageQueue::front() const noexcept {
  const Place& place = places_[first_ % kPlaces];
  return place.turn.load(std::memory_order_acquire) == first_ + 1 ? &place.message : nullptr;
}

void MessageQueue::pop() noexcept {
  places_[first_ % kPlaces].turn.store(first_ + kPlaces, std::memory_order_release);
  ++first_;
}

bool LocalLine::write(std::span<const std::uint8_t> bytes) noexcept {
  const MonoTime now = whole_ticks(clock_.now());
  written_ns_[next_stamp_.fetch_add(1) % kStamps].store(to_ns(now));
  return requests_.push(bytes, now) && requests_wait_.wake();
}

std::optional<SerialLine::Departure> LocalLine::departure(std::int64_t, MonoTime before,
                                                          MonoTime after) noexcept {
  MonoTime first = MonoTime::max(), last = MonoTime::min();
  for (const auto& written_ns : written_ns_) {
    const MonoTime written = from_ns(written_ns.load());
    if (written < whole_ticks(before) || written > after) continue;
    first = std::min(first, written);
    last = std::max(last, written);
  }
  return first <= last ? std::optional(Departure{first, last}) : std::nullopt;
}

std::optional<std::size_t> LocalLine::read(std::span<std::uint8_t> bytes) noexcept {
  replies_wait_.take();
  std::size_t count = 0;
  while (const MessageQueue::Message* reply = replies_.front()) {
    const std::size_t part = std::min(bytes.size() - count, reply->size - taken_);
    std::copy_n(reply->bytes.begin() + static_cast<std::ptrdiff_t>(taken_), part,
                bytes.begin() + static_cast<std::ptrdiff_t>(count));
    count += part;
    taken_ += part;
    if (taken_ < reply->size) break;
    replies_.pop();
    taken_ = 0;
  }
  return count;
}

bool LocalLine::wait(MonoTime until) noexcept {
  const timespec timeout = time_left(until);
  pollfd polled[] = {{replies_wait_.fd(), POLLIN, 0}, {wake_fd_, POLLIN, 0}};
  if (ppoll(polled, 2, &timeout, nullptr) <= 0) return false;
  std::uint64_t wakes = 0;
  if (polled[1].revents != 0 && ::read(wake_fd_, &wakes, sizeof wakes) < 0) wakes = 0;
  return true;
}

bool LocalLine::poll(MonoTime until) noexcept {
  bool ready = false;
  do ready = wait(MonoTime{});
  while (!ready && clock_.now() < until);
  return ready;
}

void LocalLine::reply(const flash_sequencer::Frame& frame) noexcept {
  std::array<std::uint8_t, flash_sequencer::kMaxFrame> wire;
  const std::size_t size = flash_sequencer::encode(frame, wire);
  // A loop that takes nothing has lost them, as it would with any line.
  if (replies_.push(std::span(wire).first(size), MonoTime{})) replies_wait_.wake();
}

LocalSequencer::LocalSequencer(Rp1Hardware& hardware, LocalLine& line, Clock& clock, std::uint64_t boot)
    : hardware_(hardware), line_(line), clock_(clock), controller_(hardware, boot, false) {}

void LocalSequencer::turn() noexcept {
  const bool active = controller_.phase() == Phase::armed || controller_.phase() == Phase::playing;
  hardware_.poll(clock_.now() + (active ? kActiveTurn : kIdleTurn));
  answer_requests();
  controller_.turn();
  flash_sequencer::Frame report;
  while (controller_.next_input(report)) line_.reply(report);
}

void LocalSequencer::answer_requests() noexcept {
  while (const MessageQueue::Message* message = line_.requests().front()) {
    // Of two writers the one that was first may have its stamp later.
    newest_request_ = std::max(newest_request_, message->written);
    for (std::size_t i = 0; i < message->size; ++i) {
      const flash_sequencer::Frame* request = decoder_.take(message->bytes[i]);
      flash_sequencer::Frame reply;
      if (request != nullptr && controller_.answer(*request, to_ns(newest_request_) / kTick_ns, reply))
        line_.reply(reply);
    }
    line_.requests().pop();
  }
}

void LocalSequencer::start(int priority) {
  thread_ = std::thread([this, priority] {
    become_real_time(priority);  // what is wrong with the rights is told of the loop's
    prefault_stack();
    while (!stop_) turn();
    hardware_.cut();
  });
}

void LocalSequencer::stop() noexcept {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace strobe::firmware
