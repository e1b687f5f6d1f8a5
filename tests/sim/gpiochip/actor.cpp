// actor ROLE ...: what tests of the simulated chip run as child processes with the library preloaded.
//   hold LINES VALUES             takes outputs, says "ready", sleeps
//   toggle LINES COUNT PAUSE_US   takes outputs at 0, says "ready", sets them all 1, 0, 1, ... (COUNT 0: for
//   ever) orphan LINE                   takes an output at 1, forks a child that keeps it, says the child's
//   pid, ends copy LINE                     takes an output, keeps only a dup of it, says "ready", sets it to
//   1 on SIGUSR1 events LINE EDGES FLAGS       takes an event line, says "ready", prints every event as "ID
//   STAMP" until SIGTERM late LINE                     takes an event line, says "ready", prints what is
//   queued when SIGUSR1 comes nobody LINE                   becomes an ordinary user, then toggles the line
//   once and waits for one event on it unplugged LINE                takes an output and an event line, says
//   "ready", and on SIGUSR1 what is left
#include <grp.h>
#include <poll.h>
#include <signal.h>
#include <sys/types.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/sim/gpiochip/actor_parts.hpp"
#include "tests/sim/gpiochip/conformance/uapi_client.hpp"

namespace {

using namespace actor;

unsigned number(const char* text) { return static_cast<unsigned>(std::strtoul(text, nullptr, 10)); }

int outputs(const std::vector<unsigned>& lines, const std::vector<unsigned>& values) {
  return must("request", uapi::request_lines(chip(), lines, GPIOHANDLE_REQUEST_OUTPUT, values, "actor"));
}

int event_line(unsigned line, std::uint32_t edges, std::uint32_t flags = 0) {
  return must("event request",
              uapi::request_event(chip(), line, GPIOHANDLE_REQUEST_INPUT | flags, edges, "actor"));
}

void set_all(int handle, unsigned value) {
  gpiohandle_data data{};
  memset(data.values, static_cast<int>(value), sizeof(data.values));
  must("set", uapi::outcome(ioctl(handle, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &data)));
}

sigset_t only(int number) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, number);
  return set;
}

void wait_for_signal(int number) {
  const sigset_t set = only(number);
  int received = 0;
  sigwait(&set, &received);
}

void hold(const char* lines, const char* values) {
  outputs(numbers(lines), numbers(values));
  std::puts("ready");
  pause();
}

void toggle(const char* lines, unsigned long count, unsigned pause_us) {
  const int handle = outputs(numbers(lines), {});
  std::puts("ready");
  for (unsigned long i = 0; count == 0 || i < count; ++i) {
    set_all(handle, i % 2 == 0 ? 1 : 0);
    if (pause_us > 0) usleep(pause_us);
  }
  std::puts("done");
}

void orphan(unsigned line) {
  outputs({line}, {1});
  const pid_t child = fork();
  if (child == 0) {
    pause();
    std::_Exit(0);
  }
  std::printf("child %d\n", child);
}

void copy(unsigned line) {
  const int handle = outputs({line}, {0}), kept = dup(handle);
  close(handle);
  std::puts("ready");
  wait_for_signal(SIGUSR1);
  set_all(kept, 1);
  std::puts("set");
  pause();
}

void print_events(int descriptor, std::size_t most) {
  gpioevent_data events[64];
  const ssize_t size = read(descriptor, events, most * sizeof(events[0]));
  if (size < 0) give_up("read", -errno);
  for (std::size_t i = 0; i < static_cast<std::size_t>(size) / sizeof(events[0]); ++i)
    std::printf("%u %llu\n", events[i].id, static_cast<unsigned long long>(events[i].timestamp));
}

void events(unsigned line, std::uint32_t edges, std::uint32_t flags) {
  const int descriptor = event_line(line, edges, flags);
  std::puts("ready");
  for (;;) print_events(descriptor, 1);
}

void late(unsigned line) {
  const int descriptor = event_line(line, GPIOEVENT_REQUEST_BOTH_EDGES);
  std::puts("ready");
  wait_for_signal(SIGUSR1);
  print_events(descriptor, 64);
  std::puts("end");
}

void nobody(unsigned line) {
  constexpr unsigned kNobody = 65534;
  if (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0) give_up("setuid", -errno);
  const int handle = outputs({line}, {0});
  set_all(handle, 1);
  close(handle);
  const int descriptor = event_line(line, GPIOEVENT_REQUEST_BOTH_EDGES);
  std::puts("ready");
  print_events(descriptor, 1);
}

void unplugged(unsigned line) {
  const int handle = outputs({line}, {0});
  const int descriptor = event_line(line + 1, GPIOEVENT_REQUEST_BOTH_EDGES);
  std::puts("ready");
  wait_for_signal(SIGUSR1);
  gpiohandle_data data{};
  const auto name = [](int result) { return result < 0 ? strerrorname_np(-result) : "ok"; };
  std::printf("set %s\n", name(uapi::outcome(ioctl(handle, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &data))));
  std::printf("get %s\n", name(uapi::outcome(ioctl(descriptor, GPIOHANDLE_GET_LINE_VALUES_IOCTL, &data))));
  struct pollfd waiting {
    descriptor, POLLIN, 0
  };
  const int ready = poll(&waiting, 1, 1000);
  std::printf("poll %d %s\n", ready, (waiting.revents & POLLHUP) != 0 ? "hang-up" : "data");
  gpioevent_data event{};
  std::printf("read %s\n", name(uapi::outcome(static_cast<int>(read(descriptor, &event, sizeof(event))))));
  std::printf("open %s\n", name(uapi::open_chip(kDevice)));
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const sigset_t user = only(SIGUSR1);
  sigprocmask(SIG_BLOCK, &user, nullptr);
  const std::string role = argc > 2 ? argv[1] : "";
  const unsigned line = argc > 2 ? number(argv[2]) : 0;
  if (role == "hold" && argc == 4) {
    hold(argv[2], argv[3]);
  } else if (role == "toggle" && argc == 5) {
    toggle(argv[2], number(argv[3]), number(argv[4]));
  } else if (role == "orphan") {
    orphan(line);
  } else if (role == "copy") {
    copy(line);
  } else if (role == "events" && argc == 5) {
    events(line, number(argv[3]), number(argv[4]));
  } else if (role == "late") {
    late(line);
  } else if (role == "nobody") {
    nobody(line);
  } else if (role == "unplugged") {
    unplugged(line);
  } else {
    std::fprintf(stderr, "actor: see the top of actor.cpp\n");
    return 2;
  }
  return 0;
}
