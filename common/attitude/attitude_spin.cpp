#include "common/attitude/attitude_spin.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include "common/attitude/turn.hpp"

namespace strobe::attitude {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
// Of the attitude, the spin, the decay, the wobble, in that order.
constexpr int kUnknowns = 10, kSpin = 3, kDecay = 6, kWobble = 7;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Covariance = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Design = Eigen::Matrix<double, 3, kUnknowns>;

// 5 sd of three degrees of freedom, about; a chance of 1e-5 each.
constexpr double kGate = 25.0;
constexpr double kMedianOfChiSquared3 = 2.366;
// While a start grows, attitudes may be worse by this factor of the variance than they say.
constexpr double kGrowing = 4.0;
constexpr double kLargestScatter = 9.0;
// An attitude that is expected only to so much would be taken for one a turn away.
constexpr double kTooUncertain_rad = 0.7;
constexpr double kThousandToOne = 13.8;  // 2·log(1000), of chi squared
constexpr std::size_t kMaxStarts = 40;
constexpr int kMaxTurns = 1000;

Matrix3d left_jacobian(const Vector3d& v) {
  const Turn turn(v);
  Matrix3d jacobian;
  for (int k = 0; k < 3; ++k) jacobian.row(k) = turn.transposed_jacobian(Vector3d::Unit(k)).transpose();
  return jacobian;
}

/// Of the spin during `t`: the integral of exp(-decay·t), to second order.
double decayed(double t, double decay) { return t * (1.0 - 0.5 * decay * t); }

struct State {
  double time_s = 0.0;  ///< the reference
  Matrix3d attitude = Matrix3d::Identity();
  Vector3d spin = Vector3d::Zero();
  double decay = 0.0;
  Vector3d wobble = Vector3d::Zero();
  Covariance covariance = Covariance::Zero();

  Matrix3d at(double time) const {
    const double t = time - time_s;
    return rotation(spin * decayed(t, decay)) * rotation(wobble * t) * attitude;
  }
  Vector3d residual(const TimedAttitude& one) const {
    return rotation_vector_rad(one.attitude * at(one.time_s).transpose());
  }
  Design design(double time) const {
    const double t = time - time_s, s = decayed(t, decay);
    const Matrix3d turned = rotation(spin * s);
    Design h;
    h << turned * rotation(wobble * t), left_jacobian(spin * s) * s, -0.5 * t * t * spin,
        turned * left_jacobian(wobble * t) * t;
    return h;
  }
  void move_reference(double time) {
    const double t = time - time_s;
    const Matrix3d turned = rotation(spin * decayed(t, decay));
    attitude = at(time);
    wobble = turned * wobble;
    spin *= 1.0 - decay * t;
    time_s = time;
  }
};

double squared(const Vector3d& residual, const Matrix3d& covariance) {
  return residual.dot(covariance.ldlt().solve(residual));
}

class SpinFitter {
 public:
  SpinFitter(std::span<const TimedAttitude> given, const SpinSearch& search)
      : given_(given), search_(search), fastest_(search.fastest_spin_radps) {
    order_.resize(given.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::stable_sort(order_, {}, [&](std::size_t i) { return given_[i].time_s; });
  }

  std::vector<SpinFit> run() {
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t apart : {1U, 2U})
      for (std::size_t k = 0; k + apart < order_.size(); ++k)
        pairs.emplace_back(order_[k], order_[k + apart]);
    const std::size_t step = (pairs.size() + kMaxStarts - 1) / kMaxStarts;
    for (std::size_t k = 0; k < pairs.size(); k += step) start(pairs[k].first, pairs[k].second);
    return ranked();
  }

 private:
  struct Solution {
    State state;
    std::vector<bool> used;
    double cost = 0.0;  ///< chi squared, an outlier's cut off at the widest gate
  };

  void start(std::size_t i, std::size_t j) {
    const TimedAttitude &a = given_[i], &b = given_[j];
    const double dt = b.time_s - a.time_s;
    const Vector3d turn = rotation_vector_rad(b.attitude * a.attitude.transpose());
    const double angle = turn.norm();
    const Vector3d axis = angle > 0.0 ? Vector3d(turn / angle) : Vector3d::UnitX();
    const int most = std::min(kMaxTurns, static_cast<int>(fastest_ * dt / (2.0 * std::numbers::pi)) + 1);
    for (int whole = -most; whole <= most; ++whole) {
      const double rate = (angle + 2.0 * std::numbers::pi * whole) / dt;
      if (std::abs(rate) > fastest_) continue;
      State state{.time_s = a.time_s, .attitude = a.attitude, .spin = axis * rate};
      grow(state, i, j);
    }
  }

