// The flash sequencer within strobed: its line, its thread, and what ends all outputs, on a simulated PIO block.
#include "firmware/rp1_pio/local_sequencer.hpp"

#include <poll.h>

#include <atomic>
#include <thread>

#include "firmware/core/pulse_schedule.hpp"
#include "firmware/linux/system_clock.hpp"
#include "tests/firmware/rp1_bench.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;
using namespace strobe::testing;

TEST_GROUP(LocalLine) {
  SystemClock clock;
  LocalLine line{clock};
};

TEST(LocalLine, GivesWhatTwoThreadsWriteWholeAndInOrderOfEach) {
  constexpr std::uint8_t kWrites = 200;
  std::atomic<int> writing{2};
  const auto write = [&](std::uint8_t who) {
    for (std::uint8_t i = 0; i < kWrites;) {
      const std::array<std::uint8_t, 9> bytes{who, i, who, i, who, i, who, i, who};
      if (line.write(bytes)) ++i;
      else std::this_thread::yield();
    }
    --writing;
  };
  std::thread one([&] { write(1); }), two([&] { write(2); });
  std::array<int, 3> next{};
  bool well = true;
  while (writing > 0 || line.requests().front() != nullptr) {
    const MessageQueue::Message* message = line.requests().front();
    if (message == nullptr) {
      std::this_thread::yield();
      continue;
    }
    const std::uint8_t who = message->bytes[0];
    well = well && message->size == 9 && (who == 1 || who == 2) && message->bytes[8] == who && message->bytes[7] == next[who];
    if (who < next.size()) ++next[who];
    line.requests().pop();
  }
  one.join();
  two.join();
  CHECK_TRUE(well);
  CHECK_EQUAL(+kWrites, next[1]);
  CHECK_EQUAL(+kWrites, next[2]);
}

TEST(LocalLine, HasRoomForAFewFramesAndRefusesMore) {
  const std::array<std::uint8_t, MessageQueue::kMaxBytes + 1> bytes{};
  CHECK_FALSE(line.write(bytes));
  int written = 0;
  while (line.write(std::span(bytes).first(5))) ++written;
  CHECK_EQUAL(64, written);
  line.requests().pop();
  CHECK_TRUE(line.write(std::span(bytes).first(5)));
}

TEST(LocalLine, KnowsWhenItWasWrittenToAsTheSequencerDoes) {
  for (int i = 0; i < 40; ++i) {
    const MonoTime before = clock.now();
    CHECK_TRUE(line.write(std::array<std::uint8_t, 3>{1, 2, 3}));
    const auto departure = line.departure(3, before, clock.now());
    CHECK_TRUE(departure.has_value());
    CHECK_EQUAL(line.requests().front()->written, departure->not_before);
    CHECK_EQUAL(line.requests().front()->written, departure->not_after);
    line.requests().pop();
  }
  CHECK_FALSE(line.departure(3, clock.now() + milliseconds(1), clock.now() + milliseconds(2)).has_value());
}

TEST(LocalLine, GivesRepliesInPartsAndWakesWhoeverWaits) {
  CHECK_FALSE(line.wait(MonoTime{}));
  flash_sequencer::Decoder decoder;
  for (std::uint8_t number = 1; number <= 3; ++number) {
    flash_sequencer::Frame frame = flash_sequencer::to_frame(flash_sequencer::Status{});
    frame.number = number;
    line.reply(frame);
  }
  CHECK_TRUE(line.wait(MonoTime::max()));
  std::array<std::uint8_t, 7> bytes;
  std::uint8_t heard = 0;
  while (const std::size_t count = line.read(bytes).value()) {
    for (std::size_t i = 0; i < count; ++i) {
      const flash_sequencer::Frame* frame = decoder.take(bytes[i]);
      if (frame == nullptr) continue;
      CHECK_TRUE(flash_sequencer::read_status(*frame).has_value());
      ++heard;
      CHECK_EQUAL(+heard, +frame->number);
    }
  }
  CHECK_EQUAL(3, +heard);
  CHECK_FALSE(line.wait(MonoTime{}));
  EventFd wake;
  line.set_wake(wake.fd());
  wake.wake();
  CHECK_TRUE(line.wait(MonoTime::max()));
  CHECK_FALSE(line.wait(MonoTime{}));
}

namespace {

/// A shot that is under way on the bench, with its shutter open.
struct UnderWay final : ScheduledOutputs::Listener {
  Rp1Bench bench;
  PulseSchedule schedule;
  MonoTime start;
  std::string failure;

  UnderWay() {
    CHECK_TRUE_TEXT(bench.connected.has_value(), bench.connected ? "" : bench.connected.error().message.c_str());
    schedule.reserve(bench.config.lamps.max_flashes);
    build_schedule(bench.config.plan, bench.config, schedule);
    turn_until(bench.rp1.time + milliseconds(4000));
    start = bench.rp1.time + bench.outputs.lead(schedule);
    bench.outputs.begin(schedule, start, *this);
    turn_until(start + schedule.exposure_begin + milliseconds(100));
    CHECK_TRUE(bench.outputs.active(Output::shutter));
    CHECK_EQUAL(std::string(), failure);
  }
  void turn_until(MonoTime end) {
    std::array<Edge, 64> edges;
    while (bench.rp1.time < end) {
      bench.inputs.wait(std::min(end, bench.rp1.time + milliseconds(50)), edges);
      bench.outputs.run(*this);
      bench.outputs.take_failure();
    }
  }
  /// After that instant, until all pins are low for good.
  Duration low_after(MonoTime instant) {
    bench.rp1.block.advance();
    unsigned high = 0;
    MonoTime last{};
    for (const auto& pin : bench.rp1.block.pins) {
      high = pin.level ? high | 1U << pin.pin : high & ~(1U << pin.pin);
      last = pin.time;
    }
    CHECK_EQUAL(0u, high);
    return last - instant;
  }
  bool allows(const PlannedPulse&, MonoTime) noexcept override { return true; }
  void switched_on(const PlannedPulse&, const Issue&) noexcept override {}
  void switched_off(Output, const Issue&, Duration) noexcept override {}
  void failed(const ShortText& why, MonoTime) noexcept override {
    if (failure.empty()) failure = why.view();
    bench.outputs.cut();
  }
};

}  // namespace

