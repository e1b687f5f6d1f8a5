// The contact mechanics fitted with a posterior: does it find what made the data, does it hold what it says, and does it say
// what it cannot know?
#include <cmath>
#include <string>
#include <vector>

#include "common/impact/fit/rebound_model.hpp"
#include "common/impact/fit/model_fit.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "tests/common/impact_fit/check.hpp"
#include "tests/common/impact_fit/sessions.hpp"
#include "tests/common/impact_fit/shot_sessions.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;
using namespace strobe::testing;

namespace {

constexpr Parameter kCoefficients[] = {Parameter::mu,
                                       Parameter::offset_reference_mps,
                                       Parameter::alpha,
                                       Parameter::stiffness_ratio,
                                       Parameter::damping_ratio,
                                       Parameter::offset_share};

const ContactCoefficients kMade{.mu = 0.5,
                                .stiffness_ratio = 1.2,
                                .damping_ratio = 0.6,
                                .offset_share = 0.12,
                                .offset_reference_mps = 4.0};
constexpr double kMadeAlpha = 0.56;

double made(Parameter p) {
  switch (p) {
    case Parameter::mu:
      return kMade.mu;
    case Parameter::offset_reference_mps:
      return kMade.offset_reference_mps;
    case Parameter::alpha:
      return kMadeAlpha;
    case Parameter::stiffness_ratio:
      return kMade.stiffness_ratio;
    case Parameter::damping_ratio:
      return kMade.damping_ratio;
    default:
      return kMade.offset_share;
  }
}

/// The ball leaves the surface before its centre is one radius above it, which is where the dwell time ends.
double until_release_s(double dwell_s, double e) {
  const NormalSpring unit = normal_spring(1.0, e, 1.0).value();
  return dwell_s / (1.0 + 2.0 * unit.damping_ratio / unit.frequency_radps);
}

/// The thesis's touchdowns with the lift-off that the integrator gives, and noise of these sds, stated.
std::vector<Observation> integrated(double vx_sd_mps, double omega_sd_radps, int times,
                                    std::mt19937_64& source) {
  std::normal_distribution<double> normal;
  std::vector<Observation> out;
  for (int i = 0; i < times; ++i) {
    for (Observation o : conditions()) {
      ContactCoefficients c = kMade;
      c.e = o.e;
      c.dwell_s = until_release_s(o.dwell_s, o.e);
      const auto contact = simulate({.alpha = kMadeAlpha}, o.touchdown, c, {.tolerance = 1e-10});
      o.lift_off = contact.value().lift_off;
      o.lift_off.vx_mps += vx_sd_mps * normal(source);
      o.lift_off.omega_radps += omega_sd_radps * normal(source);
      o.touchdown_sd = {};
      o.lift_off_sd = {vx_sd_mps, 0.0, omega_sd_radps};
      o.e_sd = o.dwell_sd_s = 0.0;
      o.series += std::to_string(i);
      out.push_back(o);
    }
  }
  return out;
}

FitOptions ode_options(PosteriorMethod method = PosteriorMethod::automatic) {
  FitOptions out = default_options(ReboundModel::ode);
  out.posterior.method = method;
  return out;
}

const FittedParameter& of(const ModelFit& fit, Parameter p) { return fit.parameters[index(p)]; }

std::size_t place(const ModelFit& fit, Parameter p) {
  const auto& all = fit.posterior->parameters;
  return static_cast<std::size_t>(std::find(all.begin(), all.end(), p) - all.begin());
}

}  // namespace

TEST_GROUP(ContactModelFit){};

