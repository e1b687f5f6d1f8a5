#include "tests/common/impact_fit/shot_sessions.hpp"

#include <random>

#include "common/impact/fit/model_fit.hpp"
#include "common/reduction/reduce.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::testing {

namespace {

using impact::Observation;
using impact::Parameter;
using reduction::Quantity;

constexpr const char* kConditions[] = {"zero_17", "zero_23", "zero_34", "zero_41", "zero_49", "zero_60",
                                       "zero_68", "top_18",  "top_23",  "top_34",  "top_42",  "top_48",
                                       "top_61",  "top_71",  "back_17", "back_22", "back_35", "back_40",
                                       "back_45", "back_59", "back_68"};

impact::ParameterValues drawn_truth(std::mt19937_64& source) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(source);
  };
  impact::ParameterValues out = impact::default_values(impact::ReboundModel::ode);
  out[impact::index(Parameter::mu)] = between(0.4, 0.7);
  out[impact::index(Parameter::stiffness_ratio)] = between(1.1, 1.8);
  out[impact::index(Parameter::damping_ratio)] = between(0.4, 1.0);
  out[impact::index(Parameter::offset_share)] = between(0.08, 0.25);
  out[impact::index(Parameter::alpha)] = between(0.52, 0.6);
  return out;
}

sim::Scene with_coefficients(sim::Scene scene, const impact::ParameterValues& truth) {
  sim::BounceSettings& b = scene.bounce;
  b.contact = sim::ContactLaw::ode;
  b.mu = truth[impact::index(Parameter::mu)];
  b.stiffness_ratio = truth[impact::index(Parameter::stiffness_ratio)];
  b.damping_ratio = truth[impact::index(Parameter::damping_ratio)];
  b.offset_share = truth[impact::index(Parameter::offset_share)];
  b.mu_sd = b.stiffness_ratio_sd = b.offset_share_sd = 0.0;
  scene.ball.alpha = truth[impact::index(Parameter::alpha)];
  return scene;
}

/// As `strobe fit` reads a row of results.csv; false where it would leave it out.
bool read(const reduction::Readout& r, Observation& out) {
  bool complete = !r.flags.has(reduction::Flag::spin_aliased);
  const auto take = [&](Quantity q, double& value, double& sd) {
    complete = complete && r.value[q].has_value();
    value = r.value[q].value_or(0.0);
    sd = r.sd[q].value_or(0.0);
  };
  take(Quantity::vx_td_mps, out.touchdown.vx_mps, out.touchdown_sd.vx_mps);
  take(Quantity::vy_td_mps, out.touchdown.vy_mps, out.touchdown_sd.vy_mps);
  take(Quantity::omega_td_radps, out.touchdown.omega_radps, out.touchdown_sd.omega_radps);
  take(Quantity::vx_lo_mps, out.lift_off.vx_mps, out.lift_off_sd.vx_mps);
  take(Quantity::omega_lo_radps, out.lift_off.omega_radps, out.lift_off_sd.omega_radps);
  take(Quantity::e, out.e, out.e_sd);
  take(Quantity::dwell_time_ms, out.dwell_s, out.dwell_sd_s);
  out.dwell_s /= 1e3;
  out.dwell_sd_s /= 1e3;
  return complete;
}

}  // namespace

Result<std::vector<sim::Scene>> scenes_of_conditions() {
  std::vector<sim::Scene> out;
  for (const char* name : kConditions) {
    auto scene = sim::load_scene(name);
    if (!scene) return tl::unexpected(scene.error());
    out.push_back(*std::move(scene));
  }
  return out;
}

Result<ShotSession> shoot_session(const std::vector<sim::Scene>& scenes, int shots_of_each,
                                  std::uint64_t seed) {
  std::mt19937_64 source(seed);
  ShotSession out;
  out.truth = drawn_truth(source);
  out.options = impact::default_options(impact::ReboundModel::ode);
  out.options.weighting = impact::Weighting::stated_sd;
  out.options.posterior.seed = seed;
  out.options.posterior.draws = 2000;
  for (const sim::Scene& scene : scenes) {
    auto shooter = sim::Shooter::make(with_coefficients(scene, out.truth), source());
    if (!shooter) return tl::unexpected(shooter.error());
    for (int shot = 1; shot <= shots_of_each; ++shot) {
      Observation o;
      o.name = scene.name + " " + std::to_string(shot);
      o.series = scene.name;
      o.gravity_mps2 = 9.80665;
      const auto readout = reduction::reduce(shooter->shoot(shot).frame, reduction::Estimator::best);
      if (readout && read(*readout, o) && !impact::find_observation_failure(o, 0, out.options))
        out.shots.push_back(std::move(o));
      else
        ++out.without_numbers;
    }
  }
  return out;
}

}  // namespace strobe::testing
