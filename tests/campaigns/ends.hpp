// One end of strobed: a fault that befalls its worker, its guardian or both at a moment of a shot, drawn from a
// seed, and what an observer outside saw of it: the chip's lines and the journal. Real time; one thread.
#pragma once

#include <string>

#include "tests/campaigns/campaign.hpp"

namespace strobe::ends {

enum class Victim { worker, guardian, both };

enum class FaultKind {
  signal,        ///< argument: its number
  stop,          ///< SIGSTOP, until the trial's end; of one process only
  held_thread,   ///< one thread stands still, until the trial's end; argument: which, modulo their number
  ended_thread,  ///< one thread ends; argument: which, modulo their number
  closed_file,   ///< a descriptor is closed; argument: which, modulo their number, standard ones not counted
  failing_call,  ///< a system call fails from now on; argument: which, and the error
  no_descriptors,  ///< RLIMIT_NOFILE 0
  no_file_growth,  ///< RLIMIT_FSIZE 0, as a full disk: writes end with EFBIG, a signal is sent
  no_memory,       ///< RLIMIT_AS 0: no more memory can be mapped
  no_real_time,    ///< RLIMIT_RTTIME 1: the kernel ends a process that takes CPU at real-time priority
  removed_chip,    ///< somebody pulls its cable
};

enum class Moment {
  at_rest,
  armed,
  trigger_on,   ///< the trigger's line has risen
  shutter_on,   ///< the shutter's line has risen
  flash,        ///< STROBE_A has risen for the nth time
  shutter_off,  ///< the shutter's line has fallen
};

struct Trial {
  Victim victim = Victim::worker;
  FaultKind fault = FaultKind::signal;
  int argument = 0;
  Moment moment = Moment::at_rest;
  int nth = 1;        ///< of Moment::flash
  int delay_us = 0;   ///< from the moment to the fault
  bool keeps = true;  ///< the chip keeps a dead process's lines; false: it lets them go
};

Trial drawn(campaigns::Draws draws);

/// "worker, SIGSEGV, flash 17 + 230 us, chip keeps".
std::string describe(const Trial& trial);
/// "worker, SIGSEGV", "guardian, write EIO fails".
std::string describe_fault(const Trial& trial);
const char* name(Moment moment);

/// A system call that a trial may let fail, and how.
struct FailingCall {
  const char* name = "";
  int number = 0;
  int error = 0;
  std::string words() const;  ///< "write EIO"
};
/// argument: 0 or more.
FailingCall failing_call(int argument);

/// Starts a rig, does it, ends the rig. Counts what was "not possible" for lack of rights or of a shot that reached the
/// moment, "ended strobed", and "late": an output was active for longer after it had to be inactive than is stated for
/// this fault. std::runtime_error if the rig does not come up.
campaigns::Verdict run_trial(const Trial& trial);

/// The same up to three times while its outputs are inactive, but late: a virtual machine's host stands still
/// for 10-170 ms in 1-2 % of the time. A violation if they are in the end.
campaigns::Verdict run_trial_despite_freezes(const Trial& trial);

/// What a table counts it under: "worker, a signal", "guardian, write fails".
std::string family(const Trial& trial);

}  // namespace strobe::ends