// The defaults are the least of the same mechanics with vx and omega over .38 m/s and 11.5 rad/s, e by the means of vy and
// u0 at 6 m/s; here 1 m/s of R·omega weighs like 1 m/s of vx, which is 2 % more. Chi squared: 42.2·.38².
TEST(ContactModelFit, TheThesissConditionsGiveTheMechanicsDefaults) {
  const auto fit = impact::fit(conditions(), ode_options());
  CHECK_TRUE(fit.has_value());
  const ContactCoefficients shipped;
  const std::pair<Parameter, double> defaults[] = {
      {Parameter::mu, shipped.mu},
      {Parameter::offset_reference_mps, shipped.offset_reference_mps},
      {Parameter::alpha, kContactAlpha},
      {Parameter::stiffness_ratio, shipped.stiffness_ratio},
      {Parameter::damping_ratio, shipped.damping_ratio},
      {Parameter::offset_share, shipped.offset_share}};
  for (const auto& [p, value] : defaults) {
    DOUBLES_EQUAL(value, of(*fit, p).value, 0.25 * *of(*fit, p).sd);
    CHECK(*of(*fit, p).lower < value && value < *of(*fit, p).upper);
  }
  DOUBLES_EQUAL(42.2 * 0.38 * 0.38, fit->chi2, 0.1);
  CHECK_TRUE(fit->posterior->reliable);
  const auto tied =
      fit->posterior->correlation(static_cast<Eigen::Index>(place(*fit, Parameter::offset_reference_mps)),
                                  static_cast<Eigen::Index>(place(*fit, Parameter::offset_share)));
  CHECK_COMPARE(tied, >, 0.8);
}

// The collocation's error of 1e-7 and the priors, against residuals that are zero but for it.
TEST(ContactModelFit, CoefficientsThatMadeTheDataAreFoundAgain) {
  std::mt19937_64 source(1);
  FitOptions options = ode_options(PosteriorMethod::laplace);
  const auto fit = impact::fit(integrated(0.0, 0.0, 1, source), options);
  for (const Parameter p : kCoefficients) DOUBLES_EQUAL(made(p), of(*fit, p).value, 1e-3 * made(p));
}

// A fifth of a single shot's sds: nearly normal. Ends of intervals by two samplers that share nothing but the density, each
// good to a tenth of an sd (kEnoughDraws), and the Laplace approximation's.
TEST(ContactModelFit, ImportanceAndMetropolisAgree) {
  std::mt19937_64 source(2);
  const auto shots = integrated(0.08, 2.5, 1, source);
  FitOptions options = ode_options(PosteriorMethod::importance);
  const auto importance = impact::fit(shots, options);
  options.posterior = {.method = PosteriorMethod::metropolis, .draws = testing::repetitions(4000)};
  const auto metropolis = impact::fit(shots, options);
  CHECK_TRUE(importance->posterior->reliable);
  for (const Parameter p : kCoefficients) {
    const double sd = *of(*importance, p).sd;
    DOUBLES_EQUAL(*of(*importance, p).lower, *of(*metropolis, p).lower, testing::widened(0.45) * sd);
    DOUBLES_EQUAL(*of(*importance, p).upper, *of(*metropolis, p).upper, testing::widened(0.45) * sd);
    DOUBLES_EQUAL(sd, *of(*metropolis, p).sd, testing::widened(0.2) * sd);
  }
}

TEST(ContactModelFit, ASeedGivesTheSameNumbers) {
  const auto one = impact::fit(conditions(), ode_options()), two = impact::fit(conditions(), ode_options());
  FitOptions other = ode_options();
  other.posterior.seed = 2;
  const auto three = impact::fit(conditions(), other);
  for (const Parameter p : kCoefficients) {
    DOUBLES_EQUAL(*of(*one, p).upper, *of(*two, p).upper, 0.0);
    CHECK(*of(*one, p).upper != *of(*three, p).upper);
    DOUBLES_EQUAL(of(*one, p).value, of(*three, p).value, 0.0);
  }
}

