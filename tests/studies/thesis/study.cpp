#include "tests/studies/thesis/study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/impact/fit/model_fit.hpp"
#include "common/reduction/reduce.hpp"
#include "sim/fit/fit.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::studies {

using reduction::Quantity;

Result<Predictions> predict_all(const thesis::Data& data, Dashpot dashpot, Vertical vertical) {
  std::vector<impact::Observation> observations;
  for (const thesis::Condition& c : data.conditions) observations.push_back(impact::observation_of(c));
  Predictions out;
  out.dashpot = dashpot;
  out.vertical = vertical;
  for (const char* spin : {"zero", "top", "back"}) {
    auto constants = constants_without(spin, observations, vertical, dashpot);
    if (!constants) return tl::unexpected(constants.error());
    out.constants.push_back(*std::move(constants));
  }
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const impact::Observation& o = observations[i];
    const auto constants = std::ranges::find(out.constants, o.spin, &Constants::left_out);
    const auto prediction = predict(o, *constants, vertical);
    if (!prediction) return tl::unexpected(prediction.error());
    out.conditions.push_back(
        {&data.conditions[i], o, &*constants, *prediction, input_spread(o, *constants, vertical)});
    const impact::ContactSummary& s = prediction->contact;
    for (Cell& cell :
         cells_of(data.conditions[i], quantities_of(o.touchdown, s.lift_off, s.dwell_s, s.dwell_distance_m),
                  vertical))
      out.cells.push_back(std::move(cell));
  }
  return out;
}

Result<std::vector<Algebraic>> algebraic_models(const thesis::Data& data) {
  const auto observations = impact::observations_of(data.conditions, impact::Spread::replicate);
  std::vector<Algebraic> out;
  for (const auto model :
       {impact::ReboundModel::slide_roll, impact::ReboundModel::grip, impact::ReboundModel::grip_offset}) {
    const auto validation = impact::leave_one_group_out(observations, impact::default_options(model),
                                                        impact::CrossValidationGroup::spin);
    if (!validation) return fail(impact::message(validation.error(), observations));
    Algebraic one{.model = std::string(impact::name(model)), .cells = {}};
    for (const impact::HeldOutGroup& group : validation->groups) {
      for (std::size_t i = 0; i < group.observations.size(); ++i) {
        const impact::Observation& o = observations[group.observations[i]];
        const impact::Motion& lift_off = group.predicted[i].predicted.lift_off;
        one.cells.push_back(
            {o.name, Quantity::vx_lo_mps, lift_off.vx_mps, o.lift_off.vx_mps, o.lift_off_sd.vx_mps, false});
        one.cells.push_back({o.name, Quantity::omega_lo_radps, lift_off.omega_radps, o.lift_off.omega_radps,
                             o.lift_off_sd.omega_radps, false});
      }
    }
    out.push_back(std::move(one));
  }
  return out;
}

Result<Shots> shoot_all(const Predictions& predictions, int shots, std::uint64_t seed, bool exact) {
  Shots out{.name = exact ? "shots without spread and noise" : "means of shots", .cells = {}};
  for (const PredictedCondition& predicted : predictions.conditions) {
    const auto series = shoot_series(*predicted.condition, predicted.prediction, shots, seed, exact);
    if (!series) return fail(predicted.condition->name() + ": " + series.error().message);
    out.shots += series->shots;
    out.without_readout += series->without_readout;
    for (Cell& cell : cells_of(*predicted.condition, series->mean, predictions.vertical))
      out.cells.push_back(std::move(cell));
  }
  return out;
}

using reduction::Quantity;

bool is_lift_off_motion(Quantity quantity) {
  return quantity == Quantity::vx_lo_mps || quantity == Quantity::vy_lo_mps ||
         quantity == Quantity::omega_lo_radps;
}

reduction::Quantities quantities_of(const impact::Motion& touchdown, const impact::Motion& lift_off,
                                    double dwell_s, double dwell_distance_m) {
  reduction::Quantities q;
  q[Quantity::vx_lo_mps] = lift_off.vx_mps;
  q[Quantity::vy_lo_mps] = lift_off.vy_mps;
  q[Quantity::v_lo_mps] = std::hypot(lift_off.vx_mps, lift_off.vy_mps);
  q[Quantity::theta_out_deg] = std::atan2(lift_off.vy_mps, lift_off.vx_mps) * 180.0 / std::numbers::pi;
  q[Quantity::omega_lo_radps] = lift_off.omega_radps;
  q[Quantity::e] = -lift_off.vy_mps / touchdown.vy_mps;
  q[Quantity::mu] = (touchdown.vx_mps - lift_off.vx_mps) / (lift_off.vy_mps - touchdown.vy_mps);
  q[Quantity::dwell_time_ms] = 1e3 * dwell_s;
  q[Quantity::dwell_distance_cm] = 1e2 * dwell_distance_m;
  return q;
}

