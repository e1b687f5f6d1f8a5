#include "tests/stops/model.hpp"

#include <fmt/format.h>

#include <utility>

#include <algorithm>
#include <vector>

namespace strobe::stops {

namespace {

using firmware::State;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr Duration kExpires = std::chrono::hours{10'000};  // arming_ends says when
// More than kSendAgain and kSignOfShot; more than a shot and its photograph take.
constexpr Duration kWait = std::chrono::seconds{2}, kLongWait = std::chrono::seconds{60};

constexpr std::array<const char*, static_cast<std::size_t>(Step::count)> kWords{
    "A's operator gives the command to fire",
    "A's operator presses Ctrl-\\",
    "A's series takes a turn",
    "A's series takes a turn two seconds later",
    "A's series takes a turn a minute later",
    "A hears a status",
    "A hears a refusal",
    "A hears the event of a stop",
    "A's shot counts",
    "A's shot does not count",
    "A repeats DISARM",
    "A hears of a DISARM that was taken in",
    "A's RESET arrives",
    "A's ARM arrives",
    "A's FIRE arrives",
    "A's DISARM arrives",
    "A's DISARM is lost",
    "B's operator gives the command to fire",
    "B's RESET arrives",
    "B's ARM arrives",
    "B's FIRE arrives",
    "B's DISARM arrives",
    "the key is turned off",
    "the key is turned on",
    "the e-stop is pressed",
    "the e-stop is released",
    "the rig's computer sleeps",
    "the arming ends",
    "a fault",
    "CLEAR arrives",
    "the firmware starts anew",
    "the trigger is due",
    "the shot is over"};

host::CommandFactory& factory_of_a() {
  static host::CommandFactory factory{kHostA};
  return factory;
}

host::ShotSeriesSettings settings_of(const Limits& limits) {
  host::ShotSeriesSettings settings;
  settings.shots = limits.shots;
  settings.retries = limits.retries;
  settings.blocked_timeout_s = 1e9;
  return settings;
}

/// Of numbers that are only compared: their order. 0 stays 0.
class Ranks {
 public:
  explicit Ranks(std::vector<std::int64_t> numbers) : sorted_(std::move(numbers)) {
    sorted_.push_back(0);
    std::sort(sorted_.begin(), sorted_.end());
    sorted_.erase(std::unique(sorted_.begin(), sorted_.end()), sorted_.end());
  }
  int operator()(std::int64_t number) const {
    return static_cast<int>(std::lower_bound(sorted_.begin(), sorted_.end(), number) - sorted_.begin());
  }

 private:
  std::vector<std::int64_t> sorted_;
};

class KeyWriter {
 public:
  template <typename... Values>
  void put(Values... values) {
    ((key_.at(used_++) = static_cast<std::uint8_t>(values)), ...);
  }
  const Key& key() const { return key_; }

 private:
  Key key_{};
  std::size_t used_ = 0;
};

int host_index(std::int64_t host) { return host == 0 ? 0 : host == kHostA ? 1 : 2; }

}  // namespace

const char* words(Step step) { return kWords[static_cast<std::size_t>(step)]; }

Model::Model(const Limits& limits, const Fault& fault)
    : limits_(limits), fault_(fault), lock_(kExpires, 0, *fault.table), disarm_(kHostA) {
  lock_.start(true, false);
}

Snapshot Model::snapshot() const {
  return {boot_,
          lock_.state(),
          lock_.key_active(),
          lock_.estop_active(),
          lock_.fault_text()[0] != '\0',
          lock_.stop_text()[0] != '\0',
          lock_.arm_host(),
          lock_.arm_token(),
          lock_.shot_id()};
}

status_t Model::heard() const {
  status_t status{};
  status.boot_id = heard_.boot;
  status.state = static_cast<std::int8_t>(heard_.state);
  status.key_active = heard_.key;
  status.estop_active = heard_.estop;
  status.arm_host_id = heard_.arm_host;
  status.arm_token = heard_.arm_token;
  status.last_shot_id = heard_.last_shot;
  status.journal_ok = true;
  if (heard_.fault || heard_.stop || heard_.estop || !heard_.key) status.message = "cannot be armed";
  if (!fault_.deaf_series) return status;
  status.key_active = true;
  status.estop_active = false;
  status.message.clear();
  if (heard_.state == State::stopped || heard_.state == State::fault) status.state = status_t::IDLE;
  return status;
}

bool Model::possible(Step step) const {
  const bool runs = series_ && !series_->finished();
  const bool under_way = runs && series_->shot_under_way();
  switch (step) {
    case Step::a_presses:
      return heard_.boot != 0;
    case Step::a_turns:
    case Step::a_waits:
      return runs && heard_.boot != 0;
    case Step::a_hears_nothing:
    case Step::a_result_good:
    case Step::a_result_bad:
      return under_way;
    case Step::a_hears_refusal:
      return runs && std::get<11>(series_->progress()) == 0;
    case Step::a_hears_stop:
      return runs;
    case Step::a_repeats_disarm:
      return disarm_.open();
    case Step::a_hears_disarmed:
      return disarm_.open() && disarmed_ != 0;
    case Step::reset_of_a_comes:
      return sent_.acted != MonoTime{};
    case Step::arm_of_a_comes:
      return sent_.arm;
    case Step::fire_of_a_comes:
      return sent_.token != 0;
    case Step::disarm_of_a_comes:
    case Step::disarm_of_a_lost:
      return sent_.disarm != 0;
    case Step::reset_of_b_comes:
    case Step::arm_of_b_comes:
      return b_goes_on_;
    case Step::fire_of_b_comes:
      return lock_.arm_host() == kHostB;
    case Step::key_off:
      return lock_.key_active();
    case Step::key_on:
      return !lock_.key_active();
    case Step::estop_on:
      return !lock_.estop_active();
    case Step::estop_off:
      return lock_.estop_active();
    case Step::arming_ends:
      return lock_.state() == State::armed;
    case Step::clear_comes:
      return lock_.fault_text()[0] != '\0';
    case Step::fault:
      return limits_.faults;
    case Step::firmware_restarts:
      return limits_.restarts;
    case Step::trigger_due:
      return lock_.state() == State::firing && lock_.trigger_pending();
    case Step::shot_over:
      return lock_.state() == State::firing;
    default:
      return true;
  }
}

void Model::command() {
  act_a_ = later();
  series_.emplace(settings_of(limits_), factory_of_a());
  // Another process, which knows nothing of what the one before it heard, or was about to disarm.
  heard_ = {};
  disarm_ = host::DisarmRequest(kHostA);
  confirmed_ = false;
}

void Model::press() {
  pressed_ = later();
  confirmed_ = false;
  disarm_was_sent_ = false;
  first_disarm_ = 0;
  disarm_.begin(host_now_);
}

/// Commands for a firmware that is no more are not even kept.
void Model::step_series(Duration passed) {
  host_now_ += passed;
  series_->step(heard(), host_now_);
  for (const command_t& command : series_->take_commands()) {
    if (command.boot_id != boot_) continue;
    if (command.kind == command_t::RESET) sent_.acted = fault_.act_as_sent ? later() : act_a_;
    if (command.kind == command_t::ARM) sent_.arm = true;
    if (command.kind == command_t::FIRE) sent_.token = command.arm_token;
  }
  series_->take_notifications();
  if (series_->take_disarm()) press();
}

void Model::hear_disarmed() {
  event_t event{};
  event.kind = event_t::DISARMED;
  event.boot_id = disarmed_boot_;
  event.detail = fmt::format("disarmed by command {} of {:x} a@lab", disarmed_, kHostA);
  if (disarm_.on_event(event, heard_.boot)) confirmed_ = true;
}

/// Newer than every command.
void Model::event(std::int8_t kind) {
  const auto asked = std::get<8>(series_->progress()), begun = std::get<3>(series_->progress());
  event_t event{};
  event.kind = kind;
  event.boot_id = kind == event_t::REFUSED ? asked : begun;
  event.sequence = 1;
  series_->on_event(event);
}

void Model::result(bool good) {
  host::Shot result;
  result.boot_id = std::get<5>(series_->progress());
  result.host_id = kHostA;
  result.shot_id = series_->shot_number();
  if (!good) result.rejected = "aborted";
  series_->on_shot_result(result);
}

void Model::restart() {
  const bool key = lock_.key_active(), estop = lock_.estop_active();
  const std::int32_t shot = lock_.shot_id();
  ++boot_;
  lock_ = firmware::Interlock{kExpires, shot, *fault_.table};
  lock_.start(key, estop);
  sent_ = {};
  b_goes_on_ = false;
  if (!key || estop || limits_.strict_restart) return;
  last_stop_ = {};
  confirmed_ = false;
}

std::string Model::trigger() {
  if (!lock_.release_trigger(lock_.shot_id())) return "";
  triggered_ = true;
  const MonoTime act = fired_by_ == kHostA ? act_a_ : act_b_;
  if (lock_.estop_active() || !lock_.key_active()) return "TRIGGER WITH A SWITCH AGAINST IT";
  if (act <= last_stop_) return "TRIGGER AFTER A STOP WITHOUT A PERSON'S ACT";
  if (confirmed_ && act <= pressed_) return "TRIGGER AFTER A CONFIRMED DISARM WITHOUT A PERSON'S ACT";
  return "";
}

void Model::take_of_a(Step step) {
  switch (step) {
    case Step::a_commands:
      return command();
    case Step::a_presses:
      if (series_) series_->stop();
      return press();
    case Step::a_turns:
      return step_series({});
    case Step::a_waits:
      return step_series(kWait);
    case Step::a_hears_nothing:
      return step_series(kLongWait);
    case Step::a_hears_status:
      heard_ = snapshot();
      return;
    case Step::a_hears_disarmed:
      return hear_disarmed();
    case Step::a_hears_refusal:
      return event(event_t::REFUSED);
    case Step::a_hears_stop:
      return event(event_t::KEY);
    case Step::a_result_good:
    case Step::a_result_bad:
      return result(step == Step::a_result_good);
    default:
      break;
  }
  host_now_ += host::DisarmRequest::kRepeat;
  if (!disarm_.due(host_now_) || (fault_.disarm_once && disarm_was_sent_)) return;
  disarm_was_sent_ = true;
  disarm_.on_sent(++disarms_);
  if (first_disarm_ == 0) first_disarm_ = disarms_;
  sent_.disarm = heard_.boot == boot_ ? disarms_ : 0;
  if (fault_.disarm_believed) {
    disarm_ = host::DisarmRequest(kHostA);
    confirmed_ = true;
  }
}

void Model::take_at_firmware(Step step) {
  const MonoTime now = later();
  const auto fire = [this, now](std::int64_t host, std::int64_t token) {
    if (lock_.fire(host, token, lock_.shot_id() + 1, false, now) == nullptr) fired_by_ = host;
  };
  const auto arm = [this, now](std::int64_t host) {
    lock_.arm(host, next_token_++, now + firmware::Interlock::kRestartDelay);
  };
  const auto reset = [this, now](std::int64_t host, MonoTime acted) {
    lock_.reset(host, acted, now - firmware::Interlock::kRestartDelay);
  };
  switch (step) {
    case Step::reset_of_a_comes:
      return reset(kHostA, sent_.acted);
    case Step::reset_of_b_comes:
      return reset(kHostB, fault_.act_as_sent ? now : act_b_);
    case Step::arm_of_a_comes:
      return arm(kHostA);
    case Step::arm_of_b_comes:
      return arm(kHostB);
    case Step::fire_of_a_comes:
      return fire(kHostA, sent_.token);
    case Step::fire_of_b_comes:
      return fire(kHostB, lock_.arm_token());
    case Step::disarm_of_a_comes:
      disarmed_ = std::exchange(sent_.disarm, 0);
      disarmed_boot_ = boot_;
      [[fallthrough]];
    case Step::disarm_of_b_comes:
      lock_.disarm(now);
      return stopped(now);
    case Step::disarm_of_a_lost:
      sent_.disarm = 0;
      return;
    case Step::key_off:
    case Step::key_on:
      lock_.key(step == Step::key_on, now);
      return stopped(now);
    case Step::estop_on:
    case Step::estop_off:
      lock_.estop(step == Step::estop_on, now);
      return stopped(now);
    case Step::sleeps:
      lock_.suspended(now);
      return stopped(now);
    case Step::arming_ends:
      lock_.stood_still();
      return;
    case Step::fault:
      lock_.fault("broken");
      return;
    case Step::clear_comes:
      lock_.clear();
      return;
    case Step::firmware_restarts:
      return restart();
    default:
      lock_.shot_over();
  }
}

std::string Model::take(Step step) {
  triggered_ = false;
  if (step == Step::trigger_due) return trigger();
  if (step == Step::b_acts) {
    act_b_ = later();
    b_goes_on_ = true;
  } else if (step < Step::reset_of_a_comes) {
    take_of_a(step);
  } else {
    take_at_firmware(step);
  }
  return "";
}

Key Model::key() const {
  KeyWriter out;
  out.put(lock_.state(), lock_.key_active(), lock_.estop_active(), lock_.trigger_pending(),
          lock_.fault_text()[0] != '\0', lock_.stop_text()[0] != '\0', lock_.admitted(kHostA),
          lock_.admitted(kHostB), host_index(lock_.arm_host()));
  const bool runs = series_ && !series_->finished();
  const bool firing = lock_.state() == State::firing;
  out.put(firing ? host_index(fired_by_) : 0, b_goes_on_, disarm_.open(), confirmed_, sent_.arm,
          sent_.disarm != 0, disarm_was_sent_ && fault_.disarm_once, runs);
  // Which DISARMs would confirm what was pressed last.
  const auto confirms = [this](std::int64_t id) {
    return disarm_.open() && id != 0 && first_disarm_ != 0 && id >= first_disarm_;
  };
  out.put(disarm_.open() && first_disarm_ != 0, confirms(sent_.disarm), confirms(disarmed_),
          disarm_.open() && disarmed_ != 0 && disarmed_boot_ == heard_.boot);
  // Who acted after what.
  const bool presses = disarm_.open() || confirmed_;
  const auto order = [&](MonoTime act) {
    return (act > last_stop_ ? 1 : 0) + (presses && act > pressed_ ? 2 : 0);
  };
  const bool reset = sent_.acted != MonoTime{};
  out.put(order(act_a_), order(act_b_), reset, reset && sent_.acted > last_stop_);
  const bool hears = heard_.boot != 0;
  if (!runs) {
    out.put(sent_.token != 0 && sent_.token == lock_.arm_token(), hears && heard_.boot == boot_, hears);
    return out.key();
  }
  const auto [state, entered, sent, begun, admitted, boot, before, fired, asked, good, refired, refusals,
              refused, ending] = series_->progress();
  const bool of_shot = fired || series_->shot_under_way();
  const Ranks boots({boot_, heard_.boot, begun, of_shot ? boot : 0, asked});
  const Ranks shots({lock_.shot_id(), heard_.last_shot, of_shot ? before : 0});
  const Ranks tokens({lock_.arm_token(), heard_.arm_token});
  out.put(sent_.token != 0 && sent_.token == lock_.arm_token(),
          sent_.token != 0 && sent_.token == heard_.arm_token, tokens(lock_.arm_token()),
          tokens(heard_.arm_token), host_index(heard_.arm_host));
  out.put(boots(boot_), boots(heard_.boot), boots(begun), boots(of_shot ? boot : 0), boots(asked),
          shots(lock_.shot_id()), shots(heard_.last_shot), shots(of_shot ? before : 0));
  out.put(static_cast<int>(heard_.state) + 8 * (heard_.key ? 1 : 0) + 16 * (heard_.estop ? 1 : 0) +
              32 * (heard_.fault ? 1 : 0) + 64 * (heard_.stop ? 1 : 0),
          static_cast<int>(state), host_now_ - entered >= kWait, host_now_ - sent >= kWait);
  out.put(admitted + 2 * fired + 4 * refused + 8 * ending, good, refired, refusals);
  return out.key();
}

std::string Model::revive(int& turns) const {
  Model then = *this;
  const auto take_if_possible = [&then](Step step) {
    return then.possible(step) ? then.take(step) : std::string();
  };
  if (then.possible(Step::shot_over)) then.take(Step::shot_over);
  if (then.disarm_.open()) {
    for (const Step step :
         {Step::a_hears_status, Step::a_repeats_disarm, Step::disarm_of_a_comes, Step::a_hears_disarmed})
      take_if_possible(step);
    if (then.disarm_.open()) return "A DISARM IS NEVER CONFIRMED";
  }
  for (const Step step :
       {Step::clear_comes, Step::disarm_of_b_comes, Step::key_on, Step::estop_off, Step::a_commands})
    take_if_possible(step);
  for (turns = 1; turns <= 20; ++turns) {
    for (const Step step : {Step::a_hears_status, Step::a_waits, Step::reset_of_a_comes, Step::arm_of_a_comes,
                            Step::fire_of_a_comes})
      take_if_possible(step);
    then.sent_ = {};
    if (!then.possible(Step::trigger_due)) continue;
    if (const std::string wrong = then.take(Step::trigger_due); !wrong.empty()) return wrong;
    if (then.triggered_) return "";
  }
  return "ONE ACT OF A PERSON DOES NOT LEAD TO A SHOT";
}

}  // namespace strobe::stops
