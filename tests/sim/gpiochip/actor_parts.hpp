// What the actors of both uAPI versions are made of.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/sim/gpiochip/conformance/uapi_client.hpp"

namespace actor {

inline constexpr const char* kDevice = "/dev/gpiochip0";

[[noreturn]] inline void give_up(const char* what, int error) {
  std::printf("%s: %s\n", what, strerrorname_np(-error));
  std::exit(1);
}

inline int must(const char* what, int result) {
  if (result < 0) give_up(what, result);
  return result;
}

inline int chip() { return must("open", uapi::open_chip(kDevice)); }

/// Of a list such as "0,1,5".
inline std::vector<unsigned> numbers(const std::string& list) {
  std::vector<unsigned> found;
  for (std::size_t at = 0; at < list.size();) {
    std::size_t length = 0;
    found.push_back(static_cast<unsigned>(std::stoul(list.substr(at), &length)));
    at += length + 1;
  }
  return found;
}

}  // namespace actor
