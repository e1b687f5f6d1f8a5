#include "sim/effects/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/reduction/reduce.hpp"

namespace strobe::sim {

namespace {

using reduction::Quantity;

constexpr double kUnstatedCentre_m = 1e-4;
constexpr double kUnstatedEquator_rad = 0.1 * std::numbers::pi / 180.0;

/// Of the frame, from what is measured of the ball.
double px_per_m(const reduction::Frame& frame) {
  double sum = 0.0;
  for (const reduction::BallImage& image : frame.images) sum += image.diameter_px;
  return frame.images.empty() ? 1.0
                              : sum / (static_cast<double>(frame.images.size()) * frame.ball_diameter_m);
}

}  // namespace

void PerQuantity::max_with(const PerQuantity& other) {
  for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = std::max(values_[i], other.values_[i]);
}

bool PerQuantity::all_zero() const {
  return std::ranges::all_of(values_, [](double value) { return value == 0.0; });
}

bool within(const PerQuantity& change, const PerQuantity& allowed) {
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q)
    if (!(change[q] <= allowed[q])) return false;
  return true;
}

PerQuantity difference(const reduction::Quantities& a, const reduction::Quantities& b) {
  PerQuantity result;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (a[q] && b[q]) result[i] = std::abs(*a[q] - *b[q]);
    if (a[q].has_value() != b[q].has_value()) result[i] = std::numeric_limits<double>::infinity();
  }
  return result;
}

reduction::Quantities readout_of(reduction::Frame frame) {
  const double scale = px_per_m(frame);
  if (!frame.centre_sd_px) frame.centre_sd_px = kUnstatedCentre_m * scale;
  if (!frame.surface_sd_px) frame.surface_sd_px = frame.centre_sd_px;
  if (!frame.diameter_sd_px) frame.diameter_sd_px = 2.0 * *frame.centre_sd_px;
  if (!frame.equator_sd_rad) frame.equator_sd_rad = kUnstatedEquator_rad;
  const auto readout = reduction::reduce(frame, reduction::Estimator::best,
                                         {.effects = flight::Effects{}, .reject_outliers = false});
  return readout ? readout->value : reduction::Quantities{};
}

PerQuantity readout_scales(const Scene& scene) {
  const double v = scene.machine.speed_mps;
  constexpr double kRadian_deg = 180.0 / std::numbers::pi;
  PerQuantity scale;
  for (const Quantity q : {Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::v_td_mps, Quantity::vx_lo_mps,
                           Quantity::vy_lo_mps, Quantity::v_lo_mps, Quantity::slip_lo_mps})
    scale[q] = v;
  for (const Quantity q : {Quantity::omega_td_radps, Quantity::omega_lo_radps})
    scale[q] = v / scene.ball.radius_m();
  for (const Quantity q : {Quantity::theta_in_deg, Quantity::theta_out_deg}) scale[q] = kRadian_deg;
  for (const Quantity q : {Quantity::e, Quantity::mu}) scale[q] = 1.0;
  scale[Quantity::dwell_time_ms] = 1e3 * scene.bounce.dwell_s;
  scale[Quantity::dwell_distance_cm] = 1e2 * v * scene.bounce.dwell_s;
  scale[Quantity::court_pace] = 100.0;
  return scale;
}

PerQuantity tolerances(const Scene& scene, double relative) {
  PerQuantity result = readout_scales(scene);
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) result[i] *= relative;
  for (const auto& [quantity, absolute] : scene.readout.absolute)
    result[quantity] = absolute < 0.0 ? std::numeric_limits<double>::infinity() : absolute;
  return result;
}

reduction::Quantity worst(const PerQuantity& change, const PerQuantity& tolerance) {
  std::size_t result = 0;
  double largest = -1.0;
  for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) {
    const double share = change[q] > 0.0 ? change[q] / tolerance[q] : 0.0;
    if (!(share > largest)) continue;  // infinite of infinite is none
    largest = share;
    result = q;
  }
  return static_cast<reduction::Quantity>(result);
}

std::string_view unit(Quantity quantity) {
  const std::string_view name = reduction::name(quantity);
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kUnits{
      {{"_radps", "rad/s"}, {"_mps", "m/s"}, {"_deg", "deg"}, {"_ms", "ms"}, {"_cm", "cm"}}};
  for (const auto& [suffix, text] : kUnits) {
    if (name.ends_with(suffix)) return text;
  }
  return "";
}

}  // namespace strobe::sim
