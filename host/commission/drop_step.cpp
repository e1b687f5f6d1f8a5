#include "host/commission/drop_step.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <vector>

#include "common/flight/aerodynamics.hpp"
#include "common/geometry/line.hpp"
#include "host/commission/shot_step.hpp"
#include "host/commission/statistics.hpp"
#include "host/commission/steps.hpp"

namespace strobe::commission {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kMinOfLeg = 3;
constexpr double kOutlier_sd = 5.0;
constexpr int kIterations = 8;
/// Centres that state less are not better known: texture and light move a centre by some hundredths of a
/// pixel.
constexpr double kMinCentreSd_px = 0.02;

struct Point {
  double time_s = 0.0;  ///< from the leg's mean
  Vector2d place_m = Vector2d::Zero();
  Matrix2d weight = Matrix2d::Identity();  ///< Cholesky factor of the inverse covariance, transposed
  int leg = 0;
};

struct Axes {
  Vector2d origin_px, along, up;
};

std::optional<Axes> axes_of(const reduction::Frame& frame) {
  std::vector<Vector2d> points;
  for (const auto& p : frame.surface_px) points.emplace_back(p.x, p.y);
  const auto line = geometry::fit_line(points);
  if (!line) return std::nullopt;
  Vector2d along = line->direction();
  if (along.x() < 0.0) along = -along;
  return Axes{line->origin(), along, Vector2d(-along.y(), along.x())};
}

Matrix2d covariance_px2(const reduction::Frame& frame, const reduction::BallImage& image) {
  Matrix2d c;
  if (image.centre_cov_px2) {
    const auto& v = *image.centre_cov_px2;
    c << v[0], v[1], v[2], v[3];
  } else {
    const double sd = frame.centre_sd_px.value_or(0.3);
    c = sd * sd * Matrix2d::Identity();
  }
  return c + kMinCentreSd_px * kMinCentreSd_px * Matrix2d::Identity();
}

/// Cholesky's: u with transpose(u) u = m.
Matrix2d upper_factor(const Matrix2d& m) {
  const double first = std::sqrt(m(0, 0)), across = m(1, 0) / first;
  Matrix2d u;
  u << first, across, 0.0, std::sqrt(m(1, 1) - across * across);
  return u;
}

/// Those of a frame's legs that have images enough; legs: how many there are before and after.
void add_legs(const reduction::Frame& frame, double px_per_m, std::vector<Point>& points, int& legs) {
  const auto axes = axes_of(frame);
  if (!axes) return;
  Matrix2d turn;
  turn.row(0) = axes->along.transpose() / px_per_m;
  turn.row(1) = axes->up.transpose() / px_per_m;
  for (const Leg which : {Leg::incoming, Leg::rebound}) {
    std::vector<Point> of_leg;
    double sum_s = 0.0;
    for (const reduction::BallImage& image : frame.images) {
      if (image.leg != which || image.other_leg) continue;
      const Matrix2d covariance = turn * covariance_px2(frame, image) * turn.transpose();
      of_leg.push_back({image.time_s,
                        turn * (Vector2d(image.centre_px.x, image.centre_px.y) - axes->origin_px),
                        upper_factor(covariance.inverse()), legs});
      sum_s += image.time_s;
    }
    if (static_cast<int>(of_leg.size()) < kMinOfLeg) continue;
    for (Point& point : of_leg) point.time_s -= sum_s / static_cast<double>(of_leg.size());
    points.insert(points.end(), of_leg.begin(), of_leg.end());
    ++legs;
  }
}

/// Common: gravity along and up, the share of drag. Then of each leg: place and velocity at its mean time.
constexpr int kCommon = 3, kOfLeg = 4;

class FreeFallFit {
 public:
  FreeFallFit(std::vector<Point> points, int legs, const flight::Aerodynamics& air)
      : points_(std::move(points)), legs_(legs), air_(air) {
    parameters_ = VectorXd::Zero(kCommon + kOfLeg * legs_);
    parameters_[1] = -flight::kStandardGravity_mps2;
    parameters_[2] = 1.0;
    for (int leg = 0; leg < legs_; ++leg) start(leg);
  }

