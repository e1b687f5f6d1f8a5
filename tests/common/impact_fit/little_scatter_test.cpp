// What one measurement cannot tell: copies of it, near copies, and many of one condition. No sd may be less than
// the stated noise allows, and no model may tell more combinations of parameters than the observations do.
#include <cmath>
#include <string>
#include <vector>

#include "common/impact/fit/model_fit.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "tests/common/impact_fit/check.hpp"
#include "tests/support/property.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;
using namespace strobe::testing;

namespace {

constexpr double kMu = 0.4;
constexpr double kAlpha = ball::kThinShellAlpha;
constexpr double kRadius_m = 0.5 * ball::kThesisDiameter_m;

/// Slides throughout: the slip of 15 m/s or more is twice what mu·J·(1 + 1/alpha) = 0.4·1.8·8·2.5 takes, and less.
Observation sliding(double vx_mps, double vy_mps) {
  Observation o;
  o.touchdown = {vx_mps, vy_mps, 0.0};
  o.e = 0.8;
  const double impulse = 1.8 * -vy_mps;
  o.lift_off = {vx_mps - kMu * impulse, -0.8 * vy_mps, -kMu * impulse / (kAlpha * kRadius_m)};
  o.lift_off_sd = {0.1, 0.0, 3.0};
  return o;
}

/// Of the lift-off's vx and spin alone, both linear in mu, the touchdown being known.
double information_on_mu(const Observation& o) {
  const double impulse = (1.0 + o.e) * -o.touchdown.vy_mps;
  return std::pow(impulse / o.lift_off_sd.vx_mps, 2) +
         std::pow(impulse / (kAlpha * kRadius_m * o.lift_off_sd.omega_radps), 2);
}

double sd_of_mu(const std::vector<Observation>& observations) {
  double sum = 0.0;
  for (const Observation& o : observations) sum += information_on_mu(o);
  return 1.0 / std::sqrt(sum);
}

FitOptions mu_alone() {
  FitOptions out = default_options(ReboundModel::slide_roll);
  out.weighting = Weighting::stated_sd;
  return out;
}

const FittedParameter& mu_of(const ModelFit& fit) { return fit.parameters[index(Parameter::mu)]; }

void move_lift_off(Observation& o, double sds, std::mt19937_64& source) {
  std::normal_distribution<double> normal;
  o.lift_off.vx_mps += sds * o.lift_off_sd.vx_mps * normal(source);
  o.lift_off.omega_radps += sds * o.lift_off_sd.omega_radps * normal(source);
}

}  // namespace

TEST_GROUP(LittleScatter){};

TEST(LittleScatter, OfCopiesTheFirstIsKeptWithTheLargestSds) {
  std::vector<Observation> all(6, sliding(20.0, -8.0));
  all[0].name = "a";
  all[1] = sliding(21.0, -8.0);
  all[1].name = "b";
  all[2].e_sd = 0.02;
  all[3].lift_off_sd = {0.05, 0.0, 4.0};
  all[3].lift_off.vy_mps = 3.0;  // of no model: e is given
  all[4].dwell_s = 5e-3;
  all[4].series = "another";
  all[5].touchdown.vx_mps = std::nextafter(20.0, 30.0);
  const auto lines = leave_copies_out(all);
  LONGS_EQUAL(3, all.size());
  LONGS_EQUAL(1, lines.size());
  CHECK_EQUAL("a: 4 with the same numbers, which count as one", lines[0]);
  CHECK_EQUAL("a", all[0].name);
  CHECK_EQUAL("b", all[1].name);
  DOUBLES_EQUAL(0.1, all[0].lift_off_sd.vx_mps, 0.0);
  DOUBLES_EQUAL(4.0, all[0].lift_off_sd.omega_radps, 0.0);
  DOUBLES_EQUAL(0.02, all[0].e_sd, 0.0);
}

