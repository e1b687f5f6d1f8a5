#include "common/reduction/joint_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

namespace strobe::reduction {
namespace {

struct Symmetric2 {
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  Vec2 operator*(Vec2 v) const { return {xx * v.x + xy * v.y, xy * v.x + yy * v.y}; }
  void add(const Symmetric2& other, double factor) {
    xx += factor * other.xx;
    xy += factor * other.xy;
    yy += factor * other.yy;
  }
};

Symmetric2 inverse(const Symmetric2& m) {
  const double determinant = m.xx * m.yy - m.xy * m.xy;
  return {m.yy / determinant, -m.xy / determinant, m.xx / determinant};
}

double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }

struct NormalEquations {
  JointMatrix matrix = JointMatrix::Zero();  // lower triangle
  JointVector right = JointVector::Zero();
};

/// Measurements to take: all, or those of one noise level.
bool wanted(std::optional<Noise> only, Noise noise) { return !only || *only == noise; }

/// Where the model puts an image, and how that depends on scale and tilt through the fall.
struct Model {
  Vec2 at;
  Vec2 by_scale;
  Vec2 by_tilt;
};

Model model(const JointFit& fit, std::size_t leg, double s) {
  const int k = kLegStart[leg];
  const auto& z = fit.unknowns;
  const double half = 0.5 * fit.legs[leg].span_s * fit.legs[leg].span_s * s * s;
  const double cos = std::cos(z[kTilt]);
  const double sin = std::sin(z[kTilt]);
  const Vec2 fall{half * (cos * fit.gravity_mps2.x - sin * fit.gravity_mps2.y),
                  half * (sin * fit.gravity_mps2.x + cos * fit.gravity_mps2.y)};
  const double scale = z[kScale];
  return {{z[k] + z[k + 2] * s + scale * fall.x, z[k + 1] + z[k + 3] * s + scale * fall.y},
          fall,
          {-scale * fall.y, scale * fall.x}};
}

/// A flash's error in time moves the image along its path.
Symmetric2 covariance(const Observations& all, const JointFit& fit, const Observation& o) {
  Symmetric2 c{o.cov_xx_m2, o.cov_xy_m2, o.cov_yy_m2};
  if (o.centre_noise != Noise::stated) c.xx = c.yy = all.levels[Noise::centre] * all.levels[Noise::centre];
  if (o.time_sd_s > 0.0) {
    const std::size_t leg = leg_index(*o.leg);
    const double sd = o.time_sd_s / fit.legs[leg].span_s;
    const Vec2 shift{sd * fit.unknowns[kLegStart[leg] + 2], sd * fit.unknowns[kLegStart[leg] + 3]};
    c.add({shift.x * shift.x, shift.x * shift.y, shift.y * shift.y}, 1.0);
  }
  return c;
}

/// Sums over one leg's images; the coordinates of position and velocity share their 2x2 blocks.
struct LegSums {
  Symmetric2 pp, pv, vv;
  Vec2 tilt_p, tilt_v, scale_p, scale_v, right_p, right_v;
  double tilt_tilt = 0.0, tilt_scale = 0.0, scale_scale = 0.0, right_tilt = 0.0, right_scale = 0.0;