  void grow(State state, std::size_t i, std::size_t j) {
    std::vector<bool> used(given_.size(), false);
    used[i] = used[j] = true;
    if (!refine(state, used)) return;
    const double middle = 0.5 * (given_[i].time_s + given_[j].time_s);
    std::vector<std::size_t> nearest = order_;
    std::ranges::stable_sort(nearest, {}, [&](std::size_t k) { return std::abs(given_[k].time_s - middle); });
    for (const std::size_t k : nearest) {
      if (used[k]) continue;
      const Design h = state.design(given_[k].time_s);
      const Matrix3d expected = h * state.covariance * h.transpose();
      if (expected.trace() > kTooUncertain_rad * kTooUncertain_rad) continue;
      const Matrix3d all = kGrowing * (expected + given_[k].covariance_rad2);
      if (squared(state.residual(given_[k]), all) > kGate) continue;
      used[k] = true;
      if (!refine(state, used)) return;
    }
    settle(state, used);
  }

  /// Who is an outlier is decided anew by the whole fit, until that stays.
  void settle(State state, std::vector<bool> used) {
    for (int round = 0; round < 10; ++round) {
      const double scatter = scatter_of(state, used);
      std::vector<bool> now(given_.size());
      for (std::size_t k = 0; k < given_.size(); ++k) now[k] = chi_squared(state, k) <= kGate * scatter;
      if (now == used || std::ranges::count(now, true) < 2) break;
      used = now;
      if (!refine(state, used)) return;
    }
    if (state.spin.norm() > fastest_) return;
    Solution solution{state, used, values(state).dot(prior(state) * values(state))};
    for (std::size_t k = 0; k < given_.size(); ++k)
      solution.cost += std::min(kGate * kLargestScatter, chi_squared(state, k));
    keep(std::move(solution));
  }

  double chi_squared(const State& state, std::size_t k) const {
    return squared(state.residual(given_[k]), given_[k].covariance_rad2);
  }

  /// By how much the used ones' variances are larger than stated, by their median, at least 1.
  double scatter_of(const State& state, const std::vector<bool>& used) const {
    std::vector<double> all;
    for (std::size_t k = 0; k < given_.size(); ++k)
      if (used[k]) all.push_back(chi_squared(state, k));
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::ranges::nth_element(all, middle);
    return std::clamp(*middle / kMedianOfChiSquared3, 1.0, kLargestScatter);
  }

  /// Inverse covariance of what decay and wobble may be. A wobble along the spin would be the spin's.
  Covariance prior(const State& state) const {
    constexpr double kNone = 1e-6, kAlongOfAcross = 1e-3;
    const double decay_sd = std::max(kNone, search_.decay_sd_per_s);
    const double across = std::max(kNone, search_.wobble_sd) * std::max(1.0, state.spin.norm());
    const double along = kAlongOfAcross * across;
    const Vector3d axis = state.spin.norm() > 0.0 ? Vector3d(state.spin.normalized()) : Vector3d::UnitX();
    const Matrix3d onto = axis * axis.transpose();
    Covariance p = Covariance::Zero();
    p(kDecay, kDecay) = 1.0 / (decay_sd * decay_sd);
    p.block<3, 3>(kWobble, kWobble) =
        (Matrix3d::Identity() - onto) / (across * across) + onto / (along * along);
    return p;
  }

  static Unknowns values(const State& state) {
    Unknowns v = Unknowns::Zero();
    v[kDecay] = state.decay;
    v.segment<3>(kWobble) = state.wobble;
    return v;
  }