TEST_GROUP(LocalSequencer){};

TEST(LocalSequencer, EstopAndKeyCutTheOutputsWithoutIt) {
  for (const unsigned pin : {rp1_pin::estop, rp1_pin::key}) {
    UnderWay shot;
    const MonoTime now = shot.bench.rp1.time;
    const MonoTime pressed = now + microseconds(1234);
    shot.bench.rp1.schedule(pressed, pin, false);
    shot.bench.rp1.schedule(pressed + milliseconds(300), pin, true);
    shot.bench.rp1.stop_threads(now + milliseconds(8));  // neither watchers nor beats are missed yet
    shot.turn_until(now + milliseconds(6));
    // Two cycles of synchronizers, up to two until it looks, four samples over 97, four to the zeros: 0.55 us.
    const Duration after = shot.low_after(pressed);
    CHECK(after > nanoseconds(480) && after < nanoseconds(560));
    shot.turn_until(now + milliseconds(500));
    STRCMP_CONTAINS(pin == rp1_pin::key ? "the key is off" : "the e-stop is pressed", shot.failure.c_str());
    CHECK_EQUAL(after, shot.low_after(pressed));  // it stays so although the pin is high again
  }
}

TEST(LocalSequencer, OutputsAreCutWhenItsThreadStandsStill) {
  UnderWay shot;
  const MonoTime now = shot.bench.rp1.time;
  shot.bench.rp1.stop_threads(now + milliseconds(400));
  shot.turn_until(now + milliseconds(300));
  // The watchers were fed at most 2 ms and a turn before, and count 18 ms by a clock that is 23 ppm slow.
  const Duration after = shot.low_after(now);
  CHECK(after > milliseconds(15) && after < microseconds(18'010));
}

TEST(LocalSequencer, OutputsAreCutWhenTheLoopsBeatsStop) {
  UnderWay shot;
  const MonoTime now = shot.bench.rp1.time;
  shot.bench.rp1.beat = nullptr;
  shot.turn_until(now + milliseconds(300));
  // A beat of up to 4 ms before counts for 15 ms; then within a turn of 0.8 ms and the calls of two.
  const Duration after = shot.low_after(now);
  CHECK(after > milliseconds(10) && after < microseconds(16'200));
  CHECK_FALSE(shot.failure.empty());
}

namespace {

/// Real time passes by itself; the block's calls take what they take.
class RealTime final : public VirtualTime {
 public:
  MonoTime at() const override { return SystemClock().now(); }
  void pass(Duration) override {}
};

class NoEdges final : public EdgeSource {
 public:
  explicit NoEdges(int wake_fd) : wake_fd_(wake_fd) {}
  std::optional<std::size_t> wait(MonoTime until, std::span<Edge>) noexcept override {
    const timespec timeout = time_left(until);
    pollfd polled{wake_fd_, POLLIN, 0};
    std::uint64_t wakes = 0;
    if (ppoll(&polled, 1, &timeout, nullptr) > 0 && ::read(wake_fd_, &wakes, sizeof wakes) < 0) return std::nullopt;
    return 0;
  }
  std::optional<std::size_t> poll(MonoTime until, std::span<Edge> edges) noexcept override { return wait(until, edges); }
  std::optional<bool> level(Input input) noexcept override { return input == Input::key; }
  std::int64_t kernel_overflows() const noexcept override { return 0; }

 private:
  int wake_fd_;
};

}  // namespace

TEST(LocalSequencer, AnswersFromAThreadOfItsOwn) {
  SystemClock clock;
  RealTime time;
  SimulatedPioBlock block(time);
  for (const unsigned pin : {rp1_pin::key, rp1_pin::estop}) block.input(pin, true);
  LocalLine line(clock);
  NoEdges edges(line.request_fd());
  Rp1Hardware hardware(block, edges, clock, rp1_pins(), 37);
  CHECK_TRUE(hardware.take());
  LocalSequencer sequencer(hardware, line, clock, 1001);
  sequencer.start(1);
  Heartbeat heartbeat(line, clock);
  FlashSequencerLink link(line, heartbeat, clock);
  const auto connected = link.connect(milliseconds(60'000));
  CHECK_TRUE_TEXT(connected.has_value(), connected ? "" : connected.error().message.c_str());
  // The line is exact, and the clocks are one: a tick, and what its rounding makes of the fit.
  const MonoTime now = clock.now();
  const MonoTime told = link.clock_relation().to_time(to_ns(now) / flash_sequencer::kTick_ns);
  CHECK(told - now < nanoseconds(50) && now - told < nanoseconds(50));
  sequencer.stop();
}
