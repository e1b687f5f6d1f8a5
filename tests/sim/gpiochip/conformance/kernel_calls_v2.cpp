// kernel_calls_v2 DEVICE A B C ANSWERS: the GPIO uAPI v2 by bare system calls, answer by answer.
//
// As kernel_calls.cpp for v1. C is a line that the outside drives, low at first: a line "please: C 1 0" says
// how; whoever did it opens the FIFO ANSWERS and closes it again. Left out is what depends on the hardware,
// and on the kernel's version: Linux 6.1 with its later corrections and 6.12 answer alike.
#include <signal.h>
#include <sys/wait.h>

#include <cstdlib>

#include "tests/sim/gpiochip/conformance/answers_v2.hpp"

namespace {

using namespace answers;
using namespace uapi::v2;

void chip_calls() {
  say("line is an input at first", info_of(line_a));
  say("info of a line past the last", info_of(1000));
  gpio_v2_line_info info{};
  info.offset = line_a;
  info.padding[3] = 1;
  say_outcome("info with padding", uapi::outcome(ioctl(chip, GPIO_V2_GET_LINEINFO_IOCTL, &info)));
  say_outcome("line info to nowhere", with_null(chip, GPIO_V2_GET_LINEINFO_IOCTL));
  say_outcome("request from nowhere", with_null(chip, GPIO_V2_GET_LINE_IOCTL));
  say_outcome("watch from nowhere", with_null(chip, GPIO_V2_GET_LINEINFO_WATCH_IOCTL));
  say_outcome("end of a watch from nowhere", with_null(chip, GPIO_GET_LINEINFO_UNWATCH_IOCTL));
  say_outcome("set values on the chip", set(chip, 1, 1));
  say_outcome("configure on the chip", configure(chip, config(kIn)));
}

void request_refusals() {
  const auto request = [](std::uint64_t flags) { return take(chip, {line_a}, config(flags)); };
  say_request("no lines", take(chip, std::vector<unsigned>{}, config(kIn)));
  say_request("65 lines", take(chip, std::vector<unsigned>(65, line_a), config(kIn)));
  say_request("a line past the last", take(chip, {1000}, config(kIn)));
  say_request("one line twice", take(chip, {line_a, line_a}, config(kIn)));
  say_request("input and output", request(kIn | kOut));
  say_request("the flag of used lines", request(kIn | GPIO_V2_LINE_FLAG_USED));
  say_request("unknown flag", request(kIn | std::uint64_t{1} << 40));
  say_request("edges of an output", request(kOut | kBoth));
  say_request("edges as it is", request(kRising));
  say_request("open drain input", request(kIn | kDrain));
  say_request("open source as it is", request(kSource));
  say_request("open drain and open source", request(kOut | kDrain | kSource));
  say_request("bias without direction", request(kUp));
  say_request("pull up and down", request(kIn | kUp | kDown));
  say_request("pull up and disabled", request(kIn | kUp | kNoBias));
  say_request("hardware clock", request(kIn | kRising | kHardwareClock));
  say_request("realtime as it is", request(kRealtime));
  gpio_v2_line_request padded = request_of({line_a}, config(kIn));
  padded.padding[4] = 1;
  say_request("padding", take(chip, padded));
  padded = request_of({line_a}, config(kIn));
  padded.config.padding[0] = 1;
  say_request("padding of the configuration", take(chip, padded));
  say("line after refusals", info_of(line_a));
}

void attribute_refusals() {
  gpio_v2_line_config many = config(kIn);
  many.num_attrs = GPIO_V2_LINE_NUM_ATTRS_MAX;
  say_request("ten attributes that say nothing", take(chip, {line_a}, many));
  ++many.num_attrs;
  say_request("eleven attributes", take(chip, {line_a}, many));
  const auto request = [](const gpio_v2_line_config& asked) { return take(chip, {line_a, line_b}, asked); };
  say_request("flags of one line refused", request(config(kIn, {flags(kIn | kOut, 2)})));
  say_request("flags of no line", request(config(kIn, {flags(kIn | kOut, 4)})));
  say_request("defaults that no line uses", request(config(kIn | kOut, {flags(kIn, 3)})));
  say_request("debounced output", request(config(kOut, {debounce_us(10, 1)})));
  say_request("debounced as it is", request(config(0, {debounce_us(10, 2)})));
  say_request("an unknown attribute", request(config(kIn, {{77, 1, 3}})));
  gpio_v2_line_request small = request_of({line_a}, config(kIn | kBoth));
  small.event_buffer_size = 1;
  say_request("a queue of one event", take(chip, small));
  say("line then", info_of(line_a));
  small.config.flags = kIn;
  const int descriptor = take(chip, small);
  say_outcome("a queue of one event, without events", descriptor);
  say_outcome("then with events", configure(descriptor, config(kIn | kRising)));
  say("line then", info_of(line_a));
  close(descriptor);
  small.config.flags = kIn | kBoth;
  small.event_buffer_size = 1000000;
  say_request("a queue of a million events", take(chip, small));
}

void outputs() {
  const int request = take(chip, {line_a, line_b}, config(kOut, {values(1, 3)}), "conform");
  say_outcome("outputs", request);
  say("access mode", access_mode(request));
  say("it closes on exec", (fcntl(request, F_GETFD) & FD_CLOEXEC) != 0 ? "yes" : "no");
  say("line is taken", info_of(line_a));
  say_value("levels as asked", get(request, 3));
  say_outcome("set both", set(request, 2, 3));
  say_value("levels", get(request, 3));
  say_outcome("set one", set(request, 3, 1));
  say_value("levels", get(request, 3));
  say_value("level of the second", get(request, 2));
  say_outcome("set with bits of others", set(request, ~std::uint64_t{0}, ~std::uint64_t{0} - 1));
  say_value("levels with bits of others", get(request, ~std::uint64_t{0}));
  say_outcome("set of no line", set(request, 3, 0));
  say_outcome("set of lines it has not", set(request, 12, 12));
  say_value("get of no line", get(request, 0));
  say_value("get of lines it has not", get(request, 12));
  say_request("second request for a taken line", take(chip, {line_a}, config(kIn)));
  say_request("v1 handle of a taken line", uapi::request_lines(chip, {line_a}, GPIOHANDLE_REQUEST_INPUT));
  say_request("v1 event of a taken line",
              uapi::request_event(chip, line_a, GPIOHANDLE_REQUEST_INPUT, GPIOEVENT_REQUEST_BOTH_EDGES));
  say_outcome("v1 set", uapi::set(request, {1}));
  say_value("v1 get", uapi::get(request));
  say_outcome("v1 configuration", uapi::configure(request, GPIOHANDLE_REQUEST_INPUT));
  say_outcome("unknown call", with_null(request, kUnknownRequest));
  say_outcome("chip info", with_null(request, GPIO_GET_CHIPINFO_IOCTL));
  say_outcome("terminal call", terminal_call(request));
  say_outcome("set from nowhere", with_null(request, GPIO_V2_LINE_SET_VALUES_IOCTL));
  say_outcome("get to nowhere", with_null(request, GPIO_V2_LINE_GET_VALUES_IOCTL));
  say_outcome("configuration from nowhere", with_null(request, GPIO_V2_LINE_SET_CONFIG_IOCTL));
  say("poll", polled(request, POLLIN | POLLOUT));
  fcntl(request, F_SETFL, O_NONBLOCK);
  say_outcome("read without waiting", read_bytes(request, 48));
  say_outcome("read of less than an event", read_bytes(request, 47));
  say_outcome("read of nothing", read_bytes(request, 0));
  say_outcome("write", write_bytes(request, 48));
  close(request);
  say("line after release", info_of(line_a));
  say_outcome("set on a closed request", set(request, 1, 1));
}

void mixed_lines() {
  const int request = take(chip, {line_a, line_b},
                           config(kOut | kLow, {flags(kIn | kBoth | kRealtime, 2), flags(kOut, 3),
                                                values(3, 3), debounce_us(2000, 2)}));
  say("of two attributes the first counts", info_of(line_a));
  say("input with edges, debounced", info_of(line_b));
  say_value("level of the output", get(request, 1));
  say_outcome("set of the output", set(request, 0, 1));
  say_outcome("set of both", set(request, 1, 3));
  say_value("level of the output stays", get(request, 1));
  close(request);
  say("line after release", info_of(line_b));
  const int handle = uapi::request_lines(chip, {line_b}, GPIOHANDLE_REQUEST_INPUT);
  say_request("request for a line of a v1 handle", take(chip, {line_b}, config(kIn)));
  say_value("v2 get on a v1 handle", get(handle, 1));
  say_outcome("v2 set on a v1 handle", set(handle, 1, 1));
  say_outcome("v2 configuration of a v1 handle", configure(handle, config(kIn)));
  close(handle);
  const int event =
      uapi::request_event(chip, line_b, GPIOHANDLE_REQUEST_INPUT, GPIOEVENT_REQUEST_BOTH_EDGES, "watch");
  say_request("request for a v1 event line", take(chip, {line_b}, config(kIn)));
  say("v1 event line", info_of(line_b));
  say_value("v2 get on a v1 event line", get(event, 1));
  close(event);
}

void flags_and_values() {
  int request = take(chip, {line_a}, config(kOut | kLow, {values(1, 1)}));
  say("active-low output", info_of(line_a));
  say_value("its value", get(request, 1));
  close(request);
  request = take(chip, {line_a}, config(0));
  say("then taken as it is", info_of(line_a));
  say_value("its level", get(request, 1));
  say_outcome("set of an output taken as it is", set(request, 1, 1));
  say_value("its level then", get(request, 1));
  close(request);
  request = take(chip, {line_a}, config(kOut | kDrain));
  say("open drain output", info_of(line_a));
  say_value("driven low", get(request, 1));
  say_outcome("let go", set(request, 1, 1));
  say_outcome("driven again", set(request, 0, 1));
  say_value("low again", get(request, 1));
  close(request);
  request = take(chip, {line_a}, config(kOut | kSource, {values(1, 1)}));
  say("open source output", info_of(line_a));
  say_value("driven high", get(request, 1));
  close(request);
  request = take(chip, {line_a}, config(kIn | kUp));
  say("input pulled up", info_of(line_a));
  say_outcome("set on an input", set(request, 1, 1));
  close(request);
  request = take(chip, {line_a}, config(kIn | kNoBias), "");
  say("owner without a name", info_of(line_a));
  close(request);
  request = take(chip, {line_a}, config(kIn), "0123456789012345678901234567890123456789");
  say("owner with a long name", info_of(line_a));
  close(request);
}

void reconfiguration() {
  const int request = take(chip, {line_a, line_b}, config(kIn));
  say_outcome("configure as outputs", configure(request, config(kOut, {values(1, 3)})));
  say_value("levels", get(request, 3));
  say_outcome("the second as active-low output",
              configure(request, config(kOut, {flags(kOut | kLow, 2), values(2, 2)})));
  say("first", info_of(line_a));
  say("second", info_of(line_b));
  say_value("values", get(request, 3));
  say_outcome("without direction", configure(request, config(kLow)));
  say("first", info_of(line_a));
  say("second", info_of(line_b));
  say_outcome("with input and output", configure(request, config(kIn | kOut)));
  gpio_v2_line_config padded = config(kIn);
  padded.padding[1] = 1;
  say_outcome("with padding", configure(request, padded));
  say("first", info_of(line_a));
  say_outcome("the first as pulled-down input with edges",
              configure(request, config(0, {flags(kIn | kDown | kFalling, 1), debounce_us(500, 1)})));
  say("first", info_of(line_a));
  say("second", info_of(line_b));
  say_outcome("set of the second", set(request, 1, 2));
  say_outcome("set of both", set(request, 3, 3));
  say_outcome("inputs", configure(request, config(kIn)));
  say("first", info_of(line_a));
  say_outcome("outputs again", configure(request, config(kOut)));
  say_value("levels", get(request, 3));
  close(request);
}

void lifetimes(const char* device) {
  int request = take(chip, {line_a}, config(kOut));
  const int copy = dup(request);
  close(request);
  say_request("request while a copy is open", take(chip, {line_a}, config(kIn)));
  say_outcome("set through the copy", set(copy, 1, 1));
  say_value("level through the copy", get(copy, 1));
  close(copy);
  say_request("request after the copy closed", take(chip, {line_a}, config(kIn)));
  const int other = uapi::open_chip(device);
  request = take(other, {line_a}, config(kOut));
  close(other);
  say_outcome("set after the chip was closed", set(request, 1, 1));
  const pid_t child = fork();
  if (child == 0) {
    set(request, 0, 1);
    pause();
  }
  for (int i = 0; i < 1000 && get(request, 1) != 0; ++i) usleep(1000);
  say_value("level set by a child", get(request, 1));
  close(request);
  say_request("request while a child has it", take(chip, {line_a}, config(kIn)));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  say_request("request after the child was killed", take(chip, {line_a}, config(kIn)));
  const int busy = take(chip, {line_b}, config(kIn));
  say_request("a free and a taken line", take(chip, {line_a, line_b}, config(kOut, {values(3, 3)})));
  say("the free one was driven and released", info_of(line_a));
  close(busy);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "usage: kernel_calls_v2 DEVICE LINE_A LINE_B LINE_C ANSWERS\n");
    return 2;
  }
  line_a = static_cast<unsigned>(std::atoi(argv[2]));
  line_b = static_cast<unsigned>(std::atoi(argv[3]));
  line_c = static_cast<unsigned>(std::atoi(argv[4]));
  chip = uapi::open_chip(argv[1]);
  if (chip < 0) {
    std::fprintf(stderr, "kernel_calls_v2: %s: %s\n", argv[1], strerror(-chip));
    return 1;
  }
  std::setvbuf(stdout, nullptr, _IONBF, 0);  // a forked child has nothing left to print
  chip_calls();
  request_refusals();
  attribute_refusals();
  outputs();
  mixed_lines();
  flags_and_values();
  reconfiguration();
  lifetimes(argv[1]);
  watch_lines(argv[1]);
  drive_edges(argv[5]);
}
