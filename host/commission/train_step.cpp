#include "host/commission/train_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "common/units/time.hpp"
#include "host/commission/shot_step.hpp"
#include "host/commission/statistics.hpp"
#include "host/commission/steps.hpp"
#include "host/session/train_report.hpp"

namespace strobe::commission {
namespace {

using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

/// By the lamp's letter.
struct Names {
  char own, other;
  bool own_fitted;
  std::int64_t flash_t::*own_seen;
  std::int64_t flash_t::*other_seen;
  double expected_us;
};

Names names_of(Lamps lamp, const shot_t& shot) {
  const auto a = &flash_t::observed_a_ns, b = &flash_t::observed_b_ns;
  if (lamp == Lamps::a) return {'A', 'B', shot.sensor_a_fitted != 0, a, b, shot.lamp_delay_a_us};
  return {'B', 'A', shot.sensor_b_fitted != 0, b, a, shot.lamp_delay_b_us};
}

bool seen(const flash_t& flash, std::int64_t flash_t::*by) { return known(from_ns(flash.*by)); }

/// From the call that set the line.
double delay_us(const flash_t& flash, std::int64_t flash_t::*by) {
  return to_microseconds(from_ns(flash.*by) - from_ns(flash.issue_end_ns));
}

/// The line changed some time in the call that set it: the delay lies between those from its end and from its
/// begin.
struct Delay {
  double call_us = 0.0, from_end_us = 0.0;
};

struct Delays {
  int count = 0;
  double mean_us = 0.0;
  double half_width_us = 0.0;  ///< of what the calls leave open
  double mean_sd_us = 0.0;     ///< of what differs from flash to flash
  double jitter_us = 0.0;
  Interval of_jitter_us;
  double sd_us() const { return std::hypot(mean_sd_us, half_width_us / std::sqrt(3.0)); }
};

/// By the shortest calls, as they tell most: those of up to twice the shortest one and 1 us, ten at least.
Delays delays_of(std::vector<Delay> delays) {
  Delays found;
  found.count = static_cast<int>(delays.size());
  if (delays.size() < 2) return found;
  Sample from_end, from_start, mean, call;
  for (const Delay& delay : delays) {
    from_end.add(delay.from_end_us);
    from_start.add(delay.from_end_us + delay.call_us);
  }
  std::ranges::sort(delays, {}, &Delay::call_us);
  const double longest_us = 2.0 * delays.front().call_us + 1.0;
  for (const Delay& delay : delays) {
    if (mean.count() >= 10 && delay.call_us > longest_us) break;
    mean.add(delay.from_end_us + 0.5 * delay.call_us);
    call.add(delay.call_us);
  }
  const Sample& steadier = from_end.sd() < from_start.sd() ? from_end : from_start;
  found.mean_us = mean.mean();
  found.half_width_us = 0.5 * call.mean();
  found.mean_sd_us = mean.mean_sd();
  found.jitter_us = steadier.sd();
  found.of_jitter_us = steadier.sd_interval();
  return found;
}

struct Tally {
  int planned = 0, own = 0, other = 0, extra = 0, late = 0;
  Delays delays;
};

Tally tally_of(const shot_t& shot, const Names& names) {
  Tally tally;
  std::vector<Delay> delays;
  for (const flash_t& flash : shot.flashes) {
    ++tally.planned;
    tally.extra += flash.extra_edges;
    tally.other += seen(flash, names.other_seen);
    if (!seen(flash, names.own_seen)) continue;
    ++tally.own;
    const Delay delay{to_microseconds(from_ns(flash.issue_end_ns) - from_ns(flash.issue_start_ns)),
                      delay_us(flash, names.own_seen)};
    tally.late += delay.from_end_us - names.expected_us > shot.late_tolerance_us;
    if (flash.extra_edges == 0) delays.push_back(delay);
  }
  tally.delays = delays_of(std::move(delays));
  return tally;
}

std::optional<StepResult> light_fault(const Names& names, const Tally& tally) {
  const char a = names.own, b = names.other;
  if (tally.own == 0 && tally.other == 0)
    return failed("lamp_dark", fmt::format("of {} flashes of lamp {} no sensor saw any", tally.planned, a),
                  fmt::format("if you saw it flash: sensor {}, its comparator, wire and line; if not: lamp "
                              "{}'s power, opto-coupler, wire and line",
                              a, a));
  if (10 * tally.own <= tally.planned && 10 * tally.other >= 9 * tally.planned)
    return failed("sensors_swapped",
                  fmt::format("lamp {}'s flashes are seen by sensor {} ({} of {}), not by its own ({})", a, b,
                              tally.other, tally.planned, tally.own),
                  fmt::format("if you saw lamp {} flash, the sensors are swapped; if lamp {} flashed, the "
                              "lamps: wires or line numbers",
                              a, b));
  if (tally.own < tally.planned)
    return failed("lamp_weak",
                  fmt::format("sensor {} missed {} of {} flashes of lamp {}", a, tally.planned - tally.own,
                              tally.planned, a),
                  "the lamp needs longer to recharge (min_period_us), a stronger pulse (pulse_us), or its "
                  "sensor more light or a lower threshold");
  if (tally.other > 0)
    return failed("cross_talk",
                  fmt::format("sensor {} saw {} of {} flashes of lamp {}", b, tally.other, tally.planned, a),
                  fmt::format("put a tube around sensor {}, and look for wires that run together", b));
  if (tally.extra > 0)
    return failed("double_flashes",
                  fmt::format("{} edges too many in {} flashes of lamp {}", tally.extra, tally.planned, a),
                  "the lamp fires twice (fit a one-shot that cannot be retriggered), or the sensor's "
                  "comparator rings (hysteresis, one-shot)");
  return std::nullopt;
}

StepResult judge_timing(const Names& names, const Tally& tally, const host::CommissionTable& limits) {
  const Delays& delays = tally.delays;
  if (tally.late > 0)
    return failed(
        "late_flashes",
        fmt::format("{} of {} flashes of lamp {} came late after their pulse", tally.late, tally.planned,
                    names.own),
        "the lamp's trigger input or its one-shot delays some pulses: look at it with an oscilloscope");
  StepResult result = passed({}, {}, "", "");
  result.words = fmt::format(
      "lamp {} flashes {:.2f} ± {:.2f} us after its pulse (rig file: {:.1f} us); jitter {:.2f} us; {} "
      "flashes, "
      "each seen once",
      names.own, delays.mean_us, delays.sd_us(), names.expected_us, delays.jitter_us, tally.planned);
  hold(result, delays.of_jitter_us, {.most = limits.jitter_limit_us}, "jitter",
       "look for noise on the lamp's trigger and the sensor's threshold");
  const bool by_calls = delays.half_width_us > 0.1 * limits.delay_tolerance_us;
  hold(result, interval(delays.mean_us, delays.sd_us()), within(limits.delay_tolerance_us, names.expected_us),
       "delay_off",
       fmt::format("if lamp and sensor are what they should be, write delay_{}_us = {:.1f} into [lamps] and "
                   "start strobed anew",
                   names.own == 'A' ? 'a' : 'b', delays.mean_us),
       by_calls ? fmt::format("the calls that set the line take {:.0f} us, give strobed its real-time rights "
                              "and a core of its own (strobed --check)",
                              2.0 * delays.half_width_us)
                : kMoreShots);
  return result;
}

StepResult with_numbers(StepResult result, const Names& names, const Tally& tally,
                        const host::CommissionTable& limits) {
  const Delays& delays = tally.delays;
  result.limit = fmt::format("{:.1f} ± {:.1f} us, jitter at most {:.1f} us, each flash seen once",
                             names.expected_us, limits.delay_tolerance_us, limits.jitter_limit_us);
  const std::string letter = names.own == 'A' ? "a" : "b";
  const double planned = tally.planned;
  result.figures = {{"flashes", planned, {}, {}, 0},
                    {"seen_by_own_sensor", static_cast<double>(tally.own), {}, planned, 0},
                    {"seen_by_other_sensor", static_cast<double>(tally.other), {}, 0.0, 0},
                    {"extra_edges", static_cast<double>(tally.extra), {}, 0.0, 0}};
  if (delays.count < 2) return result;
  result.value = delays.mean_us;
  result.sd = delays.sd_us();
  result.unit = "us";
  result.figures.push_back(
      {"delay_" + letter + "_us", delays.mean_us, delays.sd_us(), names.expected_us, delays.count});
  result.figures.push_back({"jitter_" + letter + "_us", delays.jitter_us, {}, {}, delays.count});
  return result;
}

Sample skew_of(const shot_t& shot) {
  Sample skew;
  for (const flash_t& flash : shot.flashes)
    if (seen(flash, &flash_t::observed_a_ns) && seen(flash, &flash_t::observed_b_ns))
      skew.add(delay_us(flash, &flash_t::observed_a_ns) - delay_us(flash, &flash_t::observed_b_ns));
  return skew;
}

std::optional<StepResult> together_fault(const shot_t& shot) {
  for (const Lamps lamp : {Lamps::a, Lamps::b}) {
    const Names names = names_of(lamp, shot);
    const Tally tally = tally_of(shot, names);
    if (tally.own < tally.planned)
      return failed("lamp_weak_together",
                    fmt::format("where both lamps flash, sensor {} missed {} of {} flashes", names.own,
                                tally.planned - tally.own, tally.planned),
                    "if the lamp alone has passed, the lamps share a supply that is too weak for both");
    if (tally.extra > 0)
      return failed("double_flashes",
                    fmt::format("{} edges too many in {} flashes of both lamps", tally.extra, tally.planned),
                    "one lamp's pulse fires the other one again: look for wires that run together");
  }
  return std::nullopt;
}

/// A lag's limits, and on which side it is.
void hold_lag(StepResult& result, const Sample& lag_ms, double expected_ms, double tolerance_ms) {
  hold(result, lag_ms.mean_interval(), within(tolerance_ms, expected_ms),
       lag_ms.mean() > expected_ms ? "shutter_late" : "shutter_early",
       fmt::format(
           "if the shutter is what it should be, write lag_ms = {:.1f} into [shutter] and start strobed anew",
           lag_ms.mean()));
}

/// The mean of a hundred delays with 1 us of jitter is known to 0.1 us; a flash missed in one of 33 is missed
/// in a hundred with 95 % probability.
constexpr int kLampFlashes = 100;
constexpr int kShutterTrains = 5;
constexpr int kShutterFlashes = 50;  // so that the exposure outlasts any lag

/// All flashes as of one train.
shot_t pooled(const std::vector<shot_t>& shots) {
  shot_t all = shots.front();
  for (std::size_t k = 1; k < shots.size(); ++k)
    all.flashes.insert(all.flashes.end(), shots[k].flashes.begin(), shots[k].flashes.end());
  return all;
}

const std::vector<std::string> kLampTables{"chip", "lines", "lamps", "sensors"};

class TrainStep final : public ShotStep {
 public:
  using Judge = std::function<StepResult(const std::vector<shot_t>& shots, const host::RigFile& rig)>;
  TrainStep(StepInfo info, Lamps lamps, int trains, int flashes, Judge judge_shots)
      : ShotStep({std::move(info)}, {.outputs = true}, {}),
        lamps_(lamps),
        trains_(trains),
        flashes_(flashes),
        judge_(std::move(judge_shots)) {}

