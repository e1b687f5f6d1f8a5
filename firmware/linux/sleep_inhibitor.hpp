// Keeps the machine awake while a shot may come: a lock of logind's on sleep and lid, held by a
// systemd-inhibit(1) that waits for the end of a pipe of this process's, and so ends with it, whatever ends
// it. Not real-time; one thread's.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>

#include "common/units/time.hpp"

namespace strobe::firmware {

class SleepInhibitor {
 public:
  /// Held for so long after the last wish, so that the shots of a series share one lock.
  static constexpr Duration kLinger = milliseconds(5'000);

  /// say: a line for a person, once, if the lock cannot be had.
  explicit SleepInhibitor(std::function<void(const std::string&)> say) : say_(std::move(say)) {}
  SleepInhibitor(const SleepInhibitor&) = delete;
  SleepInhibitor& operator=(const SleepInhibitor&) = delete;
  ~SleepInhibitor() { let_go(); }

  /// At each change of the wish, and once a second or so besides. Waits for nothing but the start of the
  /// program.
  void turn(bool wanted, MonoTime now);

 private:
  void start();
  void let_go();
  void look_after_child();
  void give_up(const std::string& why);

  std::function<void(const std::string&)> say_;
  MonoTime wanted_until_{};
  pid_t child_ = 0;    ///< 0: none
  int lifeline_ = -1;  ///< the pipe's end that keeps the child; -1: it is to end
  bool gave_up_ = false;
};

}  // namespace strobe::firmware
