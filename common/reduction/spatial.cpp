#include "common/reduction/spatial.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "common/geometry/leg.hpp"
#include "common/reduction/spin_check.hpp"
#include "common/reduction/spin_line.hpp"
#include "common/statistics/distributions.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

using attitude::LineReading;
using attitude::LineSpin;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// What chance makes no oftener is rejected.
constexpr double kByChance = 1e-4;
/// Of the tilt: the first order of test_planar() is then off by a hundredth of it.
constexpr double kSmallTilt_rad = 0.15;
/// Over which the tilts of a line show both components of a spin across the camera's axis.
constexpr double kMinTurn_rad = 0.2;
/// A camera that is levelled and squared up by eye is within 3 sd of that.
constexpr double kSquaredUp_rad = 3.0 * kCameraRollSd_rad;

/// A leg's images whose line was measured whole.
struct LegLines {
  std::vector<std::size_t> index;
  std::vector<LineReading> readings;
};

LegLines lines_of(const Frame& frame, const ShotFit& fit, std::size_t leg) {
  LegLines lines;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    const BallImage& image = frame.images[i];
    const Observation& o = fit.observations.images[i];
    if (!image.equator_tilt_rad || !o.leg || *o.leg == Leg::contact || leg_index(*o.leg) != leg) continue;
    const std::optional<double> angle_sd = image.equator_sd_rad ? image.equator_sd_rad : frame.equator_sd_rad;
    if (!angle_sd) continue;
    LineReading& r = lines.readings.emplace_back();
    r.time_s = o.time_s;
    r.angle_rad = *image.equator_rad;
    r.tilt_rad = *image.equator_tilt_rad;
    r.angle_sd_rad = *angle_sd;
    r.tilt_sd_rad = *image.equator_tilt_sd_rad;
    r.correlation = image.equator_tilt_correlation.value_or(0.0);
    r.time_sd_s = o.time_sd_s;
    lines.index.push_back(i);
  }
  return lines;
}

/// Each reading with the angle that continues those before it, as the planar spin turns.
std::vector<LineReading> unwrapped(const LegLines& lines, const ShotFit& fit, const SpinFit& spin) {
  std::vector<LineReading> all = lines.readings;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Observation& o = fit.observations.images[lines.index[k]];
    const double expected = spin.angle_rad + spin.omega_radps * (o.time_s - spin.time_s);
    const double turns = std::round((expected - o.equator_rad) / kPi);
    all[k].angle_rad += turns * (fit.observations.surface.mirrored ? -kPi : kPi);
    if (std::fmod(std::abs(turns), 2.0) == 1.0) all[k].tilt_rad = -all[k].tilt_rad;
  }
  return all;
}

/// Whether the planar spin explains the leg's equators.
bool equators_fit(const LegLines& lines, const ShotFit& fit, std::size_t leg) {
  const auto& spin = fit.spin[leg];
  const std::size_t count = fit.equators[leg].size();
  return spin && count >= lines.readings.size() &&
         (count < 3 || !improbable(spin->chi_squared, count) ||
          statistics::chi_squared_tail(spin->chi_squared, static_cast<double>(count) - 2.0) > kByChance);
}

/// And all tilts are small.
bool seems_planar(const LegLines& lines, const ShotFit& fit, std::size_t leg) {
  if (!equators_fit(lines, fit, leg)) return false;
  return std::ranges::all_of(lines.readings,
                             [](const LineReading& r) { return std::abs(r.tilt_rad) < kSmallTilt_rad; });
}

attitude::SpinLimits limits_of(const ShotFit& fit, std::size_t leg) {
  const SpinSearch search = spin_search(fit)[leg];
  return {search.fastest_radps, search.decay_per_s};
}

/// Sd of the spin about the camera's axis by the angles alone, were they a straight line.
double planar_sd(const LegLines& lines, const LineSpin& spin) {
  geometry::LinearRegression<double> line;
  for (const LineReading& r : lines.readings) {
    const double by_time = spin.omega_radps.z() * r.time_sd_s;
    line.add(spin.stretched_s(r.time_s), 0.0, 1.0 / (r.angle_sd_rad * r.angle_sd_rad + by_time * by_time));
  }
  return std::sqrt(line.slope_variance());
}

