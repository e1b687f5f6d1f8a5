#include "common/attitude/line_spin.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/attitude/turn.hpp"
#include "common/units/angles.hpp"

namespace strobe::attitude {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Rows = Eigen::Matrix<double, 2, 5>;

constexpr int kMaxIterations = 20;
constexpr int kFewIterations = 4;
constexpr int kTurnLimit = 1000;  // more between two images are beyond any flash train
/// A reading that costs more is wrong, not unlikely: it must not lead a start astray.
constexpr double kCostLimit = 32.0;
/// The cheapest starts are refined.
constexpr std::size_t kMaxRefined = 6;

/// A reading ready for the fit.
struct Plane {
  double s = 0.0;  ///< stretched time from the mean
  LinePlane axes;
  double a_sd = 0.0, b_sd = 0.0;  ///< of the normal along the chord and along by_tilt
  double correlation = 0.0;
  double time_sd_s = 0.0;
  bool used = true;
};

struct Solution {
  Vector3d normal = Vector3d::Zero(), omega = Vector3d::Zero();
  double cost = std::numeric_limits<double>::infinity();
};

/// Of a plane's normal from the one expected, in sds: along the chord and along by_tilt, whitened; gnomonic,
/// so that it grows without bound as the two come to stand square on each other.
struct Residual {
  Vector2d white = Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_normal = Eigen::Matrix<double, 2, 3>::Zero();
};

Residual residual(const Plane& p, const Vector3d& expected, const Vector3d& omega) {
  const double along = expected.dot(p.axes.normal);
  const double cosine = std::copysign(std::max(std::abs(along), 1e-3), along);
  const Vector2d off(expected.dot(p.axes.chord) / cosine, expected.dot(p.axes.by_tilt) / cosine);
  double aa = p.a_sd * p.a_sd, bb = p.b_sd * p.b_sd, ab = p.correlation * p.a_sd * p.b_sd;
  if (p.time_sd_s > 0.0) {
    const Vector3d way = omega.cross(expected) * p.time_sd_s;
    const double a = way.dot(p.axes.chord), b = way.dot(p.axes.by_tilt);
    aa += a * a, bb += b * b, ab += a * b;
  }
  const double l11 = std::sqrt(aa), l21 = ab / l11, l22 = std::sqrt(std::max(bb - l21 * l21, 1e-30));
  const auto whiten = [&](const auto& first, const auto& second, auto&& one, auto&& two) {
    one = first / l11;
    two = (second - (l21 / l11) * first) / l22;
  };
  Residual r;
  whiten(off.x(), off.y(), r.white.x(), r.white.y());
  const Eigen::RowVector3d a_by = (p.axes.chord - off.x() * p.axes.normal).transpose() / cosine;
  const Eigen::RowVector3d b_by = (p.axes.by_tilt - off.y() * p.axes.normal).transpose() / cosine;
  r.by_normal.row(0) = a_by / l11;
  r.by_normal.row(1) = (b_by - (l21 / l11) * a_by) / l22;
  return r;
}

double robust_cost(std::span<const Plane> planes, const Vector3d& normal, const Vector3d& omega) {
  double cost = 0.0;
  for (const Plane& p : planes) {
    if (!p.used) continue;
    cost += std::min(residual(p, Turn(omega * p.s) * normal, omega).white.squaredNorm(), kCostLimit);
  }
  return cost;
}

/// Two directions square to a unit vector.
Eigen::Matrix<double, 3, 2> tangents(const Vector3d& unit) {
  Eigen::Matrix<double, 3, 2> t;
  t.col(0) = unit.unitOrthogonal();
  t.col(1) = unit.cross(t.col(0));
  return t;
}

struct Normal {
  Matrix5d matrix = Matrix5d::Zero();
  Vector5d right = Vector5d::Zero();
  double cost = 0.0;
};

/// `prior`: weights of omega's components, which are 0 before the images.
Normal normal_equations(std::span<const Plane> planes, const Vector3d& prior, const Solution& at) {
  Normal n;
  n.matrix.diagonal().tail<3>() = prior;
  n.right.tail<3>() = prior.cwiseProduct(at.omega);
  n.cost = at.omega.dot(n.right.tail<3>());
  const auto tangent = tangents(at.normal);
  for (const Plane& p : planes) {
    if (!p.used) continue;
    const Turn turn(at.omega * p.s);
    const Vector3d now = turn * at.normal;
    const Residual r = residual(p, now, at.omega);
    const Eigen::Matrix<double, 3, 2> turned =
        (Eigen::Matrix<double, 3, 2>() << turn * Vector3d(tangent.col(0)), turn * Vector3d(tangent.col(1)))
            .finished();
    Rows rows;
    rows.leftCols<2>() = r.by_normal * turned;
    // d(now) = s·(J d(omega)) x now
    for (Eigen::Index k = 0; k < 2; ++k) {
      const Vector3d by = r.by_normal.row(k);
      rows.row(k).tail<3>() = p.s * turn.transposed_jacobian(now.cross(by)).transpose();
    }
    n.matrix.noalias() += rows.transpose() * rows;
    n.right.noalias() += rows.transpose() * r.white;
    n.cost += r.white.squaredNorm();
  }
  return n;
}

/// What no image tells, a turn about the normals themselves, stays slow: an sd of the fastest.
Vector3d slow(double fastest_radps) { return Vector3d::Constant(1.0 / (fastest_radps * fastest_radps)); }

/// Gauss-Newton, damped (Levenberg, Marquardt) where a step does not help: a spin about the normals
/// themselves is hardly told, and must not run away. `hopeful`: a cost of which little is left after a few
/// steps; what stays above is given up.
Solution refine(std::span<const Plane> planes, const Vector3d& prior, Solution at, double hopeful) {
  Normal n = normal_equations(planes, prior, at);
  at.cost = n.cost;
  double damping = 1e-9;
  for (int i = 0; i < kMaxIterations; ++i) {
    if (i == kFewIterations && at.cost > hopeful) return at;
    Matrix5d damped = n.matrix;
    damped.diagonal() += damping * (n.matrix.diagonal() + Vector5d::Constant(1e-12));
    const Vector5d step = -damped.ldlt().solve(n.right);
    if (!step.allFinite()) return at;
    Solution next = at;
    next.normal = (at.normal + tangents(at.normal) * step.head<2>()).normalized();
    next.omega += step.tail<3>();
    const Normal there = normal_equations(planes, prior, next);
    next.cost = there.cost;
    if (!(next.cost <= at.cost + 1e-9)) {
      damping = std::max(1e-6, damping * 100.0);
      if (damping > 1e6) return at;
      continue;
    }
    const bool still = at.cost - next.cost < 1e-6 * (1.0 + next.cost) && -step.dot(n.right) < 1e-6;
    damping = std::max(1e-9, damping * 0.1);
    at = next;
    n = there;
    if (still) break;
  }
  return at;
}

/// Cones through three normals, with every sign of two of them, and every turn up to the limit.
class Starts {
 public:
  Starts(std::span<const Plane> planes, double fastest_radps) : planes_(planes), fastest_(fastest_radps) {}

