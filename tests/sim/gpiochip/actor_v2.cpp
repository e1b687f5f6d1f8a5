// actor_v2 ROLE ...: as actor.cpp, for uAPI v2.
//   hold LINES BITS          takes outputs, says "ready", sleeps
//   toggle LINES COUNT       takes outputs at 0, says "ready", sets them all 1, 0, 1, ... (COUNT 0: for ever)
//   turn LINE                takes an output at 1, says "ready", makes it an input on SIGUSR1, says "input"
//   events LINES BUFFER      takes lines for both edges, says "ready", prints every event until SIGTERM
//   pulled LINE BIAS         takes an input with bias 0 down, 1 up or 2 none, says "ready" and its level, sleeps
//   late LINES BUFFER        the same, prints what is queued when SIGUSR1 comes, then "end"
//   bouncing LINE PERIOD_US  takes a line for both edges, debounced, says "ready", prints every event
//   slots LINES COUNT        takes every line by a request of its own and lets go of them all, COUNT times
//   watch LINES              watches lines, says "ready", prints every change until SIGTERM
//   opens COUNT              opens the chip COUNT times, says how many of these could watch
//   unplugged LINE           takes an output and an event line, says "ready", and on SIGUSR1 what is left
// An event is printed as "ID LINE NUMBER NUMBER_OF_LINE STAMP", a change as "KIND LINE CONSUMER".
#include <poll.h>
#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/sim/gpiochip/actor_parts.hpp"
#include "tests/sim/gpiochip/conformance/uapi_v2_client.hpp"

namespace {

using namespace actor;
using namespace uapi::v2;

constexpr std::uint64_t kAll = ~std::uint64_t{0};

int outputs(const std::vector<unsigned>& lines, std::uint64_t bits) {
  return must("request", take(chip(), lines, config(kOut, {values(bits, kAll)}), "actor"));
}

int edges(const std::vector<unsigned>& lines, std::uint32_t buffer) {
  gpio_v2_line_request request = request_of(lines, config(kIn | kBoth), "actor");
  request.event_buffer_size = buffer;
  return must("request", take(chip(), request));
}

void pulled(unsigned line, unsigned long bias) {
  const std::uint64_t flag = bias == 1 ? kUp : bias == 0 ? kDown : kNoBias;
  const int request = must("request", take(chip(), {line}, config(kIn | flag), "actor"));
  gpio_v2_line_values now{0, 1};
  must("get", uapi::outcome(ioctl(request, GPIO_V2_LINE_GET_VALUES_IOCTL, &now)));
  std::printf("ready %u\n", static_cast<unsigned>(now.bits));
  pause();
}

void wait_for_signal() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGUSR1);
  int received = 0;
  sigwait(&set, &received);
}

void toggle(const std::vector<unsigned>& lines, unsigned long count) {
  const int request = outputs(lines, 0);
  const std::uint64_t mask = (std::uint64_t{1} << lines.size()) - 1;
  std::puts("ready");
  for (unsigned long i = 0; count == 0 || i < count; ++i)
    must("set", set(request, i % 2 == 0 ? mask : 0, mask));
  std::puts("done");
}

void turn(unsigned line) {
  const int request = outputs({line}, 1);
  std::puts("ready");
  wait_for_signal();
  must("configure", configure(request, config(kIn)));
  std::puts("input");
  pause();
}

/// Reads once, into room for some events and a third of another. False if there is none, and none is waited
/// for.
bool print_events(int request) {
  gpio_v2_line_event events[11];
  const int size = uapi::outcome(static_cast<int>(read(request, events, 10 * sizeof(events[0]) + 16)));
  if (size == -EAGAIN) return false;
  must("read", size);
  for (std::size_t i = 0; i < static_cast<std::size_t>(size) / sizeof(events[0]); ++i) {
    const gpio_v2_line_event& event = events[i];
    std::printf("%u %u %u %u %llu\n", event.id, event.offset, event.seqno, event.line_seqno,
                static_cast<unsigned long long>(event.timestamp_ns));
  }
  return true;
}

