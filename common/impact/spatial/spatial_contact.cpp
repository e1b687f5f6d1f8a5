#include "common/impact/spatial/spatial_contact.hpp"

#include <algorithm>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>

namespace strobe::impact {

namespace detail {

namespace {

using Along = Eigen::Vector2d;

constexpr int kMaxSpatialSteps = 100'000;
constexpr double kLargestSpatialStep = 0.1, kMinSpatialStep = 1e-12;
constexpr double kStepShare = 0.1;  // of the tolerance at release that one step may use
/// Normal force below which a slip without a dashpot turns no faster: too stiff, and of no account.
constexpr double kMinForce = 1e-5;
constexpr double kUndecidedStep = 1e-7;  // where rounding cannot tell grip from slip

Along pair(const SpatialComponents& z, std::size_t at) { return {z[at], z[at + 1]}; }
void put(SpatialComponents& z, std::size_t at, const Along& value) {
  z[at] = value[0];
  z[at + 1] = value[1];
}

Along direction_of(const Along& a, const Along& otherwise) {
  const double length = a.norm();
  return length > 0.0 ? Along(a / length) : otherwise;
}

/// What acts at a state. In a slip without a dashpot the stretch follows from the friction, and its direction
/// is what the state has in its place.
struct Contact {
  double normal, normal_rate;
  Along slip, spin, stretch, hold;  ///< hold: the force that would hold the contact point
  Along towards;                    ///< of a slip's friction
};

Contact contact_at(const SpatialSystem& c, bool grips, const SpatialComponents& z) {
  const System& s = c.system;
  Contact out;
  const double pushed = z[kSpatialDepth] + 2.0 * s.zeta * z[kSpatialDepthRate];
  out.normal = std::max(pushed, 0.0);
  out.normal_rate = z[kSpatialDepthRate] + 2.0 * s.zeta * (s.gravity - pushed);
  out.spin = c.w0 + pair(z, kSpatialSpin);
  out.slip = c.slip0 + (pair(z, kSpatialVelocity) + pair(z, kSpatialSpin));
  out.stretch = pair(z, kSpatialStretch);
  if (!grips && s.ct == 0.0) out.stretch = s.mu * out.normal / s.kt * out.stretch.normalized();
  out.hold = s.kt * out.stretch + s.ct * out.slip;
  out.towards =
      !grips && s.ct == 0.0 ? Along(pair(z, kSpatialStretch).normalized()) : direction_of(out.hold, out.slip);
  return out;
}

/// Gripping mu·N - |F|; slipping what |F| of a grip would exceed mu·N by, without a dashpot how fast it
/// would: positive where the law holds.
double law_at(const SpatialSystem& c, bool grips, const SpatialComponents& z) {
  const System& s = c.system;
  const Contact at = contact_at(c, grips, z);
  if (!grips && s.ct == 0.0) return s.kt * at.slip.dot(at.towards) - s.mu * at.normal_rate;
  const double spare = s.mu * at.normal - at.hold.norm();
  return grips ? spare : -spare;
}

/// Friction, and the rate of what the state has for the stretch.
struct Friction2 {
  Along force, stretch_rate, held_rate;
};

Friction2 friction_at(const SpatialSystem& c, bool grips, const Contact& at) {
  const System& s = c.system;
  const double limit = s.mu * at.normal;
  if (s.ct == 0.0 ? grips : at.hold.norm() <= limit) return {at.hold, at.slip, at.slip};
  const Along force = limit * at.towards;
  if (s.ct > 0.0) {
    const Along rate = (force - s.kt * at.stretch) / s.ct;
    return {force, rate, rate};
  }
  if (limit == 0.0) return {force, Along::Zero(), Along::Zero()};
  const Along across = at.slip - at.slip.dot(at.towards) * at.towards;
  return {force, s.mu * at.normal_rate / s.kt * at.towards + across,
          s.kt / std::max(limit, kMinForce * s.mu) * across};
}

/// Rates along x, tau = T·x²(3 - 2x).
struct SpatialEquations {
  const SpatialSystem& c;
  bool grips;

