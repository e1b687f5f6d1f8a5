#include "common/reduction/observations.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "common/geometry/leg.hpp"
#include "common/geometry/leg_classification.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

/// Standard deviation to start from where the frame states none: a hundredth of the ball's diameter, the
/// order of digitizing by hand, as is kUsualEquatorSd_rad. The residuals replace them; where these cannot,
/// only the sd is lost, not the number.
constexpr double kGuessOfDiameter = 0.01;

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

Eigen::Vector2d vector(const PointPx& p) { return {p.x, p.y}; }

std::optional<geometry::SurfaceFrame> surface_frame(const Frame& frame) {
  const double px_per_m = first_scale(frame);
  if (frame.surface_px.empty()) {
    geometry::Line photograph;
    if (!frame.images.empty()) photograph.reference = vector(frame.images.front().centre_px);
    return geometry::SurfaceFrame{photograph, px_per_m, false};
  }
  std::vector<Eigen::Vector2d> points;
  points.reserve(frame.surface_px.size());
  for (const PointPx& p : frame.surface_px) points.push_back(vector(p));
  // Points within a hundredth of a millimetre, which no digitizer resolves, are one point.
  const auto line = geometry::fit_line(points, {}, 1e-5 * px_per_m);
  if (!line) return std::nullopt;
  return geometry::SurfaceFrame{*line, px_per_m, false};
}

CholeskyFactor cholesky_of(const std::array<double, 4>& covariance) {
  const double xx = std::sqrt(covariance[0]);
  const double yx = 0.5 * (covariance[1] + covariance[2]) / xx;
  const double largest = std::sqrt(covariance[3]);
  return {xx, yx, std::sqrt((largest - yx) * (largest + yx))};
}

/// In the surface's axes, made triangular again; its determinant does not change.
CholeskyFactor in_surface_axes(const CholeskyFactor& l, const geometry::SurfaceFrame& surface) {
  const double cos = surface.line.tilt.cos();
  const double sin = surface.line.tilt.sin();
  const Eigen::Vector2d top{cos * l.xx + sin * l.yx, sin * l.yy};
  const Eigen::Vector2d bottom{cos * l.yx - sin * l.xx, cos * l.yy};
  const double xx = std::hypot(top.x(), top.y());
  const double px = surface.px_per_unit;
  return {xx / px, top.dot(bottom) / xx / px, l.xx / xx * l.yy / px};
}

void set_centre_noise(const BallImage& image, const Frame& frame, const geometry::SurfaceFrame& surface,
                      Observation& o) {
  if (image.centre_cov_px2) {
    o.centre_cholesky_m = in_surface_axes(cholesky_of(*image.centre_cov_px2), surface);
  } else if (frame.centre_sd_px) {
    o.centre_cholesky_m.xx = o.centre_cholesky_m.yy = *frame.centre_sd_px / surface.px_per_unit;
  } else {
    o.centre_noise = NoiseGroup::centre;
  }
}

Observation observation(const BallImage& image, const Frame& frame, const geometry::SurfaceFrame& surface) {
  Observation o;
  o.time_s = image.time_s - frame.images.front().time_s;
  o.centre_m = surface.from_image(vector(image.centre_px));
  o.diameter_m = image.diameter_px / surface.px_per_unit;
  set_centre_noise(image, frame, surface, o);
  if (const auto sd = image.diameter_sd_px ? image.diameter_sd_px : frame.diameter_sd_px) {
    o.diameter_sd_m = *sd / surface.px_per_unit;
  } else {
    o.diameter_noise = NoiseGroup::diameter;
  }
  if (const auto sd = image.equator_sd_rad ? image.equator_sd_rad : frame.equator_sd_rad) {
    o.equator_sd_rad = *sd;
  } else {
    o.equator_noise = NoiseGroup::equator;
  }
  o.equator_rad = image.equator_rad.value_or(0.0);
  o.use_equator = image.equator_rad.has_value();
  o.time_sd_s = image.time_sd_s.value_or(0.0);
  o.digitized = image.source == "auto";
  o.probability = image.probability;
  return o;
}