void print_for_ever(int request) {
  std::puts("ready");
  for (;;) print_events(request);
}

void slots(const std::vector<unsigned>& lines, unsigned long count) {
  const int device = chip();
  for (unsigned long i = 0; i < count; ++i) {
    std::vector<int> requests;
    requests.reserve(lines.size());
    for (const unsigned line : lines)
      requests.push_back(must("request", take(device, {line}, config(kIn | kBoth))));
    for (const int request : requests) close(request);
  }
  std::puts("done");
}

void watch_all(const std::vector<unsigned>& lines) {
  const int device = chip();
  for (const unsigned line : lines) must("watch", watch(device, line));
  std::puts("ready");
  for (;;) {
    gpio_v2_line_info_changed change{};
    must("read", uapi::outcome(static_cast<int>(read(device, &change, sizeof(change)))));
    std::printf("%u %u %s\n", change.event_type, change.info.offset, change.info.consumer);
  }
}

void opens(unsigned long count) {
  int watching = 0;
  for (unsigned long i = 0; i < count; ++i) watching += watch(chip(), 0) == 0 ? 1 : 0;
  std::printf("watching %d\n", watching);
  must("request", take(chip(), {0}, config(kIn)));
  std::puts("ready");
  pause();
}

void unplugged(unsigned line) {
  const int output = outputs({line}, 0), events = edges({line + 1}, 0), device = chip();
  std::puts("ready");
  wait_for_signal();
  const auto name = [](int result) { return result < 0 ? strerrorname_np(-result) : "ok"; };
  std::printf("set %s\n", name(set(output, 1, 1)));
  std::printf("get %s\n", name(get(events, 1)));
  std::printf("configure %s\n", name(configure(output, config(kIn))));
  for (const int descriptor : {events, device}) {
    struct pollfd waiting {
      descriptor, POLLIN, 0
    };
    poll(&waiting, 1, 1000);
    char record[512];
    std::printf("poll%s%s\n", (waiting.revents & POLLHUP) != 0 ? " hang-up" : "",
                (waiting.revents & POLLIN) != 0 ? " data" : "");
    std::printf("read %s\n", name(uapi::outcome(static_cast<int>(read(descriptor, record, 288)))));
  }
  std::printf("info %s\n", name(watch(device, line)));
}

bool play(const std::string& role, const std::vector<unsigned>& lines, unsigned long number) {
  if (role == "hold") {
    outputs(lines, number);
    std::puts("ready");
    pause();
  } else if (role == "toggle") {
    toggle(lines, number);
  } else if (role == "turn") {
    turn(lines[0]);
  } else if (role == "events") {
    print_for_ever(edges(lines, static_cast<std::uint32_t>(number)));
  } else if (role == "bouncing") {
    const auto debounced = config(kIn | kBoth, {debounce_us(static_cast<std::uint32_t>(number), kAll)});
    print_for_ever(must("request", take(chip(), lines, debounced)));
  } else if (role == "pulled") {
    pulled(lines[0], number);
  } else if (role == "late") {
    const int request = edges(lines, static_cast<std::uint32_t>(number));
    std::puts("ready");
    wait_for_signal();
    fcntl(request, F_SETFL, O_NONBLOCK);
    while (print_events(request)) continue;
    std::puts("end");
  } else if (role == "slots") {
    slots(lines, number);
  } else if (role == "watch") {
    watch_all(lines);
  } else if (role == "opens") {
    opens(lines[0]);
  } else if (role == "unplugged") {
    unplugged(lines[0]);
  } else {
    return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  sigset_t user;
  sigemptyset(&user);
  sigaddset(&user, SIGUSR1);
  sigprocmask(SIG_BLOCK, &user, nullptr);
  const unsigned long number = argc > 3 ? std::strtoul(argv[3], nullptr, 10) : 0;
  if (argc > 2 && play(argv[1], numbers(argv[2]), number)) return 0;
  std::fprintf(stderr, "actor_v2: see the top of actor_v2.cpp\n");
  return 2;
}