  void add(const Vector3d& normal_there, double s, const Vector3d& omega) {
    Solution start{Turn(-omega * s) * normal_there, omega};
    start.cost = robust_cost(planes_, start.normal, omega);
    starts_.push_back(start);
  }

  void add_cones(const Plane& one, const Plane& two, const Plane& three) {
    for (int signs = 0; signs < 4; ++signs) {
      const Vector3d a = one.axes.normal;
      const Vector3d b = (signs & 1) != 0 ? Vector3d(-two.axes.normal) : two.axes.normal;
      const Vector3d c = (signs & 2) != 0 ? Vector3d(-three.axes.normal) : three.axes.normal;
      const Vector3d across = (b - a).cross(c - b);
      const double length = across.norm();
      if (!(length > 1e-9)) continue;
      add_turns(across / length, a, b, c, one.s, two.s - one.s, three.s - two.s);
    }
  }

  /// The cheapest, best first.
  std::vector<Solution> best() {
    const auto cheaper = [](const Solution& a, const Solution& b) { return a.cost < b.cost; };
    const std::size_t count = std::min(kMaxRefined, starts_.size());
    std::partial_sort(starts_.begin(), starts_.begin() + static_cast<std::ptrdiff_t>(count), starts_.end(),
                      cheaper);
    starts_.resize(count);
    return std::move(starts_);
  }

