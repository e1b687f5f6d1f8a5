#include "common/reduction/matching/contact_match.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace strobe::matching {
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

/// An image of the ball costs what its place is off, two in the mean; one that is none does not.
constexpr double kExpectedMiss = 2.0;

double is_ball(const TrackPoint& image) { return -2.0 * std::log(image.probability); }
double is_no_ball(const TrackPoint& image) {
  const bool certain = !(image.probability < 1.0);
  return certain ? std::numeric_limits<double>::infinity()
                 : kExpectedMiss - 2.0 * std::log(1.0 - image.probability);
}

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

/// Next to the one leg that is known, else from the first flash on.
int first_beside(std::size_t count, const LegCandidate& in, const LegCandidate& out) {
  if (!in.empty()) return in.last() + 1;
  return out.empty() ? 0 : out.first() - static_cast<int>(count);
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
  r.dwell = track.dwell;
  return r;
}

double contact_penalty(const BounceEstimate& r) {
  const auto& [vx_td, vy_td, vx_lo, vy_lo, dwell, distance] = r.value;
  if (vy_td >= 0.0 || vy_lo <= 0.0) return std::numeric_limits<double>::infinity();
  double penalty = squared(outside(dwell, r.dwell.least_s, r.dwell.most_s) / r.sd[4]);
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

ContactMatcher::ContactMatcher(std::span<const TrackPoint> images, std::span<const double> times_s,
                               const Track& track)
    : images_(images),
      times_s_(times_s),
      track_(track),
      variance_(squared(track.sd_px) + squared(kContactModelSd_m * track.px_per_m)),
      missed_(-2.0 * std::log(track.missed_share)) {
  for (const TrackPoint& image : images) no_ball_.push_back(is_no_ball(image));
  least_no_ball_ = no_ball_;
  std::ranges::sort(least_no_ball_);
  std::partial_sum(least_no_ball_.begin(), least_no_ball_.end(), least_no_ball_.begin());
}

double ContactMatcher::least_penalty(int flashes) const {
  const int missed = flashes - static_cast<int>(images_.size());
  return missed >= 0 ? missed_ * missed : least_no_ball_[static_cast<std::size_t>(-missed - 1)];
}

const ContactFlashes& ContactMatcher::match(const LegCandidate& in, const LegCandidate& out) {
  best_.flash.resize(images_.size());
  best_.penalty = 0.0;
  if (in.empty() || out.empty()) {
    take_from(first_beside(images_.size(), in, out));
    return best_;
  }
  const int first = in.last() + 1, flashes = out.first() - first;
  if (images_.empty() || !in.crossing || !out.crossing || in.crossing->time_s >= out.crossing->time_s) {
    take_from(first);
    const bool enough = flashes >= static_cast<int>(images_.size());
    best_.penalty = enough ? least_penalty(flashes) : std::numeric_limits<double>::infinity();
    return best_;
  }
  expected_.resize(static_cast<std::size_t>(flashes));
  set_expected(*in.crossing, *out.crossing, first);
  fill_costs();
  best_.penalty = cost(images_.size(), expected_.size());
  if (std::isfinite(best_.penalty)) trace_back(first);
  return best_;
}

void ContactMatcher::take_from(int first) { std::iota(best_.flash.begin(), best_.flash.end(), first); }

void ContactMatcher::set_expected(const geometry::Crossing& down, const geometry::Crossing& off, int first) {
  for (std::size_t j = 0; j < expected_.size(); ++j) {
    const double time_s = times_s_[static_cast<std::size_t>(first) + j];
    const double depth = depth_at(time_s, down, off);
    expected_[j] = {place_at(time_s, down, off), depth, variance_ + squared(kDepthModelShare * depth)};
  }
}

double ContactMatcher::miss(std::size_t image, std::size_t slot) const {
  const Expected& at = expected_[slot];
  const Eigen::Vector2d& centre = images_[image].centre_px;
  const double deep = track_.radius_px - centre.y() - at.depth_px;
  return squared(centre.x() - at.place_px) / variance_ + squared(deep) / at.depth_variance;
}

void ContactMatcher::fill_costs() {
  const std::size_t n = images_.size(), m = expected_.size();
  cost_.resize((n + 1) * (m + 1));
  for (std::size_t j = 0; j <= m; ++j) cost(0, j) = missed_ * static_cast<double>(j);
  for (std::size_t i = 1; i <= n; ++i) {
    const double ball = is_ball(images_[i - 1]);
    cost(i, 0) = cost(i - 1, 0) + no_ball_[i - 1];
    for (std::size_t j = 1; j <= m; ++j)
      cost(i, j) = std::min({cost(i, j - 1) + missed_, cost(i - 1, j) + no_ball_[i - 1],
                             cost(i - 1, j - 1) + miss(i - 1, j - 1) + ball});
  }
}

void ContactMatcher::trace_back(int first) {
  for (std::size_t i = images_.size(), j = expected_.size(); i > 0;) {
    if (j > 0 && cost(i, j) == cost(i, j - 1) + missed_) {
      --j;
    } else if (cost(i, j) == cost(i - 1, j) + no_ball_[i - 1]) {
      best_.flash[--i] = kNoFlash;
    } else {
      best_.flash[--i] = first + static_cast<int>(--j);
    }
  }
}

}  // namespace strobe::matching
