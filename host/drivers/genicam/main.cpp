// Industrial cameras of GenICam, by Aravis: host/tether says what is spoken with it.
#include <fmt/format.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "host/drivers/genicam/driver.hpp"
#include "host/tether/driver_channel.hpp"

namespace {

/// What a camera sends must cost this program's life at most.
void limit_memory() {
  constexpr rlim_t kMaxMemory_bytes = rlim_t{4} << 30;
  const rlimit memory{kMaxMemory_bytes, kMaxMemory_bytes};
  setrlimit(RLIMIT_AS, &memory);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
}

}  // namespace

int main() {
  limit_memory();
  // It ends when its input does, not before: the host has the last word.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    strobe::tether::DriverChannel channel;
    strobe::genicam::Driver(channel).run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "strobe-camera-genicam: {}\n", error.what());
    std::_Exit(1);
  }
  // Farewells to cameras that are gone are not waited for.
  std::_Exit(0);
}
