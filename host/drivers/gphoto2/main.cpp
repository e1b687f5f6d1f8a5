// strobe-camera-gphoto2: the driver of DSLRs and mirrorless cameras, started by strobe.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

#include "host/drivers/gphoto2/driver.hpp"

namespace {

constexpr rlim_t kMaxMemory = rlim_t{4} << 30;
constexpr rlim_t kMaxFile = rlim_t{1} << 30;

/// Whatever a camera says, or what plays one on the network.
void limit_damage() {
  const rlimit memory{kMaxMemory, kMaxMemory}, file{kMaxFile, kMaxFile};
  setrlimit(RLIMIT_AS, &memory);
  setrlimit(RLIMIT_FSIZE, &file);
  std::signal(SIGXFSZ, SIG_IGN);  // the write fails
}

}  // namespace

int main() {
  limit_damage();
  std::signal(SIGPIPE, SIG_IGN);
  // libgphoto2 complains of each try to reach a camera that is away; what concerns a person is an event.
  if (std::freopen("/dev/null", "w", stderr) == nullptr) return 1;
  // Away from descriptor 0, which libgphoto2 closes (gphoto_camera.cpp).
  const int input = fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  strobe::gphoto2::Driver(input, STDOUT_FILENO).run();
  return 0;
}
