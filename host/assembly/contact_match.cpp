#include "host/assembly/contact_match.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace strobe::host {
namespace {

// The cubic leaves out the true course of the friction: about 3 mm.
constexpr double kContactModelSd_m = 3e-3;
// The half sine leaves out the force's true course: this share of the depth, beside kContactModelSd_m.
constexpr double kDepthModelShare = 0.15;
// Distance over dwell lies between the two velocities; this part of their difference is allowed beyond.
constexpr double kMeanMargin = 0.1;
constexpr double kMinRestitution = 0.2;
constexpr double kMaxRestitution = 1.0;

double outside(double value, double least, double most) {
  if (value < least) return least - value;
  return value > most ? value - most : 0.0;
}

double squared(double z) { return z * z; }

/// Place along the surface: straight flight outside the contact, a cubic that keeps both ends' velocity
/// within.
double place_at(double time_s, const geometry::Crossing& down, const geometry::Crossing& off) {
  if (time_s <= down.time_s) return down.position.x() + down.velocity.x() * (time_s - down.time_s);
  if (time_s >= off.time_s) return off.position.x() + off.velocity.x() * (time_s - off.time_s);
  const double dwell = off.time_s - down.time_s;
  const double s = (time_s - down.time_s) / dwell;
  const double r = 1.0 - s;
  return r * r * (1.0 + 2.0 * s) * down.position.x() + s * s * (3.0 - 2.0 * s) * off.position.x() +
         s * r * dwell * (r * down.velocity.x() - s * off.velocity.x());
}

/// How far the centre is below its height at touchdown: a half sine that keeps both ends' velocity.
double depth_at(double time_s, const geometry::Crossing& down, const geometry::Crossing& off) {
  const double dwell = off.time_s - down.time_s;
  const double s = std::clamp((time_s - down.time_s) / dwell, 0.0, 1.0);
  const double speed = (1.0 - s) * std::abs(down.velocity.y()) + s * std::abs(off.velocity.y());
  return dwell / std::numbers::pi * std::sin(std::numbers::pi * s) * speed;
}

std::vector<int> between(const LegCandidate& in, const LegCandidate& out) {
  std::vector<int> slots(static_cast<std::size_t>(std::max(0, out.first() - in.last() - 1)));
  std::iota(slots.begin(), slots.end(), in.last() + 1);
  return slots;
}

/// Next to the one leg that is known, else from the first flash on.
std::vector<int> adjacent(std::size_t count, const LegCandidate& in, const LegCandidate& out) {
  std::vector<int> slots(count);
  const int first = !in.empty() ? in.last() + 1 : !out.empty() ? out.first() - static_cast<int>(count) : 0;
  std::iota(slots.begin(), slots.end(), first);
  return slots;
}

}  // namespace

BounceEstimate estimate_bounce(const LegCandidate& in, const LegCandidate& out, const Track& track) {
  const geometry::Crossing& down = *in.crossing;
  const geometry::Crossing& off = *out.crossing;
  BounceEstimate r;
  const double dwell = off.time_s - down.time_s;
  r.value = {down.velocity.x(),
             down.velocity.y(),
             off.velocity.x(),
             off.velocity.y(),
             dwell,
             off.position.x() - down.position.x()};
  const double v_in = track.sd_px * std::sqrt(in.fit.velocity_variance());
  const double v_out = track.sd_px * std::sqrt(out.fit.velocity_variance());
  const double p_in = track.sd_px * std::sqrt(in.fit.position_variance(down.time_s));
  const double p_out = track.sd_px * std::sqrt(out.fit.position_variance(off.time_s));
  // A height error moves the crossing's time by error / v_up, and with it its place.
  const double t_in = p_in / std::abs(down.velocity.y());
  const double t_out = p_out / std::abs(off.velocity.y());
  const double x_in = std::hypot(p_in, t_in * down.velocity.x());
  const double x_out = std::hypot(p_out, t_out * off.velocity.x());
  r.sd = {v_in, v_in, v_out, v_out, std::hypot(t_in, t_out), std::hypot(x_in, x_out)};
  r.contact_model_sd_px = kContactModelSd_m * track.px_per_m;
  return r;
}

double contact_penalty(const BounceEstimate& r) {
  const auto& [vx_td, vy_td, vx_lo, vy_lo, dwell, distance] = r.value;
  if (vy_td >= 0.0 || vy_lo <= 0.0) return std::numeric_limits<double>::infinity();
  double penalty = squared(outside(dwell, kShortestDwell_s, kLongestDwell_s) / r.sd[4]);
  const double restitution = -vy_lo / vy_td;
  const double restitution_sd = std::hypot(r.sd[3], restitution * r.sd[1]) / std::abs(vy_td);
  penalty += squared(outside(restitution, kMinRestitution, kMaxRestitution) / restitution_sd);
  // Judged as a distance: a dwell near zero would make distance over dwell meaningless.
  const double margin = kMeanMargin * std::abs(vx_td - vx_lo);
  const double slow = std::min(vx_td, vx_lo) - margin;
  const double fast = std::max(vx_td, vx_lo) + margin;
  const double positive_dwell = std::max(dwell, 0.0);
  const double sd =
      std::hypot(r.sd[5], 0.5 * (std::abs(slow) + std::abs(fast)) * r.sd[4], r.contact_model_sd_px);
  return penalty + squared(outside(distance, slow * positive_dwell, fast * positive_dwell) / sd);
}

ContactFlashes contact_flashes(std::span<const TrackPoint> images, const LegCandidate& in,
                               const LegCandidate& out, std::span<const double> times_s, const Track& track) {
  ContactFlashes best;
  if (images.empty()) return best;
  if (in.empty() || out.empty()) {
    best.flash = adjacent(images.size(), in, out);
    return best;
  }
  const std::vector<int> slots = between(in, out);
  if (!in.crossing || !out.crossing || in.crossing->time_s >= out.crossing->time_s) {
    best.flash.assign(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(images.size()));
    return best;
  }
  const double variance = squared(track.sd_px) + squared(kContactModelSd_m * track.px_per_m);
  // Dynamic programming over (image, slot): the least cost of the first i images in the first j slots.
  const std::size_t n = images.size(), m = slots.size();
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::vector<double> cost((n + 1) * (m + 1), kNever);
  const auto at = [&](std::size_t i, std::size_t j) -> double& { return cost[i * (m + 1) + j]; };
  const auto with = [&](std::size_t i, std::size_t j) {
    const double time_s = times_s[static_cast<std::size_t>(slots[j - 1])];
    const double place = place_at(time_s, *in.crossing, *out.crossing);
    const double depth = depth_at(time_s, *in.crossing, *out.crossing);
    const double miss = track.radius_px - images[i - 1].centre_px.y() - depth;
    return at(i - 1, j - 1) + squared(images[i - 1].centre_px.x() - place) / variance +
           squared(miss) / (variance + squared(kDepthModelShare * depth));
  };
  for (std::size_t j = 0; j <= m; ++j) at(0, j) = 0.0;
  for (std::size_t i = 1; i <= n; ++i) {
    for (std::size_t j = i; j <= m; ++j) at(i, j) = std::min(at(i, j - 1), with(i, j));
  }
  best.chi_squared = at(n, m);
  best.flash.resize(n);
  for (std::size_t i = n, j = m; i > 0; --j) {
    if (j > i && at(i, j) == at(i, j - 1)) continue;
    best.flash[--i] = slots[j - 1];
  }
  return best;
}

}  // namespace strobe::host