/// The angles that the spin about the camera's axis alone would have made.
void put_in_plane(const LegLines& lines, const LineSpin& spin, Frame& frame) {
  const double ratio = std::sqrt(spin.covariance(2, 2)) / planar_sd(lines, spin);
  geometry::LinearRegression<double> trend;
  std::vector<double> residual;
  for (const LineReading& r : lines.readings) {
    const double model = attitude::line_angle_rad(spin.normal_at(r.time_s), r.sight);
    residual.push_back(wrap_half_turn(r.angle_rad - model));
    trend.add(spin.stretched_s(r.time_s), residual.back(), 1.0 / (r.angle_sd_rad * r.angle_sd_rad));
  }
  const double start = std::atan2(-spin.normal.x(), spin.normal.y());
  for (std::size_t k = 0; k < lines.readings.size(); ++k) {
    const double s = spin.stretched_s(lines.readings[k].time_s);
    BallImage& image = frame.images[lines.index[k]];
    image.equator_rad = start + spin.omega_radps.z() * s + ratio * (residual[k] - trend.at(s));
    image.equator_sd_rad = ratio * lines.readings[k].angle_sd_rad;
    if (std::ranges::find(spin.left_out, k) != spin.left_out.end())
      image.equator_rad.reset(), image.equator_sd_rad.reset();
    image.equator_tilt_rad.reset();
    image.equator_tilt_sd_rad.reset();
    image.equator_tilt_correlation.reset();
  }
}

/// Whether a spin vector says no more of the turn than the equators do.
bool is_told_by_equators(const LegLines& lines, const ShotFit& fit, std::size_t leg, const LineSpin& spin) {
  return equators_fit(lines, fit, leg) && std::sqrt(spin.covariance(2, 2)) < 2.0 * planar_sd(lines, spin);
}

double tilt_of_axis(const Vector3d& omega) { return std::atan2(omega.head<2>().norm(), std::abs(omega.z())); }

/// Of the angle between axis and camera: first order, but no less than a quarter of what 4 sd of the spin
/// across make of it, as it does not follow them evenly.
double tilt_sd_rad(const Vector3d& omega, const Eigen::Matrix3d& covariance) {
  constexpr double kFar_sd = 4.0;
  const double across = omega.head<2>().norm(), along = std::abs(omega.z());
  const double sd = std::sqrt(0.5 * covariance.topLeftCorner<2, 2>().trace());
  const double less = std::max(0.0, across - kFar_sd * sd);
  const double far = (std::atan2(across, along) - std::atan2(less, along)) / kFar_sd;
  if (across < sd) return std::max(far, std::atan2(sd, along));
  Vector3d by;
  by << omega.head<2>() * (along / across), -std::copysign(across, omega.z());
  return std::max(far, std::sqrt(by.dot(covariance * by)) / omega.squaredNorm());
}

/// Tilts of two images that differ, which a spin about the camera's axis would not make.
bool tilts_differ(const LegLines& lines, const ShotFit& fit, std::size_t leg) {
  if (lines.readings.size() != 2 || !fit.spin[leg]) return false;
  const auto two = unwrapped(lines, fit, *fit.spin[leg]);
  const double apart = two[1].tilt_rad - two[0].tilt_rad;
  const double variance = std::pow(two[0].tilt_sd_rad, 2) + std::pow(two[1].tilt_sd_rad, 2);
  constexpr double kRejectedOfOne = 15.14;  // of one degree of freedom, once in ten thousand
  return apart * apart > kRejectedOfOne * variance;
}

