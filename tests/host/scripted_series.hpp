// A series of shots and the firmware that it is fired on, in virtual time.
#pragma once

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "host/session/shot_series.hpp"
#include "tests/support/string_from.hpp"

namespace strobe::host_test {

using namespace host;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

inline constexpr std::int64_t kHost = 0x1234;
inline constexpr std::int64_t kBoot = 77;

/// Dispatches as the firmware's interlock does, and counts what it did.
struct Firmware {
  status_t status{};
  int fired = 0, armed = 0, reset = 0, cleared = 0;
  bool deaf = false;                        // commands are lost
  std::string refuses_fire, refuses_reset;  // why

  Firmware() {
    status.boot_id = kBoot;
    status.key_active = true;
    status.journal_ok = true;
    status.last_shot_id = 3;
  }
  void dispatch(const command_t& command, ShotSeries& series) {
    if (deaf || command.boot_id != status.boot_id) return;
    if (command.kind == command_t::RESET) {
      ++reset;
      if (status.state == status_t::STOPPED && refuses_reset.empty()) status.state = status_t::IDLE;
      if (!refuses_reset.empty()) refuse("RESET: " + refuses_reset, series);
    } else if (command.kind == command_t::ARM && status.state == status_t::IDLE) {
      ++armed;
      status.state = status_t::ARMED;
      status.arm_host_id = command.host_id;
      status.arm_token = 900 + command.command_id;
    } else if (command.kind == command_t::FIRE && command.arm_token == status.arm_token &&
               status.arm_token != 0) {
      status.state = status_t::IDLE;
      status.arm_host_id = status.arm_token = 0;
      if (!refuses_fire.empty()) return refuse("FIRE: " + refuses_fire, series);
      ++fired;
      ++status.last_shot_id;
    } else if (command.kind == command_t::CLEAR) {
      ++cleared;
      status.state = status_t::IDLE;
      status.message.clear();
    }
  }
  event_t event(std::int8_t kind, const std::string& detail = "") {
    event_t event{};
    event.boot_id = status.boot_id;
    event.kind = kind;
    event.sequence = ++status.last_sequence;
    event.detail = detail;
    return event;
  }
  void refuse(const std::string& why, ShotSeries& series) { series.on_event(event(event_t::REFUSED, why)); }
};

struct Play {
  CommandFactory factory{kHost, "anna@desk"};
  Firmware firmware;
  ShotSeries series;
  HostTime now;
  int answered = 0;
  std::deque<std::string> verdicts;  // of the shots to come; empty text: good
  std::string problem;               // of the rejected ones
  bool photograph_missing = false;   // of those
  std::vector<std::string> notifications;
  bool heard = true;

  explicit Play(ShotSeriesSettings settings) : series(std::move(settings), factory) {}

  void turn() {
    now += milliseconds{20};
    series.step(heard ? std::optional(firmware.status) : std::nullopt, now);
    for (const command_t& command : series.take_commands()) firmware.dispatch(command, series);
    for (const std::string& text : series.take_notifications()) notifications.push_back(text);
  }
  void answer() {
    if (firmware.fired == answered) return;
    Shot shot_result;
    shot_result.boot_id = firmware.status.boot_id;
    shot_result.host_id = kHost;
    shot_result.shot_id = firmware.status.last_shot_id;
    if (!verdicts.empty()) {
      if (!verdicts.front().empty()) {
        shot_result.rejected = verdicts.front();
        shot_result.problem = problem;
        if (photograph_missing) shot_result.readout.flags.set(reduction::Flag::no_photograph);
      }
      verdicts.pop_front();
    }
    ++answered;
    series.on_shot_result(shot_result);
  }
  void run(int turns) {
    for (int i = 0; i < turns && !series.finished(); ++i) {
      turn();
      if (i % 10 == 9) answer();
    }
  }
  void turn_until_fired() {
    while (firmware.fired == 0) turn();
  }
  void succeeds(int fired = 1) {
    run(2000);
    CHECK_TRUE(series.succeeded());
    LONGS_EQUAL(fired, firmware.fired);
  }
  void ends(const char* why, int fired = 0) {
    run(2000);
    CHECK_TRUE(series.finished());
    CHECK_FALSE(series.succeeded());
    LONGS_EQUAL(fired, firmware.fired);
    STRCMP_CONTAINS(why, series.blocking_reason().c_str());
  }
  status_t& armed_by_another() {
    firmware.status.state = status_t::ARMED;
    firmware.status.arm_host_id = 999;
    firmware.status.arm_token = 5;
    return firmware.status;
  }
};

inline ShotSeriesSettings series(int shots, int retries = 0) {
  ShotSeriesSettings settings;
  settings.shots = shots;
  settings.retries = retries;
  return settings;
}

}  // namespace strobe::host_test