// 60 intervals of 10 sessions; those of one session are not independent: as if it were half as many. Four sd of the share
// that misses, 5 %.
TEST(ContactModelFit, IntervalsHoldTheTruthOfShotsByTheSimulator) {
  const auto scenes = scenes_of_conditions();
  CHECK_TRUE(scenes.has_value());
  const int sessions = testing::repetitions(10);
  Coverage coverage;
  for (int i = 0; i < sessions; ++i) {
    const auto session = shoot_session(*scenes, 2, 1000 + static_cast<std::uint64_t>(i));
    const auto fit = impact::fit(session->shots, session->options);
    CHECK_TRUE(fit.has_value());
    for (const Parameter p : kCoefficients) coverage.add(of(*fit, p), session->truth[index(p)]);
  }
  std::printf("%d of %d; ", coverage.held, coverage.intervals);
  const double least = 0.95 - 4.0 * std::sqrt(0.05 * 0.95 / (0.5 * coverage.intervals));
  CHECK_COMPARE(static_cast<double>(coverage.held) / coverage.intervals, >=, least);
}

TEST(ContactModelFit, ADwellTimeThatWasNotMeasuredIsNotTold) {
  std::mt19937_64 source(3);
  auto shots = integrated(0.2, 6.0, 2, source);
  for (Observation& o : shots) o.dwell_s = 0.0;
  const auto fit = impact::fit(shots, ode_options());
  CHECK_TRUE(of(*fit, Parameter::dwell_s).status == ParameterStatus::undetermined);
  CHECK_COMPARE(fit->posterior->prior_shares[place(*fit, Parameter::dwell_s)], >, kUntoldShare);
  CHECK_COMPARE(*of(*fit, Parameter::dwell_s).lower, <, 4e-3);
  CHECK_COMPARE(*of(*fit, Parameter::dwell_s).upper, >, 6e-3);
  // With their own dwell times nothing depends on it.
  const auto with = impact::fit(integrated(0.2, 6.0, 2, source), ode_options(PosteriorMethod::laplace));
  CHECK_TRUE(of(*with, Parameter::dwell_s).status == ParameterStatus::fixed);
}

// Steep shots without spin all grip: any more friction gives the same.
TEST(ContactModelFit, FrictionThatNoShotReachesIsLeftToThePrior) {
  std::mt19937_64 source(4);
  auto shots = integrated(0.2, 6.0, 4, source);
  std::erase_if(shots, [](const Observation& o) {
    return o.spin != "zero" || o.touchdown.vx_mps > -0.8 * o.touchdown.vy_mps;
  });
  CHECK_COMPARE(shots.size(), >=, 8U);
  const auto fit = impact::fit(shots, ode_options(PosteriorMethod::importance));
  const FittedParameter& mu = of(*fit, Parameter::mu);
  CHECK_COMPARE(*mu.upper, >, 1.0);
  CHECK_COMPARE(fit->posterior->prior_shares[place(*fit, Parameter::mu)], >, 0.5);
}

TEST(ContactModelFit, AFixedCoefficientIsKeptAndTheOthersFollow) {
  FitOptions options = ode_options(PosteriorMethod::laplace);
  options.free[index(Parameter::offset_reference_mps)] = false;
  options.start[index(Parameter::offset_reference_mps)] = 20.0;
  const auto fit = impact::fit(conditions(), options);
  DOUBLES_EQUAL(20.0, of(*fit, Parameter::offset_reference_mps).value, 0.0);
  CHECK_TRUE(of(*fit, Parameter::offset_reference_mps).status == ParameterStatus::fixed);
  CHECK_COMPARE(of(*fit, Parameter::offset_share).value, >, 0.25);
}

TEST(ContactModelFit, LeavesConditionsOutInTurn) {
  const auto left_out = leave_one_group_out(conditions(), ode_options(), CrossValidationGroup::spin);
  LONGS_EQUAL(3, left_out->groups.size());
  LONGS_EQUAL(21, left_out->statistics.count);
  // One shot's sds are .38 m/s and 11.5 rad/s, and the predicted spin is of its own kind.
  CHECK_COMPARE(left_out->statistics.rms_vx_mps, <, 1.5 * 0.38);
  CHECK_COMPARE(left_out->statistics.rms_omega_radps, <, 1.7 * 11.5);
}

