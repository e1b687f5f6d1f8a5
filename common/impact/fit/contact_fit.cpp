#include "common/impact/fit/contact_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <set>

#include "common/impact/fit/bounded_least_squares.hpp"
#include "common/impact/ode/normal_spring.hpp"

namespace strobe::impact {

namespace {

/// Near the published fit of this mechanics (mu .555, k_t/k 1.39, c_t .75, offset .098, alpha .55).
const ContactVector kStart{0.55, 1.4, 0.7, 0.1, 0.55};
const ContactVector kLowerBounds{0.0, 1e-2, 0.01, 0.0, 0.1};
const ContactVector kUpperBounds{10.0, 1e2, 10.0, 1.0, ball::kThinShellAlpha};

/// Limited by the accuracy of the finite differences.
constexpr double kContactRankTolerance = 1e-6;

Error refused(const Observation& o, InputError error) {
  return Error{o.name + ": " + std::string(message(error))};
}

tl::expected<ContactSummary, InputError> compute(const Observation& o, const ContactVector& p,
                                                 const ContactFitOptions& options) {
  return simulate(ball_of(p), o.touchdown, coefficients_of(o, p, options), options.contact());
}

Result<Eigen::VectorXd> residuals(std::span<const Observation> observations, const ContactVector& p,
                                  const ContactFitOptions& options) {
  Eigen::VectorXd r(2 * static_cast<Eigen::Index>(observations.size()));
  Eigen::Index row = 0;
  for (const Observation& o : observations) {
    const auto computed =
        lift_off(ball_of(p), o.touchdown, coefficients_of(o, p, options), options.contact());
    if (!computed) return tl::unexpected(refused(o, computed.error()));
    r[row++] = (computed->lift_off.vx_mps - o.lift_off.vx_mps) / options.vx_sd_mps;
    r[row++] = (computed->lift_off.omega_radps - o.lift_off.omega_radps) / options.omega_sd_radps;
  }
  return r;
}

/// A contact is accurate to about 1e-9, not to rounding: wider differences, and a tolerance above its
/// noise.
LeastSquaresProblem problem_of(std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals) {
  return {.residuals = std::move(residuals),
          .lower = kLowerBounds,
          .upper = kUpperBounds,
          .scale = ContactVector::Constant(0.01),
          .difference_step = 1e-4,
          .function_tolerance = 1e-10};
}

struct Optimum {
  ContactVector value;
  double chi_square;
  Eigen::MatrixXd jacobian;
  int iterations;
};

Result<Optimum> optimum(std::span<const Observation> observations, const ContactFitOptions& options) {
  std::optional<Error> refusal;
  const LeastSquaresProblem problem = problem_of([&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    auto r = residuals(observations, at, options);
    if (r) return *std::move(r);
    if (!refusal) refusal = r.error();
    return Eigen::VectorXd::Constant(2 * static_cast<Eigen::Index>(observations.size()),
                                     std::numeric_limits<double>::infinity());
  });
  if (problem.residuals(kStart); refusal) return tl::unexpected(*refusal);
  const LeastSquaresResult found = levenberg_marquardt(problem, kStart);
  Eigen::MatrixXd at_minimum = jacobian(problem, found.parameters);
  if (refusal) return tl::unexpected(*refusal);
  if (!converged(found.termination)) return fail("the contact's fit does not converge");
  return Optimum{found.parameters, found.sum_of_squares, std::move(at_minimum), found.iterations};
}

Result<std::vector<ContactFitPoint>> compare_all(std::span<const Observation> observations,
                                                 const ContactVector& p, const ContactFitOptions& options) {
  std::vector<ContactFitPoint> points;
  for (const Observation& o : observations) {
    const auto computed = compute(o, p, options);
    if (!computed) return tl::unexpected(refused(o, computed.error()));
    const auto spring = normal_spring(ball_of(p).mass_kg, o.e, o.dwell_s);
    if (!spring) return tl::unexpected(refused(o, spring.error()));
    points.push_back({.name = o.name,
                      .computed = *computed,
                      .stiffness_npm = spring->stiffness_npm,
                      .damping_ratio = spring->damping_ratio,
                      .vx_residual_mps = computed->lift_off.vx_mps - o.lift_off.vx_mps,
                      .omega_residual_radps = computed->lift_off.omega_radps - o.lift_off.omega_radps});
  }
  return points;
}

struct Rms {
  double vx;
  double omega;
};

Rms rms_of(std::span<const ContactFitPoint> points) {
  Rms sum{0.0, 0.0};
  for (const ContactFitPoint& point : points) {
    sum.vx += point.vx_residual_mps * point.vx_residual_mps;
    sum.omega += point.omega_residual_radps * point.omega_residual_radps;
  }
  const auto n = static_cast<double>(std::max<std::size_t>(points.size(), 1));
  return {std::sqrt(sum.vx / n), std::sqrt(sum.omega / n)};
}

}  // namespace

Observation observation_of(const thesis::Condition& c) {
  Observation o = observations_of({&c, 1}, Spread::replicate).front();
  o.e = -o.lift_off.vy_mps / o.touchdown.vy_mps;
  return o;
}

ContactVector within_bounds(const ContactVector& parameters) {
  return parameters.cwiseMax(kLowerBounds).cwiseMin(kUpperBounds);
}

double ContactFit::sd(ContactParameter parameter) const {
  return std::sqrt(covariance(parameter, parameter));
}

ContactCoefficients coefficients_of(const Observation& o, const ContactVector& p,
                                    const ContactFitOptions& options) {
  return {.e = o.e,
          .dwell_s = o.dwell_s,
          .mu = p[kFitMu],
          .stiffness_ratio = p[kFitStiffness],
          .damping_ratio = p[kFitDamping],
          .offset_share = p[kFitOffset],
          .offset_reference_mps = options.offset_reference_mps,
          .offset_law = options.law};
}

ball::Ball ball_of(const ContactVector& p) { return {.alpha = p[kFitAlpha]}; }

Result<ContactFit> fit_contact(std::span<const Observation> observations, const ContactFitOptions& options) {
  if (observations.size() < 3) return fail("a fit of the contact needs three conditions or more");
  const auto best = optimum(observations, options);
  if (!best) return tl::unexpected(best.error());
  const auto inverse = unscaled_covariance(best->jacobian, kContactRankTolerance);
  if (!inverse) return fail("the conditions do not determine the contact's parameters");
  auto points = compare_all(observations, best->value, options);
  if (!points) return tl::unexpected(points.error());
  ContactFit fit;
  fit.value = best->value;
  fit.chi_square = best->chi_square;
  fit.degrees_of_freedom = static_cast<int>(best->jacobian.rows()) - kFitParameters;
  fit.covariance = fit.chi_square / fit.degrees_of_freedom * *inverse;
  assert(Eigen::MatrixXd(fit.covariance).llt().info() == Eigen::Success);
  fit.coefficients = coefficients_of(observations.front(), best->value, options);
  fit.iterations = best->iterations;
  fit.points = std::move(*points);
  const Rms rms = rms_of(fit.points);
  fit.vx_rms_mps = rms.vx;
  fit.omega_rms_radps = rms.omega;
  return fit;
}

Result<std::vector<ContactHeldOutGroup>> leave_one_group_out(std::span<const Observation> observations,
                                                             const ContactFitOptions& options) {
  std::set<std::string> groups;
  for (const Observation& o : observations) groups.insert(o.spin);
  std::vector<ContactHeldOutGroup> out;
  for (const std::string& group : groups) {
    std::vector<Observation> kept;
    std::vector<Observation> left;
    for (const Observation& o : observations) (o.spin == group ? left : kept).push_back(o);
    const auto fit = fit_contact(kept, options);
    if (!fit) return tl::unexpected(fit.error());
    const auto points = compare_all(left, fit->value, options);
    if (!points) return tl::unexpected(points.error());
    const Rms rms = rms_of(*points);
    out.push_back({group, fit->value, rms.vx, rms.omega});
  }
  return out;
}

}  // namespace strobe::impact
