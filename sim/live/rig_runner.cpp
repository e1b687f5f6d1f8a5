#include "sim/live/rig_runner.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>

namespace strobe::sim {

namespace {

constexpr Duration kLongestWait = milliseconds(100);  // latency of stop()
constexpr Duration kDriveTooLate = milliseconds(3);   // a sensor edge as late as the next flash may confuse
constexpr int kPriority = 40;                         // below the program under test, above everything else

void become_prompt() {
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  // Without the permission the rig only reacts later; stamps stay exact and late drives mark the shot.
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters));
}

}  // namespace

RigRunner::RigRunner(Chip chip, const Scene& scene, std::uint64_t seed, ExposureStore& exposure_store,
                     bool record_changes, const Model& model)
    : chip_(std::move(chip)),
      rig_(scene, seed, chip_.now(), model),
      exposure_store_(exposure_store),
      record_changes_(record_changes),
      cursor_(chip_.cursor_now()) {}

RigRunner::~RigRunner() { stop(); }

void RigRunner::start() {
  thread_ = std::thread([this] { run(stopping_); });
}

void RigRunner::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  chip_.begin_time();  // its wait must end where no program was ever started
  thread_.join();
}

void RigRunner::take_changes(MonoTime deadline) {
  fresh_.clear();
  if (!chip_.wait_changes(cursor_, deadline, fresh_)) rig_.mark_overrun();
  if (listener_ && !fresh_.empty()) listener_(fresh_);
  for (const Change& change : fresh_) {
    const auto line = rig_line(change.line);
    if (line && change.cause != Cause::drive) rig_.line_changed(*line, change.level, change.time);
  }
  if (record_changes_) recorded_.insert(recorded_.end(), fresh_.begin(), fresh_.end());
}

void RigRunner::give_drives(MonoTime now) {
  drives_.clear();
  exposures_.clear();
  rig_.collect(now, drives_, exposures_);
  for (const Drive& drive : drives_) {
    chip_.drive(static_cast<std::uint32_t>(drive.line), drive.level, drive.at);
    if (now - drive.at > kDriveTooLate) rig_.mark_overrun();
  }
  for (Exposure& exposure : exposures_) exposure_store_.add(std::move(exposure));
}

void RigRunner::run(const std::atomic<bool>& stopping) {
  become_prompt();
  while (!stopping) {
    take_changes(std::min(rig_.next_due(), chip_.now() + kLongestWait));
    give_drives(chip_.now());
    exposure_store_.set_exposing(rig_.exposing_since());
  }
  take_changes(chip_.now());
  exposures_.clear();
  rig_.finish(chip_.now(), exposures_);
  for (Exposure& exposure : exposures_) exposure_store_.add(std::move(exposure));
  exposure_store_.set_exposing(std::nullopt);
}

}  // namespace strobe::sim
