// What must hold for any photograph: limits, continuity, numbers that are numbers. A failure prints the RC_PARAMS that
// repeat it.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cfenv>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"
#include "tests/common/reduction/drawn_frames.hpp"

using namespace strobe;
using namespace strobe::reduction;
using strobe::testing::between;
using strobe::testing::holds_of_all;
using strobe::testing::one_in;
using strobe::testing::over_decades;
using strobe::testing::Worst;
using test::Bounce;
using test::Setup;
using test::whole;

namespace {

/// These photographs are of flight without air.
Readout reduced(const Frame& frame, Estimator estimator = Estimator::best) {
  const auto readout = reduce(frame, estimator, {.effects = flight::kGravityOnly, .covariance = true});
  RC_ASSERT(readout.has_value());
  return *readout;
}

Frame exact(const Bounce& b, Setup setup) {
  setup.noise_factor = 0.0;
  test::Random random = test::any_random();
  return test::photograph(b, setup, random);
}

/// Within a millionth of the sd, where the fit stops, and rounding. A flash just after lift-off may come before it by
/// its jitter.
void equals_truth(const Readout& r, const Bounce& b, Worst& worst) {
  RC_PRE(!r.flags.has(Flag::overlaps_surface));
  const Quantities truth = test::truth(b);
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (!truth[q]) continue;
    RC_ASSERT(r.value[q].has_value());
    RC_ASSERT(worst.within(std::abs(*r.value[q] - *truth[q]), 1e-6 * *r.sd[q] + 1e-9 * std::abs(*truth[q])));
  }
}

/// What something is divided by.
bool divisors_are_beyond(double sds, const Numbers& n) {
  for (const Quantity q : {Quantity::v_td_mps, Quantity::vy_td_mps, Quantity::v_lo_mps, Quantity::vy_lo_mps})
    if (n.sd[q] && !(std::abs(*n.value[q]) >= sds * *n.sd[q])) return false;
  return true;
}

bool is_first_order(const Numbers& n) { return divisors_are_beyond(20.0, n); }

}  // namespace

TEST_GROUP(ReductionProperties){};

TEST(ReductionProperties, WithoutNoiseTheBestEstimatorIsExact) {
  CHECK(holds_of_all([](Worst& worst) {
    const Bounce b = test::ordinary_bounce();
    equals_truth(reduced(exact(b, test::in_vacuum())), b, worst);
  }));
}

TEST(ReductionProperties, WithoutNoiseAndGravityTwoPointIsExact) {
  CHECK(holds_of_all([](Worst& worst) {
    const Bounce b = test::ordinary_bounce();
    Setup setup = test::in_vacuum();
    setup.gravity_mps2 = 0.0;
    equals_truth(reduced(exact(b, setup), Estimator::two_point), b, worst);
  }));
}

// The same noise, a thousandth and a ten-thousandth of it: 0.5 um and 0.05 um on paths of 6 mm and more. What is not
// linear is some ten thousandths of it, of an error times the number of sd that it is.
TEST(ReductionProperties, AsNoiseGoesToNothingSdsAndErrorsDoSoInProportion) {
  CHECK(holds_of_all([](Worst& worst) {
    const Bounce b = test::ordinary_bounce();
    const Setup setup = test::in_vacuum();
    const auto seed = *rc::gen::arbitrary<std::uint64_t>();
    const auto readout = [&](double factor, Estimator estimator) {
      Setup s = setup;
      for (double* sd : {&s.centre_sd_m, &s.diameter_sd_m, &s.equator_sd_rad, &s.surface_sd_m}) *sd *= factor;
      if (estimator == Estimator::two_point) s.gravity_mps2 = 0.0;
      test::Random random(seed);
      return reduced(test::photograph(b, s, random), estimator);
    };
    const Quantities truth = test::truth(b);
    for (const Estimator estimator : {Estimator::best, Estimator::two_point}) {
      const Readout small = readout(1e-3, estimator), smaller = readout(1e-4, estimator);
      RC_PRE(!small.flags.has(Flag::overlaps_surface));  // see equals_truth()
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (!truth[q]) continue;
        RC_LOG() << small.method << ' ' << kQuantityNames[i] << ' ' << *truth[q] << ": " << *small.value[q] << " +- "
                 << *small.sd[q] << ", " << *smaller.value[q] << " +- " << *smaller.sd[q] << '\n';
        RC_ASSERT(worst.within(std::abs(*small.sd[q] / *smaller.sd[q] - 10.0), 1e-2));
        const double sds = (*small.value[q] - *truth[q]) / *small.sd[q];
        RC_ASSERT(worst.within(std::abs((*smaller.value[q] - *truth[q]) / *smaller.sd[q] - sds), 1e-2));
      }
    }
  }));
}