std::vector<Cell> cells_of(const thesis::Condition& c, const reduction::Quantities& predicted,
                           Vertical vertical) {
  struct Published {
    Quantity quantity;
    const thesis::MeanSd& number;
    bool vertical;
  };
  const std::array<Published, 9> published{{{Quantity::vx_lo_mps, c.vx_lo_mps, false},
                                            {Quantity::vy_lo_mps, c.vy_lo_mps, true},
                                            {Quantity::v_lo_mps, c.v_lo_mps, false},
                                            {Quantity::theta_out_deg, c.theta_out_deg, false},
                                            {Quantity::omega_lo_radps, c.omega_lo_radps, false},
                                            {Quantity::e, c.e, true},
                                            {Quantity::mu, c.mu, false},
                                            {Quantity::dwell_time_ms, c.dwell_time_ms, true},
                                            {Quantity::dwell_distance_cm, c.dwell_distance_cm, false}}};
  std::vector<Cell> cells;
  for (const Published& p : published) {
    if (!predicted[p.quantity]) continue;
    cells.push_back({c.name(), p.quantity, *predicted[p.quantity], p.number.mean, p.number.sd,
                     p.vertical && vertical == Vertical::measured});
  }
  return cells;
}

namespace {

using reduction::kQuantityCount;
using reduction::Quantity;

Result<sim::Scene> scene_of(const thesis::Condition& condition, const Prediction& prediction) {
  auto fitted = sim::fit_scene(condition);
  if (!fitted) return tl::unexpected(fitted.error());
  sim::Scene scene = fitted->scene;
  scene.ball.alpha = prediction.ball.alpha;
  sim::BounceSettings& b = scene.bounce;
  b.contact = sim::ContactLaw::ode;
  b.e = prediction.coefficients.e;
  b.e_speed_mps = -prediction.inputs.touchdown.vy_mps;
  b.mu = prediction.coefficients.mu;
  b.mu_sd = 0.0;
  b.dwell_s = prediction.coefficients.dwell_s;
  b.stiffness_ratio = prediction.coefficients.stiffness_ratio;
  b.damping_ratio = prediction.coefficients.damping_ratio;
  b.offset_share = prediction.coefficients.offset_share;
  b.offset_share_sd = b.stiffness_ratio_sd = 0.0;
  return scene;
}

void make_exact(sim::Scene& scene) {
  sim::MachineSettings& m = scene.machine;
  m.speed_sd_mps = m.angle_sd_rad = m.spin_sd_radps = m.lag_sd_s = m.spot_sd_m = 0.0;
  scene.bounce.e_sd = scene.bounce.dwell_sd_s = 0.0;
  scene.lamps.jitter_s = scene.sensors.jitter_s = scene.shutter.lag_sd_s = 0.0;
}

struct Sums {
  double n = 0.0, mean = 0.0, squares = 0.0;
  void add(double value) {
    n += 1.0;
    const double away = value - mean;
    mean += away / n;
    squares += away * (value - mean);
  }
};

}  // namespace

Result<ShotSeries> shoot_series(const thesis::Condition& condition, const Prediction& prediction, int shots,
                                std::uint64_t seed, bool exact) {
  auto scene = scene_of(condition, prediction);
  if (!scene) return tl::unexpected(scene.error());
  if (exact) make_exact(*scene);
  auto shooter = sim::Shooter::make(*scene, seed, sim::Model::full(), {.perfect_digitizer = exact});
  if (!shooter) return tl::unexpected(shooter.error());
  std::array<Sums, kQuantityCount> sums;
  ShotSeries series;
  for (int shot = 1; shot <= (exact ? 1 : shots); ++shot) {
    ++series.shots;
    const auto readout = reduction::reduce(shooter->shoot(shot).frame, reduction::Estimator::best);
    if (!readout || !readout->value[Quantity::vx_lo_mps]) {
      ++series.without_readout;
      continue;
    }
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      if (const auto value = readout->value[static_cast<Quantity>(i)]) sums[i].add(*value);
  }
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    if (sums[i].n == 0.0) continue;
    series.mean[static_cast<Quantity>(i)] = sums[i].mean;
    series.sd[static_cast<Quantity>(i)] = std::sqrt(sums[i].squares / sums[i].n);
  }
  return series;
}

}  // namespace strobe::studies
