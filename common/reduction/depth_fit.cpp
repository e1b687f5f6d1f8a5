#include "common/reduction/depth_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/attitude/line_normal.hpp"
#include "common/attitude/line_spin.hpp"
#include "common/reduction/lift_misfit.hpp"
#include "common/reduction/propagate.hpp"

namespace strobe::reduction {
namespace {

/// Touchdown and lift-off; where a leg does not meet the surface its image next to the other leg's.
std::optional<std::array<double, 2>> contact_s(const ShotFit& fit) {
  const auto& legs = fit.joint.legs;
  if (!legs[0].fitted && !legs[1].fitted) return std::nullopt;
  Readout numbers;
  const Crossings crossings = propagate(fit, {}, numbers);
  const double end = legs[0].fitted ? legs[0].last_s : legs[1].first_s;
  const double start = legs[1].fitted ? legs[1].first_s : legs[0].last_s;
  const double touchdown = crossings[0].value_or(end);
  return std::array{touchdown, std::max(touchdown, crossings[1].value_or(start))};
}

/// What a rate before and after the bounce adds up to since the middle of the contact, in which it is their
/// mean.
Eigen::Vector2d since_bounce(const std::array<double, 2>& contact_s, double time_s) {
  const double half = 0.5 * (contact_s[1] - contact_s[0]), middle = contact_s[0] + half;
  if (half > 0.0 && std::abs(time_s - middle) < half)
    return Eigen::Vector2d::Constant(0.5 * (time_s - middle));
  const double mean = std::copysign(0.5 * half, time_s - middle), rest = time_s - middle - 2.0 * mean;
  return time_s < middle ? Eigen::Vector2d(mean + rest, mean) : Eigen::Vector2d(mean, mean + rest);
}

PointPx from_foot(const PointPx& point, const PointPx& foot, double factor) {
  return {foot.x + factor * (point.x - foot.x), foot.y + factor * (point.y - foot.y)};
}

/// Of the rates, before any diameter: a machine is aimed along the plane to kAimSd_rad.
Eigen::Matrix2d aim_of(const Frame& frame, const ShotFit& fit) {
  Eigen::Matrix2d aim = Eigen::Matrix2d::Zero();
  for (const std::size_t leg : {0, 1}) {
    const double sd = kAimSd_rad * mean_speed_mps(fit.observations, leg) / frame.lens->distance_m;
    aim(static_cast<Eigen::Index>(leg), static_cast<Eigen::Index>(leg)) = std::max(sd * sd, 1e-12);
  }
  return aim;
}

}  // namespace

Frame seen_on_axis(Frame frame) {
  double diameters_px = 0.0;
  for (const BallImage& image : frame.images) diameters_px += image.diameter_px;
  const double images = static_cast<double>(frame.images.size());
  const double scale = frame.px_per_m.value_or(diameters_px / (images * frame.ball_diameter_m));
  const double lens_px = frame.lens->distance_m * scale;
  for (BallImage& image : frame.images) {
    if (!image.equator_tilt_rad) continue;
    const Eigen::Vector2d sight(frame.lens->foot_px.x - image.centre_px.x,
                                frame.lens->foot_px.y - image.centre_px.y);
    const Eigen::Vector3d normal =
        attitude::line_plane(*image.equator_rad, *image.equator_tilt_rad, sight / lens_px).normal;
    image.equator_rad = attitude::line_angle_rad(normal, Eigen::Vector2d::Zero());
    image.equator_tilt_rad = std::asin(std::clamp(-normal.z(), -1.0, 1.0));
  }
  return frame;
}

std::optional<DepthFit> fit_depth(const Frame& frame, const ShotFit& fit) {
  const auto at = contact_s(fit);
  if (!frame.lens || !at) return std::nullopt;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::array<int, 2> count{};
  // Where a calibration is the scale none is in use.
  const bool any_used = std::ranges::any_of(fit.observations.images, &Observation::use_diameter);
  // 1/diameter falls in proportion to the height.
  DepthFit depth;
  depth.diameter_px = frame.images.front().diameter_px;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const Observation& o = fit.observations.images[i];
    if (!(any_used ? o.use_diameter : o.use_centre) || !o.leg || *o.leg == Leg::contact) continue;
    const std::size_t leg = leg_index(*o.leg);
    const double inverse = depth.diameter_px / frame.images[i].diameter_px;
    const double sd = inverse * fit.observations.diameter_sd(o) / o.diameter_m;
    const Eigen::Vector2d since = since_bounce(*at, o.time_s);
    const Eigen::Vector3d row(1.0, -since.x(), -since.y());
    ++count[leg];
    matrix.noalias() += row * row.transpose() / (sd * sd);
    right.noalias() += row * (inverse / (sd * sd));
  }
  // A leg of which no rate is told keeps its depth.
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (count[leg] < 2)
      matrix(1 + static_cast<Eigen::Index>(leg), 1 + static_cast<Eigen::Index>(leg)) += 1e12;
  }
  if (count[0] + count[1] < 3) return std::nullopt;
  const Eigen::Matrix3d covariance = matrix.inverse();
  const Eigen::Vector3d value = covariance * right;
  if (!covariance.allFinite() || !(value[0] > 0.0)) return std::nullopt;
  depth.contact_s = *at;
  depth.diameter_px /= value[0];
  depth.diameter_sd_px = depth.diameter_px * std::sqrt(covariance(0, 0)) / value[0];
  depth.rate_per_s = value.tail<2>() / value[0];
  depth.covariance = covariance.bottomRightCorner<2, 2>() / (value[0] * value[0]);
  // Unless an aim off the plane explains them hardly better.
  const Eigen::Matrix2d with_aim = depth.covariance + aim_of(frame, fit);
  const double gain = depth.rate_per_s.dot(depth.covariance.ldlt().solve(depth.rate_per_s)) -
                      depth.rate_per_s.dot(with_aim.ldlt().solve(depth.rate_per_s));
  depth.moves = gain > attitude::kRejectedOfTwo;
  return depth;
}