// Of exact data, so that it changes no number: information adds up. The errors of a map are not among it, they are
// carried through a fit that knows nothing of them.
TEST(ReductionProperties, OneImageMoreIncreasesNoSd) {
  CHECK(holds_of_all([](Worst& worst) {
    const Bounce b = test::ordinary_bounce();
    Setup setup = test::in_vacuum();
    const bool incoming = one_in(2);
    (incoming ? setup.incoming : setup.rebound) += 1;
    Frame frame = exact(b, setup);
    test::add_statements(frame, setup.px_per_m);
    frame.map_errors.clear();
    const Readout more = reduced(frame);
    frame.images.erase(incoming ? frame.images.begin() : frame.images.end() - 1);
    const Readout fewer = reduced(frame);
    RC_PRE(is_first_order(fewer));  // what else a divisor near zero adds is not that of one estimate
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (!fewer.sd[q]) continue;
      RC_LOG() << kQuantityNames[i] << '\n';
      RC_ASSERT(more.sd[q].has_value());
      RC_ASSERT(worst.within(*more.sd[q] / *fewer.sd[q] - 1.0, 1e-6));
    }
  }));
}

namespace {

constexpr Quantity kPrimaries[] = {Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::omega_td_radps,
                                   Quantity::vx_lo_mps, Quantity::vy_lo_mps, Quantity::omega_lo_radps};
constexpr Eigen::Index kPrimaryPlace[] = {0, 1, 2, 4, 5, 6};

/// Correlations, whose eigenvalues are of order one.
Eigen::MatrixXd correlations(const PrimaryCovariance& covariance) {
  constexpr auto kSize = static_cast<Eigen::Index>(kPrimaryCount);
  Eigen::MatrixXd c(kSize, kSize);
  for (Eigen::Index i = 0; i < kSize; ++i)
    for (Eigen::Index k = 0; k < kSize; ++k)
      c(i, k) = covariance[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  const Eigen::VectorXd scale = c.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * c * scale.asDiagonal();
}

bool exists(const std::optional<double>& x, double least) { return x && std::isfinite(*x) && *x >= least; }

void is_sound(const Numbers& n) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    RC_LOG() << kQuantityNames[i] << '\n';
    RC_ASSERT(!n.value[q] || std::isfinite(*n.value[q]));
    RC_ASSERT(!n.sd[q] || exists(n.sd[q], 0.0));
    RC_ASSERT(!n.sd_systematic[q] || exists(n.sd_systematic[q], 0.0));
    RC_ASSERT(!n.degrees_of_freedom[q] || exists(n.degrees_of_freedom[q], 0.5));
    RC_ASSERT(n.value[q] || !(n.sd[q] || n.sd_systematic[q] || n.degrees_of_freedom[q]));
    if (n.sd[q]) RC_ASSERT(*expanded_uncertainty(n, q) >= *n.sd[q]);
  }
}

}  // namespace