  std::string briefing(const host::RigFile& rig) const override {
    const bool both = lamps_ == Lamps::both;
    return fmt::format(
        "FLASHES: {} flash{} {} times{}, and the shutter opens; the machine's trigger stays still. Key on, "
        "e-stop released.{}",
        what(), both ? "" : "es", dry_train(rig, lamps_, flashes_).code.size(),
        trains(rig) > 1 ? fmt::format(", in each of {} trains", trains(rig)) : "",
        both ? "" : " Look which lamp it is.");
  }

 private:
  int trains(const host::RigFile& rig) const { return trains_ * rig.commission.times; }
  std::string what() const {
    if (lamps_ == Lamps::both) return "both lamps";
    return lamps_ == Lamps::a ? "lamp A alone" : "lamp B alone";
  }
  std::vector<Fire> shots(const host::RigFile& rig) const override {
    Fire fire;
    fire.plan = dry_train(rig, lamps_, flashes_);
    fire.words = fmt::format("{}: {} flashes", what(), fire.plan.code.size());
    return std::vector<Fire>(static_cast<std::size_t>(trains(rig)), fire);
  }
  std::vector<StepResult> judge(const std::vector<SoundShot>& sound, const host::RigFile& rig) override {
    std::vector<shot_t> shots;
    for (const SoundShot& shot : sound) shots.push_back(*shot.fired.summary);
    return {judge_(shots, rig)};
  }

