#include "common/impact/fit/skid_and_energy.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>

#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact {

namespace {

constexpr int kInputs = 5;  // vx, vy, omega at touchdown; vy at lift-off; dwell time

/// The inputs with one of them moved by a number of its sds.
Observation moved(Observation o, int input, double sds) {
  double vy_lo = -o.e * o.touchdown.vy_mps;
  switch (input) {
    case 0:
      o.touchdown.vx_mps += sds * o.touchdown_sd.vx_mps;
      break;
    case 1:
      o.touchdown.vy_mps += sds * o.touchdown_sd.vy_mps;
      break;
    case 2:
      o.touchdown.omega_radps += sds * o.touchdown_sd.omega_radps;
      break;
    case 3:
      vy_lo += sds * o.lift_off_sd.vy_mps;
      break;
    default:
      o.dwell_s += sds * o.dwell_sd_s;
  }
  o.e = std::clamp(-vy_lo / o.touchdown.vy_mps, kMinSpringRestitution, 1.0);
  return o;
}

/// Sums the variance of one quantity by central differences.
class DeltaMethod {
 public:
  explicit DeltaMethod(std::optional<double> value) : value_(value) {}

  void add(std::optional<double> above, std::optional<double> below) {
    if (!value_) return;
    // Where a time is absent on one side, the other side alone is used.
    const double difference = above && below ? 0.5 * (*above - *below)
                              : above        ? *above - *value_
                              : below        ? *value_ - *below
                                             : 0.0;
    variance_ += difference * difference;
  }

  std::optional<ValueSd> result() const {
    if (!value_) return std::nullopt;
    return ValueSd{*value_, std::sqrt(variance_)};
  }

 private:
  std::optional<double> value_;
  double variance_ = 0.0;
};

double normal_impulse(double zeta, double tau) {
  const double square = (1.0 - zeta) * (1.0 + zeta);
  const double q = std::sqrt(std::abs(square));
  const double ratio = q * tau < 1e-6 ? tau : (square > 0.0 ? std::sin(q * tau) : std::sinh(q * tau)) / q;
  const double even = square > 0.0 ? std::cos(q * tau) : std::cosh(q * tau);
  return 1.0 - std::exp(-zeta * tau) * (even - zeta * ratio);
}

/// Time at which the normal impulse reaches `impulse`·m·|vy_TD|.
std::optional<double> time_of_impulse(const NormalSpring& spring, double e, double impulse) {
  if (!(impulse < 1.0 + e)) return std::nullopt;
  double low = 0.0;
  double high = release_phase(spring.damping_ratio);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_impulse(spring.damping_ratio, middle) < impulse ? low : high) = middle;
  }
  return 0.5 * (low + high) / spring.frequency_radps;
}

std::optional<double> grip_by_impulse(const Observation& o, const ContactVector& p) {
  const ball::Ball ball = ball_of(p);
  const auto spring = normal_spring(ball.mass_kg, o.e, o.dwell_s);
  if (!spring || !(p[kFitMu] > 0.0)) return std::nullopt;
  const double slip = std::abs(o.touchdown.vx_mps + ball.radius_m() * o.touchdown.omega_radps);
  const double needed = slip * p[kFitAlpha] / (1.0 + p[kFitAlpha]) / p[kFitMu];
  return time_of_impulse(*spring, o.e, needed / -o.touchdown.vy_mps);
}

double kinetic_j(const ball::Ball& ball, const Motion& m) {
  return 0.5 * ball.mass_kg * (m.vx_mps * m.vx_mps + m.vy_mps * m.vy_mps) +
         0.5 * ball.inertia_kgm2() * m.omega_radps * m.omega_radps;
}

/// The quantities of a condition.
enum Quantity : std::size_t {
  kDwell,
  kGrip,
  kSlipZero,
  kByImpulse,
  kTouchdown,
  kLoss,
  kNormal,
  kSliding,
  kTangential,
  kOffset,
  kQuantities
};
using Values = std::array<std::optional<double>, kQuantities>;