// Eigenvalues of correlations to rounding, 1e-16 by the condition of the fit, 1e6 at worst; variances on the diagonal
// are those of the sds, but that Student's factor and what a divisor near zero lacks are in these alone.
TEST(ReductionProperties, NumbersAndSdsAreFiniteOrAbsentAndCovariancesPositiveSemidefinite) {
  CHECK(holds_of_all([](Worst& worst) {
    const Frame frame = one_in(5) ? test::any_flight() : test::any_frame();
    for (const Estimator estimator : {Estimator::best, Estimator::two_point}) {
      if (frame.surface_px.empty() && estimator != Estimator::best) continue;
      const auto r = reduce(frame, estimator, {.covariance = true});
      RC_ASSERT(r.has_value());
      is_sound(*r);
      if (r->launch) is_sound(*r->launch);
      if (!r->covariance) continue;
      const Eigen::MatrixXd c = correlations(*r->covariance);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(c);
      RC_ASSERT(worst.within(std::max(-solver.eigenvalues().minCoeff(), 0.0), 1e-9));
      for (std::size_t i = 0; i < std::size(kPrimaries); ++i) {
        const auto place = static_cast<std::size_t>(kPrimaryPlace[i]);
        const double sd = std::sqrt((*r->covariance)[place][place]);
        if (!r->sd[kPrimaries[i]]) continue;
        RC_ASSERT(sd <= *r->sd[kPrimaries[i]] * (1.0 + 1e-9));
        if (!r->degrees_of_freedom[kPrimaries[i]] && frame.map_errors.empty() && is_first_order(*r))
          RC_ASSERT(sd >= *r->sd[kPrimaries[i]] * (1.0 - 1e-9));
      }
    }
  }));
}

namespace {

/// A tenth of an sd of some equator makes another spin the better one, once in some thousand frames.
bool spin_flips(const Budget& budget, const Numbers& numbers) {
  return std::ranges::any_of(budget.sources, [&](const BudgetSource& source) {
    return std::abs(source.of(Quantity::omega_td_radps)) > 3.0 * numbers.sd[Quantity::omega_td_radps].value_or(0.0) ||
           std::abs(source.of(Quantity::omega_lo_radps)) > 3.0 * numbers.sd[Quantity::omega_lo_radps].value_or(0.0);
  });
}

}  // namespace

// Its lines from differences, the sds from the fit's covariance. That leaves out products of small errors: of flash
// times with spins, of an open spin, and of an uncertain instant with the spin's decay, which slow legs have.
TEST(ReductionProperties, TheLinesOfTheBudgetAddUpToTheSds) {
  CHECK(holds_of_all([](Worst& worst) {
    Frame frame = one_in(5) ? test::any_flight() : test::any_frame();
    for (BallImage& image : frame.images) image.time_sd_s.reset();
    for (const Estimator estimator : {Estimator::best, Estimator::two_point}) {
      if (frame.surface_px.empty() && estimator != Estimator::best) continue;
      const auto readout = reduce(frame, estimator);
      const auto budget = uncertainty_budget(frame, estimator);
      RC_ASSERT(readout.has_value() && budget.has_value());
      const Numbers& numbers = readout->launch ? static_cast<const Numbers&>(*readout->launch) : *readout;
      const bool unread = !numbers.value[Quantity::omega_td_radps] ||
                          !(readout->launch || numbers.value[Quantity::omega_lo_radps]);
      const FlagSet& flags = readout->flags;
      if (unread || flags.has(Flag::spin_aliased) || flags.has(Flag::degenerate_geometry)) continue;
      if (!is_first_order(numbers) || spin_flips(*budget, numbers)) continue;
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (!numbers.sd[q]) continue;
        const bool spin = q == Quantity::omega_td_radps || q == Quantity::omega_lo_radps || q == Quantity::slip_lo_mps;
        if (spin && !divisors_are_beyond(100.0, numbers)) continue;
        const auto freedom = numbers.degrees_of_freedom[q];
        if (freedom && !frame.map_errors.empty()) continue;  // Student's factor is of one part of the sd
        double sum = 0.0;
        for (const BudgetSource& source : budget->sources)
          if (!is_systematic(source.source)) sum = std::hypot(sum, source.of(q));
        const double sd = *numbers.sd[q] / (freedom ? statistics::student_t_sigma(*freedom) : 1.0);
        RC_LOG() << readout->method << ' ' << kQuantityNames[i] << " +- " << sd << ": " << sum << '\n';
        RC_ASSERT(worst.within(std::abs(sum / sd - 1.0), 0.02));
      }
    }
  }));
}

