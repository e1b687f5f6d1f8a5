#include "host/commission/electrical/lamp_judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/units/time.hpp"
#include "host/commission/core/sample.hpp"

namespace strobe::commission {
namespace {

using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

/// Normal deviate that is exceeded so often.
constexpr double kOnceInAThousand = 3.09;
/// Of good rigs within the limit: one in a thousand is beyond it on either side.
constexpr double kWithinByChance = 0.998;

/// By the lamp's letter.
struct Names {
  char own, other;
  bool own_fitted, other_fitted;
  std::int64_t flash_t::*own_seen;
  std::int64_t flash_t::*other_seen;
  double expected_us;
};

Names names_of(Lamps lamp, const shot_t& shot) {
  if (lamp == Lamps::a)
    return {'A',
            'B',
            shot.sensor_a_fitted != 0,
            shot.sensor_b_fitted != 0,
            &flash_t::observed_a_ns,
            &flash_t::observed_b_ns,
            shot.lamp_delay_a_us};
  return {'B',
          'A',
          shot.sensor_b_fitted != 0,
          shot.sensor_a_fitted != 0,
          &flash_t::observed_b_ns,
          &flash_t::observed_a_ns,
          shot.lamp_delay_b_us};
}

bool seen(const flash_t& flash, std::int64_t flash_t::*by) { return known(from_ns(flash.*by)); }

/// From the call that set the line.
double delay_us(const flash_t& flash, std::int64_t flash_t::*by) {
  return to_microseconds(from_ns(flash.*by) - from_ns(flash.issue_end_ns));
}

/// The line changed some time in the call that set it: the delay lies between those from its end and from its begin.
struct Delay {
  double call_us = 0.0, from_end_us = 0.0;
};

struct Delays {
  int count = 0;
  double mean_us = 0.0;
  double half_width_us = 0.0;  ///< of what the calls leave open
  double mean_sd_us = 0.0;     ///< of what differs from flash to flash
  double margin_us = 0.0;      ///< how far chance moves the mean
  double jitter_us = 0.0, least_jitter_us = 0.0;
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
  found.margin_us = mean.mean_margin(kWithinByChance);
  found.jitter_us = steadier.sd();
  found.least_jitter_us = steadier.sd_lower_bound(kOnceInAThousand);
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

std::optional<StepResult> light_fault(const std::string& id, const Names& names, const Tally& tally) {
  const char a = names.own, b = names.other;
  if (tally.own == 0 && tally.other == 0)
    return failed(
        id, "lamp_dark", fmt::format("of {} flashes of lamp {} no sensor saw any", tally.planned, a),
        fmt::format("if you saw it flash: sensor {}, its comparator, wire and line; if not: lamp {}'s "
                    "power, opto-coupler, wire and line",
                    a, a));
  if (10 * tally.own <= tally.planned && 10 * tally.other >= 9 * tally.planned)
    return failed(id, "sensors_swapped",
                  fmt::format("lamp {}'s flashes are seen by sensor {} ({} of {}), not by its own ({})", a, b,
                              tally.other, tally.planned, tally.own),
                  fmt::format("if you saw lamp {} flash, the sensors are swapped; if lamp {} flashed, the "
                              "lamps: wires or line numbers",
                              a, b));
  if (tally.own < tally.planned)
    return failed(
        id, "lamp_weak",
        fmt::format("sensor {} missed {} of {} flashes of lamp {}", a, tally.planned - tally.own,
                    tally.planned, a),
        "the lamp needs longer to recharge (min_period_us), a stronger pulse (pulse_us), or its sensor "
        "more light or a lower threshold");
  if (tally.other > 0)
    return failed(id, "cross_talk",
                  fmt::format("sensor {} saw {} of {} flashes of lamp {}", b, tally.other, tally.planned, a),
                  fmt::format("put a tube around sensor {}, and look for wires that run together", b));
  if (tally.extra > 0)
    return failed(
        id, "double_flashes",
        fmt::format("{} edges too many in {} flashes of lamp {}", tally.extra, tally.planned, a),
        "the lamp fires twice (fit a one-shot that cannot be retriggered), or the sensor's comparator "
        "rings (hysteresis, one-shot)");
  return std::nullopt;
}

std::optional<StepResult> timing_fault(const std::string& id, const Names& names, const Tally& tally,
                                       const host::CommissionTable& limits) {
  const Delays& delays = tally.delays;
  if (tally.late > 0)
    return failed(
        id, "late_flashes",
        fmt::format("{} of {} flashes of lamp {} came late after their pulse", tally.late, tally.planned,
                    names.own),
        "the lamp's trigger input or its one-shot delays some pulses: look at it with an oscilloscope");
  if (delays.least_jitter_us > limits.jitter_limit_us)
    return failed(
        id, "jitter",
        fmt::format("lamp {} jitters by {:.1f} us (sd) from flash to flash", names.own, delays.jitter_us),
        "look for noise on the lamp's trigger and the sensor's threshold");
  const double off_us = std::abs(delays.mean_us - names.expected_us);
  if (off_us > limits.delay_tolerance_us + delays.half_width_us + delays.margin_us) {
    const char letter = names.own == 'A' ? 'a' : 'b';
    return failed(id, "delay_off",
                  fmt::format("lamp {} flashes {:.1f} ± {:.1f} us after its pulse, the rig file says {:.1f}",
                              names.own, delays.mean_us, delays.sd_us(), names.expected_us),
                  fmt::format("if lamp and sensor are what they should be, write delay_{}_us = {:.1f} into "
                              "[lamps] and start strobed anew",
                              letter, delays.mean_us));
  }
  return std::nullopt;
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

std::optional<StepResult> together_fault(const std::string& id, const shot_t& shot, const Sample& skew,
                                         const host::CommissionTable& limits) {
  for (const Lamps lamp : {Lamps::a, Lamps::b}) {
    const Names names = names_of(lamp, shot);
    const Tally tally = tally_of(shot, names);
    if (tally.own < tally.planned)
      return failed(id, "lamp_weak_together",
                    fmt::format("where both lamps flash, sensor {} missed {} of {} flashes", names.own,
                                tally.planned - tally.own, tally.planned),
                    "if the lamp alone has passed, the lamps share a supply that is too weak for both");
    if (tally.extra > 0)
      return failed(id, "double_flashes",
                    fmt::format("{} edges too many in {} flashes of both lamps", tally.extra, tally.planned),
                    "one lamp's pulse fires the other one again: look for wires that run together");
  }
  if (std::abs(skew.mean()) > limits.skew_limit_us + skew.mean_margin(kWithinByChance))
    return failed(id, "skew",
                  fmt::format("lamp A flashes {:.1f} us {} lamp B", std::abs(skew.mean()),
                              skew.mean() > 0 ? "after" : "before"),
                  "images of both lamps blur: use lamps, opto-couplers and sensors of one kind");
  return std::nullopt;
}

}  // namespace

StepResult judge_lamp_alone(const std::string& id, Lamps lamp, const shot_t& shot,
                            const host::CommissionTable& limits) {
  const Names names = names_of(lamp, shot);
  if (!names.own_fitted)
    return skipped(id, fmt::format("the rig file names no sensor {}", names.own),
                   fmt::format("without it nothing tells when lamp {} flashes: fit one", names.own));
  const Tally tally = tally_of(shot, names);
  if (auto fault = light_fault(id, names, tally))
    return with_numbers(std::move(*fault), names, tally, limits);
  if (auto fault = timing_fault(id, names, tally, limits))
    return with_numbers(std::move(*fault), names, tally, limits);
  StepResult result;
  result.id = id;
  result.state = StepState::passed;
  result.words = fmt::format(
      "lamp {} flashes {:.2f} ± {:.2f} us after its pulse (rig file: {:.1f}); jitter {:.2f} us; {} "
      "flashes, each seen once",
      names.own, tally.delays.mean_us, tally.delays.sd_us(), names.expected_us, tally.delays.jitter_us,
      tally.planned);
  return with_numbers(std::move(result), names, tally, limits);
}

StepResult judge_lamps_together(const std::string& id, const shot_t& shot,
                                const host::CommissionTable& limits) {
  if (!shot.sensor_a_fitted || !shot.sensor_b_fitted)
    return skipped(id, fmt::format("the rig file names no sensor {}", shot.sensor_a_fitted ? 'B' : 'A'),
                   "without it nothing tells whether the lamps flash together: fit one");
  const Sample skew = skew_of(shot);
  StepResult result;
  if (auto fault = together_fault(id, shot, skew, limits)) {
    result = std::move(*fault);
  } else {
    result.id = id;
    result.state = StepState::passed;
    result.words = fmt::format("lamp A flashes {:.2f} ± {:.2f} us after lamp B ({:.2f} from flash to flash)",
                               skew.mean(), skew.mean_sd(), skew.sd());
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

}  // namespace strobe::commission