/// All nullopt where the model refuses the inputs.
Values evaluate(const Observation& o, const ContactVector& p, const ContactFitOptions& options) {
  const auto s = simulate(ball_of(p), o.touchdown, coefficients_of(o, p, options), options.contact());
  if (!s) return {};
  const ContactEnergy& e = s->energy;
  return {s->dwell_s,
          s->skid_to_grip_s,
          s->slip_zero_s,
          grip_by_impulse(o, p),
          e.kinetic_td_j,
          e.dissipated_j(),
          e.normal_damping_j + e.normal_spring_left_j,
          e.sliding_j,
          e.tangential_damping_j + e.tangential_spring_left_j,
          e.offset_j};
}

std::array<std::optional<ValueSd>, kQuantities> with_sds(const Observation& o, const ContactFit& fit,
                                                         const ContactFitOptions& options) {
  const Values middle = evaluate(o, fit.value, options);
  std::vector<DeltaMethod> sums(middle.begin(), middle.end());
  const auto add = [&sums](const Values& above, const Values& below) {
    for (std::size_t i = 0; i < kQuantities; ++i) sums[i].add(above[i], below[i]);
  };
  for (int input = 0; input < kInputs; ++input)
    add(evaluate(moved(o, input, 1.0), fit.value, options),
        evaluate(moved(o, input, -1.0), fit.value, options));
  // Columns of the covariance's Cholesky factor.
  const ContactMatrix factor = Eigen::MatrixXd(fit.covariance).llt().matrixL();
  for (int i = 0; i < kFitParameters; ++i) {
    const auto at = [&](double sign) { return within_bounds(fit.value + sign * factor.col(i)); };
    add(evaluate(o, at(1.0), options), evaluate(o, at(-1.0), options));
  }
  std::array<std::optional<ValueSd>, kQuantities> out;
  for (std::size_t i = 0; i < kQuantities; ++i) out[i] = sums[i].result();
  return out;
}

/// With the published sd of the six velocities and the fitted alpha's.
ValueSd measured_loss(const Observation& o, const ContactFit& fit) {
  const ball::Ball ball = ball_of(fit.value);
  const double m = ball.mass_kg;
  double variance = 0.0;
  const auto add = [&](const Motion& v, const Motion& sd) {
    for (const double term : {m * v.vx_mps * sd.vx_mps, m * v.vy_mps * sd.vy_mps,
                              ball.inertia_kgm2() * v.omega_radps * sd.omega_radps})
      variance += term * term;
  };
  add(o.touchdown, o.touchdown_sd);
  add(o.lift_off, o.lift_off_sd);
  const double by_alpha =
      0.5 * m * ball.radius_m() * ball.radius_m() *
      (o.touchdown.omega_radps * o.touchdown.omega_radps - o.lift_off.omega_radps * o.lift_off.omega_radps) *
      fit.sd(kFitAlpha);
  return {kinetic_j(ball, o.touchdown) - kinetic_j(ball, o.lift_off),
          std::sqrt(variance + by_alpha * by_alpha)};
}

}  // namespace

Result<SkidAndEnergy> skid_and_energy(std::span<const Observation> observations, const ContactFit& fit,
                                      const ContactFitOptions& options) {
  SkidAndEnergy out;
  for (const Observation& o : observations) {
    const auto computed =
        simulate(ball_of(fit.value), o.touchdown, coefficients_of(o, fit.value, options), options.contact());
    if (!computed) return fail(o.name + ": " + std::string(message(computed.error())));
    const auto values = with_sds(o, fit, options);
    const double radius = ball_of(fit.value).radius_m();
    out.skid_to_grip.push_back(
        {.name = o.name,
         .regime = computed->regime,
         .dwell_s = *values[kDwell],
         .grip_s = values[kGrip],
         .slip_zero_s = values[kSlipZero],
         .by_impulse_s = values[kByImpulse],
         .slip_lo_mps = computed->slip_lo_mps,
         .measured_slip_lo_mps = {o.lift_off.vx_mps + radius * o.lift_off.omega_radps,
                                  std::hypot(o.lift_off_sd.vx_mps, radius * o.lift_off_sd.omega_radps)},
         .friction_reversals = computed->friction_reversals});
    out.energy.push_back({.name = o.name,
                          .touchdown_j = *values[kTouchdown],
                          .measured_loss_j = measured_loss(o, fit),
                          .computed_loss_j = *values[kLoss],
                          .normal_damping_j = *values[kNormal],
                          .sliding_j = *values[kSliding],
                          .tangential_j = *values[kTangential],
                          .offset_j = *values[kOffset]});
  }
  return out;
}

}  // namespace strobe::impact