// Without noise, and with 1e-4 of what is stated, which one degree of freedom has by chance once in ten thousand.
// Tolerance: the touchdowns are known, so that the sd is linear but for the noise moving mu by 1e-4 of its sd.
TEST(LittleScatter, ObservationsThatAgreeTooWellHaveTheSdThatTheirNoiseAllows) {
  auto source = random_source("agree");
  for (const double noise : {0.0, 1e-8, 1e-4}) {
    for (const int count : {1, 2, 3, 5, 20}) {
      for (const CovarianceScale scale : {CovarianceScale::clustered, CovarianceScale::residuals}) {
        std::vector<Observation> shots(static_cast<std::size_t>(count), sliding(20.0, -8.0));
        for (Observation& o : shots) move_lift_off(o, noise, source);
        FitOptions options = mu_alone();
        options.scale = scale;
        const auto fitted = fit(shots, options);
        CHECK(fitted.has_value());
        DOUBLES_EQUAL(sd_of_mu(shots), *mu_of(*fitted).sd, 1e-3 * sd_of_mu(shots));
        CHECK_TRUE(fitted->covariance_scale == CovarianceScale::stated);
      }
    }
  }
}

// Of 200 sessions with the noise that is stated 4 in the mean scatter less than once in fifty, sd 2: four of these.
TEST(LittleScatter, HonestNoiseIsSeldomTakenForTooLittle) {
  auto source = random_source("honest");
  for (const int count : {2, 6}) {
    int by_stated = 0;
    for (int i = 0; i < 200; ++i) {
      std::vector<Observation> shots(static_cast<std::size_t>(count), sliding(20.0, -8.0));
      for (Observation& o : shots) move_lift_off(o, 1.0, source);
      const auto fitted = fit(shots, mu_alone());
      by_stated += fitted->covariance_scale == CovarianceScale::stated;
    }
    CHECK_COMPARE(by_stated, <=, 12);
    CHECK_COMPARE(by_stated, >, 0);  // none: once in 50
  }
}

// Conditions that differ by far more than the noise, shots of each alike to a thousandth of it: the conditions scatter.
// Their mus are known: the sd is that of the mean of eight.
TEST(LittleScatter, ShotsAlikeWithinTheirConditionsHideNoScatterBetweenThem) {
  std::vector<Observation> shots;
  auto source = random_source("conditions");
  std::vector<double> mus;
  for (int condition = 0; condition < 8; ++condition) {
    Observation o = sliding(20.0, -8.0);
    const double more = 0.02 * (condition % 2 == 0 ? 1.0 : -1.0) * (1.0 + 0.1 * condition), impulse = 1.8 * 8.0;
    mus.push_back(kMu + more);
    o.lift_off.vx_mps -= more * impulse;
    o.lift_off.omega_radps -= more * impulse / (kAlpha * kRadius_m);
    o.series = std::to_string(condition);
    o.lift_off_sd = {0.01, 0.0, 0.3};
    for (int i = 0; i < 4; ++i) {
      shots.push_back(o);
      move_lift_off(shots.back(), 1e-3, source);
    }
  }
  double mean = 0.0, squares = 0.0;
  for (const double mu : mus) mean += mu / 8.0;
  for (const double mu : mus) squares += std::pow(mu - mean, 2);
  const auto fitted = fit(shots, mu_alone());
  CHECK_TRUE(fitted->covariance_scale == CovarianceScale::clustered);
  // Student's t of seven degrees of freedom, 1.08, is in it.
  const double of_mean = std::sqrt(squares / 7.0 / 8.0);
  CHECK_COMPARE(*mu_of(*fitted).sd, >, 0.99 * of_mean);
  CHECK_COMPARE(*mu_of(*fitted).sd, <, 1.2 * of_mean);
}