namespace {

struct Input {
  std::string name;
  double* value;
  double step;  ///< a fiftieth of its sd
};

/// One of the frame's numbers.
Input any_input(Frame& frame) {
  BallImage& image = frame.images[static_cast<std::size_t>(whole(0, static_cast<int>(frame.images.size()) - 1))];
  const double px = frame.centre_sd_px.value_or(2.0) / 50.0, rad = frame.equator_sd_rad.value_or(0.0175) / 50.0;
  std::vector<Input> inputs{{"centre x", &image.centre_px.x, px},
                            {"centre y", &image.centre_px.y, px},
                            {"diameter", &image.diameter_px, px},
                            {"time", &image.time_s, 5e-7},
                            {"ball's diameter", &frame.ball_diameter_m, 1e-5},
                            {"inclination", &frame.surface_angle_deg, 0.1},
                            {"density", &*frame.air_density_kgpm3, 1e-3}};
  if (image.equator_rad) inputs.push_back({"equator", &*image.equator_rad, rad});
  if (frame.px_per_m) inputs.push_back({"scale", &*frame.px_per_m, *frame.px_per_m_sd / 50.0});
  if (!frame.surface_px.empty()) {
    const int point = whole(0, static_cast<int>(frame.surface_px.size()) - 1);
    inputs.push_back({"surface point", &frame.surface_px[static_cast<std::size_t>(point)].y, px});
  }
  return inputs[static_cast<std::size_t>(whole(0, static_cast<int>(inputs.size()) - 1))];
}

/// Which image is of which leg, and whether its diameter measures the scale or the ball.
using Uses = std::vector<std::pair<std::optional<Leg>, bool>>;

Uses uses_of(const Frame& frame) {
  Uses uses;
  const auto fits = image_fits(frame);
  for (const ImageFit& image : *fits) uses.emplace_back(image.leg, image.diameter_used);
  return uses;
}

/// What a readout says that is no number: the switches.
bool alike(const Readout& a, const Readout& b) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (a.value[q].has_value() != b.value[q].has_value()) return false;
  }
  return a.flags == b.flags && a.flight_effects == b.flight_effects && a.mirrored == b.mirrored;
}

}  // namespace

// Second differences of steps of a fiftieth of an input's sd: a number goes with it by its sd at most, which makes
// 0.02 sd a step, and itself changes by less than a tenth of it in an sd. Where a divisor near zero begins to count
// there is a kink, of a tenth of a step.
TEST(ReductionProperties, NumbersAndSdsFollowEachInputWithoutAJump) {
  CHECK(holds_of_all([](Worst& worst) {
    Frame frame = one_in(5) ? test::any_flight() : test::any_frame();
    RC_PRE(frame.centre_sd_px.has_value());  // an sd that one residual tells has a kink where that is zero
    const Input input = any_input(frame);
    for (const Estimator estimator : {Estimator::best, Estimator::two_point}) {
      if (frame.surface_px.empty() && estimator != Estimator::best) continue;
      std::vector<Readout> last;
      Uses uses;
      const double start = *input.value;
      for (int step = 0; step < 20; ++step) {
        *input.value = start + step * input.step;
        auto readout = reduce(frame, estimator);
        RC_ASSERT(readout.has_value());
        const Uses before = std::exchange(uses, uses_of(frame));
        if (!last.empty() && !(before == uses && alike(last.back(), *readout))) last.clear();
        last.push_back(std::move(*readout));
        // Which image, which spins it may be, and whether a leg meets the surface at all are switches, too.
        const auto& flags = last.back().flags;
        if (flags.has(Flag::outlier_image) || flags.has(Flag::spin_aliased)) continue;
        if (last.size() < 3 || flags.has(Flag::degenerate_geometry)) continue;
        const auto back = [&](std::size_t i) -> const Numbers& {
          const Readout& r = last[last.size() - 1 - i];
          return r.launch ? static_cast<const Numbers&>(*r.launch) : r;
        };
        if (!divisors_are_beyond(6.0, back(1))) continue;  // within 4 their quotients' sds have no end
        for (std::size_t i = 0; i < kQuantityCount; ++i) {
          const auto q = static_cast<Quantity>(i);
          if (!back(0).sd[q] || !back(1).sd[q] || !back(2).sd[q]) continue;
          const double value = *back(0).value[q] - 2.0 * *back(1).value[q] + *back(2).value[q];
          const double sd = *back(0).sd[q] - 2.0 * *back(1).sd[q] + *back(2).sd[q];
          RC_LOG() << input.name << ": " << last.back().method << ' ' << kQuantityNames[i] << ' ' << *back(2).value[q]
                   << ' ' << *back(1).value[q] << ' ' << *back(0).value[q] << " +- " << *back(2).sd[q] << ' '
                   << *back(1).sd[q] << ' ' << *back(0).sd[q] << '\n';
          RC_ASSERT(worst.within(std::abs(value) / *back(1).sd[q], 5e-3));
          RC_ASSERT(worst.within(std::abs(sd) / *back(1).sd[q], 5e-3));
        }
      }
      *input.value = start;
    }
  }));
}

