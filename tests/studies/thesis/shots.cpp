#include "tests/studies/thesis/shots.hpp"

#include <cmath>

#include "common/reduction/reduce.hpp"
#include "sim/fit/fit.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::studies {

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