namespace {

std::vector<Observation> drawn_shots() {
  const auto count = static_cast<std::size_t>(1 + std::lround(11.0 * fraction()));
  const double noise = over_decades(1e-12, 3.0), sd = over_decades(1e-6, 1.0);
  const bool one_condition = one_in(3);
  const ParameterValues truth{between(0.2, 0.8), between(0.0, 0.3), between(0.0, 5e-3), between(0.5, 6.0), 0.55};
  std::vector<Observation> shots;
  for (std::size_t i = 0; i < count; ++i) {
    Observation o;
    o.name = o.series = std::to_string(one_in(2) ? i : i / 3);
    o.touchdown = {between(0.0, 30.0), -over_decades(0.5, 30.0), between(-300.0, 300.0)};
    o.e = between(0.3, 0.95);
    if (one_condition && !shots.empty()) o.touchdown = shots.front().touchdown, o.e = shots.front().e;
    shots.push_back(o);
  }
  shots = true_rebounds(shots, truth);
  for (Observation& o : shots) {
    const double own = sd * over_decades(0.1, 10.0);
    o.lift_off_sd = {own, 0.0, 30.0 * own};
    o.touchdown_sd = one_in(2) ? Motion{own, own, 30.0 * own} : Motion{};
    o.e_sd = one_in(2) ? 0.1 * std::min(own, 0.1) : 0.0;
    o.lift_off.vx_mps += noise * own * between(-2.0, 2.0);
    o.lift_off.omega_radps += 30.0 * noise * own * between(-2.0, 2.0);
  }
  if (one_in(4)) shots.insert(shots.end(), 4, shots.front());
  return shots;
}

FitOptions drawn_options() {
  constexpr ReboundModel models[] = {ReboundModel::slide_roll, ReboundModel::grip, ReboundModel::grip_offset};
  constexpr CovarianceScale scales[] = {CovarianceScale::clustered, CovarianceScale::residuals,
                                        CovarianceScale::stated};
  FitOptions out = default_options(models[*rc::gen::inRange(0, 3)]);
  out.scale = scales[*rc::gen::inRange(0, 3)];
  if (one_in(2)) out.weighting = Weighting::stated_sd;
  if (one_in(3)) out.free[index(Parameter::alpha)] = true;
  return out;
}

/// The least eigenvalue of the correlations of what has a variance, and how far the matrix is from its transpose.
double worst_of(const ModelFit& fit) {
  using Matrix = Eigen::Matrix<double, kParameterCount, kParameterCount>;
  const Matrix asymmetry = fit.covariance - fit.covariance.transpose();
  Matrix correlation = Matrix::Identity();
  for (std::size_t a = 0; a < kParameterCount; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
      correlation(i, j) = correlation(j, i) = fit.correlation(static_cast<Parameter>(a), static_cast<Parameter>(b));
    }
  const Eigen::SelfAdjointEigenSolver<Matrix> axes(correlation, Eigen::EigenvaluesOnly);
  return std::max(-axes.eigenvalues().minCoeff(), asymmetry.cwiseAbs().maxCoeff());
}

/// Nine rows of products that are each rounded a few times.
constexpr double kRoundingOfNine = 16.0 * kParameterCount * 2.2e-16;

}  // namespace

TEST(LittleScatter, CovariancesAreSymmetricAndPositiveSemidefinite) {
  CHECK(holds_of_all([](Worst& worst) {
    const auto shots = drawn_shots();
    const FitOptions options = drawn_options();
    const auto fitted = fit(shots, options);
    if (!fitted) return;
    RC_ASSERT(fitted->covariance.allFinite());
    RC_ASSERT(worst.within(std::max(0.0, worst_of(*fitted)), kRoundingOfNine));
    for (std::size_t i = 0; i < kParameterCount; ++i) {
      const FittedParameter& p = fitted->parameters[i];
      const double variance = fitted->covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
      RC_ASSERT(variance >= 0.0);
      const double stated = p.status == ParameterStatus::fitted ? *p.sd * *p.sd : 0.0;
      RC_ASSERT(variance == stated);
    }
  }));
}