  /// Gauss-Newton. The model is all but linear: a fixed number of steps is enough.
  void solve() {
    for (int i = 0; i <= kIterations; ++i) {
      const VectorXd r = residuals(parameters_);
      const MatrixXd jacobian = derivative();
      information_ = jacobian.transpose() * jacobian;
      chi_squared_ = r.head(r.size() - 1).squaredNorm();
      if (i < kIterations) parameters_ -= solve_normal(information_, jacobian.transpose() * r);
    }
  }

  /// Leaves the worst image out; false: none is so far off.
  bool drop_outlier() {
    const VectorXd r = residuals(parameters_);
    std::vector<double> sizes;
    for (Eigen::Index i = 0; i + 1 < r.size(); i += 2) sizes.push_back(r.segment<2>(i).norm());
    // By the median: the outliers themselves do not hide each other.
    constexpr double kMedianOfTwo = 1.1774;  // of the length of two standard normals (Rayleigh)
    std::vector<double> sorted = sizes;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    double worst = kOutlier_sd * std::max(1.0, *middle / kMedianOfTwo);
    auto outlier = points_.end();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (sizes[k] <= worst || std::ranges::count(points_, points_[k].leg, &Point::leg) <= kMinOfLeg)
        continue;
      worst = sizes[k];
      outlier = points_.begin() + static_cast<std::ptrdiff_t>(k);
    }
    if (outlier == points_.end()) return false;
    points_.erase(outlier);
    return true;
  }

  FreeFall result() const {
    FreeFall found;
    const Vector2d g = parameters_.head<2>();
    // More scatter than stated: as much more uncertain (Birge's ratio). The drag's prior is one more row.
    found.degrees_of_freedom =
        2 * static_cast<int>(points_.size()) + 1 - static_cast<int>(parameters_.size());
    found.chi_squared = chi_squared_;
    const double birge = std::max(1.0, chi_squared_ / std::max(1, found.degrees_of_freedom));
    const MatrixXd covariance = birge * information_.inverse();
    found.g_mps2 = g.norm();
    const Vector2d unit = g.normalized(), across(-unit.y(), unit.x());
    const Matrix2d of_g = covariance.topLeftCorner<2, 2>();
    found.g_sd_mps2 = std::sqrt(unit.dot(of_g * unit));
    found.inclination_rad = std::atan2(-g.x(), -g.y());
    found.inclination_sd_rad = std::sqrt(across.dot(of_g * across)) / found.g_mps2;
    found.drag_share = parameters_[2];
    found.legs = legs_;
    found.images = static_cast<int>(points_.size());
    return found;
  }

 private:
  void start(int leg) {
    Vector2d mean = Vector2d::Zero(), slope = Vector2d::Zero();
    double moment = 0.0, count = 0.0;
    for (const Point& p : points_)
      if (p.leg == leg) mean += p.place_m, count += 1.0;
    mean /= count;
    for (const Point& p : points_)
      if (p.leg == leg) slope += p.time_s * (p.place_m - mean), moment += p.time_s * p.time_s;
    parameters_.segment<2>(kCommon + kOfLeg * leg) = mean;
    if (moment > 0.0) parameters_.segment<2>(kCommon + kOfLeg * leg + 2) = slope / moment;
  }

