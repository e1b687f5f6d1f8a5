// Estimators on photographs of known shots.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <thread>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"
#include "tests/studies/in_parallel.hpp"
#include "tests/studies/trade/impact_scenes.hpp"
#include "tests/studies/trade/stopwatch.hpp"
#include "tests/studies/trade/studies.hpp"

namespace strobe::studies::trade {

namespace {

using reduction::Estimator;
using reduction::Quantity;

struct Estimate {
  const char* method;
  const char* parameter;
  Estimator estimator;
  reduction::ReduceOptions options;
};

constexpr flight::Effects kAll{.gravity = true, .drag = true, .magnus = true};

std::vector<Estimate> estimates() {
  return {{"two-point", "", Estimator::two_point, {}},
          {"legacy", "", Estimator::legacy, {}},
          {"best", "effects=none", Estimator::best, {.effects = flight::kNoEffects}},
          {"best", "effects=gravity", Estimator::best, {.effects = flight::kGravityOnly}},
          {"best", "effects=gravity+drag", Estimator::best, {.effects = flight::Effects{true, true, false}}},
          {"best", "effects=auto", Estimator::best, {}},
          {"best", "effects=all", Estimator::best, {.effects = kAll}},
          {"best", "effects=auto;covariance=yes", Estimator::best, {.effects = {}, .covariance = true}}};
}

/// What an error of 1 is, as for the tolerances of a readout.
double scale_of(const test::Bounce& b, Quantity q) {
  const double speed = std::hypot(b.vx_td, b.vy_td);
  switch (q) {
    case Quantity::omega_td_radps:
    case Quantity::omega_lo_radps:
      return speed / (0.5 * b.diameter_m);
    case Quantity::theta_in_deg:
    case Quantity::theta_out_deg:
      return 180.0 / std::numbers::pi;
    case Quantity::e:
    case Quantity::mu:
      return 1.0;
    case Quantity::dwell_time_ms:
      return b.dwell_s * 1e3;
    case Quantity::dwell_distance_cm:
      return speed * b.dwell_s * 1e2;
    default:
      return speed;
  }
}

/// One condition: the rms error of each quantity by each estimator, in its scale and in its bound.
struct Condition {
  test::Bounce bounce;
  struct Of {
    std::array<Tally, reduction::kQuantityCount> scaled;
    std::array<Tally, reduction::kQuantityCount> by_bound;
    int absent = 0;
  };
  std::vector<Of> of{};
};

void measure(Condition& condition, const test::Setup& plain, const std::vector<Estimate>& all, int shots,
             std::uint64_t seed) {
  constexpr int kPhases = 20;
  test::Random random(seed);
  const auto truth = test::truth(condition.bounce);
  condition.of.resize(all.size());
  test::Setup setup = plain;
  for (int phase = 0; phase < kPhases; ++phase) {
    setup.phase = (phase + 0.5) / kPhases;
    const auto bound = test::cramer_rao(condition.bounce, setup);
    for (int shot = shots * phase / kPhases; shot < shots * (phase + 1) / kPhases; ++shot) {
      const auto frame = test::photograph(condition.bounce, setup, random);
      for (std::size_t m = 0; m < all.size(); ++m) {
        const auto readout = reduction::reduce(frame, all[m].estimator, all[m].options);
        for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
          const auto q = static_cast<Quantity>(i);
          if (!truth[q]) continue;
          if (!readout || !readout->value[q]) {
            ++condition.of[m].absent;
            continue;
          }
          const double error = *readout->value[q] - *truth[q];
          condition.of[m].scaled[i].add(error / scale_of(condition.bounce, q));
          condition.of[m].by_bound[i].add(error / *bound[q]);
        }
      }
    }
  }
}

std::vector<test::Bounce> practical_bounces(int count, std::uint64_t seed) {
  std::vector<test::Bounce> bounces;
  for (const ImpactScene& s : practical_impacts(60 * count, seed)) {
    const double steep = std::atan2(-s.touchdown.vy_mps, s.touchdown.vx_mps) * 180.0 / std::numbers::pi;
    if (s.speed_mps() < 8.0 || s.speed_mps() > 40.0 || steep < 12.0 || steep > 75.0) continue;
    const auto run = impact::simulate(s.ball, s.touchdown, s.contact);
    // Half a turn between flashes of 3 ms cannot be told from none.
    constexpr double kMax_radps = 400.0;
    if (!run || std::abs(s.touchdown.omega_radps) > kMax_radps ||
        std::abs(run->lift_off.omega_radps) > kMax_radps)
      continue;
    bounces.push_back({.label = s.name,
                       .vx_td = s.touchdown.vx_mps,
                       .vy_td = s.touchdown.vy_mps,
                       .omega_td = s.touchdown.omega_radps,
                       .vx_lo = run->lift_off.vx_mps,
                       .vy_lo = run->lift_off.vy_mps,
                       .omega_lo = run->lift_off.omega_radps,
                       .dwell_s = run->dwell_s,
                       .dwell_x_m = run->dwell_distance_m,
                       .diameter_m = s.ball.diameter_m});
    if (static_cast<int>(bounces.size()) == count) break;
  }
  return bounces;
}

std::vector<Condition> measure_all(const std::vector<test::Bounce>& bounces, const test::Setup& setup,
                                   int shots, std::uint64_t seed) {
  std::vector<Condition> conditions;
  for (const test::Bounce& b : bounces) conditions.push_back({.bounce = b});
  const auto all = estimates();
  in_parallel(conditions.size(), std::thread::hardware_concurrency(),
              [&](std::size_t i) { measure(conditions[i], setup, all, shots, seed + i); });
  return conditions;
}

Error error_over(const std::vector<Condition>& conditions, std::size_t method) {
  Tally tally;
  for (const Condition& c : conditions) {
    double worst = 0.0;
    for (const Tally& t : c.of[method].scaled) worst = std::max(worst, t.error().rms);
    tally.add(worst);
  }
  return tally.error();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values.empty() ? 0.0 : values[values.size() / 2];
}

/// In the units people know, over the thesis's conditions: medians.
std::string in_units(const std::vector<Condition>& conditions, std::size_t method) {
  const auto typical = [&](Quantity q, bool by_bound) {
    std::vector<double> values;
    for (const Condition& c : conditions) {
      const auto i = static_cast<std::size_t>(q);
      const Condition::Of& of = c.of[method];
      values.push_back(by_bound ? of.by_bound[i].error().rms
                                : of.scaled[i].error().rms * scale_of(c.bounce, q));
    }
    return median(values);
  };
  int absent = 0;
  for (const Condition& c : conditions) absent += c.of[method].absent;
  return fmt::format(
      "vx_TD {:.4f} m/s ({:.2f} of the bound) e {:.4f} ({:.2f}) omega_TD {:.2f} rad/s ({:.2f}){}",
      typical(Quantity::vx_td_mps, false), typical(Quantity::vx_td_mps, true), typical(Quantity::e, false),
      typical(Quantity::e, true), typical(Quantity::omega_td_radps, false),
      typical(Quantity::omega_td_radps, true), absent > 0 ? fmt::format(" {} readouts absent", absent) : "");
}

std::vector<reduction::Frame> frames_of(const std::vector<test::Bounce>& bounces, test::Setup setup) {
  test::Random random(7);
  std::vector<reduction::Frame> frames;
  for (const double phase : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    setup.phase = phase;
    for (const test::Bounce& b : bounces) frames.push_back(test::photograph(b, setup, random));
  }
  return frames;
}

Study study_of(Study study, const test::Setup& setup, const Effort& effort) {
  auto thesis = test::thesis_bounces();
  if (effort.quick) thesis.resize(3);
  const auto practical = practical_bounces(effort.quick ? 3 : 60, effort.seed + 2);
  const auto of_thesis = measure_all(thesis, setup, effort.shots, effort.seed);
  const auto of_practical = measure_all(practical, setup, effort.shots, effort.seed + 100);
  const auto frames = frames_of(thesis, setup);
  study.unit = "of the readouts' scales";
  study.what += fmt::format(
      ": five images a leg, {} shots of each condition over 20 phases of the flash train, camera rolled "
      "by .3 degree; the largest over all readouts of the rms error in the readout's scale (v_td, "
      "v_td/R, 1 rad, 1 for e and mu, the dwell time, v_td*dwell); {} practical conditions of 8-40 "
      "m/s, 12-75 degrees, spins within 400 rad/s; against the truth",
      effort.shots, practical.size());
  const auto all = estimates();
  for (std::size_t m = 0; m < all.size(); ++m) {
    Row row{.method = all[m].method, .parameter = all[m].parameter, .source = Source::noise};
    row.practical = error_over(of_practical, m);
    row.thesis = error_over(of_thesis, m);
    row.remark = in_units(of_thesis, m);
    row.cost_us = least_cost_us(effort.repetitions, frames.size(), [&](std::size_t i) {
      keep(reduction::reduce(frames[i], all[m].estimator, all[m].options));
    });
    study.rows.push_back(row);
  }
  return study;
}

}  // namespace

std::vector<Study> estimator_studies(const Effort& effort) {
  test::Setup setup;
  setup.roll_rad = 0.3 * std::numbers::pi / 180.0;
  const Study stated{.name = "reduce",
                     .title = "Readout of a frame measured by hand, noise stated",
                     .what = "centre, diameter, surface .5 mm, equator 1 degree"};
  const Study estimated{.name = "reduce_estimated",
                        .title = "The same, noise estimated from the shot",
                        .what = "as reduce",
                        .drawn = false};
  const Study fine{.name = "reduce_fine",
                   .title = "Readout of a frame measured finely, noise stated",
                   .what = "centre, diameter, surface .02 mm, equator .05 degree"};
  std::vector<Study> studies;
  studies.push_back(study_of(stated, setup, effort));
  test::Setup unstated = setup;
  unstated.state_noise = false;
  studies.push_back(study_of(estimated, unstated, effort));
  test::Setup sharp = setup;
  sharp.centre_sd_m = sharp.diameter_sd_m = sharp.surface_sd_m = 2e-5;
  sharp.equator_sd_rad = 0.05 * std::numbers::pi / 180.0;
  studies.push_back(study_of(fine, sharp, effort));
  return studies;
}

}  // namespace strobe::studies::trade