 private:
  static double phase(const Vector3d& axis, const Vector3d& from, const Vector3d& to) {
    return std::atan2(axis.dot(from.cross(to)), from.dot(to) - axis.dot(from) * axis.dot(to));
  }

  void add_turns(const Vector3d& axis, const Vector3d& a, const Vector3d& b, const Vector3d& c, double from_s,
                 double first_s, double second_s) {
    const double first = phase(axis, a, b), second = phase(axis, b, c);
    const double turns = fastest_ * first_s / (2.0 * kPi) + 1.0;
    const int most = turns < kTurnLimit ? static_cast<int>(turns) : kTurnLimit;
    for (int k = -most; k <= most; ++k) {
      const double turned = first + 2.0 * kPi * k;
      const double more =
          second + 2.0 * kPi * std::round((turned * second_s / first_s - second) / (2.0 * kPi));
      const double rate = (turned + more) / (first_s + second_s);
      if (std::abs(rate) <= 1.05 * fastest_) add(a, from_s, rate * axis);
    }
  }

  std::span<const Plane> planes_;
  double fastest_;
  std::vector<Solution> starts_;
};

bool same_spin(const Solution& a, const Solution& b, double apart_radps) {
  return (a.omega - b.omega).norm() < apart_radps;
}

double shortest_s(std::span<const Plane> planes) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < planes.size(); ++i)
    shortest = std::min(shortest, planes[i].s - planes[i - 1].s);
  return shortest;
}

/// All minima that the starts lead to, the least first.
std::vector<Solution> minima(std::span<const Plane> planes, double fastest_radps,
                             std::span<const Vector3d> guesses) {
  std::vector<const Plane*> used;
  for (const Plane& p : planes) {
    if (p.used) used.push_back(&p);
  }
  Starts starts(planes, fastest_radps);
  for (const Vector3d& guess : guesses) starts.add(used.front()->axes.normal, used.front()->s, guess);
  constexpr std::size_t kMaxTriples = 4;
  for (std::size_t i = 0; i + 2 < used.size() && i < kMaxTriples; ++i)
    starts.add_cones(*used[i], *used[i + 1], *used[i + 2]);
  std::vector<Solution> found;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double kHopeful = 100.0;
  const double apart = 0.25 * kPi / (planes.back().s - planes.front().s);
  const auto keep = [&](Solution start) {
    const Solution there = refine(planes, slow(fastest_radps), start,
                                  found.empty() ? infinity : kHopeful * (1.0 + found.front().cost));
    if (!std::isfinite(there.cost) || there.omega.norm() > fastest_radps) return;
    for (Solution& known : found) {
      if (!same_spin(known, there, apart)) continue;
      if (there.cost < known.cost) known = there;
      return;
    }
    found.push_back(there);
  };
  for (const Solution& start : starts.best()) keep(start);
  if (found.empty()) return found;
  // A turn more, or half a turn where the cone is nearly a plane, in the shortest interval about the same
  // axis.
  const Solution least = *std::ranges::min_element(found, {}, &Solution::cost);
  const double rate = least.omega.norm(), half_turn = kPi / shortest_s(planes);
  if (rate > 0.0 && (fastest_radps + rate) / half_turn < kTurnLimit) {
    const int most = static_cast<int>((fastest_radps + rate) / half_turn);
    for (int k = -most; k <= most; ++k) {
      const double other = rate + k * half_turn;
      if (k == 0 || std::abs(other) > fastest_radps) continue;
      const Vector3d omega = least.omega * (other / rate);
      if (robust_cost(planes, least.normal, omega) < least.cost + 4.0 * kCostLimit)
        keep({least.normal, omega});
    }
  }
  std::ranges::sort(found, {}, &Solution::cost);
  return found;
}