TEST(ReductionProperties, NoFrameOfNumbersBreaksIt) {
  CHECK(holds_of_all([] {
    Frame frame;
    frame.ball_diameter_m = between(0.01, 1.0);
    const auto coordinate = [] { return between(-1.0, 1.0) * std::pow(10.0, between(-3.0, 6.0)); };
    const int surface = whole(2, 5);
    for (int i = 0; i < surface; ++i) frame.surface_px.push_back({coordinate(), coordinate()});
    const int images = whole(0, 11);
    double time = 0.0;
    for (int i = 0; i < images; ++i) {
      BallImage image;
      image.time_s = time += between(1e-6, 1.0);
      const int leg = whole(0, 3);
      if (leg < 3) image.leg = static_cast<Leg>(leg);
      image.centre_px = {coordinate(), coordinate()};
      image.diameter_px = std::pow(10.0, between(-3.0, 6.0));
      if (one_in(2)) image.equator_rad = between(-10.0, 10.0);
      frame.images.push_back(image);
    }
    for (const Estimator estimator : {Estimator::best, Estimator::two_point, Estimator::legacy}) {
      const Readout r = reduced(frame, estimator);
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (r.value[q]) RC_ASSERT(std::isfinite(*r.value[q]));
        if (r.sd[q]) RC_ASSERT(std::isfinite(*r.sd[q]) && *r.sd[q] >= 0.0);
      }
    }
  }));
}

// Numbers at the edge of what a frame may hold and beyond it: a complaint that names the field, or a readout
// of finite numbers, with the floating-point exceptions of bad arithmetic trapped.

namespace {

/// An invalid operation, a division by zero or an overflow ends the test program.
class Trapped {
 public:
  Trapped() {
    std::feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(kExceptions);
  }
  Trapped(const Trapped&) = delete;
  Trapped& operator=(const Trapped&) = delete;
  ~Trapped() { fedisableexcept(kExceptions); }

 private:
  static constexpr int kExceptions = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;
};

Frame limiting_photograph(const Setup& setup = {}) {
  test::Random random(11);
  return test::photograph(Bounce{}, setup, random);
}

void check_finite(const Numbers& r) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (r.value[q]) RC_ASSERT(std::isfinite(*r.value[q]));
    if (r.sd[q]) RC_ASSERT(std::isfinite(*r.sd[q]) && *r.sd[q] >= 0.0);
    if (r.sd_systematic[q]) RC_ASSERT(std::isfinite(*r.sd_systematic[q]) && *r.sd_systematic[q] >= 0.0);
  }
}

void check_finite(const Readout& r) {
  check_finite(static_cast<const Numbers&>(r));
  if (r.launch) check_finite(static_cast<const Numbers&>(*r.launch));
  if (r.likely_cause) RC_ASSERT(std::isfinite(r.likely_cause->value) && std::isfinite(r.likely_cause->sd));
  if (!r.covariance) return;
  for (const auto& row : *r.covariance)
    for (const double x : row) RC_ASSERT(std::isfinite(x));
}