// Chi squared at its fiftieth or above leaves at least that share of the stated variance.
TEST(LittleScatter, NoSdIsFarBelowWhatTheStatedNoiseAllows) {
  CHECK(holds_of_all([](Worst& worst) {
    const auto count = static_cast<std::size_t>(1 + std::lround(9.0 * fraction()));
    const double noise = over_decades(1e-12, 1.0);
    std::vector<Observation> shots;
    for (std::size_t i = 0; i < count; ++i) {
      shots.push_back(sliding(between(20.0, 30.0), -between(2.0, 8.0)));
      shots.back().lift_off.vx_mps += 0.1 * noise * between(-2.0, 2.0);
      shots.back().lift_off.omega_radps += 3.0 * noise * between(-2.0, 2.0);
    }
    FitOptions options = mu_alone();
    options.scale = CovarianceScale::residuals;
    const auto fitted = fit(shots, options);
    RC_ASSERT(fitted.has_value());
    if (!mu_of(*fitted).sd) return;  // a single shot's scatter may be too uncertain to say that it slides
    const double least = std::sqrt(least_likely_chi2(fitted->dof) / fitted->dof);
    RC_ASSERT(worst.within(least * sd_of_mu(shots) / *mu_of(*fitted).sd, 1.0 + 1e-6));
  }));
}

namespace {

/// By the integrator, of the contact mechanics' own defaults.
Observation by_integration(double vx_mps, double vy_mps, double mu) {
  Observation o;
  o.touchdown = {vx_mps, vy_mps, 0.0};
  o.e = 0.8;
  o.dwell_s = 4.7e-3;
  const NormalSpring unit = normal_spring(1.0, o.e, 1.0).value();
  ContactCoefficients c{.e = o.e, .dwell_s = o.dwell_s / (1.0 + 2.0 * unit.damping_ratio / unit.frequency_radps)};
  c.mu = mu;
  o.lift_off = simulate({.alpha = 0.55}, o.touchdown, c, {.tolerance = 1e-10}).value().lift_off;
  o.lift_off_sd = {0.05, 0.0, 1.5};
  return o;
}

int fitted_count(const ModelFit& fit) {
  int out = 0;
  for (const FittedParameter& p : fit.parameters) out += p.status == ParameterStatus::fitted;
  return out;
}

}  // namespace

// Vx and spin at one touchdown are two numbers, of which a slide tells mu. With all else known its sd would be that
// of the linear change of the two by mu; unknown coefficients only add to it. The sampler's sd is good to a fifth.
TEST(LittleScatter, OneConditionTellsTheContactMechanicsTwoCombinationsAtMost) {
  auto source = random_source("one condition");
  const Observation one = by_integration(20.0, -6.0, 0.5), more = by_integration(20.0, -6.0, 0.5 + 1e-3);
  std::vector<Observation> shots(5, one);
  for (Observation& o : shots) move_lift_off(o, 1e-7, source);
  const double by_vx = (more.lift_off.vx_mps - one.lift_off.vx_mps) / 1e-3 / one.lift_off_sd.vx_mps;
  const double by_spin = (more.lift_off.omega_radps - one.lift_off.omega_radps) / 1e-3 / one.lift_off_sd.omega_radps;
  const double least_sd = 1.0 / std::sqrt(5.0 * (by_vx * by_vx + by_spin * by_spin));
  FitOptions options = default_options(ReboundModel::ode);
  options.weighting = Weighting::stated_sd;
  options.posterior.method = PosteriorMethod::laplace;
  const auto laplace = fit(shots, options);
  CHECK_TRUE(laplace->covariance_scale == CovarianceScale::stated);
  CHECK_COMPARE(*mu_of(*laplace).sd, >, 0.999 * least_sd);
  CHECK_COMPARE(fitted_count(*laplace), <=, 2);
  options.posterior.method = PosteriorMethod::metropolis;
  options.posterior.draws = 1000;
  for (const std::uint64_t seed : {1U, 2U}) {
    options.posterior.seed = seed;
    const auto sampled = fit(shots, options);
    // Worth few draws: the seed must not matter.
    CHECK_TRUE(sampled->posterior->method == PosteriorMethod::laplace);
    CHECK_FALSE(sampled->posterior->reliable);
    DOUBLES_EQUAL(*mu_of(*laplace).sd, *mu_of(*sampled).sd, 0.0);
    CHECK_COMPARE(*mu_of(*sampled).sd, >, 0.8 * least_sd);
    CHECK_COMPARE(fitted_count(*sampled), <=, 2);
    CHECK_COMPARE(worst_of(*sampled), <=, kRoundingOfNine);
  }
}
