#include "common/reduction/frame.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/ball/ball.hpp"

namespace strobe::reduction {
namespace {

using Complaint = std::optional<std::string>;

constexpr double kLargestPx = 1e12;
constexpr double kSmallest = 1e-9;
constexpr double kLargestRad = 1e6;
constexpr double kLongest_s = 1e9;
constexpr double kShortestInterval_s = 1e-9;

/// NaN is outside; asking raises no floating-point exception.
bool within(double value, double least, double most) {
  return std::isgreaterequal(value, least) && std::islessequal(value, most);
}
bool within(const PointPx& p) {
  return within(p.x, -kLargestPx, kLargestPx) && within(p.y, -kLargestPx, kLargestPx);
}
bool bad(const std::optional<double>& value, double least, double most) {
  return value && !within(*value, least, most);
}
bool bad_sd_px(const std::optional<double>& sd) { return bad(sd, kSmallest, kLargestPx); }
bool bad_sd_rad(const std::optional<double>& sd) { return bad(sd, kSmallest, kLargestRad); }
constexpr const char* kPointNeeded = "must be two numbers from -1e12 to 1e12";
constexpr const char* kLengthNeeded = "must be from 1e-9 to 1e12";
constexpr const char* kAngleSdNeeded = "must be from 1e-9 to 1e6";

Complaint invalid_covariance(const std::array<double, 4>& c) {
  constexpr double kMin = kSmallest * kSmallest;
  constexpr double kMax = kLargestPx * kLargestPx;
  const double mean = 0.5 * (c[1] + c[2]);
  if (!within(c[0], kMin, kMax) || !within(c[3], kMin, kMax) || !within(mean, -kMax, kMax)) {
    return "must be positive definite, variances from 1e-18 to 1e24";
  }
  const double largest = std::sqrt(c[0]) * std::sqrt(c[3]);
  // Closer to one, the correlation is all rounding.
  constexpr double kMaxCorrelation = 1.0 - 1e-12;
  if (!(std::abs(mean) <= kMaxCorrelation * largest)) return "must be positive definite";
  if (!(std::abs(c[1] - c[2]) <= 1e-6 * largest)) return "must be symmetric";
  return std::nullopt;
}

Complaint invalid_tilt(const BallImage& image) {
  if (!image.equator_tilt_rad) return std::nullopt;
  constexpr double kQuarterTurn = 1.5707963267948966;
  if (bad(image.equator_tilt_rad, -kQuarterTurn, kQuarterTurn))
    return "equator_tilt_rad: must be from -pi/2 to pi/2";
  if (!image.equator_rad) return "equator_tilt_rad: needs equator_rad";
  if (!image.equator_tilt_sd_rad) return "equator_tilt_rad: needs equator_tilt_sd_rad";
  if (bad_sd_rad(image.equator_tilt_sd_rad)) return std::string("equator_tilt_sd_rad: ") + kAngleSdNeeded;
  // Closer to one, the correlation is all rounding.
  if (bad(image.equator_tilt_correlation, -1.0 + 1e-12, 1.0 - 1e-12))
    return "equator_tilt_correlation: must be above -1 and below 1";
  return std::nullopt;
}

Complaint invalid_image(const BallImage& image) {
  if (!within(image.time_s, -kLongest_s, kLongest_s)) return "time_s: must be from -1e9 to 1e9";
  if (!within(image.centre_px)) return std::string("centre_px: ") + kPointNeeded;
  const bool contact = image.leg == Leg::contact;  // a flattened ball may have no diameter
  const bool any = contact && within(image.diameter_px, -kLargestPx, kLargestPx);
  if (!any && !within(image.diameter_px, kSmallest, kLargestPx)) {
    return std::string("diameter_px: ") + kLengthNeeded;
  }
  if (bad(image.equator_rad, -kLargestRad, kLargestRad)) {
    return "equator_rad: must be from -1e6 to 1e6";
  }
  if (bad(image.time_sd_s, 0.0, 1.0)) return "time_sd_s: must not be negative, nor above 1";
  if (bad_sd_px(image.diameter_sd_px)) return std::string("diameter_sd_px: ") + kLengthNeeded;
  if (bad_sd_rad(image.equator_sd_rad)) return std::string("equator_sd_rad: ") + kAngleSdNeeded;
  if (bad(image.probability, 0.0, 1.0) || image.probability == 0.0)
    return "probability: must be above 0, and not above 1";
  if (const Complaint c = invalid_tilt(image)) return c;
  if (image.centre_cov_px2) {
    if (const Complaint c = invalid_covariance(*image.centre_cov_px2)) return "centre_cov_px2: " + *c;
  }
  return std::nullopt;
}

Complaint invalid_noise(const Frame& frame) {
  if (bad_sd_px(frame.surface_sd_px)) return std::string("surface_sd_px: ") + kLengthNeeded;
  if (bad_sd_px(frame.centre_sd_px)) return std::string("centre_sd_px: ") + kLengthNeeded;
  if (bad_sd_px(frame.diameter_sd_px)) return std::string("diameter_sd_px: ") + kLengthNeeded;
  if (bad_sd_px(frame.shared_diameter_sd_px) && *frame.shared_diameter_sd_px != 0.0) {
    return "shared_diameter_sd_px: must not be negative; 0, or from 1e-9 to 1e12";
  }
  if (bad_sd_rad(frame.equator_sd_rad)) return std::string("equator_sd_rad: ") + kAngleSdNeeded;
  if (bad_sd_px(frame.px_per_m)) return std::string("px_per_m: ") + kLengthNeeded;
  if (bad_sd_px(frame.px_per_m_sd) && *frame.px_per_m_sd != 0.0) {
    return "px_per_m_sd: must not be negative; 0, or from 1e-9 to 1e12";
  }
  return std::nullopt;
}

Complaint invalid_law(const flight::AirLaw& law) {
  for (const flight::AirLawField& field : flight::kAirLawFields) {
    if (!within(law.*field.member, field.least, field.most))
      return "air_law." + std::string(field.name) + ": is out of range";
  }
  if (law.least_mps > law.most_mps) return "air_law.most_mps: must not be below least_mps";
  return std::nullopt;
}

Complaint invalid_constants(const Frame& frame) {
  if (!within(frame.ball_diameter_m, 0.01, 1.0)) return "ball_diameter_m: must be from 0.01 to 1";
  if (bad(frame.ball_diameter_sd_m, 0.0, 1.0)) return "ball_diameter_sd_m: must be from 0 to 1";
  if (bad(frame.ball_mass_kg, 0.001, 10.0)) return "ball_mass_kg: must be from 0.001 to 10";
  if (frame.ball_alpha &&
      (!within(*frame.ball_alpha, 0.0, ball::kThinShellAlpha) || *frame.ball_alpha == 0.0)) {
    return "ball_alpha: must be above 0 and at most 2/3";
  }
  if (bad(frame.fastest_spin_radps, 1e-9, 1e9)) return "fastest_spin_radps: must be from 1e-9 to 1e9";
  if (bad(frame.ball_alpha_sd, 0.0, ball::kThinShellAlpha)) return "ball_alpha_sd: must be from 0 to 2/3";
  if (bad(frame.air_density_kgpm3, 0.0, 100.0)) return "air_density_kgpm3: must be from 0 to 100";
  if (frame.lens) {
    if (!within(frame.lens->distance_m, 0.01, 1e6)) return "lens.distance_m: must be from 0.01 to 1e6";
    if (!within(frame.lens->foot_px)) return std::string("lens.foot_px: ") + kPointNeeded;
  }
  if (frame.air_law) {
    if (const Complaint c = invalid_law(*frame.air_law)) return c;
  }
  if (!within(frame.surface_angle_deg, -90.0, 90.0)) return "surface_angle_deg: must be from -90 to 90";
  if (bad(frame.temperature_c, kMinTemperature_degC, kMaxTemperature_degC)) {
    return "temperature_c: must be from -60 to 100";
  }
  return invalid_noise(frame);
}

Complaint invalid_map_error(const MapError& error, const Frame& frame) {
  if (error.images.size() != frame.images.size()) return "images: must be one for each image";
  if (error.surface_px.size() != frame.surface_px.size()) return "surface_px: must be one for each point";
  const bool images = std::ranges::all_of(error.images, [](const MapError::Shift& s) {
    return within(s.centre_px) && within(s.diameter_px, -kLargestPx, kLargestPx) &&
           within(s.equator_rad, -kLargestRad, kLargestRad);
  });
  if (!images) return "images: must be numbers, pixels from -1e12 to 1e12 and angles from -1e6 to 1e6";
  if (!std::ranges::all_of(error.surface_px, [](const PointPx& p) { return within(p); }))
    return std::string("surface_px: ") + kPointNeeded;
  return std::nullopt;
}

Complaint invalid_map_errors(const Frame& frame) {
  constexpr std::size_t kMaxMapErrors = 64;
  if (frame.map_errors.size() > kMaxMapErrors) return "map_errors: at most 64";
  for (std::size_t i = 0; i < frame.map_errors.size(); ++i) {
    if (const Complaint complaint = invalid_map_error(frame.map_errors[i], frame))
      return "map_errors[" + std::to_string(i) + "]." + *complaint;
  }
  return std::nullopt;
}

/// Before and after it, or in it.
bool shows_bounce(const Frame& frame) {
  const auto any = [&](Leg leg) {
    return std::ranges::any_of(frame.images, [=](const BallImage& image) { return image.leg == leg; });
  };
  return any(Leg::contact) || (any(Leg::incoming) && any(Leg::rebound));
}

Complaint invalid_surface(const Frame& frame) {
  if (frame.surface_px.size() == 1) return "surface_px: needs at least two points";
  if (frame.surface_px.empty() && shows_bounce(frame))
    return "surface_px: needs at least two points, as the images are labelled as those of a bounce";
  for (std::size_t i = 0; i < frame.surface_px.size(); ++i) {
    if (!within(frame.surface_px[i])) return "surface_px[" + std::to_string(i) + "]: " + kPointNeeded;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> validation_error(const Frame& frame) {
  if (Complaint complaint = invalid_constants(frame)) return complaint;
  if (Complaint complaint = invalid_surface(frame)) return complaint;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const std::string place = "images[" + std::to_string(i) + "].";
    if (const Complaint complaint = invalid_image(frame.images[i])) return place + *complaint;
    if (i > 0 && !(frame.images[i].time_s - frame.images[i - 1].time_s >= kShortestInterval_s)) {
      return place + "time_s: must be later than the image before, by a nanosecond or more";
    }
  }
  return invalid_map_errors(frame);
}

std::optional<double> temperature_c(const Frame& frame) {
  if (frame.temperature_c) return frame.temperature_c;
  const auto entry = frame.record.find("temperature_c");
  if (entry == frame.record.end()) return std::nullopt;
  const std::string& text = entry->second;
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value >= kMinTemperature_degC && value <= kMaxTemperature_degC ? std::optional(value) : std::nullopt;
}

}  // namespace strobe::reduction