  void add(const Symmetric2& weight, const Model& m, Vec2 residual, double s) {
    pp.add(weight, 1.0);
    pv.add(weight, s);
    vv.add(weight, s * s);
    const Vec2 wt = weight * m.by_tilt;
    const Vec2 ws = weight * m.by_scale;
    const Vec2 wr = weight * residual;
    sum(tilt_p, wt, 1.0), sum(tilt_v, wt, s);
    sum(scale_p, ws, 1.0), sum(scale_v, ws, s);
    sum(right_p, wr, 1.0), sum(right_v, wr, s);
    tilt_tilt += dot(m.by_tilt, wt);
    tilt_scale += dot(m.by_tilt, ws);
    scale_scale += dot(m.by_scale, ws);
    right_tilt += dot(m.by_tilt, wr);
    right_scale += dot(m.by_scale, wr);
  }
  static void sum(Vec2& into, Vec2 v, double factor) {
    into.x += factor * v.x;
    into.y += factor * v.y;
  }
};

void put(JointMatrix& m, int row, int column, const Symmetric2& block) {
  m(row, column) += block.xx;
  m(row + 1, column) += block.xy;
  if (row != column) m(row, column + 1) += block.xy;
  m(row + 1, column + 1) += block.yy;
}

void put(JointMatrix& m, int row, int column, Vec2 v) {
  m(row, column) += v.x;
  m(row + 1, column) += v.y;
}

void put(NormalEquations& n, std::size_t leg, const LegSums& s) {
  const int k = kLegStart[leg];
  put(n.matrix, k, k, s.pp);
  put(n.matrix, k + 2, k, s.pv);
  put(n.matrix, k + 2, k + 2, s.vv);
  put(n.matrix, k, kTilt, s.tilt_p);
  put(n.matrix, k + 2, kTilt, s.tilt_v);
  put(n.matrix, k, kScale, s.scale_p);
  put(n.matrix, k + 2, kScale, s.scale_v);
  n.matrix(kTilt, kTilt) += s.tilt_tilt;
  n.matrix(kScale, kTilt) += s.tilt_scale;
  n.matrix(kScale, kScale) += s.scale_scale;
  n.right[kTilt] += s.right_tilt;
  n.right[kScale] += s.right_scale;
  n.right.segment<2>(k) << s.right_p.x, s.right_p.y;
  n.right.segment<2>(k + 2) << s.right_v.x, s.right_v.y;
}

void add_images(const Observations& all, const JointFit& fit, std::optional<Noise> only, NormalEquations& n) {
  LegSums sums[2];
  for (const Observation& o : all.images) {
    if (o.use_diameter && wanted(only, o.diameter_noise)) {
      const double weight = 1.0 / (all.diameter_sd(o) * all.diameter_sd(o));
      const double residual = o.diameter_m - fit.unknowns[kScale] * all.ball_diameter_m;
      n.matrix(kScale, kScale) += weight * all.ball_diameter_m * all.ball_diameter_m;
      n.right[kScale] += weight * all.ball_diameter_m * residual;
    }
    if (!o.use_centre || !wanted(only, o.centre_noise)) continue;
    const std::size_t leg = leg_index(*o.leg);
    if (!fit.legs[leg].fitted) continue;
    const double s = fit.legs[leg].scaled(o.time_s);
    const Model m = model(fit, leg, s);
    const Vec2 residual{o.centre_m.x - m.at.x, o.centre_m.y - m.at.y};
    sums[leg].add(inverse(covariance(all, fit, o)), m, residual, s);
  }
  for (std::size_t leg = 0; leg < 2; ++leg) put(n, leg, sums[leg]);
}

void add_surface(const Observations& all, const JointFit& fit, std::optional<Noise> only,
                 NormalEquations& n) {
  if (!wanted(only, all.surface_noise)) return;
  const double weight = 1.0 / (all.surface_sd() * all.surface_sd());
  const double cos = std::cos(fit.unknowns[kTilt]);
  const double sin = std::sin(fit.unknowns[kTilt]);
  for (const Vec2& p : all.surface_m) {
    const double residual = surface_residual(fit, p);
    const double by_tilt =
        cos * p.x + sin * p.y;  // of height - normal . p: opposite sign of the residual's slope
    n.matrix(kTilt, kTilt) += weight * by_tilt * by_tilt;
    n.matrix(kHeight, kTilt) += weight * by_tilt;
    n.matrix(kHeight, kHeight) += weight;
    n.right[kTilt] += weight * by_tilt * residual;
    n.right[kHeight] += weight * residual;
  }
}

NormalEquations assemble(const Observations& all, const JointFit& fit, std::optional<Noise> only) {
  NormalEquations n;
  add_images(all, fit, only, n);
  add_surface(all, fit, only, n);
  if (all.scale && wanted(only, Noise::stated)) {
    const double weight = 1.0 / (all.scale_sd * all.scale_sd);
    n.matrix(kScale, kScale) += weight;
    n.right[kScale] += weight * (*all.scale - fit.unknowns[kScale]);
  }
  return n;
}

/// What nothing was measured of stays where it is.
void pin_unmeasured(NormalEquations& n) {
  for (int i = 0; i < kJointCount; ++i) {
    if (!(n.matrix(i, i) > 0.0)) n.matrix(i, i) = 1.0;
  }
}

std::array<LegTime, 2> leg_times(const Observations& all) {
  std::array<LegTime, 2> legs;
  int count[2] = {0, 0};
  for (const Observation& o : all.images) {
    if (!o.use_centre) continue;
    LegTime& leg = legs[leg_index(*o.leg)];
    if (count[leg_index(*o.leg)]++ == 0) leg.first_s = o.time_s;
    leg.last_s = o.time_s;
    leg.origin_s += o.time_s;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    legs[i].fitted = count[i] >= 2;
    if (!legs[i].fitted) continue;
    legs[i].origin_s /= count[i];
    legs[i].span_s = legs[i].last_s - legs[i].first_s;
  }
  return legs;
}

}  // namespace

double surface_residual(const JointFit& fit, Vec2 p) {
  const double tilt = fit.unknowns[kTilt];
  return std::cos(tilt) * p.y - std::sin(tilt) * p.x - fit.unknowns[kHeight];
}

CentreResidual centre_residual(const Observations& all, const JointFit& fit, const Observation& image) {
  const std::size_t leg = leg_index(*image.leg);
  const Model m = model(fit, leg, fit.legs[leg].scaled(image.time_s));
  const Symmetric2 c = covariance(all, fit, image);
  return {{image.centre_m.x - m.at.x, image.centre_m.y - m.at.y}, c.xx, c.xy, c.yy};
}

JointMatrix information(const Observations& all, const JointFit& fit, Noise noise) {
  return assemble(all, fit, noise).matrix.selfadjointView<Eigen::Lower>();
}

JointFit fit_joint(const Observations& all, Vec2 gravity_mps2) {
  JointFit fit;
  fit.gravity_mps2 = gravity_mps2;
  fit.legs = leg_times(all);
  fit.unknowns[kScale] = 1.0;
  const bool time_noise = std::any_of(all.images.begin(), all.images.end(),
                                      [](const Observation& o) { return o.time_sd_s > 0.0; });
  constexpr int kMostSteps = 12;
  constexpr double kConverged = 1e-10;  // predicted fall of chi squared: a hundred-thousandth of an sd
  Eigen::LLT<JointMatrix, Eigen::Lower> factor;
  JointVector unit;
  for (int step = 0; step < kMostSteps; ++step) {
    NormalEquations n = assemble(all, fit, std::nullopt);
    pin_unmeasured(n);
    unit = n.matrix.diagonal().cwiseSqrt().cwiseInverse();  // the columns' units differ by many orders
    const JointMatrix scaled = unit.asDiagonal() * n.matrix * unit.asDiagonal();
    factor.compute(scaled);
    const JointVector change = unit.asDiagonal() * factor.solve(unit.asDiagonal() * n.right);
    fit.unknowns += change;
    const bool weights_settled = !time_noise || step >= 2;
    if (change.dot(n.right) < kConverged && weights_settled) break;
  }
  fit.covariance = unit.asDiagonal() * factor.solve(JointMatrix::Identity()) * unit.asDiagonal();
  return fit;
}

}  // namespace strobe::reduction
