#include "common/reduction/joint_fit.hpp"

#include <algorithm>
#include <cmath>

#include "common/reduction/factorization.hpp"

namespace strobe::reduction {
namespace {

using geometry::Rotation2d;

/// A flash's error in time moves the image along its path by `shift`. The determinant of L L^T + s s^T is a
/// sum of squares, of which none can cancel another, however long the shift.
Whitening whitening(const Observations& all, const Observation& o, const Eigen::Vector2d& shift) {
  const double unit = all.unit(o.centre_noise);
  const CholeskyFactor& own = o.centre_cholesky_m;
  const CholeskyFactor l{unit * own.xx, unit * own.yx, unit * own.yy};
  if (shift.isZero(0.0)) return {1.0 / l.xx, -l.yx / l.xx / l.yy, 1.0 / l.yy};
  const double xx = std::hypot(l.xx, shift.x());
  const double yx = (l.xx * l.yx + shift.x() * shift.y()) / xx;
  const double along = l.yy * shift.x();
  const double across = l.xx * shift.y() - l.yx * shift.x();
  const double yy = std::hypot(l.xx * l.yy, std::hypot(along, across)) / xx;
  return {1.0 / xx, -yx / xx / yy, 1.0 / yy};
}

/// The whitened problem about the present unknowns, reduced to triangles.
class Problem {
 public:
  Problem(const Observations& all, const JointFit& fit) : all_(all), fit_(fit), tilt_(tilt_of(fit)) {
    // Large rows first keep the small ones exact (Cox, Higham 1998), and a calibration weighs most.
    add_scale();
    add_surface();
    add_images();
    shared_.reflect([](const auto&) {});
  }

  /// Fills the factor; returns the whitened right side.
  JointVector factor(SquareRootInformation& f) const {
    JointVector right{};
    for (int i = 0; i < 3; ++i) {
      for (int k = i; k < 3; ++k) f.r[i][k] = shared_.triangle(i, k);
      if (f.r[i][i] != 0.0) right[static_cast<std::size_t>(i)] = shared_.triangle(i, 3);
    }
    for (std::size_t l = 0; l < 2; ++l) {
      for (int i = 0; i < 4; ++i) {
        for (int k = i; k < 4; ++k) f.leg[l].r[i][k] = legs_[l].triangle(i, k);
        for (int k = 0; k < 2; ++k) f.leg[l].coupling[i][k] = legs_[l].triangle(i, 4 + k);
        right[kLegStart[l] + static_cast<std::size_t>(i)] = legs_[l].triangle(i, 6);
      }
    }
    return right;
  }

 private:
  void share(double tilt, double height, double scale, double right) {
    if (all_.scale_exact()) scale = 0.0;
    shared_.add({tilt, height, scale, right}, [](const auto&) {});
  }

  void add_scale() {
    if (all_.scale && !all_.scale_exact()) {
      share(0.0, 0.0, 1.0 / all_.scale_sd, (*all_.scale - fit_.unknowns[kScale]) / all_.scale_sd);
    }
    if (all_.scale_exact()) return;
    for (const Observation& o : all_.images) {
      if (!o.use_diameter) continue;
      const double sd = all_.diameter_sd(o);
      share(0.0, 0.0, all_.ball_diameter_m / sd,
            (o.diameter_m - fit_.unknowns[kScale] * all_.ball_diameter_m) / sd);
    }
  }

  void add_surface() {
    if (!all_.has_surface()) {
      share(1.0 / kCameraRollSd_rad, 0.0, 0.0, -fit_.unknowns[kTilt] / kCameraRollSd_rad);
      return share(0.0, 1.0, 0.0, 0.0);  // no number depends on the height
    }
    const double weight = 1.0 / all_.surface_sd();
    for (const Eigen::Vector2d& p : all_.surface_m) {
      const Eigen::Vector2d q = tilt_.inverse() * p;
      share(weight * q.x(), weight, 0.0, weight * (q.y() - fit_.unknowns[kHeight]));
    }
  }

