// How the conformance programs print what a chip answers.
#pragma once

#include <poll.h>
#include <termios.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/sim/gpiochip/conformance/uapi_client.hpp"

namespace answers {

constexpr unsigned long kUnknownRequest = _IO(0xB4, 0x7f);

/// Errors by name; descriptors and other successes as "ok".
inline std::string named(int result) { return result < 0 ? strerrorname_np(-result) : "ok"; }

inline void say(const char* what, const std::string& answer) {
  std::printf("%s: %s\n", what, answer.c_str());
}
inline void say_outcome(const char* what, int result) { say(what, named(result)); }
inline void say_value(const char* what, int result) {
  say(what, result < 0 ? named(result) : std::to_string(result));
}

/// For requests: names the outcome and lets go again.
inline void say_request(const char* what, int descriptor) {
  say_outcome(what, descriptor);
  if (descriptor >= 0) close(descriptor);
}

/// Asks whoever reads these lines to do something to the chip, and waits until they have: then they close the fifo.
inline void please(const char* fifo_path, const char* what) {
  std::printf("please: %s\n", what);
  const int fifo = open(fifo_path, O_RDONLY);  // once somebody has it open for writing
  char rest[64];
  while (fifo >= 0 && read(fifo, rest, sizeof rest) > 0) continue;
  if (fifo < 0) std::exit(1);
  close(fifo);
}

inline std::string access_mode(int descriptor) {
  const int mode = fcntl(descriptor, F_GETFL) & O_ACCMODE;
  return mode == O_RDONLY ? "read-only" : mode == O_RDWR ? "read-write" : "write-only";
}

inline std::string polled(int descriptor, short events, int limit_ms = 0) {
  struct pollfd waiting {
    descriptor, events, 0
  };
  poll(&waiting, 1, limit_ms);
  std::string text;
  if ((waiting.revents & POLLIN) != 0) text += "in ";
  if ((waiting.revents & POLLOUT) != 0) text += "out ";
  if ((waiting.revents & (POLLERR | POLLHUP)) != 0) text += "error ";
  return text.empty() ? "nothing" : text;
}

inline int read_bytes(int descriptor, std::size_t size) {
  char data[1024];
  return uapi::outcome(static_cast<int>(read(descriptor, data, size)));
}
inline int write_bytes(int descriptor, std::size_t size) {
  const char data[256] = {};
  return uapi::outcome(static_cast<int>(write(descriptor, data, size)));
}
inline int terminal_call(int descriptor) {
  struct termios settings {};
  return uapi::outcome(ioctl(descriptor, TCGETS, &settings));
}
inline int with_null(int descriptor, unsigned long request) {
  return uapi::outcome(ioctl(descriptor, request, nullptr));
}

}  // namespace answers
