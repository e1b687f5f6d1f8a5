// gpiochip_host DIR: holds the rig's 16-line chip in DIR until SIGINT or SIGTERM. For trying programs by
// hand:
//   gpiochip_host /dev/shm/chip &
//   STROBE_GPIOCHIP_DIR=/dev/shm/chip LD_PRELOAD=build/release/lib/libstrobe-gpiochip.so gpioinfo
#include <signal.h>

#include <cstdio>

#include "tests/sim/gpiochip/standard_chip.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: gpiochip_host DIR\n");
    return 2;
  }
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGINT);
  sigaddset(&ending, SIGTERM);
  sigprocmask(SIG_BLOCK, &ending, nullptr);
  const auto chip = strobe::sim::Chip::create(argv[1], strobe::sim::standard_chip());
  if (!chip) {
    std::fprintf(stderr, "gpiochip_host: %s\n", chip.error().message.c_str());
    return 1;
  }
  const auto library = strobe::sim::preload_path();
  std::printf("STROBE_GPIOCHIP_DIR=%s LD_PRELOAD=%s\n", chip->dir().c_str(),
              library ? library->c_str() : library.error().message.c_str());
  std::fflush(stdout);
  int received = 0;
  sigwait(&ending, &received);
}