/// All images as seen at the bounce's depth.
void put_at_one_depth(const DepthFit& depth, const ShotFit& fit, Frame& frame) {
  const PointPx& foot = frame.lens->foot_px;
  const Eigen::Matrix2d root = depth.covariance.llt().matrixL();
  std::array<MapError, 2> errors;
  for (MapError& e : errors) e.surface_px.resize(frame.surface_px.size());
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    BallImage& image = frame.images[i];
    const Eigen::Vector2d since = since_bounce(depth.contact_s, fit.observations.images[i].time_s);
    const double factor = 1.0 - depth.rate_per_s.dot(since);
    image.centre_px = from_foot(image.centre_px, foot, factor);
    if (image.top_px) image.top_px = from_foot(*image.top_px, foot, factor);
    image.diameter_px *= factor;
    for (Eigen::Index k = 0; k < 2; ++k) {
      const double share = -root.col(k).dot(since);
      errors[static_cast<std::size_t>(k)].images.push_back(
          {{share * (image.centre_px.x - foot.x), share * (image.centre_px.y - foot.y)},
           share * image.diameter_px,
           0.0});
    }
  }
  for (MapError& e : errors) frame.map_errors.push_back(std::move(e));
}

std::array<ObservedMapError, 2> depth_doubt(const DepthFit& depth, const Frame& frame, const ShotFit& fit) {
  const Observations& all = fit.observations;
  const Eigen::Matrix2d aim = aim_of(frame, fit);
  // Of a rate with a mean of 0 before; the mean that is left uncorrected counts with its square.
  const Eigen::Matrix2d gain = aim * (aim + depth.covariance).inverse();
  const Eigen::Vector2d mean = gain * depth.rate_per_s;
  const Eigen::Matrix2d moment = aim - gain * aim + mean * mean.transpose();
  const Eigen::Matrix2d root = (0.5 * (moment + moment.transpose())).llt().matrixL();
  const Eigen::Vector2d foot = all.surface.from_image({frame.lens->foot_px.x, frame.lens->foot_px.y});
  std::array<ObservedMapError, 2> errors;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    errors[k].surface_m.resize(all.surface_m.size(), Eigen::Vector2d::Zero());
    for (const Observation& o : all.images) {
      const double share =
          root.col(static_cast<Eigen::Index>(k)).dot(since_bounce(depth.contact_s, o.time_s));
      errors[k].images.push_back({share * (o.centre_m - foot), share * o.diameter_m, 0.0});
    }
  }
  return errors;
}

void add_depth(const DepthFit& depth, const Frame& frame, const ShotFit& fit, Spatial& into) {
  const double lens_m = frame.lens->distance_m;
  double height_m = 0.0;
  if (frame.px_per_m) {
    // Of the plane's ball over the one seen.
    const double share = *frame.px_per_m * frame.ball_diameter_m / depth.diameter_px;
    height_m = lens_m * (1.0 - share);
    const double systematic = std::hypot(frame.px_per_m_sd.value_or(0.0) / *frame.px_per_m,
                                         fit.observations.size_sd_m() / frame.ball_diameter_m);
    into[SpatialQuantity::off_plane_mm] =
        DerivedNumber{1e3 * height_m, 1e3 * lens_m * share * depth.diameter_sd_px / depth.diameter_px,
                      1e3 * lens_m * share * systematic};
  }
  for (const std::size_t leg : {0, 1}) {
    if (!fit.joint.legs[leg].fitted) continue;
    const auto k = static_cast<Eigen::Index>(leg);
    const double sd = std::sqrt(depth.covariance(k, k));
    const SpatialQuantity name = leg == 0 ? SpatialQuantity::vz_td_mps : SpatialQuantity::vz_lo_mps;
    const double distance_m = lens_m - height_m;
    into[name] = DerivedNumber{distance_m * depth.rate_per_s[k], distance_m * sd, 0.0};
  }
}

}  // namespace strobe::reduction