/// Reduced by every estimator, with exceptions trapped but for the legacy one, which divides as its program
/// did and drops what is no number; the complaint if there is one.
std::string tried(const Frame& frame) {
  for (const Estimator estimator : {Estimator::best, Estimator::two_point, Estimator::legacy}) {
    if (frame.surface_px.empty() && estimator != Estimator::best) continue;
    const auto reduced = [&] { return reduce(frame, estimator, {.covariance = true, .likely_cause = true}); };
    const auto trapped = [&] {
      const Trapped traps;
      return reduced();
    };
    const Result<Readout> readout = estimator == Estimator::legacy ? reduced() : trapped();
    if (!readout) return readout.error().message;
    check_finite(*readout);
  }
  return "";
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct NamedNumber {
  const char* name;
  double* value;
};

/// Every number of a frame, with the name that a complaint gives it.
std::vector<NamedNumber> numbers_of(Frame& f) {
  BallImage& image = f.images[2];
  return {{"ball_diameter_m", &f.ball_diameter_m},
          {"ball_diameter_sd_m", &f.ball_diameter_sd_m.emplace(0.0008)},
          {"surface_px[1]", &f.surface_px[1].x},
          {"surface_px[3]", &f.surface_px[3].y},
          {"surface_sd_px", &f.surface_sd_px.emplace(2.0)},
          {"centre_sd_px", &f.centre_sd_px.emplace(2.0)},
          {"diameter_sd_px", &f.diameter_sd_px.emplace(2.0)},
          {"shared_diameter_sd_px", &f.shared_diameter_sd_px.emplace(1.0)},
          {"equator_sd_rad", &f.equator_sd_rad.emplace(0.02)},
          {"px_per_m", &f.px_per_m.emplace(4000.0)},
          {"px_per_m_sd", &f.px_per_m_sd.emplace(8.0)},
          {"surface_angle_deg", &f.surface_angle_deg},
          {"temperature_c", &f.temperature_c.emplace(20.0)},
          {"ball_mass_kg", &f.ball_mass_kg.emplace(0.0576)},
          {"ball_alpha", &f.ball_alpha.emplace(0.55)},
          {"ball_alpha_sd", &f.ball_alpha_sd.emplace(0.02)},
          {"air_density_kgpm3", &f.air_density_kgpm3.emplace(1.2)},
          {"images[2].time_s", &image.time_s},
          {"images[2].centre_px", &image.centre_px.x},
          {"images[2].centre_px", &image.centre_px.y},
          {"images[2].diameter_px", &image.diameter_px},
          {"images[2].equator_rad", &*image.equator_rad},
          {"images[2].time_sd_s", &image.time_sd_s.emplace(1e-6)},
          {"images[2].diameter_sd_px", &image.diameter_sd_px.emplace(2.0)},
          {"images[2].equator_sd_rad", &image.equator_sd_rad.emplace(0.02)},
          {"images[2].centre_cov_px2", image.centre_cov_px2.emplace(std::array{4.0, 0.0, 0.0, 4.0}).data()}};
}

/// A frame of random numbers within the limits, drawn in the middle of a property.
Frame extreme_frame() {
  const auto power = [](int least, int most) {
    return std::pow(10.0, *rc::gen::inRange(least, most + 1)) * (1.0 + *rc::gen::inRange(0, 1000) * 1e-3);
  };
  const auto sign = [] { return *rc::gen::arbitrary<bool>() ? 1.0 : -1.0; };
  const auto coordinate = [&] { return *rc::gen::inRange(0, 4) == 0 ? 0.0 : sign() * power(-12, 11); };
  const auto maybe = [] { return *rc::gen::arbitrary<bool>(); };
  Frame frame;
  frame.ball_diameter_m = 0.01 * (1 + *rc::gen::inRange(0, 99));
  if (maybe()) frame.centre_sd_px = power(-9, 11);
  if (maybe()) frame.diameter_sd_px = power(-9, 11);
  if (maybe()) frame.equator_sd_rad = power(-9, 5);
  if (maybe()) frame.surface_sd_px = power(-9, 11);
  if (maybe()) frame.px_per_m = power(-9, 11);
  if (maybe()) frame.px_per_m_sd = maybe() ? 0.0 : power(-9, 11);
  if (maybe()) frame.ball_diameter_sd_m = 0.001;
  if (maybe()) frame.shared_diameter_sd_px = power(-9, 11);
  if (maybe()) frame.temperature_c = 25.0;
  const int surface = *rc::gen::element(0, 2, 3, 4);
  for (int i = 0; i < surface; ++i) frame.surface_px.push_back({coordinate(), coordinate()});
  const int images = *rc::gen::inRange(0, 12);
  double time = 0.0;
  for (int i = 0; i < images; ++i) {
    BallImage image;
    image.time_s = time += power(-8, 6);
    const int leg = *rc::gen::inRange(0, 4);
    if (leg < 3 && surface > 0) image.leg = static_cast<Leg>(leg);
    image.centre_px = {coordinate(), coordinate()};
    image.diameter_px = power(-9, 11);
    if (maybe()) image.equator_rad = sign() * power(-9, 5);
    if (*rc::gen::inRange(0, 4) == 0) image.time_sd_s = power(-12, -1);
    if (*rc::gen::inRange(0, 4) == 0) {
      const double x = power(-9, 11), y = power(-9, 11);
      const double correlation = *rc::gen::inRange(-999, 1000) * 1e-3;
      image.centre_cov_px2 = std::array{x * x, correlation * x * y, correlation * x * y, y * y};
    }
    frame.images.push_back(image);
  }
  return frame;
}

}  // namespace