  void operator()(const SpatialComponents& z, SpatialComponents& rate, double x) const {
    const System& s = c.system;
    const Contact at = contact_at(c, grips, z);
    const Friction2 friction = friction_at(c, grips, at);
    const double share = std::clamp(z[kSpatialDepth] / s.radius, 0.0, 1.0);
    const double offset = s.delta * std::sqrt(share * (2.0 - share));
    const Along couple = -offset * at.normal / std::hypot(at.spin.norm(), s.w_ref) * at.spin;
    rate[kSpatialDepth] = z[kSpatialDepthRate];
    rate[kSpatialDepthRate] = s.gravity - z[kSpatialDepth] - 2.0 * s.zeta * z[kSpatialDepthRate];
    put(rate, kSpatialVelocity, c.along - friction.force);
    put(rate, kSpatialSpin, (couple - friction.force) / s.alpha);
    put(rate, kSpatialStretch, friction.held_rate);
    put(rate, kSpatialPath, pair(z, kSpatialVelocity));
    rate[kSpatialLosses] = 2.0 * s.zeta * z[kSpatialDepthRate] * z[kSpatialDepthRate];
    rate[kSpatialLosses + 1] = friction.force.dot(at.slip - friction.stretch_rate);
    rate[kSpatialLosses + 2] = s.ct * friction.stretch_rate.squaredNorm();
    rate[kSpatialLosses + 3] = -couple.dot(at.spin);
    const Eigen::Quaterniond attitude(&z[kSpatialAttitude]);
    const Eigen::Vector3d turn = Eigen::Vector3d(-at.spin[1], c.wy0, at.spin[0]) / (2.0 * s.radius);
    Eigen::Map<Eigen::Vector4d> turning(rate.data() + kSpatialAttitude);
    turning = (Eigen::Quaterniond(0.0, turn.x(), turn.y(), turn.z()) * attitude).coeffs();
    const double pace = 6.0 * c.tau * x * (1.0 - x);
    for (double& r : rate) r *= pace;
  }
};

using DormandPrince =
    boost::numeric::odeint::runge_kutta_dopri5<SpatialComponents, double, SpatialComponents, double,
                                               boost::numeric::odeint::array_algebra>;

SpatialComponents after(const SpatialSystem& c, const SpatialStep& from, double size) {
  SpatialComponents out;
  DormandPrince().do_step(SpatialEquations{c, from.grips}, from.start, from.x, out, size);
  return out;
}

class SpatialIntegrator {
 public:
  SpatialIntegrator(const SpatialSystem& system, double tolerance, std::vector<SpatialStep>& steps)
      : c_(system), steps_(steps), negligible_(0.1 * tolerance) {
    const System& s = c_.system;
    now_.grips = initial_mode(s) == ContactMode::grips;
    now_.start[kSpatialDepthRate] = 1.0;
    now_.start[kSpatialAttitude + 3] = 1.0;
    started_gripping_ = now_.grips;
    if (!now_.grips && s.ct == 0.0) put(now_.start, kSpatialStretch, direction_of(c_.slip0, c_.along));
    stops_ = s.slip0 == 0.0;
    const double along = std::max(s.tangential_scale(), 1e-9);
    scale_.fill(along);
    scale_[kSpatialDepth] = scale_[kSpatialDepthRate] = scale_[kSpatialLosses] = 1.0;
    for (const std::size_t i : {0, 1}) scale_[kSpatialStretch + i] = along / std::max({1.0, s.kt, along});
    for (const std::size_t i : {1, 2, 3})
      scale_[kSpatialLosses + i] = along * (s.slip0 + along + (s.delta > 0.0 ? s.w0 : 0.0));
    for (const std::size_t i : {0, 1, 2, 3}) scale_[kSpatialAttitude + i] = 1.0;
    for (double& scale : scale_) scale = 1.0 / (kStepShare * tolerance * scale);
  }