  /// Gauss-Newton, with the reference time in the middle, where attitude and spin are least correlated.
  bool refine(State& state, const std::vector<bool>& used) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < given_.size(); ++k) sum += used[k] ? given_[k].time_s : 0.0;
    state.move_reference(sum / static_cast<double>(std::ranges::count(used, true)));
    for (int step = 0; step < 20; ++step) {
      Covariance normal = prior(state);
      Unknowns right = -normal * values(state);
      for (std::size_t k = 0; k < given_.size(); ++k) {
        if (!used[k]) continue;
        const Design h = state.design(given_[k].time_s);
        const Eigen::Matrix<double, kUnknowns, 3> weighted =
            h.transpose() * given_[k].covariance_rad2.inverse();
        normal += weighted * h;
        right += weighted * state.residual(given_[k]);
      }
      // Rates are some hundred times larger numbers than angles.
      const Unknowns scale = normal.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::LDLT<Covariance> solver(scale.asDiagonal() * normal * scale.asDiagonal());
      if (!scale.allFinite() || solver.info() != Eigen::Success || !solver.isPositive()) return false;
      const Unknowns change = scale.asDiagonal() * solver.solve(scale.asDiagonal() * right);
      if (!change.allFinite()) return false;
      state.attitude = rotation(change.head<3>()) * state.attitude;
      state.spin += change.segment<3>(kSpin);
      state.decay += change[kDecay];
      state.wobble += change.segment<3>(kWobble);
      state.covariance = scale.asDiagonal() * solver.solve(Covariance::Identity()) * scale.asDiagonal();
      if (change.cwiseQuotient(state.covariance.diagonal().cwiseSqrt()).norm() < 1e-6) break;
    }
    return true;
  }

  /// Starts that end at one place are one.
  void keep(Solution solution) {
    for (Solution& other : solutions_) {
      const Matrix3d both = solution.state.covariance.block<3, 3>(kSpin, kSpin) +
                            other.state.covariance.block<3, 3>(kSpin, kSpin);
      if ((solution.state.spin - other.state.spin).squaredNorm() > kGate * both.trace()) continue;
      if (solution.cost < other.cost) other = std::move(solution);
      return;
    }
    solutions_.push_back(std::move(solution));
  }

  std::vector<SpinFit> ranked() {
    std::ranges::stable_sort(solutions_, {}, &Solution::cost);
    std::vector<SpinFit> fits;
    if (solutions_.empty()) return fits;
    const Solution& first = solutions_.front();
    const double best = first.cost, least = kThousandToOne * scatter_of(first.state, first.used);
    std::erase_if(solutions_, [&](const Solution& s) { return s.cost > best + least; });
    const auto equal =
        std::ranges::find_if(solutions_, [&](const Solution& s) { return s.cost > best + 0.1; });
    std::ranges::stable_sort(solutions_.begin(), equal, {},
                             [](const Solution& s) { return s.state.spin.norm(); });
    for (const Solution& solution : solutions_) fits.push_back(fit_of(solution));
    return fits;
  }

  SpinFit fit_of(const Solution& solution) const {
    const State& state = solution.state;
    SpinFit fit;
    fit.spin_radps = state.spin;
    fit.reference_time_s = state.time_s;
    fit.attitude = state.attitude;
    fit.decay_per_s = state.decay;
    fit.wobble_radps = state.wobble;
    fit.used = solution.used;
    for (std::size_t k = 0; k < given_.size(); ++k) {
      fit.residuals_rad.push_back(state.residual(given_[k]));
      if (fit.used[k]) fit.chi_squared += chi_squared(state, k);
    }
    const int unknowns = 6 + (search_.decay_sd_per_s > 0.0 ? 1 : 0) + (search_.wobble_sd > 0.0 ? 2 : 0);
    fit.degrees_of_freedom = 3 * static_cast<int>(std::ranges::count(fit.used, true)) - unknowns;
    const double reduced = fit.degrees_of_freedom > 0 ? fit.chi_squared / fit.degrees_of_freedom : 1.0;
    const Covariance covariance = std::max(1.0, reduced) * state.covariance;
    fit.covariance_radps2 = covariance.block<3, 3>(kSpin, kSpin);
    fit.decay_sd_per_s = std::sqrt(covariance(kDecay, kDecay));
    fit.wobble_covariance_radps2 = covariance.block<3, 3>(kWobble, kWobble);
    return fit;
  }

  std::span<const TimedAttitude> given_;
  SpinSearch search_;
  double fastest_;
  std::vector<std::size_t> order_;  ///< by time
  std::vector<Solution> solutions_;
};

std::optional<std::string> unusable(std::span<const TimedAttitude> attitudes, const SpinSearch& search) {
  if (!(search.decay_sd_per_s >= 0.0 && search.wobble_sd >= 0.0))
    return "the sds of decay and wobble must be 0 or more";
  if (!(search.fastest_spin_radps > 0.0 && std::isfinite(search.fastest_spin_radps)))
    return "the fastest spin must be above 0 rad/s";
  if (attitudes.size() < 2) return std::to_string(attitudes.size()) + " attitude: a spin needs two or more";
  if (attitudes.size() > kMaxAttitudes)
    return std::to_string(attitudes.size()) + " attitudes: at most " + std::to_string(kMaxAttitudes) +
           " are taken";
  std::vector<double> times;
  for (const TimedAttitude& one : attitudes) {
    if (!std::isfinite(one.time_s) || !one.attitude.allFinite() || !one.covariance_rad2.allFinite() ||
        one.covariance_rad2.llt().info() != Eigen::Success)
      return "an attitude is not finite, or its covariance not positive definite";
    times.push_back(one.time_s);
  }
  std::ranges::sort(times);
  if (std::ranges::adjacent_find(times) != times.end()) return "two attitudes are of the same time";
  return std::nullopt;
}

}  // namespace

Matrix3d rotation(const Vector3d& vector_rad) {
  const double angle = vector_rad.norm();
  if (angle == 0.0) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector_rad / angle).toRotationMatrix();
}

Vector3d rotation_vector_rad(const Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2.0 * q.vec();
  return 2.0 * std::atan2(sine, q.w()) / sine * q.vec();
}

Matrix3d SpinFit::attitude_at(double time_s) const {
  const double t = time_s - reference_time_s;
  return rotation(spin_radps * decayed(t, decay_per_s)) * rotation(wobble_radps * t) * attitude;
}

Result<std::vector<SpinFit>> fit_spin(std::span<const TimedAttitude> attitudes, const SpinSearch& search) {
  if (const auto problem = unusable(attitudes, search)) return fail(*problem);
  auto fits = SpinFitter(attitudes, search).run();
  if (fits.empty())
    return fail("no two attitudes agree with a spin up to " +
                std::to_string(std::llround(search.fastest_spin_radps)) + " rad/s");
  return fits;
}

}  // namespace strobe::attitude