TEST_GROUP(FrameLimits){};

TEST(FrameLimits, NotANumberInfinityAndHugeNumbersAreRefusedByName) {
  Frame frame = limiting_photograph();
  const std::size_t count = numbers_of(frame).size();
  for (std::size_t i = 0; i < count; ++i) {
    for (const double bad : {std::nan(""), kInfinity, -kInfinity, 1e308, -1e308, 1e100}) {
      Frame changed = limiting_photograph();
      const NamedNumber number = numbers_of(changed)[i];
      *number.value = bad;
      const std::string complaint = tried(changed);
      CHECK_TRUE_TEXT(complaint.rfind(number.name, 0) == 0,
                      (std::string(number.name) + " = " + std::to_string(bad) + ": " + complaint).c_str());
    }
  }
}

TEST(FrameLimits, TinyAndSubnormalNumbersAreRefusedByNameOrHarmless) {
  Frame frame = limiting_photograph();
  const std::size_t count = numbers_of(frame).size();
  for (std::size_t i = 0; i < count; ++i) {
    for (const double tiny : {5e-324, -5e-324, 1e-310, 1e-200, -1e-200, 0.0, 1e-30}) {
      Frame changed = limiting_photograph();
      const NamedNumber number = numbers_of(changed)[i];
      *number.value = tiny;
      const std::string complaint = tried(changed);
      // A time that is out of order is reported at the image where the order breaks.
      const bool time = std::string(number.name) == "images[2].time_s";
      CHECK_TRUE_TEXT(complaint.empty() || time || complaint.rfind(number.name, 0) == 0, complaint.c_str());
    }
  }
}

TEST(FrameLimits, ImagesWithinANanosecondAreRefused) {
  Frame frame = limiting_photograph();
  frame.images[3].time_s = frame.images[2].time_s + 1e-12;
  STRCMP_CONTAINS("images[3].time_s: must be later", tried(frame).c_str());
}

TEST(FrameLimits, NoFrameWithinThemGivesANumberThatIsNone) {
  CHECK_TRUE(rc::check("extreme frames", [] {
    for (int i = 0; i < 20; ++i) RC_ASSERT(tried(extreme_frame()) == "");
  }));
}

TEST(FrameLimits, IdenticalImagesAndExactDataGiveNoSpreadAndNoCrash) {
  // Exact data whose noise is to be estimated: what is left is rounding, some 1e-12 of the ball.
  Setup setup;
  setup.noise_factor = 0.0;
  setup.state_noise = false;
  setup.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  Frame frame = limiting_photograph(setup);
  frame.air_density_kgpm3 = 0.0;
  CHECK_EQUAL("", tried(frame));
  const auto r = reduce(frame, Estimator::best);
  DOUBLES_EQUAL(0.0, *r->sd[Quantity::vx_td_mps], 1e-7);
  DOUBLES_EQUAL(0.0, *r->sd[Quantity::e], 1e-7);
  DOUBLES_EQUAL(0.0, *r->sd[Quantity::omega_td_radps], 1e-6);
  // A ball that stands still, and one whose images are all one.
  for (BallImage& image : frame.images) {
    BallImage same;
    same.time_s = image.time_s;
    same.leg = image.leg;
    same.centre_px = {0, 500};
    same.diameter_px = 260.0;
    same.equator_rad = 0.3;
    image = same;
  }
  STRCMP_EQUAL("", tried(frame).c_str());
  const auto still = reduce(frame, Estimator::best);
  CHECK_TRUE(still->flags.has(Flag::degenerate_geometry));
  CHECK_FALSE(still->mirrored);
}