  /// The state at release.
  std::optional<SpatialComponents> run() {
    for (int i = 0; i < kMaxSpatialSteps && now_.x < 1.0; ++i) step();
    if (now_.x < 1.0) return std::nullopt;
    put(now_.start, kSpatialStretch, contact_at(c_, now_.grips, now_.start).stretch);
    return now_.start;
  }

  bool grips() const { return stops_ || first_grip_x_; }
  std::optional<double> first_grip_x() const {
    return started_gripping_ && stops_ ? std::optional(0.0) : first_grip_x_;
  }

 private:
  void step() {
    steps_.push_back(now_);
    double size = attempt();
    const bool deep = is_deep(now_.start);
    if (c_.system.delta > 0.0 && is_deep(end_) != deep)
      size = located(size, [&](const SpatialComponents& z) { return is_deep(z) != deep; });
    const auto broken = [&](const SpatialComponents& z) { return law_at(c_, now_.grips, z) < 0.0; };
    if (!(law_at(c_, now_.grips, end_) < -noise())) return advance(size);
    double taken = std::min(size, kUndecidedStep);
    if (law_at(c_, now_.grips, now_.start) > 0.0)
      taken = located(size, broken);
    else  // what it is just after the other law ended is rounding
      end_ = after(c_, now_, taken);
    if (contact_at(c_, now_.grips, end_).normal <
        negligible_) {  // as it sets in or ends, errors of the force decide
      end_ = after(c_, now_, size);
      return advance(size);
    }
    const bool grips = !now_.grips;
    advance(taken);
    if (c_.system.ct == 0.0) {
      const Contact at = contact_at(c_, now_.grips, now_.start);
      put(now_.start, kSpatialStretch, grips ? at.stretch : at.towards);
    }
    if (grips && !first_grip_x_) first_grip_x_ = now_.x;
    now_.grips = grips;
    size_ = std::max(size - taken, 0.1 * size);
  }

  /// The footprint has its largest size.
  bool is_deep(const SpatialComponents& z) const { return z[kSpatialDepth] > c_.system.radius; }

  double noise() const {
    const System& s = c_.system;
    return 1e-14 * (s.mu + contact_at(c_, now_.grips, end_).hold.norm() + std::max(s.ct, 1.0) * s.slip0);
  }

  /// Takes a step into end_ and returns its size.
  double attempt() {
    for (;;) {
      const double size = std::min(size_, 1.0 - now_.x);
      SpatialComponents error;
      DormandPrince().do_step(SpatialEquations{c_, now_.grips}, now_.start, now_.x, end_, size, error);
      double worst = 0.0;
      for (std::size_t i = 0; i < kSpatialComponents; ++i)
        worst = std::max(worst, std::abs(error[i]) * scale_[i]);
      const double factor = worst > 0.0 ? std::clamp(0.9 * std::pow(worst, -0.2), 0.2, 5.0) : 5.0;
      size_ = std::min(size * factor, kLargestSpatialStep);
      if (worst <= 1.0 || size <= kMinSpatialStep) return size;
    }
  }

  /// The size at which a step's end just comes to be what it was not, with the state there in end_.
  template <typename Condition>
  double located(double high, const Condition& has_come) {
    double low = 0.0;
    for (;;) {
      const double middle = 0.5 * (low + high);
      if (!(middle > low && middle < high)) return high;
      const SpatialComponents z = after(c_, now_, middle);
      if (has_come(z)) {
        high = middle;
        end_ = z;
      } else {
        low = middle;
      }
    }
  }

  void advance(double size) {
    if (c_.system.ct == 0.0 && !now_.grips)
      put(end_, kSpatialStretch, pair(end_, kSpatialStretch).normalized());
    stops_ = stops_ || (!first_grip_x_ && contact_at(c_, now_.grips, end_).slip.dot(c_.slip0) <= 0.0);
    now_.x = std::min(now_.x + size, 1.0);
    now_.start = end_;
  }

