// Of kernel_calls_v2: watched lines, by uAPI v2 and v1.
#include <time.h>

#include "tests/sim/gpiochip/conformance/answers_v2.hpp"

namespace answers {
namespace {

using namespace uapi::v2;

/// Reads at most `most` records of v2 and says them.
void say_changes(const char* what, int descriptor, std::size_t most) {
  gpio_v2_line_info_changed changes[64];
  const ssize_t size = read(descriptor, changes, most * sizeof(changes[0]));
  if (size < 0) return say_outcome(what, -errno);
  for (std::size_t i = 0; i < static_cast<std::size_t>(size) / sizeof(changes[0]); ++i) {
    const char* const names[] = {"none", "requested", "released", "configured"};
    const std::string line = changes[i].info.offset == line_a ? "A " : "B ";
    say(what, names[changes[i].event_type & 3] + std::string(" ") + line + text_of(changes[i].info));
  }
}

void refusals(int watcher) {
  gpio_v2_line_info info{};
  info.offset = line_a;
  info.padding[0] = 1;
  say_outcome("watch with padding", uapi::outcome(ioctl(watcher, GPIO_V2_GET_LINEINFO_WATCH_IOCTL, &info)));
  say_outcome("watch of a line past the last", watch(watcher, 1000));
  say_outcome("end of a watch of a line past the last", unwatch(watcher, 1000));
  say_outcome("end of no watch", unwatch(watcher, line_a));
  fcntl(watcher, F_SETFL, O_NONBLOCK);
  say_outcome("read of who watches nothing", read_bytes(watcher, 288));
  say_outcome("read of nothing of who watches nothing", read_bytes(watcher, 0));
  say_outcome("watch", watch(watcher, line_a));
  say_outcome("watch again", watch(watcher, line_a));
  gpioline_info v1{};
  v1.line_offset = line_b;
  say_outcome("watch by v1", uapi::outcome(ioctl(watcher, GPIO_GET_LINEINFO_WATCH_IOCTL, &v1)));
  say_outcome("read before a change", read_bytes(watcher, 288));
  say_outcome("read of half a change before one", read_bytes(watcher, 144));
  say("poll before a change", polled(watcher, POLLIN));
}

void changes(int watcher) {
  int request = take(chip, {line_a, line_b}, config(kIn | kLow | kBoth), "seen");
  say("poll after a request", polled(watcher, POLLIN));
  say_outcome("read of half a change", read_bytes(watcher, 144));
  say_changes("request", watcher, 4);
  configure(request, config(kOut, {values(1, 1)}));
  configure(request, config(kLow));
  configure(request, config(kIn | kOut));
  configure(request, config(kIn | kUp, {debounce_us(100, 1)}));
  set(request, 1, 1);
  say_changes("configurations, one at a time", watcher, 1);
  say_changes("configurations, one at a time", watcher, 1);
  say_changes("no more", watcher, 1);
  close(request);
  info_of(line_a);
  say_changes("release", watcher, 4);
  say_outcome("watch of the second line", watch(watcher, line_b));
  request = uapi::request_lines(chip, {line_a, line_b}, GPIOHANDLE_REQUEST_OUTPUT, {1, 0}, "v1");
  uapi::configure(request, GPIOHANDLE_REQUEST_INPUT);
  close(request);
  info_of(line_a);
  info_of(line_b);
  say_changes("v1 handle", watcher, 64);
  close(uapi::request_event(chip, line_a, GPIOHANDLE_REQUEST_INPUT, GPIOEVENT_REQUEST_BOTH_EDGES, "event"));
  info_of(line_a);
  say_changes("v1 event line", watcher, 64);
  const int busy = take(chip, {line_b}, config(kIn));
  say_request("a free and a taken line", take(chip, {line_a, line_b}, config(kIn)));
  say_changes("a free and a taken line", watcher, 64);
  close(busy);
  info_of(line_b);
  say_changes("release", watcher, 64);
}

void full_queue(int watcher) {
  const int request = take(chip, {line_a}, config(kIn));
  for (int i = 0; i < 40; ++i)
    configure(request, config(kIn, {debounce_us(static_cast<std::uint32_t>(i + 1), 1)}));
  close(request);
  info_of(line_a);
  gpio_v2_line_info_changed found[64];
  const ssize_t size = read(watcher, found, sizeof(found));
  say_value("of 42 changes are kept", static_cast<int>(size / static_cast<ssize_t>(sizeof(found[0]))));
  say("the oldest", text_of(found[0].info));
  say("the last one", text_of(found[31].info));
}

void ends(const char* device, int watcher) {
  say_outcome("end of a watch", unwatch(watcher, line_a));
  say_request("request of a line not watched any more", take(chip, {line_a}, config(kIn)));
  info_of(line_a);
  say_changes("after it", watcher, 1);
  const int other = uapi::open_chip(device, O_RDWR | O_NONBLOCK), copy = dup(other);
  say_outcome("watch by another open of the chip", watch(other, line_b));
  close(other);
  say_request("request", take(chip, {line_b}, config(kIn)));
  info_of(line_b);
  say_changes("read by a copy", copy, 1);
  say_changes("and by the first", watcher, 1);
  close(copy);
  const int late = uapi::open_chip(device, O_RDONLY | O_NONBLOCK);
  say_changes("read by a later open of the chip", late, 1);
  say_outcome("watch by a read-only open", watch(late, line_b));
  close(late);
}

void v1_watches(const char* device) {
  const int watcher = uapi::open_chip(device, O_RDWR | O_NONBLOCK);
  gpioline_info v1{};
  v1.line_offset = line_a;
  const auto watch_v1 = [&] { return uapi::outcome(ioctl(watcher, GPIO_GET_LINEINFO_WATCH_IOCTL, &v1)); };
  say_outcome("v1 watch", watch_v1());
  say_outcome("v1 watch again", watch_v1());
  say_outcome("watch by v2", watch(watcher, line_b));
  v1.line_offset = 1000;
  say_outcome("v1 watch of a line past the last", watch_v1());
  close(take(chip, {line_a}, config(kOut | kLow), "seen"));
  info_of(line_a);
  gpioline_info_changed found[4]{};
  say_value("bytes read into half a change", read_bytes(watcher, 52));
  const ssize_t size = read(watcher, found, 2 * sizeof(found[0]));
  say_value("bytes read into two changes", static_cast<int>(size));
  say("v1 change", std::to_string(found[0].event_type) + " flags " + std::to_string(found[0].info.flags) +
                       " consumer '" + found[0].info.consumer + "'");
  say_value("bytes read into four changes", read_bytes(watcher, 4 * sizeof(found[0])));
  close(take(chip, {line_a}, config(kIn)));
  info_of(line_a);
  say_value("bytes of two changes read into three", read_bytes(watcher, 3 * sizeof(found[0])));
  say_value("and the rest", read_bytes(watcher, 3 * sizeof(found[0])));
  close(take(chip, {line_a}, config(kIn)));
  info_of(line_a);
  say_value("bytes of two changes read into four", read_bytes(watcher, 4 * sizeof(found[0])));
  close(watcher);
}

}  // namespace

void watch_lines(const char* device) {
  const int watcher = uapi::open_chip(device);
  refusals(watcher);
  changes(watcher);
  full_queue(watcher);
  ends(device, watcher);
  close(watcher);
  v1_watches(device);
}

}  // namespace answers
