// kernel_calls DEVICE A B: the GPIO uAPI by bare system calls, answer by answer.
//
// Runs on the simulated chip and on a real kernel's, whose answers are compared with the same expected file:
// so the simulation cannot drift from the kernel. A and B are offsets of free lines to which nothing is
// connected, and which are inputs at first. Behaviours that depend on the hardware (the level of a floating
// input) are left out.
#include <signal.h>
#include <sys/wait.h>

#include <cstdlib>

#include "tests/sim/gpiochip/conformance/answers.hpp"

namespace {

using namespace answers;

constexpr std::uint32_t kIn = GPIOHANDLE_REQUEST_INPUT;
constexpr std::uint32_t kOut = GPIOHANDLE_REQUEST_OUTPUT;
constexpr std::uint32_t kLow = GPIOHANDLE_REQUEST_ACTIVE_LOW;
constexpr std::uint32_t kDrain = GPIOHANDLE_REQUEST_OPEN_DRAIN;
constexpr std::uint32_t kSource = GPIOHANDLE_REQUEST_OPEN_SOURCE;
constexpr std::uint32_t kUp = GPIOHANDLE_REQUEST_BIAS_PULL_UP;
constexpr std::uint32_t kDown = GPIOHANDLE_REQUEST_BIAS_PULL_DOWN;
constexpr std::uint32_t kNoBias = GPIOHANDLE_REQUEST_BIAS_DISABLE;
constexpr std::uint32_t kBoth = GPIOEVENT_REQUEST_BOTH_EDGES;

int chip = -1;
unsigned line_a = 0;
unsigned line_b = 0;

std::string info_of(unsigned line) {
  gpioline_info info{};
  const int result = uapi::info(chip, line, info);
  if (result < 0) return named(result);
  std::string text;
  const struct {
    std::uint32_t flag;
    const char* name;
  } flags[] = {{GPIOLINE_FLAG_KERNEL, "used"},
               {GPIOLINE_FLAG_IS_OUT, "out"},
               {GPIOLINE_FLAG_ACTIVE_LOW, "active-low"},
               {GPIOLINE_FLAG_OPEN_DRAIN, "open-drain"},
               {GPIOLINE_FLAG_OPEN_SOURCE, "open-source"},
               {GPIOLINE_FLAG_BIAS_PULL_UP, "pull-up"},
               {GPIOLINE_FLAG_BIAS_PULL_DOWN, "pull-down"},
               {GPIOLINE_FLAG_BIAS_DISABLE, "bias-disable"}};
  for (const auto& flag : flags)
    if ((info.flags & flag.flag) != 0) text += std::string(flag.name) + " ";
  return text + "consumer '" + info.consumer + "'";
}

void chip_calls(const char* device) {
  say("line is an input at first", info_of(line_a));
  say("info of a line past the last", info_of(1000));
  say_outcome("unknown call on the chip", with_null(chip, kUnknownRequest));
  say_outcome("terminal call on the chip", terminal_call(chip));
  gpiohandle_data data{};
  say_outcome("set values on the chip", uapi::outcome(ioctl(chip, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &data)));
  say_outcome("chip info to nowhere", with_null(chip, GPIO_GET_CHIPINFO_IOCTL));
  say_outcome("line info to nowhere", with_null(chip, GPIO_GET_LINEINFO_IOCTL));
  say_outcome("handle request from nowhere", with_null(chip, GPIO_GET_LINEHANDLE_IOCTL));
  say_outcome("event request from nowhere", with_null(chip, GPIO_GET_LINEEVENT_IOCTL));
  const int other = uapi::open_chip(device, O_RDWR | O_NONBLOCK);
  say_outcome("read of the chip without waiting", read_bytes(other, 104));
  say("poll of the chip", polled(other, POLLIN));
  close(other);
  const int reader = uapi::open_chip(device, O_RDONLY);
  say_request("request through a read-only chip", uapi::request_lines(reader, {line_a}, kIn));
  close(reader);
  say_outcome("chip info on another device", [] {
    const int null = open("/dev/null", O_RDWR);
    gpiochip_info info{};
    const int result = uapi::outcome(ioctl(null, GPIO_GET_CHIPINFO_IOCTL, &info));
    close(null);
    return result;
  }());
}

void handle_refusals() {
  const auto request = [](std::uint32_t flags) { return uapi::request_lines(chip, {line_a}, flags); };
  say_request("handle of no lines", uapi::request_lines(chip, {}, kIn));
  say_request("handle of 65 lines", uapi::request_lines(chip, std::vector<unsigned>(65, line_a), kIn));
  say_request("handle of a line past the last", uapi::request_lines(chip, {1000}, kIn));
  say_request("handle of one line twice", uapi::request_lines(chip, {line_a, line_a}, kIn));
  say_request("handle: input and output", request(kIn | kOut));
  say_request("handle: unknown flag", request(kIn | 1U << 20));
  say_request("handle: open drain input", request(kIn | kDrain));
  say_request("handle: open source as it is", request(kSource));
  say_request("handle: open drain and open source", request(kOut | kDrain | kSource));
  say_request("handle: bias without direction", request(kUp));
  say_request("handle: pull up and down", request(kIn | kUp | kDown));
  say_request("handle: pull up and disabled", request(kIn | kUp | kNoBias));
  say("line after refusals", info_of(line_a));
}

void event_refusals() {
  const auto request = [](std::uint32_t flags, std::uint32_t edges) {
    return uapi::request_event(chip, line_a, flags, edges);
  };
  say_request("event: line past the last", uapi::request_event(chip, 1000, kIn, kBoth));
  say_request("event: output", request(kOut, kBoth));
  say_request("event: open drain", request(kIn | kDrain, kBoth));
  say_request("event: open source", request(kIn | kSource, kBoth));
  say_request("event: unknown flag", request(kIn | 1U << 20, kBoth));
  say_request("event: unknown edge", request(kIn, 1U << 5));
  say_request("event: pull up and down", request(kIn | kUp | kDown, kBoth));
}

void output_handle() {
  const int handle = uapi::request_lines(chip, {line_a, line_b}, kOut, {1, 0}, "conform");
  say_outcome("output handle", handle);
  say("its access mode", access_mode(handle));
  say("it closes on exec", (fcntl(handle, F_GETFD) & FD_CLOEXEC) != 0 ? "yes" : "no");
  say("line is taken", info_of(line_a));
  say_value("first level as asked", uapi::get(handle, 0));
  say_value("second level as asked", uapi::get(handle, 1));
  say_outcome("set", uapi::set(handle, {0, 1}));
  say_value("first level after set", uapi::get(handle, 0));
  say_value("second level after set", uapi::get(handle, 1));
  say_outcome("set to 7", uapi::set(handle, {7, 0}));
  say_value("which is 1", uapi::get(handle, 0));
  say_request("second handle on a taken line", uapi::request_lines(chip, {line_a}, kIn));
  say_request("event on a taken line", uapi::request_event(chip, line_a, kIn, kBoth));
  say_outcome("unknown call on a handle", with_null(handle, kUnknownRequest));
  say_outcome("chip info on a handle", with_null(handle, GPIO_GET_CHIPINFO_IOCTL));
  say_outcome("terminal call on a handle", terminal_call(handle));
  say_outcome("set from nowhere", with_null(handle, GPIOHANDLE_SET_LINE_VALUES_IOCTL));
  say_outcome("get to nowhere", with_null(handle, GPIOHANDLE_GET_LINE_VALUES_IOCTL));
  say_outcome("configuration from nowhere", with_null(handle, GPIOHANDLE_SET_CONFIG_IOCTL));
  say_outcome("read of a handle", read_bytes(handle, 16));
  say_outcome("write to a handle", write_bytes(handle, 16));
  say("poll of a handle", polled(handle, POLLIN | POLLOUT));
  close(handle);
  say("line after release", info_of(line_a));
  say_outcome("set on a closed handle", uapi::set(handle, {1, 1}));
}

void flags_and_values() {
  int handle = uapi::request_lines(chip, {line_a}, kOut | kLow, {1});
  say("active-low output", info_of(line_a));
  say_value("its value", uapi::get(handle));
  close(handle);
  handle = uapi::request_lines(chip, {line_a}, 0);
  say("then taken as it is", info_of(line_a));
  say_value("its level", uapi::get(handle));
  say_outcome("set of an output taken as it is", uapi::set(handle, {1}));
  say_value("its level then", uapi::get(handle));
  close(handle);
  handle = uapi::request_lines(chip, {line_a}, kOut | kDrain, {0});
  say("open drain output", info_of(line_a));
  say_value("driven low", uapi::get(handle));
  say_outcome("let go", uapi::set(handle, {1}));
  say("still an output", info_of(line_a));
  say_outcome("driven again", uapi::set(handle, {0}));
  say_value("low again", uapi::get(handle));
  close(handle);
  handle = uapi::request_lines(chip, {line_a}, kOut | kDrain, {1});
  say("open drain let go at first", info_of(line_a));
  close(handle);
  handle = uapi::request_lines(chip, {line_a}, kOut | kSource, {1});
  say("open source output", info_of(line_a));
  say_value("driven high", uapi::get(handle));
  close(handle);
  handle = uapi::request_lines(chip, {line_a}, kIn | kUp);
  say("input pulled up", info_of(line_a));
  say_outcome("set on an input", uapi::set(handle, {1}));
  close(handle);
  handle = uapi::request_lines(chip, {line_a}, kIn | kNoBias, {}, "");
  say("owner without a name", info_of(line_a));
  close(handle);
  handle = uapi::request_lines(chip, {line_a}, kIn, {}, "0123456789012345678901234567890123456789");
  say("owner with a long name", info_of(line_a));
  close(handle);
}

void reconfiguration() {
  const int handle = uapi::request_lines(chip, {line_a}, kIn);
  say_outcome("configure as output", uapi::configure(handle, kOut, {1}));
  say_value("its level", uapi::get(handle));
  say_outcome("configure as active-low output", uapi::configure(handle, kOut | kLow, {1}));
  say("line", info_of(line_a));
  say_value("its value", uapi::get(handle));
  say_outcome("configure with input and output", uapi::configure(handle, kIn | kOut));
  say_outcome("configure without direction", uapi::configure(handle, 0));
  say("line", info_of(line_a));
  say_outcome("configure as pulled-down input", uapi::configure(handle, kIn | kDown));
  say("line", info_of(line_a));
  say_outcome("set on it", uapi::set(handle, {1}));
  close(handle);
}

void event_handle() {
  const int event = uapi::request_event(chip, line_a, kIn | kLow, kBoth, "watch");
  say_outcome("event descriptor", event);
  say("its access mode", access_mode(event));
  say("it closes on exec", (fcntl(event, F_GETFD) & FD_CLOEXEC) != 0 ? "yes" : "no");
  say("line", info_of(line_a));
  gpiohandle_data data{};
  say_outcome("get on an event line", uapi::outcome(ioctl(event, GPIOHANDLE_GET_LINE_VALUES_IOCTL, &data)));
  say_outcome("set on an event line", uapi::set(event, {1}));
  say_outcome("configure an event line", uapi::configure(event, kIn));
  say_outcome("unknown call on an event line", with_null(event, kUnknownRequest));
  say_outcome("terminal call on an event line", terminal_call(event));
  int waiting = 0;
  say_outcome("count of waiting bytes", uapi::outcome(ioctl(event, FIONREAD, &waiting)));
  say("poll of an event line", polled(event, POLLIN));
  fcntl(event, F_SETFL, O_NONBLOCK);
  say_outcome("read without waiting", read_bytes(event, 16));
  say_outcome("read of half an event", read_bytes(event, 8));
  say_outcome("read of nothing", read_bytes(event, 0));
  say_outcome("write to an event line", write_bytes(event, 16));
  say_request("handle on an event line", uapi::request_lines(chip, {line_a}, kIn));
  close(event);
  say("line after release", info_of(line_a));
}

void lifetimes(const char* device) {
  int handle = uapi::request_lines(chip, {line_a}, kOut, {0});
  const int copy = dup(handle);
  close(handle);
  say_request("request while a copy is open", uapi::request_lines(chip, {line_a}, kIn));
  say_outcome("set through the copy", uapi::set(copy, {1}));
  say_value("level through the copy", uapi::get(copy));
  close(copy);
  say_request("request after the copy closed", uapi::request_lines(chip, {line_a}, kIn));

  const int other = uapi::open_chip(device);
  handle = uapi::request_lines(other, {line_a}, kOut, {0});
  close(other);
  say_outcome("set after the chip was closed", uapi::set(handle, {1}));
  const int second = uapi::request_lines(chip, {line_b}, kOut, {0});
  dup2(second, handle);
  say_request("request after dup2 over the handle", uapi::request_lines(chip, {line_a}, kIn));
  say_outcome("set through dup2's copy", uapi::set(handle, {1}));
  say_value("level of the other line", uapi::get(second));
  close(handle);
  close(second);
}

void processes() {
  const int handle = uapi::request_lines(chip, {line_a}, kOut, {0});
  const pid_t child = fork();
  if (child == 0) {
    uapi::set(handle, {1});
    pause();
  }
  for (int i = 0; i < 1000 && uapi::get(handle) == 0; ++i) usleep(1000);
  say_value("level set by a child", uapi::get(handle));
  close(handle);
  say_request("request while a child has it", uapi::request_lines(chip, {line_a}, kIn));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  say_request("request after the child was killed", uapi::request_lines(chip, {line_a}, kIn));
}

void half_a_request() {
  const int busy = uapi::request_lines(chip, {line_b}, kIn);
  say_request("handle of a free and a taken line", uapi::request_lines(chip, {line_a, line_b}, kOut, {1, 1}));
  say("the free one was driven and released", info_of(line_a));
  close(busy);
  const int handle = uapi::request_lines(chip, {line_a}, 0);
  say_value("its level", uapi::get(handle));
  close(handle);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: conformance DEVICE LINE_A LINE_B\n");
    return 2;
  }
  line_a = static_cast<unsigned>(std::atoi(argv[2]));
  line_b = static_cast<unsigned>(std::atoi(argv[3]));
  chip = uapi::open_chip(argv[1]);
  if (chip < 0) {
    std::fprintf(stderr, "conformance: %s: %s\n", argv[1], strerror(-chip));
    return 1;
  }
  std::setvbuf(stdout, nullptr, _IONBF, 0);  // a forked child has nothing left to print
  chip_calls(argv[1]);
  handle_refusals();
  event_refusals();
  output_handle();
  flags_and_values();
  reconfiguration();
  event_handle();
  lifetimes(argv[1]);
  processes();
  half_a_request();
}