  const SpatialSystem& c_;
  std::vector<SpatialStep>& steps_;
  double negligible_;  ///< normal force
  SpatialStep now_;
  SpatialComponents end_{}, scale_{};
  double size_ = 1e-2;
  bool started_gripping_ = false, stops_ = false;
  std::optional<double> first_grip_x_;
};

tl::expected<SpatialSystem, InputError> spatial_system(const ball::Ball& ball, const SpatialMotion& touchdown,
                                                       const ContactCoefficients& coefficients) {
  for (const Motion& part : planar_parts(touchdown))
    if (const auto checked = make_system(ball, part, coefficients); !checked)
      return tl::unexpected(checked.error());
  if (coefficients.offset_law == OffsetLaw::constant_ahead)
    return tl::unexpected(InputError::offset_out_of_range);
  const double vy = touchdown.velocity_mps.y();
  ContactCoefficients level = coefficients;
  level.gravity_along_mps2 = 0.0;
  const auto fall = impact::lift_off(ball, Motion{.vy_mps = vy}, level, {.tolerance = 1e-12});
  if (!fall) return tl::unexpected(fall.error());
  SpatialSystem c;
  c.system = *make_system(ball, {.vy_mps = vy}, coefficients);
  System& s = c.system;
  c.v0 = along_surface(touchdown.velocity_mps) / s.speed_mps;
  c.w0 = s.radius_m * rolling_spin(touchdown.spin_radps) / s.speed_mps;
  c.slip0 = slip_mps(ball, touchdown) / s.speed_mps;
  c.along = {s.along, 0.0};
  c.wy0 = s.radius_m * touchdown.spin_radps.y() / s.speed_mps;
  c.tau = fall->dwell_s * s.frequency_radps;
  s.slip0 = c.slip0.norm();
  s.w0 = c.w0.norm();
  return c;
}

ContactEnergy energy_of(const SpatialSystem& c, const SpatialComponents& z) {
  const System& s = c.system;
  const Along dv = pair(z, kSpatialVelocity), dw = pair(z, kSpatialSpin);
  const double rate = z[kSpatialDepthRate], joule = s.mass_kg * s.speed_mps * s.speed_mps;
  const double kinetic = 0.5 * (c.v0.squaredNorm() + 1.0 + s.alpha * (c.w0.squaredNorm() + c.wy0 * c.wy0));
  const double lost =
      0.5 * (1.0 - rate) * (1.0 + rate) - dv.dot(c.v0 + 0.5 * dv) - s.alpha * dw.dot(c.w0 + 0.5 * dw);
  const double pulled = c.along.dot(c.v0 * c.tau + pair(z, kSpatialPath));
  return {.kinetic_td_j = joule * kinetic,
          .kinetic_lo_j = joule * (kinetic - lost),
          .kinetic_lost_j = joule * lost,
          .normal_damping_j = joule * z[kSpatialLosses],
          .sliding_j = joule * z[kSpatialLosses + 1],
          .tangential_damping_j = joule * z[kSpatialLosses + 2],
          .offset_j = joule * z[kSpatialLosses + 3],
          .normal_spring_left_j = joule * 0.5 * z[kSpatialDepth] * z[kSpatialDepth],
          .tangential_spring_left_j = joule * 0.5 * s.kt * pair(z, kSpatialStretch).squaredNorm(),
          .gravity_work_j = joule * (s.gravity * z[kSpatialDepth] + pulled)};
}

double tau_of(const SpatialSystem& c, double x) { return c.tau * x * x * (3.0 - 2.0 * x); }

}  // namespace

}  // namespace detail

SpatialState SpatialContact::state_of(const detail::SpatialComponents& z, double tau) const {
  using namespace detail;
  const System& s = system_.system;
  const double metre = s.speed_mps / s.frequency_radps;
  SpatialState out;
  out.time_s = tau / s.frequency_radps;
  out.motion =
      changed(touchdown_, -s.speed_mps * z[kSpatialDepthRate], s.speed_mps * pair(z, kSpatialVelocity),
              s.speed_mps / s.radius_m * pair(z, kSpatialSpin));
  const Along path = metre * (system_.v0 * tau + pair(z, kSpatialPath));
  out.displacement_m = {path[0], -metre * z[kSpatialDepth], path[1]};
  out.rotation = Eigen::Quaterniond(&z[kSpatialAttitude]).normalized();
  return out;
}

tl::expected<SpatialContact, InputError> SpatialContact::make(const ball::Ball& ball,
                                                              const SpatialMotion& touchdown,
                                                              const ContactCoefficients& coefficients,
                                                              double tolerance) {
  const auto system = detail::spatial_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  if (!(tolerance >= 1e-12 && tolerance <= 1e-3)) return tl::unexpected(InputError::tolerance_out_of_range);
  SpatialContact out;
  out.touchdown_ = touchdown;
  out.system_ = *system;
  detail::SpatialIntegrator integrator(out.system_, tolerance, out.steps_);
  const auto release = integrator.run();
  if (!release) return tl::unexpected(InputError::too_many_steps);
  static_cast<SpatialState&>(out.lift_off_) = out.state_of(*release, system->tau);
  out.lift_off_.regime = integrator.grips() ? Regime::grips : Regime::slides;
  if (const auto x = integrator.first_grip_x())
    out.lift_off_.skid_to_grip_s = detail::tau_of(*system, *x) / system->system.frequency_radps;
  out.lift_off_.energy = detail::energy_of(*system, *release);
  return out;
}

SpatialState SpatialContact::at(double time_s) const {
  const double share = std::clamp(time_s / lift_off_.time_s, 0.0, 1.0);
  const double x = std::clamp(0.5 - std::sin(std::asin(1.0 - 2.0 * share) / 3.0), 0.0, 1.0);
  const auto next = std::upper_bound(steps_.begin() + 1, steps_.end(), x,
                                     [](double at, const detail::SpatialStep& step) { return at < step.x; });
  const detail::SpatialStep& from = *(next - 1);
  return state_of(detail::after(system_, from, x - from.x), share * system_.tau);
}

tl::expected<SpatialMotion, InputError> spatial_lift_off(const ball::Ball& ball,
                                                         const SpatialMotion& touchdown,
                                                         const ContactCoefficients& coefficients,
                                                         double tolerance) {
  constexpr double kRounding = 1e-14;
  const auto system = detail::spatial_system(ball, touchdown, coefficients);
  if (!system) return tl::unexpected(system.error());
  const detail::Along spin = system->w0;
  const detail::Along n = detail::direction_of(system->slip0, detail::direction_of(spin, {1.0, 0.0}));
  const double across = n.x() * spin.y() - n.y() * spin.x();
  const bool splits = (coefficients.offset_share == 0.0 || std::abs(across) <= kRounding * spin.norm()) &&
                      (coefficients.gravity_along_mps2 == 0.0 || std::abs(n.y()) <= kRounding);
  if (!splits)
    return SpatialContact::make(ball, touchdown, coefficients, tolerance).map([](const SpatialContact& c) {
      return c.lift_off().motion;
    });
  const double v = n.dot(along_surface(touchdown.velocity_mps)),
               w = n.dot(rolling_spin(touchdown.spin_radps));
  ContactCoefficients turned = coefficients;
  turned.gravity_along_mps2 *= n.x();
  return lift_off(ball, {v, touchdown.velocity_mps.y(), w}, turned, {.tolerance = tolerance})
      .map([&](const ContactLiftOff& contact) {
        const Motion& m = contact.lift_off;
        return changed(touchdown, m.vy_mps, (m.vx_mps - v) * n, (m.omega_radps - w) * n);
      });
}

}  // namespace strobe::impact