void fit_leg(const Frame& frame, const ShotFit& fit, std::size_t leg, SpatialFit& spatial) {
  const LegLines lines = lines_of(frame, fit, leg);
  if (lines.readings.size() < 3) {
    if (!tilts_differ(lines, fit, leg)) return;
    spatial.flags.set(Flag::axis_tilted);
    spatial.flags.set(Flag::spin_aliased);
    return;
  }
  if (seems_planar(lines, fit, leg)) {
    const double turn =
        fit.spin[leg]->omega_radps * (lines.readings.back().time_s - lines.readings.front().time_s);
    const auto test = attitude::test_planar(unwrapped(lines, fit, *fit.spin[leg]));
    if (test && std::abs(turn) > kMinTurn_rad && test->chi_squared_gain < attitude::kRejectedOfTwo) {
      spatial.planar[leg] = test;
      return;
    }
  }
  std::vector<Vector3d> guesses;
  if (fit.spin[leg]) {
    const double omega = fit.spin[leg]->omega_radps;
    guesses.emplace_back(0.0, 0.0, fit.observations.surface.mirrored ? -omega : omega);
  }
  const auto spin = attitude::fit_line_spin(lines.readings, limits_of(fit, leg), guesses);
  if (!spin) {
    // Tilted, and no steady spin explains it.
    spatial.flags.set(Flag::axis_tilted);
    spatial.flags.set(Flag::spin_aliased);
    return;
  }
  spatial.spin[leg] = spin;
  // Tilts that scatter by more than they state reject no more than their scatter does.
  const double freedom = 2.0 * static_cast<double>(lines.readings.size() - spin->left_out.size()) - 5.0;
  const double scatter = std::max(1.0, spin->chi_squared / freedom);
  const bool rejected = spin->planar_excess > attitude::kRejectedOfTwo * scatter;
  if (!rejected && is_told_by_equators(lines, fit, leg, *spin)) return;
  const double clear_rad = kSquaredUp_rad + 3.0 * tilt_sd_rad(spin->omega_radps, spin->covariance);
  if (rejected && tilt_of_axis(spin->omega_radps) > clear_rad) spatial.flags.set(Flag::axis_tilted);
  if (!spatial.frame) spatial.frame = frame;
  put_in_plane(lines, *spin, *spatial.frame);
}

/// From camera axes to the surface's, as the other numbers have them.
Eigen::Matrix3d to_surface(const ShotFit& fit) {
  const geometry::Rotation2d tilt = fit.observations.surface.line.tilt;
  const double mirror = fit.observations.surface.mirrored ? -1.0 : 1.0;
  Eigen::Matrix3d m;
  // A mirror at the surface's normal turns the components of a spin across it round.
  m << tilt.cos(), tilt.sin(), 0.0, -mirror * tilt.sin(), mirror * tilt.cos(), 0.0, 0.0, 0.0, mirror;
  return m;
}

struct LegNames {
  SpatialQuantity x, y, z, tilt;
  Quantity omega;
};
constexpr std::array<LegNames, 2> kLegNames{
    {{SpatialQuantity::omega_x_td_radps, SpatialQuantity::omega_y_td_radps, SpatialQuantity::omega_z_td_radps,
      SpatialQuantity::spin_axis_tilt_td_deg, Quantity::omega_td_radps},
     {SpatialQuantity::omega_x_lo_radps, SpatialQuantity::omega_y_lo_radps, SpatialQuantity::omega_z_lo_radps,
      SpatialQuantity::spin_axis_tilt_lo_deg, Quantity::omega_lo_radps}}};

void add_spin(const LegNames& names, const Vector3d& omega, const Eigen::Matrix3d& covariance,
              const Readout& readout, Spatial& into) {
  into[names.x] = DerivedNumber{omega.x(), std::sqrt(covariance(0, 0)), 0.0};
  into[names.y] = DerivedNumber{omega.y(), std::sqrt(covariance(1, 1)), 0.0};
  into[names.z] = DerivedNumber{omega.z(), readout.sd[names.omega].value_or(std::sqrt(covariance(2, 2))),
                                readout.sd_systematic[names.omega].value_or(0.0)};
  into[names.tilt] =
      DerivedNumber{degrees(tilt_of_axis(omega)), degrees(tilt_sd_rad(omega, covariance)), 0.0};
}

