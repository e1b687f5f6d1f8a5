#include "common/reduction/observations.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/reduction/legs.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

/// Starting levels where the frame states none: a hundredth of the ball's diameter and one degree, the order
/// of digitizing by hand. The residuals replace them; where these cannot, only the sd is lost, not the
/// number.
constexpr double kGuessOfDiameter = 0.01;
constexpr double kGuessEquatorRad = 0.0175;

/// Scale to start from: the calibrated one, or the median diameter of the images that may be airborne.
double first_scale(const Frame& frame) {
  if (frame.px_per_m) return *frame.px_per_m;
  std::vector<double> diameters;
  diameters.reserve(frame.images.size());
  for (const BallImage& image : frame.images) {
    if (image.leg != Leg::contact) diameters.push_back(image.diameter_px);
  }
  if (diameters.empty()) return 1.0 / frame.ball_diameter_m;  // nothing will be measured
  const auto middle = diameters.begin() + static_cast<std::ptrdiff_t>(diameters.size() / 2);
  std::nth_element(diameters.begin(), middle, diameters.end());
  return *middle / frame.ball_diameter_m;
}

Root root_of(const std::array<double, 4>& covariance) {
  const double xx = std::sqrt(covariance[0]);
  const double yx = 0.5 * (covariance[1] + covariance[2]) / xx;
  const double largest = std::sqrt(covariance[3]);
  return {xx, yx, std::sqrt((largest - yx) * (largest + yx))};
}

/// Rotated by -tilt and made triangular again; its determinant does not change.
Root levelled(const Root& l, const Levelling& levelling) {
  const double cos = levelling.cos_tilt;
  const double sin = levelling.sin_tilt;
  const Vec2 top{cos * l.xx + sin * l.yx, sin * l.yy};
  const Vec2 bottom{cos * l.yx - sin * l.xx, cos * l.yy};
  const double xx = std::hypot(top.x, top.y);
  const double px = levelling.px_per_m;
  return {xx / px, (top.x * bottom.x + top.y * bottom.y) / xx / px, l.xx / xx * l.yy / px};
}

void set_centre_noise(const BallImage& image, const Frame& frame, const Levelling& levelling,
                      Observation& o) {
  if (image.centre_cov_px2) {
    o.centre_cholesky_m = levelled(root_of(*image.centre_cov_px2), levelling);
  } else if (frame.centre_sd_px) {
    o.centre_cholesky_m.xx = o.centre_cholesky_m.yy = *frame.centre_sd_px / levelling.px_per_m;
  } else {
    o.centre_noise = Noise::centre;
  }
}

Observation observation(const BallImage& image, const Frame& frame, const Levelling& levelling) {
  Observation o;
  o.time_s = image.time_s - frame.images.front().time_s;
  o.centre_m = levelling.point(image.centre_px);
  o.diameter_m = image.diameter_px / levelling.px_per_m;
  set_centre_noise(image, frame, levelling, o);
  if (const auto sd = image.diameter_sd_px ? image.diameter_sd_px : frame.diameter_sd_px) {
    o.diameter_sd_m = *sd / levelling.px_per_m;
  } else {
    o.diameter_noise = Noise::diameter;
  }
  if (const auto sd = image.equator_sd_rad ? image.equator_sd_rad : frame.equator_sd_rad) {
    o.equator_sd_rad = *sd;
  } else {
    o.equator_noise = Noise::equator;
  }
  o.equator_rad = image.equator_rad.value_or(0.0);
  o.use_equator = image.equator_rad.has_value();
  o.time_sd_s = image.time_sd_s.value_or(0.0);
  return o;
}

void set_surface(const Frame& frame, Observations& all) {
  for (const PointPx& p : frame.surface_px) all.surface_m.push_back(all.levelling.point(p));
  if (const auto sd = frame.surface_sd_px ? frame.surface_sd_px : frame.centre_sd_px) {
    all.surface_sd_m = *sd / all.levelling.px_per_m;
    return;
  }
  const bool shared = std::any_of(all.images.begin(), all.images.end(),
                                  [](const Observation& o) { return o.centre_noise == Noise::centre; });
  all.surface_noise = shared ? Noise::centre : Noise::surface;
}

void set_scale(const Frame& frame, Observations& all) {
  if (!frame.px_per_m) return;
  all.scale = *frame.px_per_m / all.levelling.px_per_m;
  all.scale_sd = frame.px_per_m_sd.value_or(0.0) / all.levelling.px_per_m;
}

