#include "host/drivers/raw/limits.hpp"

#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <string_view>

namespace strobe::raw {

namespace {

// A file of 120 megapixels takes .7 GB and some seconds.
constexpr rlim_t kMaxMemory = rlim_t{2} << 30;
constexpr rlim_t kMaxFile = rlim_t{512} << 20;
constexpr rlim_t kMaxTime_s = 60;

void end(int signal) {
  const std::string_view line = signal == SIGXCPU ? "strobe-raw: decoding takes too long\n"
                                                  : "strobe-raw: the library that decodes it crashed\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
  _exit(1);
}

bool limit(int resource, rlim_t most, rlim_t hard) {
  const rlimit limits{most, hard};
  return setrlimit(static_cast<__rlimit_resource>(resource), &limits) == 0;
}

}  // namespace

bool limit_this_process() {
  struct sigaction action {};
  action.sa_handler = end;
  for (const int signal : {SIGXCPU, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
    sigaction(signal, &action, nullptr);
  signal(SIGXFSZ, SIG_IGN);         // the write then fails
#if !defined(__SANITIZE_ADDRESS__)  // whose shadow alone is larger
  if (!limit(RLIMIT_AS, kMaxMemory, kMaxMemory)) return false;
#endif
  return limit(RLIMIT_CPU, kMaxTime_s, kMaxTime_s + 1) && limit(RLIMIT_FSIZE, kMaxFile, kMaxFile) &&
         limit(RLIMIT_CORE, 0, 0);
}

}  // namespace strobe::raw