double stretch(double time, double decay_per_s) {
  return decay_per_s > 0.0 ? -std::expm1(-decay_per_s * time) / decay_per_s : time;
}

std::vector<Plane> planes_of(std::span<const LineReading> readings, double mean_s, double decay_per_s) {
  std::vector<Plane> planes;
  planes.reserve(readings.size());
  for (const LineReading& r : readings) {
    Plane& p = planes.emplace_back();
    p.s = stretch(r.time_s - mean_s, decay_per_s);
    p.axes = line_plane(r.angle_rad, r.tilt_rad, r.sight);
    // A larger angle moves the normal against the chord, by the cosine of the tilt.
    const double cosine = std::max(std::cos(r.tilt_rad), 1e-6);
    p.a_sd = r.angle_sd_rad * cosine;
    p.b_sd = r.tilt_sd_rad;
    p.correlation = -r.correlation;
    p.time_sd_s = r.time_sd_s;
  }
  return planes;
}

/// Noise explains a cost beyond that once in ten thousand (Wilson and Hilferty's approximation of chi
/// squared).
double largest_cost(std::size_t readings) {
  constexpr double kQuantile = 3.719;  // of the normal distribution
  const double freedom = 2.0 * static_cast<double>(readings) - 5.0, share = 2.0 / (9.0 * freedom);
  return freedom * std::pow(1.0 - share + kQuantile * std::sqrt(share), 3);
}

}  // namespace

double LineSpin::stretched_s(double time) const { return stretch(time - time_s, decay_per_s); }

Vector3d LineSpin::normal_at(double time) const { return Turn(omega_radps * stretched_s(time)) * normal; }

namespace {

/// The best spin about the camera's axis near one, and its chi squared.
Solution best_along_camera(std::span<const Plane> planes, const Vector3d& prior, double omega_radps) {
  constexpr double kHeld = 1e8;  // to a tenth of a milliradian a second
  const auto first = std::ranges::find_if(planes, &Plane::used);
  const Vector3d omega(0.0, 0.0, omega_radps);
  Solution planar{Turn(-omega * first->s) * first->axes.normal, omega};
  planar = refine(planes, {kHeld, kHeld, prior.z()}, planar, std::numeric_limits<double>::infinity());
  planar.cost -= prior.z() * omega.z() * omega.z();
  return planar;
}

}  // namespace