/// Stated noise as relative weights, of each kind that has it for all airborne images; the rest is as it was.
/// The centres' factor is the surface's too, whose few points could not tell one of their own.
void weigh_by_stated_noise(Observations& all) {
  const auto all_stated = [&](NoiseGroup Observation::*noise) {
    return std::ranges::all_of(all.images, [&](const Observation& o) {
      return o.leg == Leg::contact || o.*noise == NoiseGroup::stated;
    });
  };
  const auto weigh = [&](NoiseGroup Observation::*noise, NoiseGroup group) {
    for (Observation& o : all.images) o.*noise = group;
    all.group_sd[group] = 1.0;
  };
  if (all_stated(&Observation::centre_noise)) {
    weigh(&Observation::centre_noise, NoiseGroup::centre);
    if (all.surface_noise == NoiseGroup::stated) all.surface_noise = NoiseGroup::centre;
  }
  if (all_stated(&Observation::diameter_noise)) weigh(&Observation::diameter_noise, NoiseGroup::diameter);
  if (all_stated(&Observation::equator_noise)) weigh(&Observation::equator_noise, NoiseGroup::equator);
}

void set_surface(const Frame& frame, Observations& all) {
  if (frame.surface_px.empty()) return;
  all.surface_m.reserve(frame.surface_px.size());
  for (const PointPx& p : frame.surface_px) all.surface_m.push_back(all.surface.from_image(vector(p)));
  if (const auto sd = frame.surface_sd_px ? frame.surface_sd_px : frame.centre_sd_px) {
    all.surface_sd_m = *sd / all.surface.px_per_unit;
    return;
  }
  const bool shared = std::any_of(all.images.begin(), all.images.end(),
                                  [](const Observation& o) { return o.centre_noise == NoiseGroup::centre; });
  all.surface_noise = shared ? NoiseGroup::centre : NoiseGroup::surface;
}

void set_scale(const Frame& frame, Observations& all, FlagSet& flags) {
  if (!frame.px_per_m) return;
  all.scale = *frame.px_per_m / all.surface.px_per_unit;
  all.scale_sd = frame.px_per_m_sd.value_or(0.0) / all.surface.px_per_unit;
  if (!frame.px_per_m_sd) flags.set(Flag::scale_sd_unknown);
}

void set_map_errors(const Frame& frame, Observations& all) {
  const Eigen::Vector2d origin = all.surface.from_image(Eigen::Vector2d::Zero());
  const auto turned = [&](const PointPx& p) -> Eigen::Vector2d {
    return all.surface.from_image(vector(p)) - origin;
  };
  for (const MapError& error : frame.map_errors) {
    ObservedMapError& observed = all.map_errors.emplace_back();
    for (const MapError::Shift& s : error.images) {
      observed.images.push_back(
          {turned(s.centre_px), s.diameter_px / all.surface.px_per_unit, s.equator_rad});
    }
    for (const PointPx& p : error.surface_px) observed.surface_m.push_back(turned(p));
  }
}

double mean_diameter_variance(const Observations& all) {
  double weight = 0.0;
  for (const Observation& o : all.images) weight += 1.0 / (all.diameter_sd(o) * all.diameter_sd(o));
  return weight > 0.0 ? 1.0 / weight : 0.0;
}

/// The images' diameters would give the scale far better than the calibration does, were the ball's own
/// diameter known as well; where its tolerance is the larger they measure the ball's size, not the scale.
bool scale_from_diameters(const Observations& all) {
  if (!all.scale || !(all.ball_diameter_sd_m || all.shared_diameter_sd_m)) return true;
  return all.size_sd_m() / all.ball_diameter_m < all.scale_sd / *all.scale;
}

std::vector<Leg> legs_of(const Frame& frame, const Observations& all, FlagSet& flags) {
  if (!all.has_surface()) return std::vector<Leg>(all.images.size(), Leg::incoming);
  geometry::LinearRegression<double> line;
  for (const Eigen::Vector2d& p : all.surface_m)
    line.add(p.x(), p.y(), 1.0 / (all.surface_sd() * all.surface_sd()));
  const double radius_variance = 0.25 * mean_diameter_variance(all);
  std::vector<geometry::TimedHeight> heights;
  heights.reserve(all.images.size());
  for (std::size_t i = 0; i < all.images.size(); ++i) {
    const Observation& o = all.images[i];
    heights.push_back({o.time_s, o.centre_m.y() - 0.5 * all.ball_diameter_m, all.centre_variance(o),
                       frame.images[i].leg, line.variance_at(o.centre_m.x()) + radius_variance});
  }
  geometry::LegAssignment found = geometry::classify_timed(heights, all.gravity_mps2.y());
  if (!found.overlaps.empty()) flags.set(Flag::overlaps_surface);
  if (std::ranges::find(found.legs, Leg::contact) == found.legs.end()) flags.set(Flag::no_contact_image);
  return std::move(found.legs);
}

