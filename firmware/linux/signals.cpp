#include "firmware/linux/signals.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <initializer_list>

namespace strobe::firmware {

namespace {

constexpr auto kIgnored = {SIGTSTP, SIGTTIN, SIGTTOU, SIGPIPE, SIGXFSZ};
constexpr auto kFaults = {SIGILL, SIGTRAP, SIGABRT, SIGBUS, SIGFPE, SIGSEGV, SIGSYS};
constexpr auto kHarmless = {SIGCHLD, SIGCONT, SIGURG, SIGWINCH};  // by default

/// The C library keeps the signals below SIGRTMIN to itself and changes nothing of them; strobed does nothing
/// that it needs them for (cancelling threads, changing users), and their default is to end the process.
void ignore_reserved_signals() {
  const std::array<unsigned long, 8> ignore{reinterpret_cast<unsigned long>(SIG_IGN)};  // struct sigaction
  constexpr std::size_t kSigsetSize = 8;                                                // the kernel's
  for (int signal = 32; signal < SIGRTMIN; ++signal)
    syscall(SYS_rt_sigaction, signal, ignore.data(), nullptr, kSigsetSize);
}

void (*call_at_fault)() = nullptr;

/// The default action follows: a fault comes again, and what somebody sent is sent again.
void end_of_fault(int signal) {
  call_at_fault();
  raise(signal);
}

}  // namespace

sigset_t guardian_stop_signals() {
  sigset_t set;
  sigfillset(&set);
  for (const auto& signals : {kIgnored, kHarmless})
    for (const int signal : signals) sigdelset(&set, signal);
  return set;
}

sigset_t worker_stop_signals() {
  sigset_t set = guardian_stop_signals();
  for (const int signal : kFaults) sigdelset(&set, signal);
  return set;
}

void set_signal_policy() {
  for (const int signal : kIgnored) std::signal(signal, SIG_IGN);
  ignore_reserved_signals();
  const sigset_t stops = guardian_stop_signals();
  sigprocmask(SIG_BLOCK, &stops, nullptr);
}

void set_worker_signal_policy(void (*at_fault)()) {
  call_at_fault = at_fault;
  struct sigaction handler {};
  handler.sa_handler = end_of_fault;
  handler.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : kFaults) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler == SIG_DFL) sigaction(signal, &handler, nullptr);
  }
  const sigset_t stops = worker_stop_signals();
  sigprocmask(SIG_SETMASK, &stops, nullptr);
}

}  // namespace strobe::firmware