std::optional<LineSpin> fit_line_spin(std::span<const LineReading> readings, const SpinLimits& limits,
                                      std::span<const Vector3d> guesses_radps) {
  if (readings.size() < 3) return std::nullopt;
  LineSpin fit;
  for (const LineReading& r : readings) fit.time_s += r.time_s / static_cast<double>(readings.size());
  fit.decay_per_s = limits.decay_per_s;
  std::vector<Plane> planes = planes_of(readings, fit.time_s, fit.decay_per_s);
  std::vector<Solution> found = minima(planes, limits.fastest_radps, guesses_radps);
  if (found.empty()) return std::nullopt;
  if (found.front().cost > largest_cost(planes.size())) {
    constexpr std::size_t kMinForOutlier = 5;
    if (planes.size() < kMinForOutlier) return std::nullopt;
    std::vector<Solution> best;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      planes[i].used = false;
      std::vector<Solution> others = minima(planes, limits.fastest_radps, guesses_radps);
      planes[i].used = true;
      if (others.empty() || (!best.empty() && others.front().cost >= best.front().cost)) continue;
      best = std::move(others);
      fit.left_out = {i};
    }
    if (best.empty() || best.front().cost > largest_cost(planes.size() - 1)) return std::nullopt;
    found = std::move(best);
    planes[fit.left_out.front()].used = false;
  }
  const double comparable = found.front().cost + kComparable;
  std::erase_if(found, [&](const Solution& s) { return s.cost >= comparable; });
  std::ranges::sort(found, {}, [](const Solution& s) { return s.omega.squaredNorm(); });
  const Solution& least = found.front();
  fit.normal = least.normal;
  fit.omega_radps = least.omega;
  const Vector3d prior = slow(limits.fastest_radps);
  const Normal at_least = normal_equations(planes, prior, least);
  fit.chi_squared = at_least.cost - least.omega.dot(prior.cwiseProduct(least.omega));
  Matrix5d inverse = at_least.matrix.ldlt().solve(Matrix5d::Identity());
  const double along = guesses_radps.empty() ? least.omega.z() : guesses_radps.front().z();
  const Solution planar = best_along_camera(planes, prior, along);
  fit.planar_excess = planar.cost - fit.chi_squared;
  if (fit.planar_excess < kRejectedOfTwo) {
    // Where images hardly tell a turn about the normal, the least is anywhere: to the first order from here.
    const Normal there = normal_equations(planes, prior, planar);
    inverse = there.matrix.ldlt().solve(Matrix5d::Identity());
    const Vector5d step = -inverse * there.right;
    fit.normal = (planar.normal + tangents(planar.normal) * step.head<2>()).normalized();
    fit.omega_radps = planar.omega + step.tail<3>();
  }
  fit.covariance = inverse.bottomRightCorner<3, 3>();
  if (!fit.covariance.allFinite() || !(fit.covariance.diagonal().minCoeff() > 0.0)) return std::nullopt;
  for (std::size_t i = 1; i < found.size(); ++i) fit.alternatives_radps.push_back(found[i].omega);
  return fit;
}

std::optional<PlanarTest> test_planar(std::span<const LineReading> readings) {
  if (readings.size() < 3) return std::nullopt;
  double weight = 0.0, mean = 0.0;
  Vector2d mean_row = Vector2d::Zero();
  const auto row = [](const LineReading& r) {
    return Vector2d(-std::sin(r.angle_rad), std::cos(r.angle_rad));
  };
  for (const LineReading& r : readings) {
    const double w = 1.0 / (r.tilt_sd_rad * r.tilt_sd_rad);
    weight += w;
    mean += w * r.tilt_rad;
    mean_row += w * row(r);
  }
  mean /= weight;
  mean_row /= weight;
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  Vector2d right = Vector2d::Zero();
  double square = 0.0;
  for (const LineReading& r : readings) {
    const double w = 1.0 / (r.tilt_sd_rad * r.tilt_sd_rad), tilt = r.tilt_rad - mean;
    const Vector2d x = row(r) - mean_row;
    matrix.noalias() += w * x * x.transpose();
    right.noalias() += (w * tilt) * x;
    square += w * tilt * tilt;
  }
  // The smaller one has lost all digits where the line hardly turned.
  const double determinant = matrix.determinant(), trace = matrix.trace();
  if (!(determinant > 1e-12 * trace * trace)) return std::nullopt;
  PlanarTest test;
  test.ratio_covariance = matrix.inverse();
  test.ratio = test.ratio_covariance * right;
  test.chi_squared_gain = test.ratio.dot(right);
  test.chi_squared = square - test.chi_squared_gain;
  test.degrees_of_freedom = static_cast<double>(readings.size()) - 3.0;
  return test;
}

}  // namespace strobe::attitude
