#include "host/assembly/leg_fit.hpp"

#include <cmath>

namespace strobe::host {

double LegFit::velocity_factor() const { return 1.0 / std::sqrt(spread_s2); }

double LegFit::position_factor(double time_s) const {
  const double dt = time_s - middle_s;
  return std::sqrt(1.0 / count + dt * dt / spread_s2);
}

LegFit fit_leg(std::span<const TrackPoint> images, std::span<const double> times_s, const Track& track) {
  LegFit fit;
  fit.count = static_cast<int>(images.size());
  if (images.empty()) return fit;
  const double n = fit.count;
  for (const double t : times_s) fit.middle_s += t / n;
  double sum_a = 0.0, sum_u = 0.0, sum_ta = 0.0, sum_tu = 0.0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const double dt = times_s[i] - fit.middle_s;
    const double along = images[i].along_px - 0.5 * track.gravity_along_px * dt * dt;
    const double up = images[i].up_px - 0.5 * track.gravity_up_px * dt * dt;
    fit.spread_s2 += dt * dt;
    sum_a += along;
    sum_u += up;
    sum_ta += dt * along;
    sum_tu += dt * up;
  }
  fit.along_px = sum_a / n;
  fit.up_px = sum_u / n;
  if (!fit.has_velocity()) return fit;
  fit.v_along_px = sum_ta / fit.spread_s2;
  fit.v_up_px = sum_tu / fit.spread_s2;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const double dt = times_s[i] - fit.middle_s;
    const double half = 0.5 * dt * dt;
    const double along =
        images[i].along_px - (fit.along_px + fit.v_along_px * dt + track.gravity_along_px * half);
    const double up = images[i].up_px - (fit.up_px + fit.v_up_px * dt + track.gravity_up_px * half);
    fit.chi_squared += along * along + up * up;
  }
  fit.chi_squared /= track.sd_px * track.sd_px;
  return fit;
}

std::optional<Crossing> crossing(const LegFit& fit, const Track& track) {
  if (!fit.has_velocity() || fit.v_up_px == 0.0) return std::nullopt;
  double dt = (track.radius_px - fit.up_px) / fit.v_up_px;
  for (int step = 0; step < 3; ++step) {  // Newton: gravity bends the path by far less than a radius
    const double slope = fit.v_up_px + track.gravity_up_px * dt;
    if (slope * fit.v_up_px <= 0.0) return std::nullopt;
    dt -= (fit.up_px + fit.v_up_px * dt + 0.5 * track.gravity_up_px * dt * dt - track.radius_px) / slope;
  }
  Crossing cross;
  cross.time_s = fit.middle_s + dt;
  cross.along_px = fit.along_px + fit.v_along_px * dt + 0.5 * track.gravity_along_px * dt * dt;
  cross.v_along_px = fit.v_along_px + track.gravity_along_px * dt;
  cross.v_up_px = fit.v_up_px + track.gravity_up_px * dt;
  return cross;
}

}  // namespace strobe::host
