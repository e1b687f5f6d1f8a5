#include "tests/studies/thesis/prediction.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/impact/fit/bounded_least_squares.hpp"

namespace strobe::studies {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using impact::ContactVector;
using impact::Observation;

constexpr double kReferences_mps[] = {2.5, 4.0, 6.0, 10.0, 20.0, 50.0};
constexpr double kVxSd_mps = 0.38;
constexpr double kOmegaSd_radps = 11.5;

double slope_of_slip(const Observation& o) {
  const double slip = o.touchdown.vx_mps + 0.5 * ball::kThesisDiameter_m * o.touchdown.omega_radps;
  return slip / -o.touchdown.vy_mps;
}

impact::ContactFitOptions options_of(double reference_mps) {
  return {.offset_reference_mps = reference_mps, .vx_sd_mps = kVxSd_mps, .omega_sd_radps = kOmegaSd_radps};
}

/// c_t/sqrt(k_t·m) of a damping ratio 1/2 of the contact point's own oscillation.
double tied_dashpot(double alpha) { return 2.0 * kTiedDamping * std::sqrt(alpha / (1.0 + alpha)); }

/// mu, k_t/k, the offset's share and alpha; the dashpot follows.
ContactVector spread_out(const VectorXd& four) {
  return {four[0], four[1], tied_dashpot(four[3]), four[2], four[3]};
}

struct Fitted {
  ContactVector value;
  double chi_square = 0.0;
};

VectorXd residuals(std::span<const Observation> kept, const ContactVector& value,
                   const impact::ContactFitOptions& options) {
  VectorXd r =
      VectorXd::Constant(2 * static_cast<Eigen::Index>(kept.size()), std::numeric_limits<double>::infinity());
  Eigen::Index row = 0;
  for (const Observation& o : kept) {
    const auto s =
        impact::simulate(impact::ball_of(value), o.touchdown, impact::coefficients_of(o, value, options));
    if (!s) return r;
    r[row++] = (s->lift_off.vx_mps - o.lift_off.vx_mps) / options.vx_sd_mps;
    r[row++] = (s->lift_off.omega_radps - o.lift_off.omega_radps) / options.omega_sd_radps;
  }
  return r;
}

Result<Fitted> fit_tied(std::span<const Observation> kept, const impact::ContactFitOptions& options) {
  const impact::LeastSquaresProblem problem{
      .residuals = [&](const VectorXd& four) { return residuals(kept, spread_out(four), options); },
      .lower = Eigen::Vector4d(0.0, 1e-2, 0.0, 0.1),
      .upper = Eigen::Vector4d(10.0, 1e2, 1.0, ball::kThinShellAlpha),
      .scale = Eigen::Vector4d::Constant(0.01),
      .difference_step = 1e-4,
      .function_tolerance = 1e-10};
  const impact::LeastSquaresResult found =
      impact::levenberg_marquardt(problem, Eigen::Vector4d(0.55, 1.4, 0.1, 0.55));
  if (!converged(found.termination) || !std::isfinite(found.sum_of_squares))
    return fail("the fit of two spins does not converge");
  return Fitted{spread_out(found.parameters), found.sum_of_squares};
}

Result<Fitted> fit(std::span<const Observation> kept, Dashpot dashpot, double reference_mps) {
  if (dashpot == Dashpot::tied) return fit_tied(kept, options_of(reference_mps));
  const auto all = impact::fit_contact(kept, options_of(reference_mps));
  if (!all) return tl::unexpected(all.error());
  return Fitted{all->value, all->chi_square};
}

/// Ordinary least squares of the observations' e and ln(dwell time).
void regress(std::span<const Observation> kept, bool with_slip, Constants& constants) {
  const auto n = static_cast<Eigen::Index>(kept.size());
  MatrixXd speed(n, with_slip ? 3 : 2), logs(n, 2);
  VectorXd e(n), dwell(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Observation& o = kept[static_cast<std::size_t>(i)];
    speed(i, 0) = logs(i, 0) = 1.0;
    speed(i, 1) = -o.touchdown.vy_mps;
    logs(i, 1) = std::log(-o.touchdown.vy_mps);
    if (with_slip) speed(i, 2) = slope_of_slip(o);
    e[i] = o.e;
    dwell[i] = std::log(o.dwell_s);
  }
  const VectorXd by = speed.colPivHouseholderQr().solve(e);
  const VectorXd power = logs.colPivHouseholderQr().solve(dwell);
  for (Eigen::Index i = 0; i < by.size(); ++i) constants.e_by[static_cast<std::size_t>(i)] = by[i];
  constants.dwell_by = {power[0], power[1]};
}

Observation with_vertical(Observation o, const Constants& constants, Vertical vertical) {
  if (vertical == Vertical::measured) return o;
  const double speed = -o.touchdown.vy_mps;
  o.e = std::clamp(constants.e_by[0] + constants.e_by[1] * speed + constants.e_by[2] * slope_of_slip(o), 0.01,
                   1.0);
  o.dwell_s = std::exp(constants.dwell_by[0] + constants.dwell_by[1] * std::log(speed));
  return o;
}

}  // namespace

