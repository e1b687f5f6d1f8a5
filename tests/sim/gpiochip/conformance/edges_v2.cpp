// Of kernel_calls_v2: events of a line that the outside drives.
#include <time.h>

#include <cstdlib>

#include "tests/sim/gpiochip/conformance/answers_v2.hpp"

namespace answers {
namespace {

using namespace uapi::v2;

const char* answers_fifo = nullptr;

void please(const char* what) { answers::please(answers_fifo, what); }

std::uint64_t ns_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(now.tv_nsec);
}

/// All events that wait, in at most two reads; stamps are only checked to be of that clock and since then.
void say_events(const char* what, int request, clockid_t clock, std::uint64_t since_ns) {
  gpio_v2_line_event events[64];
  polled(request, POLLIN, 1000);
  const ssize_t size = read(request, events, sizeof(events) - 1);  // and a part of one
  if (size < 0) return say_outcome(what, -errno);
  for (std::size_t i = 0; i < static_cast<std::size_t>(size) / sizeof(events[0]); ++i) {
    const gpio_v2_line_event& event = events[i];
    const bool in_time = event.timestamp_ns >= since_ns && event.timestamp_ns <= ns_of(clock);
    say(what, std::string(event.id == GPIO_V2_LINE_EVENT_RISING_EDGE ? "rising" : "falling") +
                  (event.offset == line_c   ? " C"
                   : event.offset == line_b ? " B"
                                            : " another line") +
                  ", number " + std::to_string(event.seqno) + ", of the line " +
                  std::to_string(event.line_seqno) + (in_time ? "" : ", stamp of another time"));
  }
}

void every_edge() {
  const int request = take(chip, {line_a, line_c}, config(kIn, {flags(kIn | kBoth, 2)}));
  fcntl(request, F_SETFL, O_NONBLOCK);
  const std::uint64_t since_ns = ns_of(CLOCK_MONOTONIC);
  please("C 1 0 1");
  say("poll", polled(request, POLLIN, 1000));
  say_value("level", get(request, 2));
  say_events("both edges", request, CLOCK_MONOTONIC, since_ns);
  say("poll", polled(request, POLLIN));
  configure(request, config(kIn, {flags(kIn | kLow | kRising, 2)}));
  please("C 0 1");
  say_events("rising edges of the line, now active low", request, CLOCK_MONOTONIC, since_ns);
  configure(request, config(kIn, {flags(kIn | kBoth | kRealtime, 2)}));
  const std::uint64_t since_real_ns = ns_of(CLOCK_REALTIME);
  please("C 0");
  say_events("by the other clock", request, CLOCK_REALTIME, since_real_ns);
  configure(request, config(kIn, {flags(kIn | kRising, 2)}));
  please("C 1");
  configure(request, config(kIn));
  say_events("queued before events were switched off", request, CLOCK_MONOTONIC, since_ns);
  please("C 0");
  say_events("none asked for", request, CLOCK_MONOTONIC, since_ns);
  close(request);
}

void debounced() {
  const int request = take(chip, {line_c}, config(kIn | kBoth, {debounce_us(1'000'000, 1)}));
  const std::uint64_t since_ns = ns_of(CLOCK_MONOTONIC);
  please("C 1 0 1");
  say_value("debounced level", get(request, 1));
  say("poll", polled(request, POLLIN));
  say("poll for longer", polled(request, POLLIN, 5000));
  say_value("debounced level", get(request, 1));
  say_events("once settled", request, CLOCK_MONOTONIC, since_ns);
  please("C 0 1");
  say("poll after a bounce that settles where it was", polled(request, POLLIN, 2000));
  configure(request, config(kIn | kBoth));
  please("C 0");
  say_value("level, not debounced any more", get(request, 1));
  say_events("at once", request, CLOCK_MONOTONIC, since_ns);
  close(request);
}

void overflow() {
  gpio_v2_line_request asked = request_of({line_c}, config(kIn | kBoth));
  asked.event_buffer_size = 3;  // which is rounded up to 4
  const int request = take(chip, asked);
  const std::uint64_t since_ns = ns_of(CLOCK_MONOTONIC);
  please("C 1 0 1 0 1 0");
  say_events("the newest four of six", request, CLOCK_MONOTONIC, since_ns);
  please("C 1 0");
  say_events("then", request, CLOCK_MONOTONIC, since_ns);
  close(request);
  asked = request_of({line_b, line_c}, config(kIn | kBoth));
  asked.event_buffer_size = 4;
  const int both = take(chip, asked);
  for (const char* driven : {"C 1 0", "B 1 0", "C 1 0"}) please(driven);
  say_events("the newest four of six of two lines", both, CLOCK_MONOTONIC, since_ns);
  close(both);
  const int pair = take(chip, {line_a, line_c}, config(kIn, {flags(kIn | kRising, 2)}));
  please("C 1 0 1 0");
  say_events("of a request of two lines", pair, CLOCK_MONOTONIC, since_ns);
  close(pair);
  const int again = take(chip, {line_c}, config(kIn | kBoth));
  fcntl(again, F_SETFL, O_NONBLOCK);
  say_events("nothing of earlier owners", again, CLOCK_MONOTONIC, since_ns);
  close(again);
}

}  // namespace

void drive_edges(const char* fifo) {
  answers_fifo = fifo;
  every_edge();
  debounced();
  overflow();
}

}  // namespace answers