  Lamps lamps_;
  int trains_, flashes_;
  Judge judge_;
};

}  // namespace

StepResult judge_lamp_alone(Lamps lamp, const shot_t& shot, const host::CommissionTable& limits) {
  const Names names = names_of(lamp, shot);
  if (!names.own_fitted)
    return skipped(fmt::format("the rig file names no sensor {}", names.own),
                   fmt::format("without it nothing tells when lamp {} flashes: fit one", names.own));
  const Tally tally = tally_of(shot, names);
  auto fault = light_fault(names, tally);
  return with_numbers(fault ? std::move(*fault) : judge_timing(names, tally, limits), names, tally, limits);
}

StepResult judge_lamps_together(const shot_t& shot, const host::CommissionTable& limits) {
  if (!shot.sensor_a_fitted || !shot.sensor_b_fitted)
    return skipped(fmt::format("the rig file names no sensor {}", shot.sensor_a_fitted ? 'B' : 'A'),
                   "without it nothing tells whether the lamps flash together: fit one");
  const Sample skew = skew_of(shot);
  StepResult result = passed({}, {}, "", "");
  if (auto fault = together_fault(shot)) {
    result = std::move(*fault);
  } else {
    result.words = fmt::format("lamp A flashes {:.2f} ± {:.2f} us after lamp B ({:.2f} from flash to flash)",
                               skew.mean(), skew.mean_sd(), skew.sd());
    hold(result, skew.mean_interval(), within(limits.skew_limit_us), "skew",
         "images of both lamps blur: use lamps, opto-couplers and sensors of one kind");
  }
  result.limit =
      fmt::format("at most {:.1f} us apart, each flash seen once by either sensor", limits.skew_limit_us);
  if (skew.count() < 2) return result;
  result.value = skew.mean();
  result.sd = skew.mean_sd();
  result.unit = "us";
  result.figures = {{"skew_us", skew.mean(), skew.mean_sd(), 0.0, skew.count()},
                    {"skew_sd_us", skew.sd(), {}, {}, skew.count()}};
  return result;
}

StepResult judge_shutter(std::span<const shot_t> shots, const host::RigFile& rig) {
  const auto with = [&](std::int8_t feedback) {
    return std::ranges::count_if(shots, [&](const shot_t& s) { return s.shutter_feedback == feedback; });
  };
  if (with(shot_t::FEEDBACK_NONE) > 0)
    return skipped("the rig file names no contact of the shutter (lines.xsync)",
                   "connect the camera's X-sync contact, or let the photographs show that no flash is lost");
  if (const auto missing = with(shot_t::FEEDBACK_MISSING); missing > 0)
    return failed(
        "shutter_stuck",
        fmt::format("in {} of {} shots the shutter's contact did not tell that it opened and closed", missing,
                    shots.size()),
        "look whether the shutter opens: bulb exposure, remote release, opto-coupler, the contact's wire; a "
        "lag longer than late_ms shows as this, too");
  Sample opening_ms, closing_ms;
  for (const shot_t& shot : shots) {
    const auto found = host::delay_calibration(shot);
    if (found.opening_lag_ms) opening_ms.add(*found.opening_lag_ms);
    if (found.closing_lag_ms) closing_ms.add(*found.closing_lag_ms);
  }
  const double expected_ms = 1e3 * rig.shutter_lag_s.value_or(0.0);
  const double tolerance_ms = rig.commission.shutter_tolerance_ms;
  StepResult result = passed(opening_ms.mean(), opening_ms.mean_sd(), "ms",
                             fmt::format("{:.1f} ± {:.1f} ms", expected_ms, tolerance_ms));
  result.words = fmt::format(
      "the shutter opens {:.2f} ± {:.2f} ms and closes {:.2f} ± {:.2f} ms after its line (rig file: {:.1f} "
      "ms)",
      opening_ms.mean(), opening_ms.mean_sd(), closing_ms.mean(), closing_ms.mean_sd(), expected_ms);
  for (const Sample& lag_ms : {opening_ms, closing_ms}) hold_lag(result, lag_ms, expected_ms, tolerance_ms);
  result.figures = {
      {"opening_lag_ms", opening_ms.mean(), opening_ms.mean_sd(), expected_ms, opening_ms.count()},
      {"closing_lag_ms", closing_ms.mean(), closing_ms.mean_sd(), expected_ms, closing_ms.count()}};
  return result;
}

std::unique_ptr<Step> lamp_step(Lamps lamp) {
  const std::string title = lamp == Lamps::a ? "lamp A alone" : "lamp B alone";
  return std::make_unique<TrainStep>(StepInfo{lamp == Lamps::a ? "lamp_a" : "lamp_b", title, kLampTables},
                                     lamp, 1, kLampFlashes, [lamp](const auto& shots, const auto& rig) {
                                       return judge_lamp_alone(lamp, pooled(shots), rig.commission);
                                     });
}

std::unique_ptr<Step> lamps_together_step() {
  return std::make_unique<TrainStep>(
      StepInfo{"lamps_together", "both lamps together", kLampTables}, Lamps::both, 1, kLampFlashes,
      [](const auto& shots, const auto& rig) { return judge_lamps_together(pooled(shots), rig.commission); });
}

std::unique_ptr<Step> shutter_step() {
  return std::make_unique<TrainStep>(
      StepInfo{"shutter", "the shutter's lag", {"chip", "lines", "shutter"}}, Lamps::both, kShutterTrains,
      kShutterFlashes, [](const auto& shots, const auto& rig) { return judge_shutter(shots, rig); });
}

}  // namespace strobe::commission