Result<Constants> constants_without(std::string_view spin, std::span<const Observation> observations,
                                    Vertical vertical, Dashpot dashpot) {
  std::vector<Observation> kept;
  for (const Observation& o : observations)
    if (o.spin != spin) kept.push_back(o);
  Constants out;
  out.left_out = spin;
  out.chi_square = std::numeric_limits<double>::infinity();
  for (const double reference_mps : kReferences_mps) {
    const auto fitted = fit(kept, dashpot, reference_mps);
    if (!fitted) return tl::unexpected(fitted.error());
    if (fitted->chi_square >= out.chi_square) continue;
    out.value = fitted->value;
    out.chi_square = fitted->chi_square;
    out.offset_reference_mps = reference_mps;
  }
  regress(kept, vertical == Vertical::by_speed_and_slip, out);
  return out;
}

Result<Prediction> predict(const Observation& observation, const Constants& constants, Vertical vertical) {
  Prediction out;
  out.inputs = with_vertical(observation, constants, vertical);
  out.coefficients =
      impact::coefficients_of(out.inputs, constants.value, options_of(constants.offset_reference_mps));
  out.ball = impact::ball_of(constants.value);
  const auto contact = impact::simulate(out.ball, out.inputs.touchdown, out.coefficients);
  if (!contact) return fail(observation.name + ": " + std::string(impact::message(contact.error())));
  out.contact = *contact;
  return out;
}

InputSpread input_spread(const Observation& observation, const Constants& constants, Vertical vertical) {
  double vx = 0.0, omega = 0.0;
  const auto add = [&](auto move) {
    std::array<impact::Motion, 2> ends{};
    for (const int side : {0, 1}) {
      Observation o = observation;
      move(o, side == 0 ? -1.0 : 1.0);
      const auto predicted = predict(o, constants, vertical);
      if (!predicted) return;
      ends[static_cast<std::size_t>(side)] = predicted->contact.lift_off;
    }
    vx += std::pow(0.5 * (ends[1].vx_mps - ends[0].vx_mps), 2);
    omega += std::pow(0.5 * (ends[1].omega_radps - ends[0].omega_radps), 2);
  };
  add([](Observation& o, double side) { o.touchdown.vx_mps += side * o.touchdown_sd.vx_mps; });
  add([](Observation& o, double side) { o.touchdown.vy_mps += side * o.touchdown_sd.vy_mps; });
  add([](Observation& o, double side) { o.touchdown.omega_radps += side * o.touchdown_sd.omega_radps; });
  if (vertical == Vertical::measured) {
    add([](Observation& o, double side) {
      o.e = std::min(1.0, o.e - side * o.lift_off_sd.vy_mps / o.touchdown.vy_mps);
    });
    add([](Observation& o, double side) { o.dwell_s += side * o.dwell_sd_s; });
  }
  return {std::sqrt(vx), std::sqrt(omega)};
}

}  // namespace strobe::studies