  void add_images() {
    const auto next = [this](const std::array<double, 3>& rest) { share(rest[0], 0.0, rest[1], rest[2]); };
    for (const Observation& o : all_.images) {
      if (!o.use_centre) continue;
      const std::size_t leg = leg_index(*o.leg);
      if (!fit_.legs[leg].fitted) continue;
      const ImageRows rows = image_rows(all_, fit_, tilt_, o);
      for (std::size_t k = 0; k < 2; ++k) {
        const auto& r = rows.row[k];
        legs_[leg].add({r[0], r[1], r[2], r[3], r[4], r[5], rows.residual[k]}, next);
      }
    }
    for (auto& leg : legs_) leg.reflect(next);
  }

  const Observations& all_;
  const JointFit& fit_;
  Rotation2d tilt_;
  HouseholderQr<4, 7> legs_[2];
  HouseholderQr<3, 4> shared_;
};

/// Times of both legs, and a first guess from their outermost images.
void start(const Observations& all, JointFit& fit) {
  int count[2] = {0, 0};
  const Observation* first[2] = {};
  const Observation* last[2] = {};
  for (const Observation& o : all.images) {
    if (!o.use_centre) continue;
    const std::size_t leg = leg_index(*o.leg);
    if (count[leg]++ == 0) first[leg] = &o;
    last[leg] = &o;
    fit.legs[leg].origin_s += o.time_s;
  }
  fit.unknowns[kScale] = all.scale.value_or(1.0);
  for (std::size_t leg = 0; leg < 2; ++leg) {
    LegTime& times = fit.legs[leg];
    times.fitted = count[leg] >= 2;
    if (!times.fitted) continue;
    times.origin_s /= count[leg];
    times.first_s = first[leg]->time_s;
    times.last_s = last[leg]->time_s;
    times.span_s = times.last_s - times.first_s;
    const Eigen::Vector2d step = last[leg]->centre_m - first[leg]->centre_m;
    const double s = times.scaled(times.first_s);
    double* z = &fit.unknowns[kLegStart[leg]];
    z[0] = first[leg]->centre_m.x() - s * step.x();
    z[1] = first[leg]->centre_m.y() - s * step.y();
    z[2] = step.x();
    z[3] = step.y();
  }
}

/// Forcing at the legs' present velocities.
void update_forcing(const FlightModel& model, JointFit& fit) {
  // The series of drag and lift is one in their share of the velocity; this bound leaves 1e-4 of it.
  constexpr double kLongest = 0.1;
  // Drag and lift are those of far slower balls; and the squares of what a frame may state overflow.
  constexpr double kSpeedOfSound_mps = 340.0;
  std::array<Eigen::Vector2d, 2> velocity{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  for (std::size_t leg = 0; leg < 2; ++leg) {
    if (!fit.legs[leg].fitted) continue;
    velocity[leg] = leg_velocity_mps(fit, leg);
    const double speed_mps = std::hypot(velocity[leg].x(), velocity[leg].y());
    const double share =
        speed_mps * fit.legs[leg].span_s * std::max(model.air.drag_per_m, model.air.lift_per_m);
    if (!(share < kLongest) || !(speed_mps < kSpeedOfSound_mps)) fit.air_used = false;
  }
  const flight::Aerodynamics air = fit.air_used ? model.air : flight::Aerodynamics{};
  for (std::size_t leg = 0; leg < 2; ++leg) {
    fit.forcing[leg] = flight::forcing(air, model.gravity_mps2, velocity[leg], model.omega_radps[leg],
                                       fit.air_used ? model.more_lift_per_s[leg] : 0.0);
  }
}

/// Measurements that contradict each other beyond any photograph: no scale, or places beyond all that valid
/// coordinates allow (1e21 m).
bool diverged(const JointFit& fit, double first_scale) {
  constexpr double kFarthest = 1e30;
  const bool near = std::all_of(fit.unknowns.begin(), fit.unknowns.end(),
                                [](double x) { return std::isless(std::abs(x), kFarthest); });
  return !near || !(fit.unknowns[kScale] > 1e-3 * first_scale);
}

}  // namespace

ImageRows image_rows(const Observations& all, const JointFit& fit, const Rotation2d& tilt,
                     const Observation& o) {
  const std::size_t leg = leg_index(*o.leg);
  const LegTime& times = fit.legs[leg];
  const flight::Forcing& forcing = fit.forcing[leg];
  const double* z = &fit.unknowns[kLegStart[leg]];
  const double scale = fit.unknowns[kScale];
  const double s = times.scaled(o.time_s);
  const double t = s * times.span_s;
  const Eigen::Vector2d bend =
      tilt * (t * t * (0.5 * forcing.acceleration_mps2 + t * forcing.jerk_mps3 / 6.0));
  const Eigen::Vector2d residual{o.centre_m.x() - (z[0] + z[2] * s + scale * bend.x()),
                                 o.centre_m.y() - (z[1] + z[3] * s + scale * bend.y())};
  // The air's pull depends on the velocity. The tilt is small enough to leave it out there.
  const double half = 0.5 * t * s;
  const Eigen::Matrix2d& by_v = forcing.by_velocity_per_s;
  const Eigen::Vector2d columns[6] = {{1.0, 0.0},
                                      {0.0, 1.0},
                                      {s + half * by_v(0, 0), half * by_v(1, 0)},
                                      {half * by_v(0, 1), s + half * by_v(1, 1)},
                                      {-scale * bend.y(), scale * bend.x()},
                                      bend};
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  if (o.time_sd_s > 0.0) {
    const double sd = o.time_sd_s / times.span_s;
    shift = {sd * z[2], sd * z[3]};
  }
  const Whitening w = whitening(all, o, shift);
  ImageRows rows;
  for (std::size_t c = 0; c < 6; ++c) {
    rows.row[0][c] = w.first(columns[c].x());
    rows.row[1][c] = w.second(columns[c].x(), columns[c].y());
  }
  rows.time_s = t;
  rows.white = w;
  rows.residual[0] = w.first(residual.x());
  rows.residual[1] = w.second(residual.x(), residual.y());
  return rows;
}

geometry::Rotation2d tilt_of(const JointFit& fit) { return Rotation2d(fit.unknowns[kTilt]); }

Eigen::Vector2d leg_velocity_mps(const JointFit& fit, std::size_t leg) {
  const double* z = &fit.unknowns[kLegStart[leg]];
  const double per_second = fit.unknowns[kScale] * fit.legs[leg].span_s;
  return tilt_of(fit).inverse() * Eigen::Vector2d(z[2] / per_second, z[3] / per_second);
}

double surface_residual(const JointFit& fit, const Eigen::Vector2d& point) {
  return (tilt_of(fit).inverse() * point).y() - fit.unknowns[kHeight];
}

double surface_lever_m(const JointFit& fit, const Eigen::Vector2d& point) {
  return (tilt_of(fit).inverse() * point).x();
}

JointFit fit_joint(const Observations& all, const FlightModel& model) {
  JointFit fit;
  start(all, fit);
  const bool time_noise = std::any_of(all.images.begin(), all.images.end(),
                                      [](const Observation& o) { return o.time_sd_s > 0.0; });
  constexpr int kMaxSteps = 12;
  // Squares of what is left, in sd: at worst each step shrinks it as the one before did.
  constexpr double kConverged = 1e-12;
  double before = 1.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    update_forcing(model, fit);
    const JointVector right = Problem(all, fit).factor(fit.factor);
    const JointVector change = fit.factor.unknowns(right);
    for (std::size_t i = 0; i < kJointCount; ++i) fit.unknowns[i] += change[i];
    if (diverged(fit, all.scale.value_or(1.0))) {
      fit.status = FitStatus::degenerate;
      return fit;
    }
    const double now = dot(right, right);
    const bool weights_settled = !time_noise || step >= 2;
    const bool small = now < kConverged || (step > 0 && now / before * now < kConverged);
    if (small && weights_settled) {
      fit.status = FitStatus::converged;
      return fit;
    }
    before = now;
  }
  fit.status = FitStatus::iteration_limit;
  return fit;
}

}  // namespace strobe::reduction
