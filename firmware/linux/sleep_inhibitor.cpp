#include "firmware/linux/sleep_inhibitor.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

namespace strobe::firmware {

namespace {

/// As errno. Its standard input is `in`, nobody hears it; it takes and ignores signals as any program does.
int spawn(const std::array<const char*, 7>& words, int in, pid_t& child) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in, STDIN_FILENO);
  for (const int out : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, out, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&attributes, &signals);
  for (const int ignored : {SIGTSTP, SIGTTIN, SIGTTOU, SIGPIPE, SIGXFSZ}) sigaddset(&signals, ignored);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  const int error =
      posix_spawnp(&child, words[0], &files, &attributes, const_cast<char* const*>(words.data()), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

}  // namespace

void SleepInhibitor::turn(bool wanted, MonoTime now) {
  if (wanted) wanted_until_ = now + kLinger;
  look_after_child();
  if (now >= wanted_until_) return let_go();
  if (child_ == 0 && !gave_up_) start();
}

void SleepInhibitor::start() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return give_up(std::strerror(errno));
  const int error = spawn({"systemd-inhibit", "--what=sleep:handle-lid-switch", "--who=strobed",
                           "--why=a shot may be under way", "--mode=block", "cat", nullptr},
                          ends[0], child_);
  close(ends[0]);
  lifeline_ = ends[1];
  if (error == 0) return;
  child_ = 0;
  let_go();
  give_up(std::string("systemd-inhibit: ") + std::strerror(error));
}

void SleepInhibitor::let_go() {
  if (lifeline_ >= 0) close(lifeline_);
  lifeline_ = -1;
}

/// One that ended by itself had no lock; one that somebody killed is followed by another.
void SleepInhibitor::look_after_child() {
  int status = 0;
  if (child_ == 0 || waitpid(child_, &status, WNOHANG) != child_) return;
  child_ = 0;
  const bool wanted = lifeline_ >= 0;
  let_go();
  if (wanted && WIFEXITED(status))
    give_up("systemd-inhibit ended with status " + std::to_string(WEXITSTATUS(status)));
}

void SleepInhibitor::give_up(const std::string& why) {
  gave_up_ = true;
  say_("warning: nothing keeps this computer from going to sleep while a shot is under way: " + why);
}

}  // namespace strobe::firmware