  /// In sds: two of each point, then the drag's, by its prior.
  VectorXd residuals(const VectorXd& of) const {
    VectorXd r(2 * static_cast<Eigen::Index>(points_.size()) + 1);
    flight::Aerodynamics air = air_;
    air.drag_per_m *= of[2];
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Point& p = points_[k];
      const Vector2d place = of.segment<2>(kCommon + kOfLeg * p.leg);
      const Vector2d velocity = of.segment<2>(kCommon + kOfLeg * p.leg + 2);
      const flight::Flight path{place, velocity, flight::forcing(air, of.head<2>(), velocity, 0.0)};
      r.segment<2>(2 * static_cast<Eigen::Index>(k)) = p.weight * (path.position_at(p.time_s) - p.place_m);
    }
    r[r.size() - 1] = (of[2] - 1.0) / std::max(air_.law.drag_share_sd(), 1e-6);
    return r;
  }

  /// By differences: the model is smooth.
  MatrixXd derivative() const {
    constexpr double kStep = 1e-5;
    MatrixXd jacobian(2 * static_cast<Eigen::Index>(points_.size()) + 1, parameters_.size());
    for (Eigen::Index i = 0; i < parameters_.size(); ++i) {
      const VectorXd step = kStep * VectorXd::Unit(parameters_.size(), i);
      jacobian.col(i) = (residuals(parameters_ + step) - residuals(parameters_ - step)) / (2.0 * kStep);
    }
    return jacobian;
  }

  std::vector<Point> points_;
  int legs_;
  flight::Aerodynamics air_;
  VectorXd parameters_;
  MatrixXd information_;
  double chi_squared_ = 0.0;
};

constexpr double kDegrees = 180.0 / std::numbers::pi;
/// No plate is levelled, and no inclinometer read, better.
constexpr double kInclination_deg = 0.5;

/// Of a ball that falls with 3 to 4 m/s: images 30 to 50 mm apart, half overlapping.
constexpr Duration kPeriod = std::chrono::milliseconds{12};
/// From the first flash: a person lets go as the flashes begin, the ball falls for half a second and leaves
/// the view again.
constexpr Duration kExposure = std::chrono::milliseconds{1300};
constexpr int kDrops = 5;

ShotPlan slow_train(const host::RigFile& rig) {
  ShotPlan plan;
  plan.dry = true;
  plan.period = std::max(kPeriod, rig.limits.lamp_period);
  plan.exposure = std::min(kExposure, rig.limits.longest_exposure);
  plan.impact_at = plan.exposure / 2;
  return plan;
}

class DropStep final : public ShotStep {
 public:
  DropStep()
      : ShotStep({{"gravity",
                   "gravity by dropped balls: scale and clock",
                   {"camera", "ball", "analysis", "commission"}},
                  {"inclination", "the plate's inclination by dropped balls", {"camera", "analysis"}}},
                 {.operator_acts = true, .outputs = true, .photographs = true},
                 {.missing = 1, .measure = true}) {}
  std::string briefing(const host::RigFile& rig) const override {
    return fmt::format(
        "FLASHES for {:.1f} s, {} times, slowly; the machine's trigger stays still. Hold a ball a metre over "
        "the plate, above the middle of the view and in the plane where balls fly; let it go, without spin, "
        "as the flashes begin.",
        to_seconds(kExposure), drops(rig));
  }

 private:
  static int drops(const host::RigFile& rig) { return kDrops * rig.commission.times; }
  std::vector<Fire> shots(const host::RigFile& rig) const override {
    Fire fire;
    fire.plan = slow_train(rig);
    fire.words = "let a ball go as the flashes begin";
    fire.photograph = true;
    return std::vector<Fire>(static_cast<std::size_t>(drops(rig)), fire);
  }

  std::vector<StepResult> judge(const std::vector<SoundShot>& shots, const host::RigFile& rig) override {
    if (!rig.camera.px_per_m)
      return nothing_judged(
          failed("no_scale", "the rig file has no scale", "calibrate the camera with a printed board"),
          "the rig file has no scale");
    const double temperature =
        std::atof(rig.record.contains("temperature_c") ? rig.record.at("temperature_c").c_str() : "20");
    std::vector<reduction::Frame> frames;
    for (const SoundShot& shot : shots) {
      if (!shot.measured) continue;
      frames.push_back(shot.measured->found.frame);
      frames.back().temperature_c = temperature;
    }
    ball::Ball ball;
    ball.diameter_m = rig.ball.diameter_m;
    ball.mass_kg = rig.ball.mass_kg.value_or(ball.mass_kg);
    const auto fall = measure_free_fall(frames, ball, *rig.camera.px_per_m);
    if (!fall)
      return nothing_judged(failed("no_drop", "no dropped ball is seen: " + fall.error().message,
                                   "let the ball go as the flashes begin, above the middle of the view"),
                            "no dropped ball is seen");
    return {judge_gravity(*fall, rig.commission.gravity_mps2,
                          rig.camera.px_per_m_sd.value_or(0.0) / *rig.camera.px_per_m),
            judge_inclination(*fall, rig.analysis.surface_angle_deg.value_or(0.0))};
  }
};

}  // namespace

