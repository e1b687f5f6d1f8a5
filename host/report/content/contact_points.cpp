#include "host/report/content/contact_points.hpp"

#include <cmath>

#include "common/reduction/observations.hpp"
#include "common/units/angles.hpp"

namespace strobe::lab_report {

namespace {

using reduction::Observation;
using reduction::Observations;
using reduction::Quantity;

/// The motion at touchdown and what the rotation is expected to be from it.
struct Touchdown {
  double time_s = 0.0;
  double x_m = 0.0;
  std::optional<double> equator_rad;
  double omega_td_radps = 0.0, omega_lo_radps = 0.0, dwell_s = 0.0;

  /// For a spin that changes evenly: good to much less than the quarter turn that tells equators apart.
  double expected_rotation_rad(double since_s) const {
    return omega_td_radps * since_s + 0.5 * (omega_lo_radps - omega_td_radps) * since_s * since_s / dwell_s;
  }
};

const Observation* last_incoming(const Observations& all) {
  const Observation* last = nullptr;
  for (const Observation& image : all.images)
    if (image.leg == strobe::Leg::incoming && image.use_centre) last = &image;
  return last;
}

std::optional<Touchdown> touchdown(const Observations& all, const reduction::Readout& readout) {
  const auto& value = readout.value;
  const auto vx = value[Quantity::vx_td_mps], vy = value[Quantity::vy_td_mps];
  const auto in = value[Quantity::omega_td_radps], out = value[Quantity::omega_lo_radps];
  const auto dwell_ms = value[Quantity::dwell_time_ms];
  const Observation* image = last_incoming(all);
  if (!image || !vx || !vy || !in || !out || !dwell_ms || !(*vy < 0.0) || !(*dwell_ms > 0.0))
    return std::nullopt;
  const double to_go_s = (image->centre_m.y() - 0.5 * all.ball_diameter_m) / -*vy;
  Touchdown td{.time_s = image->time_s + to_go_s,
               .x_m = image->centre_m.x() + *vx * to_go_s,
               .equator_rad = {},
               .omega_td_radps = *in,
               .omega_lo_radps = *out,
               .dwell_s = 1e-3 * *dwell_ms};
  if (image->use_equator) td.equator_rad = image->equator_rad + *in * to_go_s;
  return td;
}

std::optional<double> rotation_rad(const Touchdown& td, const reduction::BallImage& image,
                                   const Observation& observed, double since_s) {
  if (!td.equator_rad || !image.equator_rad) return std::nullopt;
  const double expected = td.expected_rotation_rad(since_s);
  return expected + std::remainder(observed.equator_rad - *td.equator_rad - expected, strobe::kPi);
}

}  // namespace

std::vector<ContactPoint> contact_points(const reduction::Frame& frame, const reduction::Readout& readout) {
  if (frame.images.empty() || reduction::validation_error(frame)) return {};
  reduction::FlagSet flags;
  const auto all = reduction::observe(frame, flags);
  const auto td = all ? touchdown(*all, readout) : std::nullopt;
  if (!td) return {};
  std::vector<ContactPoint> points;
  for (std::size_t i = 0; i < all->images.size(); ++i) {
    const Observation& observed = all->images[i];
    const reduction::BallImage& image = frame.images[i];
    const double since_s = observed.time_s - td->time_s;
    if (!image.top_px || since_s <= 0.0 || since_s >= td->dwell_s) continue;
    const Eigen::Vector2d top = all->surface.from_image({image.top_px->x, image.top_px->y});
    points.push_back({since_s, observed.centre_m.x() - td->x_m, top.y() - all->ball_diameter_m,
                      rotation_rad(*td, image, observed, since_s)});
  }
  return points;
}

}  // namespace strobe::lab_report
