// What makes a frame one that can be reduced.
#include <cmath>
#include <string>

#include "common/reduction/observations.hpp"

namespace strobe::reduction {
namespace {

using Complaint = std::optional<std::string>;

bool finite(const PointPx& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

bool bad_sd(const std::optional<double>& sd) { return sd && !(std::isfinite(*sd) && *sd > 0.0); }

Complaint invalid_covariance(const std::array<double, 4>& c) {
  const bool numbers =
      std::isfinite(c[0]) && std::isfinite(c[1]) && std::isfinite(c[2]) && std::isfinite(c[3]);
  const double mean = 0.5 * (c[1] + c[2]);
  if (!numbers || !(c[0] > 0.0) || !(c[0] * c[3] > mean * mean)) return "must be positive definite";
  if (std::abs(c[1] - c[2]) > 1e-6 * std::sqrt(c[0] * c[3])) return "must be symmetric";
  return std::nullopt;
}

Complaint invalid_image(const BallImage& image) {
  if (!std::isfinite(image.time_s)) return "time_s: must be a finite number";
  if (!finite(image.centre_px)) return "centre_px: must be two finite numbers";
  const bool contact = image.leg == Leg::contact;  // a flattened ball may have no diameter
  if (!std::isfinite(image.diameter_px) || (!contact && !(image.diameter_px > 0.0))) {
    return "diameter_px: must be a positive number";
  }
  if (image.equator_rad && !std::isfinite(*image.equator_rad)) return "equator_rad: must be a finite number";
  if (image.time_sd_s && !(std::isfinite(*image.time_sd_s) && *image.time_sd_s >= 0.0)) {
    return "time_sd_s: must not be negative";
  }
  if (bad_sd(image.diameter_sd_px)) return "diameter_sd_px: must be positive";
  if (bad_sd(image.equator_sd_rad)) return "equator_sd_rad: must be positive";
  if (image.centre_cov_px2) {
    if (const Complaint c = invalid_covariance(*image.centre_cov_px2)) return "centre_cov_px2: " + *c;
  }
  return std::nullopt;
}

Complaint invalid_constants(const Frame& frame) {
  if (!(frame.ball_diameter_m >= 0.01 && frame.ball_diameter_m <= 1.0)) {
    return "ball_diameter_m: must be within 0.01 and 1";
  }
  if (frame.ball_diameter_sd_m && !(*frame.ball_diameter_sd_m >= 0.0 && *frame.ball_diameter_sd_m < 1.0)) {
    return "ball_diameter_sd_m: must be at least 0 and less than 1";
  }
  if (bad_sd(frame.surface_sd_px)) return "surface_sd_px: must be positive";
  if (bad_sd(frame.centre_sd_px)) return "centre_sd_px: must be positive";
  if (bad_sd(frame.diameter_sd_px)) return "diameter_sd_px: must be positive";
  if (bad_sd(frame.equator_sd_rad)) return "equator_sd_rad: must be positive";
  if (bad_sd(frame.px_per_m)) return "px_per_m: must be positive";
  if (frame.px_per_m_sd && !(*frame.px_per_m_sd >= 0.0 && std::isfinite(*frame.px_per_m_sd))) {
    return "px_per_m_sd: must not be negative";
  }
  if (!(std::abs(frame.surface_angle_deg) <= 90.0)) return "surface_angle_deg: must be within -90 and 90";
  if (frame.temperature_c && !std::isfinite(*frame.temperature_c))
    return "temperature_c: must be a finite number";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> invalid(const Frame& frame) {
  if (Complaint complaint = invalid_constants(frame)) return complaint;
  if (frame.surface_px.size() < 2) return "surface_px: needs at least two points";
  for (std::size_t i = 0; i < frame.surface_px.size(); ++i) {
    if (!finite(frame.surface_px[i]))
      return "surface_px[" + std::to_string(i) + "]: must be two finite numbers";
  }
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const std::string place = "images[" + std::to_string(i) + "].";
    if (const Complaint complaint = invalid_image(frame.images[i])) return place + *complaint;
    if (i > 0 && !(frame.images[i].time_s > frame.images[i - 1].time_s)) {
      return place + "time_s: must be later than the image before";
    }
  }
  return std::nullopt;
}

}  // namespace strobe::reduction