Result<FreeFall> measure_free_fall(std::span<const reduction::Frame> frames, const ball::Ball& ball,
                                   double px_per_m) {
  std::vector<Point> points;
  int legs = 0;
  double density_kgpm3 = flight::kAirDensity_kgpm3;
  flight::AirLaw law;
  for (const reduction::Frame& frame : frames) {
    add_legs(frame, px_per_m, points, legs);
    if (frame.temperature_c) density_kgpm3 = flight::air_density_kgpm3(*frame.temperature_c);
    if (frame.air_law) law = *frame.air_law;
  }
  // Three images of one leg leave two residuals to three common unknowns.
  if (legs == 0) return fail("no flight with three images or more");
  FreeFallFit fit(std::move(points), legs, flight::aerodynamics(ball, density_kgpm3, {}, law));
  fit.solve();
  int outliers = 0;
  while (fit.drop_outlier()) {
    ++outliers;
    fit.solve();
  }
  FreeFall found = fit.result();
  if (found.degrees_of_freedom < 1) return fail("too few images of the flights to tell gravity");
  found.outliers = outliers;
  return found;
}

StepResult judge_gravity(const FreeFall& fall, double local_mps2, double scale_share_sd) {
  const double off = fall.g_mps2 / local_mps2 - 1.0;
  const double sd = std::hypot(fall.g_sd_mps2 / local_mps2, scale_share_sd);
  StepResult result =
      passed(fall.g_mps2, sd * local_mps2, "m/s^2",
             fmt::format("{:.4f} m/s^2 within {:.2f} %", local_mps2, 100.0 * kGravityTolerance));
  result.words =
      fmt::format("balls fall with {:.3f} ± {:.3f} m/s^2, {:+.2f} % off the place's; {} legs, {} images",
                  fall.g_mps2, sd * local_mps2, 100.0 * off, fall.legs, fall.images);
  result.figures = {
      {"gravity_mps2", fall.g_mps2, sd * local_mps2, local_mps2, fall.images},
      {"drag_share", fall.drag_share, {}, 1.0, 0},
      {"chi_squared_ratio", fall.chi_squared / std::max(1, fall.degrees_of_freedom), {}, 1.0, fall.images},
      {"outliers", static_cast<double>(fall.outliers), {}, 0.0, 0}};
  hold(result, interval(off, sd), within(kGravityTolerance), "gravity_off",
       "the scale is off by as much, or the clock by half: calibrate the camera again with the board in the "
       "plane where balls fly; see whether the ball's size is off by as much (step scale)",
       "drop more balls (--times 4), nearer to the middle of the plate and without spin");
  return result;
}

StepResult judge_inclination(const FreeFall& fall, double stated_deg) {
  const double found = fall.inclination_rad * kDegrees, sd = fall.inclination_sd_rad * kDegrees;
  StepResult result =
      passed(found, sd, "deg", fmt::format("{:.2f} deg within {:.2f} deg", stated_deg, kInclination_deg));
  result.words =
      fmt::format("balls fall at {:.2f} ± {:.2f} deg to the plate's normal, the rig file says {:.2f} deg",
                  found, sd, stated_deg);
  result.figures = {{"inclination_deg", found, sd, stated_deg, fall.images}};
  hold(result, interval(found, sd), within(kInclination_deg, stated_deg), "plate_inclined",
       "measure the plate with an inclinometer, and enter surface_angle_deg in [analysis]");
  return result;
}

std::unique_ptr<Step> drop_step() { return std::make_unique<DropStep>(); }

}  // namespace strobe::commission