void assign_legs(const Frame& frame, Observations& all, FlagSet& flags) {
  const std::vector<Leg> legs = legs_of(frame, all, flags);
  assert(legs.size() == all.images.size());
  const bool use_diameters = scale_from_diameters(all);
  for (std::size_t i = 0; i < all.images.size(); ++i) {
    Observation& o = all.images[i];
    o.leg = legs[i];
    const bool airborne = legs[i] != Leg::contact;
    o.use_centre = airborne;
    o.use_diameter = airborne && use_diameters;
    o.use_equator = o.use_equator && airborne;
  }
}

/// By its first and last image, of which the fit may leave one out: see orient().
bool seems_to_travel_left(const std::vector<Observation>& images, Leg leg) {
  const Observation* first = nullptr;
  const Observation* last = nullptr;
  for (const Observation& o : images) {
    if (o.leg != leg) continue;
    if (!first) first = &o;
    last = &o;
  }
  return first != last && travels_left(last->centre_m - first->centre_m);
}

}  // namespace

std::optional<Observations> observe(const Frame& frame, FlagSet& flags, NoiseSource noise) {
  const std::optional<geometry::SurfaceFrame> surface = surface_frame(frame);
  if (!surface) {
    flags.set(Flag::degenerate_geometry);
    return std::nullopt;
  }
  Observations all;
  all.surface = *surface;
  all.ball_diameter_m = frame.ball_diameter_m;
  all.ball_diameter_sd_m = frame.ball_diameter_sd_m;
  if (const auto sd_px = frame.shared_diameter_sd_px)
    all.shared_diameter_sd_m = *sd_px / surface->px_per_unit;
  all.gravity_mps2 = flight::gravity_mps2(radians(frame.surface_angle_deg));
  all.ball = {frame.ball_diameter_m, frame.ball_mass_kg.value_or(ball::kThesisMass_kg),
              frame.ball_alpha.value_or(ball::kMeasuredAlpha)};
  all.stated_fastest_radps = frame.fastest_spin_radps;
  all.alpha_sd = frame.ball_alpha_sd.value_or(ball::kAlphaSd);
  all.air_density_kgpm3 =
      frame.air_density_kgpm3.value_or(flight::air_density_kgpm3(temperature_c(frame).value_or(20.0)));
  if (frame.air_law) all.air_law = *frame.air_law;
  all.line_drawn = frame.line_drawn;
  const double guess = kGuessOfDiameter * frame.ball_diameter_m;
  all.group_sd[NoiseGroup::centre] = all.group_sd[NoiseGroup::surface] = all.group_sd[NoiseGroup::diameter] =
      guess;
  all.group_sd[NoiseGroup::equator] = kUsualEquatorSd_rad;
  all.images.reserve(frame.images.size());
  for (const BallImage& image : frame.images) all.images.push_back(observation(image, frame, *surface));
  set_surface(frame, all);
  set_scale(frame, all, flags);
  set_map_errors(frame, all);
  assign_legs(frame, all, flags);
  if (noise == NoiseSource::residuals) weigh_by_stated_noise(all);
  const bool any_incoming = std::any_of(all.images.begin(), all.images.end(),
                                        [](const Observation& o) { return o.leg == Leg::incoming; });
  if (seems_to_travel_left(all.images, any_incoming ? Leg::incoming : Leg::rebound)) mirror(all);
  return all;
}

bool travels_left(const Eigen::Vector2d& way) { return way.x() < -0.05 * std::abs(way.y()); }

void mirror(Observations& all) {
  all.surface.mirrored = !all.surface.mirrored;
  all.gravity_mps2.x() = -all.gravity_mps2.x();
  for (Eigen::Vector2d& p : all.surface_m) p.x() = -p.x();
  for (Observation& o : all.images) {
    o.centre_m.x() = -o.centre_m.x();
    o.centre_cholesky_m.yx = -o.centre_cholesky_m.yx;
    o.equator_rad = -o.equator_rad;
  }
  for (ObservedMapError& error : all.map_errors) {
    for (Eigen::Vector2d& p : error.surface_m) p.x() = -p.x();
    for (ObservedMapError::Shift& s : error.images) {
      s.centre_m.x() = -s.centre_m.x();
      s.equator_rad = -s.equator_rad;
    }
  }
}

void shift(const ObservedMapError& error, double sds, Observations& all) {
  assert(error.images.size() == all.images.size() && error.surface_m.size() == all.surface_m.size());
  for (std::size_t i = 0; i < all.images.size(); ++i) {
    all.images[i].centre_m += sds * error.images[i].centre_m;
    all.images[i].diameter_m += sds * error.images[i].diameter_m;
    all.images[i].equator_rad += sds * error.images[i].equator_rad;
  }
  for (std::size_t i = 0; i < all.surface_m.size(); ++i) all.surface_m[i] += sds * error.surface_m[i];
}

}  // namespace strobe::reduction