double mean_diameter_variance(const Observations& all) {
  double weight = 0.0;
  for (const Observation& o : all.images) weight += 1.0 / (all.diameter_sd(o) * all.diameter_sd(o));
  return weight > 0.0 ? 1.0 / weight : 0.0;
}

/// The images' diameters would tell the scale far better than the calibration does, were the ball's own
/// diameter known as well; where its tolerance is the greater doubt they tell the ball's size, not the scale.
bool diameters_tell_scale(const Observations& all) {
  if (!all.scale || !all.ball_diameter_sd_m) return true;
  return *all.ball_diameter_sd_m / all.ball_diameter_m < all.scale_sd / *all.scale;
}

void assign_legs(const Frame& frame, Observations& all, FlagSet& flags) {
  std::vector<Height> heights;
  heights.reserve(all.images.size());
  for (std::size_t i = 0; i < all.images.size(); ++i) {
    const Observation& o = all.images[i];
    heights.push_back(
        {o.time_s, o.centre_m.y - 0.5 * all.ball_diameter_m, all.centre_variance(o), frame.images[i].leg});
  }
  const double surface_variance =
      all.surface_sd() * all.surface_sd() / static_cast<double>(all.surface_m.size());
  const double reference = surface_variance + 0.25 * mean_diameter_variance(all);
  const LegAssignment found = classify_legs(heights, all.gravity_mps2.y, reference);
  if (!found.overlaps.empty()) flags.set(Flag::overlaps_surface);
  const bool scale_from_diameters = diameters_tell_scale(all);
  bool contact = false;
  for (std::size_t i = 0; i < all.images.size(); ++i) {
    Observation& o = all.images[i];
    o.leg = found.legs[i];
    const bool airborne = found.legs[i] != Leg::contact;
    contact = contact || !airborne;
    o.use_centre = airborne;
    o.use_diameter = airborne && scale_from_diameters;
    o.use_equator = o.use_equator && airborne;
  }
  if (!contact) flags.set(Flag::no_contact_image);
}

/// A ball within 3 degrees of the vertical has no direction of travel and is left as it is.
bool travels_left(const std::vector<Observation>& images, Leg leg) {
  const Observation* first = nullptr;
  const Observation* last = nullptr;
  for (const Observation& o : images) {
    if (o.leg != leg) continue;
    if (!first) first = &o;
    last = &o;
  }
  if (first == last) return false;
  const double dx = last->centre_m.x - first->centre_m.x;
  return dx < -0.05 * std::abs(last->centre_m.y - first->centre_m.y);
}

void mirror(Observations& all) {
  all.levelling.mirrored = true;
  all.gravity_mps2.x = -all.gravity_mps2.x;
  for (Vec2& p : all.surface_m) p.x = -p.x;
  for (Observation& o : all.images) {
    o.centre_m.x = -o.centre_m.x;
    o.centre_cholesky_m.yx = -o.centre_cholesky_m.yx;
    o.equator_rad = -o.equator_rad;
  }
}

}  // namespace

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

std::optional<Observations> observe(const Frame& frame, FlagSet& flags) {
  const std::optional<Levelling> levelling = level(frame.surface_px, first_scale(frame));
  if (!levelling) {
    flags.set(Flag::degenerate_geometry);
    return std::nullopt;
  }
  Observations all;
  all.levelling = *levelling;
  all.ball_diameter_m = frame.ball_diameter_m;
  all.ball_diameter_sd_m = frame.ball_diameter_sd_m;
  all.gravity_mps2 = flight::gravity_mps2(radians(frame.surface_angle_deg));
  all.ball = {frame.ball_diameter_m, frame.ball_mass_kg.value_or(ball::kThesisMass_kg),
              frame.ball_alpha.value_or(ball::kMeasuredAlpha)};
  all.air_density_kgpm3 =
      frame.air_density_kgpm3.value_or(flight::air_density_kgpm3(temperature_c(frame).value_or(20.0)));
  const double guess = kGuessOfDiameter * frame.ball_diameter_m;
  all.levels[Noise::centre] = all.levels[Noise::surface] = all.levels[Noise::diameter] = guess;
  all.levels[Noise::equator] = kGuessEquatorRad;
  all.images.reserve(frame.images.size());
  for (const BallImage& image : frame.images) all.images.push_back(observation(image, frame, *levelling));
  set_surface(frame, all);
  set_scale(frame, all);
  assign_legs(frame, all, flags);
  const bool any_incoming = std::any_of(all.images.begin(), all.images.end(),
                                        [](const Observation& o) { return o.leg == Leg::incoming; });
  if (travels_left(all.images, any_incoming ? Leg::incoming : Leg::rebound)) mirror(all);
  return all;
}

}  // namespace strobe::reduction