void add_leg(const SpatialFit& spatial, const ShotFit& fit, std::size_t leg, const Readout& readout,
             Spatial& into) {
  const LegNames& names = kLegNames[leg];
  const auto& in_plane = readout.value[names.omega];
  if (!in_plane) return;
  const Eigen::Matrix3d turn = to_surface(fit);
  if (const auto& spin = spatial.spin[leg]) {
    // As the spin about the camera's axis has decayed by then; of one that is nearly across it, by the time.
    const double seen = (turn * spin->omega_radps).z();
    const LegTime& time = fit.joint.legs[leg];
    const double since = (leg == 0 ? time.last_s : time.first_s) - spin->time_s;
    const double decayed = std::abs(seen) > 0.1 * spin->omega_radps.norm()
                               ? *in_plane / seen
                               : std::exp(-spin->decay_per_s * since);
    Vector3d omega = decayed * (turn * spin->omega_radps);
    omega.z() = *in_plane;
    add_spin(names, omega, turn * spin->covariance * turn.transpose(), readout, into);
  } else if (const auto& planar = spatial.planar[leg]) {
    // Ratios are of camera axes, in which the mirrored spin has the other sign.
    const double camera_omega = fit.observations.surface.mirrored ? -*in_plane : *in_plane;
    Vector3d omega;
    omega << camera_omega * planar->ratio, camera_omega;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    covariance.topLeftCorner<2, 2>() = camera_omega * camera_omega * planar->ratio_covariance;
    covariance(2, 2) = std::pow(readout.sd[names.omega].value_or(0.0), 2);
    add_spin(names, turn * omega, turn * covariance * turn.transpose(), readout, into);
  }
}

/// The spins about the camera's axis that a leg may have, the fitted one first.
std::vector<double> spins_in_plane(const SpatialFit& spatial, const ShotFit& fit, std::size_t leg,
                                   double fitted_radps) {
  std::vector<double> all{fitted_radps};
  if (!spatial.spin[leg]) return all;
  for (const Vector3d& other : spatial.spin[leg]->alternatives_radps)
    all.push_back((to_surface(fit) * other).z());
  return all;
}

/// Whether friction allows a spin vector that explains the lines as well: its laws hold for each component of
/// slip and spin by itself.
bool others_possible(const SpatialFit& spatial, const ShotFit& fit, const Readout& readout) {
  const auto& td = readout.value[Quantity::omega_td_radps];
  const auto& lo = readout.value[Quantity::omega_lo_radps];
  const auto any = [&](std::size_t leg) {
    return spatial.spin[leg] && !spatial.spin[leg]->alternatives_radps.empty();
  };
  if (!any(0) && !any(1)) return false;
  const auto friction = td && lo ? Friction::of(readout, fit) : std::nullopt;
  if (!friction) return true;
  const auto before = spins_in_plane(spatial, fit, 0, *td), after = spins_in_plane(spatial, fit, 1, *lo);
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (std::size_t k = 0; k < after.size(); ++k) {
      if (i + k > 0 && friction->likely(before[i], after[k])) return true;
    }
  }
  return false;
}

}  // namespace

bool tells_third_dimension(const Frame& frame) {
  return frame.lens || std::ranges::any_of(frame.images, [](const BallImage& image) {
           return image.equator_tilt_rad.has_value();
         });
}

SpatialFit fit_spatial(const Frame& frame, const ShotFit& fit) {
  SpatialFit spatial;
  if (fit.joint.degenerate() || fit.observations.images.size() != frame.images.size()) return spatial;
  for (std::size_t leg = 0; leg < 2; ++leg) fit_leg(frame, fit, leg, spatial);
  // A bounce does not set a tilted axis upright: a leg that tells nothing of its own is in doubt as well.
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (spatial.flags.has(Flag::axis_tilted) && fit.spin[leg] && !spatial.spin[leg] && !spatial.planar[leg])
      spatial.flags.set(Flag::spin_aliased);
  }
  spatial.depth = fit_depth(frame, fit);
  if (spatial.depth && spatial.depth->moves) {
    spatial.flags.set(Flag::out_of_plane);
    if (!spatial.frame) spatial.frame = frame;
    put_at_one_depth(*spatial.depth, fit, *spatial.frame);
  }
  return spatial;
}

void add_spatial(const SpatialFit& spatial, const Frame& frame, const ShotFit& fit, Readout& readout) {
  Spatial numbers;
  for (std::size_t leg = 0; leg < 2; ++leg) add_leg(spatial, fit, leg, readout, numbers);
  if (spatial.depth) add_depth(*spatial.depth, frame, fit, numbers);
  if (others_possible(spatial, fit, readout)) readout.flags.set(Flag::spin_aliased);
  if (std::ranges::any_of(numbers.number, [](const auto& number) { return number.has_value(); }))
    readout.spatial = numbers;
}

}  // namespace strobe::reduction