TEST(ContactModelFit, DerivativesAreThoseOfTheIntegrator) {
  const std::array<bool, kParameterCount> all{true, false, false, true, true, true, true, true, true};
  const ParameterValues at = default_values(ReboundModel::ode);
  for (const Observation& o : conditions()) {
    ModelInputs in = inputs_of(o);
    in.dwell_s = 0.0;
    const auto gradient = contact_gradient(at, ball::kThesisDiameter_m, in);
    for (std::size_t i = 0; i < kParameterCount; ++i) {
      if (!all[i]) continue;
      const auto moved = [&](double factor) {
        ParameterValues p = at;
        p[i] *= factor;
        const ContactCoefficients c{.e = o.e,
                                    .dwell_s = until_release_s(p[index(Parameter::dwell_s)], o.e),
                                    .mu = p[index(Parameter::mu)],
                                    .stiffness_ratio = p[index(Parameter::stiffness_ratio)],
                                    .damping_ratio = p[index(Parameter::damping_ratio)],
                                    .offset_share = p[index(Parameter::offset_share)],
                                    .offset_reference_mps = p[index(Parameter::offset_reference_mps)]};
        return simulate({.alpha = p[index(Parameter::alpha)]}, o.touchdown, c, {.tolerance = 1e-12})
            ->lift_off;
      };
      // Fourth order: errors of 1e-12·h^-1 and h⁴.
      constexpr double h = 1e-3;
      const Motion a = moved(1.0 - 2.0 * h), b = moved(1.0 - h), c = moved(1.0 + h), d = moved(1.0 + 2.0 * h);
      const double vx = (a.vx_mps - 8.0 * b.vx_mps + 8.0 * c.vx_mps - d.vx_mps) / (12.0 * h);
      const double omega =
          (a.omega_radps - 8.0 * b.omega_radps + 8.0 * c.omega_radps - d.omega_radps) / (12.0 * h);
      // Per unit of the parameter times its size; 1e-3 m/s moves nothing that a fit can see.
      DOUBLES_EQUAL(vx, gradient->vx[i] * at[i], 1e-3);
      DOUBLES_EQUAL(omega * ball::kThesisDiameter_m / 2.0, gradient->spin[i] * at[i], 1e-3);
    }
  }
}

TEST_GROUP(CoefficientPrior){};

TEST(CoefficientPrior, CoordinatesAndValuesAreInverse) {
  for (const Parameter p : kCoefficients) {
    const Prior prior = *prior_of(ReboundModel::ode, p);
    for (const double sds : {-3.0, -0.5, 0.0, 2.0}) {
      const double value = value_at(ReboundModel::ode, p, prior.mean + sds * prior.sd);
      DOUBLES_EQUAL(prior_value(p, sds), value, 1e-12 * value);
      DOUBLES_EQUAL(prior.mean + sds * prior.sd, coordinate_of(ReboundModel::ode, p, value), 1e-9);
      constexpr double h = 1e-5;
      const double at = prior.mean + sds * prior.sd;
      const double slope =
          (value_at(ReboundModel::ode, p, at + h) - value_at(ReboundModel::ode, p, at - h)) / (2.0 * h);
      DOUBLES_EQUAL(slope, slope_at(ReboundModel::ode, p, at), 1e-8);
    }
  }
}

TEST(CoefficientPrior, IsAsDocumented) {
  DOUBLES_EQUAL(0.127, prior_value(Parameter::mu, -1.96), 0.0005);
  DOUBLES_EQUAL(1.97, prior_value(Parameter::mu, 1.96), 0.005);
  DOUBLES_EQUAL(0.416, prior_value(Parameter::alpha, -1.96), 0.001);
  DOUBLES_EQUAL(0.656, prior_value(Parameter::alpha, 1.96), 0.001);
  DOUBLES_EQUAL(4.7e-3, prior_value(Parameter::dwell_s, 0.0), 1e-9);
  CHECK_FALSE(prior_of(ReboundModel::grip_offset, Parameter::mu).has_value());
  DOUBLES_EQUAL(0.3, coordinate_of(ReboundModel::grip, Parameter::mu, 0.3), 0.0);
}
