#include <fmt/format.h>
#include <sys/syscall.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "tests/campaigns/ends.hpp"

namespace strobe::ends {
namespace {

/// In the order of FaultKind: how often of 100, and in words.
const std::vector<int> kWeights{40, 6, 8, 8, 12, 14, 2, 3, 2, 2, 3};
constexpr std::array<const char*, 11> kFaults{"a signal",
                                              "stopped",
                                              "a thread stands still",
                                              "a thread ends",
                                              "a descriptor is closed",
                                              "",
                                              "no more descriptors",
                                              "no file may grow",
                                              "no more memory",
                                              "no real-time CPU",
                                              "the chip is removed"};
constexpr std::array<const char*, 6> kMoments{"at rest",    "armed", "trigger on",
                                              "shutter on", "flash", "shutter off"};
constexpr std::array<const char*, 3> kVictims{"worker", "guardian", "both"};

struct Call {
  const char* name;
  int number;
};
#define CALL(name) \
  Call { #name, SYS_##name }
// What the firmware's threads use while they work; exit(2) and rt_sigreturn(2) cannot fail.
constexpr std::array kCalls{CALL(read),
                            CALL(write),
                            CALL(pwrite64),
                            CALL(fdatasync),
                            CALL(fallocate),
                            CALL(ftruncate),
                            CALL(openat),
                            CALL(ioctl),
                            CALL(sendto),
                            CALL(sendmsg),
                            CALL(recvmsg),
                            CALL(ppoll),
#ifdef SYS_poll  // newer architectures have ppoll(2) only
                            CALL(poll),
#endif
                            CALL(clock_nanosleep),
                            CALL(futex),
                            CALL(mmap),
                            CALL(munmap),
                            CALL(kill),
                            CALL(wait4),
                            CALL(rt_sigtimedwait)};
#undef CALL
constexpr std::array kErrors{EIO, ENOSPC, EINTR, EAGAIN, ENOMEM, EBADF, EPERM};

std::string signal_words(int number) {
  const char* const abbreviation = sigabbrev_np(number);
  return abbreviation == nullptr ? fmt::format("signal {}", number) : fmt::format("SIG{}", abbreviation);
}

const char* victim_of(const Trial& trial) {
  return trial.fault == FaultKind::removed_chip ? "chip" : kVictims[static_cast<std::size_t>(trial.victim)];
}

/// Where one process must be left to see to the outputs.
bool of_one_process(const Trial& trial) {
  return trial.fault == FaultKind::stop || trial.fault == FaultKind::held_thread ||
         (trial.fault == FaultKind::signal && trial.argument == SIGSTOP);
}

}  // namespace

FailingCall failing_call(int argument) {
  const auto k = static_cast<std::size_t>(argument);
  const Call& call = kCalls[k % kCalls.size()];
  return {call.name, call.number, kErrors[k / kCalls.size() % kErrors.size()]};
}

std::string FailingCall::words() const { return fmt::format("{} {}", name, strerrorname_np(error)); }

Trial drawn(campaigns::Draws draws) {
  Trial trial;
  trial.fault = static_cast<FaultKind>(draws.weighted(kWeights));
  trial.argument = trial.fault == FaultKind::signal ? draws.between(1, 64) : draws.between(0, 999);
  trial.victim = static_cast<Victim>(draws.between(0, 2));
  if (of_one_process(trial) && trial.victim == Victim::both) trial.victim = Victim::worker;
  // Most of a shot is its train.
  trial.moment = static_cast<Moment>(draws.weighted({1, 1, 2, 2, 6, 1}));
  trial.nth = trial.moment == Moment::flash ? draws.between(1, 40) : 1;
  trial.delay_us = draws.between(0, 6000);
  // A chip that is removed and keeps its lines is beyond every program's reach.
  trial.keeps = draws.between(0, 3) != 0 && trial.fault != FaultKind::removed_chip;
  return trial;
}

const char* name(Moment moment) { return kMoments[static_cast<std::size_t>(moment)]; }

std::string family(const Trial& trial) {
  std::string fault = kFaults[static_cast<std::size_t>(trial.fault)];
  if (trial.fault == FaultKind::failing_call)
    fault = fmt::format("{} fails", failing_call(trial.argument).name);
  return fmt::format("{}, {}", victim_of(trial), fault);
}

std::string describe_fault(const Trial& trial) {
  if (trial.fault == FaultKind::signal)
    return fmt::format("{}, {}", victim_of(trial), signal_words(trial.argument));
  if (trial.fault == FaultKind::failing_call)
    return fmt::format("{}, {} fails", victim_of(trial), failing_call(trial.argument).words());
  return family(trial);
}

std::string describe(const Trial& trial) {
  std::string moment = name(trial.moment);
  if (trial.moment == Moment::flash) moment += fmt::format(" {}", trial.nth);
  return fmt::format("{}, {} + {} us, chip {}", describe_fault(trial), moment, trial.delay_us,
                     trial.keeps ? "keeps" : "lets go");
}

}  // namespace strobe::ends
