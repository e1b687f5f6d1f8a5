// Held against known truth: shots of all 21 conditions of the thesis, digitized with known noise.
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <cstdio>
#include <string>

#include "common/reduction/uncertainty.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/running_statistics.hpp"
#include "tests/common/reduction/simulated_shot.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using test::Bounce;
using test::Setup;
using testing::repetitions;
using testing::widened;

namespace {

std::uint64_t seed() { return test::seed_or(20240611); }

struct Spread {
  int shots = 0;
  double by_sd = 0.0;     // rms error over stated sd
  double by_bound = 0.0;  // rms error over the Cramer-Rao bound
  double bias = 0.0;      // mean error over stated sd
};
using Spreads = std::array<Spread, kQuantityCount>;

struct Study {
  int phases = 20, shots_per_phase = 500;
  Estimator estimator = Estimator::best;
};

/// Over all phases of the flash train: where the images lie relative to the impact decides how much they
/// tell.
Spreads study(const Bounce& bounce, Setup setup, const Study& plan, test::Random& random) {
  Spreads spread{};
  const Quantities truth = test::truth(bounce);
  const int shots = repetitions(plan.shots_per_phase);
  for (int phase = 0; phase < plan.phases; ++phase) {
    setup.phase = (phase + 0.5) / plan.phases;
    setup.roll_rad = std::uniform_real_distribution<double>(-0.02, 0.02)(random);
    const Quantities bound = test::cramer_rao(bounce, setup);
    for (int shot = 0; shot < shots; ++shot) {
      const auto readout = reduce(test::photograph(bounce, setup, random), plan.estimator);
      CHECK_TRUE(readout.has_value());
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (!truth[q]) continue;
        CHECK_TRUE_TEXT(readout->value[q] && readout->sd[q], std::string(name(q)).c_str());
        const double error = *readout->value[q] - *truth[q];
        ++spread[i].shots;
        spread[i].by_sd += std::pow(error / *readout->sd[q], 2);
        spread[i].by_bound += std::pow(error / *bound[q], 2);
        spread[i].bias += error / *readout->sd[q];
      }
    }
  }
  for (Spread& s : spread) {
    s.by_sd = std::sqrt(s.by_sd / s.shots);
    s.by_bound = std::sqrt(s.by_bound / s.shots);
    s.bias /= s.shots;
  }
  return spread;
}

std::string line(const std::string& label, std::size_t quantity, const Spread& s) {
  char text[160];
  std::snprintf(text, sizeof text, "%s %s: rms error / sd %.3f, / bound %.3f, bias / sd %.3f", label.c_str(),
                kQuantityNames[quantity].data(), s.by_sd, s.by_bound, s.bias);
  return text;
}

struct Limits {
  double by_bound = 0.05;  // above 1
  double by_sd = 0.05;     // from 1
  double bias = 0.06;
};

/// Of 10,000 shots the rms is known to 0.7 % (one sd): 5 % is what is asked for and seven of those. The mean
/// is known to 0.01 sd; second-order bias of ratios and angles is of that order too.
void check(const Spreads& spread, const std::string& label, const Limits& limits = {}) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    if (spread[i].shots == 0) continue;  // court pace: not asked for
    const std::string text = line(label, i, spread[i]);
    CHECK_TRUE_TEXT(std::abs(spread[i].by_sd - 1.0) < widened(limits.by_sd), text.c_str());
    CHECK_TRUE_TEXT(spread[i].by_bound <= 1.0 + widened(limits.by_bound), text.c_str());
    CHECK_TRUE_TEXT(std::abs(spread[i].bias) < widened(limits.bias), text.c_str());
  }
}

/// Sums of squares of normalized errors are chi-squared with as many degrees of freedom as shots. Two-sided,
/// such that a right estimator fails once in 10,000 runs of a family of `tests` (Bonferroni).
void check_chi_square(const Spreads& spread, const std::string& label, double tests) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    if (spread[i].shots == 0) continue;
    const boost::math::chi_squared distribution(spread[i].shots);
    const double tail = 1e-4 / (2.0 * tests);
    const double sum = spread[i].by_sd * spread[i].by_sd * spread[i].shots;
    CHECK_TRUE_TEXT(sum > quantile(distribution, tail) && sum < quantile(complement(distribution, tail)),
                    line(label, i, spread[i]).c_str());
  }
}

}  // namespace

TEST_GROUP(TruthOf21Conditions) {
  test::Random random{seed()};
  void setup() override {
    std::printf("(seed %llu: repeat with STROBE_SEED)", static_cast<unsigned long long>(seed()));
  }
};

TEST(TruthOf21Conditions, ErrorsReachTheCramerRaoBoundAndAreAsStated) {
  // The chi-square test sees a stated sd that is 4 % wrong.
  const auto bounces = test::thesis_bounces();
  for (const Bounce& b : bounces) {
    const Spreads spread = study(b, {}, {}, random);
    check(spread, b.label);
    check_chi_square(spread, b.label, 15.0 * static_cast<double>(bounces.size()));
  }
}

TEST(TruthOf21Conditions, ThreeImagesALegReachTheirBoundToo) {
  // 2,500 shots know an rms to 1.4 %, the mean to .02 sd.
  Setup setup;
  setup.incoming = setup.rebound = 3;
  const auto bounces = test::thesis_bounces();
  for (const Bounce& b : bounces) {
    const Spreads spread = study(b, setup, {.shots_per_phase = 125}, random);
    check(spread, b.label, {.by_bound = 0.07, .by_sd = 0.07, .bias = 0.1});
    check_chi_square(spread, b.label, 15.0 * static_cast<double>(bounces.size()));
  }
}

TEST(TruthOf21Conditions, ADragCoefficientAnywhereWithinThePublishedOnesCostsLittle) {
  // .51 to .65 published, .55 assumed: .10 of a drag of 3 m/s², over the 7 ms from a leg's middle to the
  // impact 2 mm/s, beside an sd of 20 to 30.
  const auto bounces = test::thesis_bounces();
  for (const double drag_coefficient : {0.51, 0.65}) {
    Setup setup;
    setup.air.drag_coefficient = drag_coefficient;
    for (const std::size_t i : {1U, 9U, 20U}) {
      const Spreads spread = study(bounces[i], setup, {}, random);
      for (std::size_t k = 0; k < kQuantityCount; ++k) {
        if (spread[k].shots == 0) continue;
        const std::string text = line(bounces[i].label, k, spread[k]);
        CHECK_TRUE_TEXT(std::abs(spread[k].bias) < widened(0.25), text.c_str());
        CHECK_TRUE_TEXT(spread[k].by_bound < 1.0 + widened(0.06), text.c_str());
      }
    }
  }
}

TEST(TruthOf21Conditions, LegsThatMustBeFoundKeepTheStatedErrorsTrue) {
  // 2,500 shots know an rms to 1.4 %, the mean to .02 sd.
  Setup setup;
  setup.labels = false;
  for (const Bounce& b : test::thesis_bounces())
    check(study(b, setup, {.shots_per_phase = 125}, random), b.label,
          {.by_bound = 0.07, .by_sd = 0.07, .bias = 0.1});
}

TEST(TruthOf21Conditions, AnInclinedPlateTakesItsGravityFromTheInclinometer) {
  Setup setup;
  setup.incline_rad = 0.35;
  const auto bounces = test::thesis_bounces();
  for (const std::size_t i : {0U, 10U, 20U}) check(study(bounces[i], setup, {}, random), bounces[i].label);
}

TEST(TruthOf21Conditions, ErrorsOfFlashTimesMoveImagesAlongTheirPath) {
  // 60 us at 17 m/s is a millimetre, twice the digitizing noise: without it in the weights the sd would be
  // half.
  test::Random own(seed() + 1);
  Setup setup;
  const Bounce b;
  double sum = 0.0;
  constexpr int kShots = repetitions(10000);
  for (int i = 0; i < kShots; ++i) {
    setup.phase = std::uniform_real_distribution<double>(0.0, 1.0)(own);
    Frame frame = test::photograph(b, setup, own);
    for (BallImage& image : frame.images) {
      image.time_sd_s = 60e-6;
      image.time_s += 60e-6 * std::normal_distribution<double>()(own);
    }
    const auto readout = reduce(frame, Estimator::best);
    CHECK_TRUE(readout.has_value());
    sum += std::pow((*readout->value[Quantity::vx_td_mps] - b.vx_td) / *readout->sd[Quantity::vx_td_mps], 2);
  }
  DOUBLES_EQUAL(1.0, std::sqrt(sum / kShots), widened(0.05));
}

namespace {

struct Coverage {
  int shots = 0, within_68 = 0, within_95 = 0;
};

std::array<Coverage, kQuantityCount> cover(const Bounce& bounce, int images, int shots,
                                           test::Random& random) {
  Setup setup;
  setup.state_noise = false;
  setup.incoming = setup.rebound = images;
  const Quantities truth = test::truth(bounce);
  std::array<Coverage, kQuantityCount> coverage{};
  for (int i = 0; i < shots; ++i) {
    setup.phase = std::uniform_real_distribution<double>(0.0, 1.0)(random);
    const auto readout = reduce(test::photograph(bounce, setup, random), Estimator::best);
    CHECK_TRUE(readout.has_value());
    for (std::size_t k = 0; k < kQuantityCount; ++k) {
      const auto q = static_cast<Quantity>(k);
      if (!truth[q]) continue;
      CHECK_TRUE_TEXT(readout->sd[q] && readout->degrees_of_freedom[q], kQuantityNames[k].data());
      const double error = std::abs(*readout->value[q] - *truth[q]);
      ++coverage[k].shots;
      if (error < *readout->sd[q]) ++coverage[k].within_68;
      if (error < *expanded_uncertainty(*readout, q)) ++coverage[k].within_95;
    }
  }
  return coverage;
}

}  // namespace

TEST(TruthOf21Conditions, IntervalsFromEstimatedNoiseCoverAsStated) {
  // Student's t holds the share of errors within an interval, 68.27 and 95 %, known to .66 and .31 % from
  // 5,000 shots. Levels with unlike degrees of freedom are pooled (Welch-Satterthwaite), good to a percent
  // or two. Three images a leg leave one degree of freedom to each spin and six to the paths.
  test::Random own(seed() + 2);
  const auto bounces = test::thesis_bounces();
  for (const int images : {3, 5}) {
    for (const std::size_t i : {1U, 9U, 20U}) {
      const auto coverage = cover(bounces[i], images, repetitions(5000), own);
      for (std::size_t k = 0; k < kQuantityCount; ++k) {
        const Coverage& c = coverage[k];
        if (c.shots == 0) continue;
        const double share_68 = static_cast<double>(c.within_68) / c.shots;
        const double share_95 = static_cast<double>(c.within_95) / c.shots;
        char text[160];
        std::snprintf(text, sizeof text, "%s %s, %d images: %.4f and %.4f", bounces[i].label.c_str(),
                      kQuantityNames[k].data(), images, share_68, share_95);
        CHECK_TRUE_TEXT(std::abs(share_68 - 0.6827) < widened(0.03), text);
        CHECK_TRUE_TEXT(std::abs(share_95 - 0.95) < widened(0.015), text);
      }
    }
  }
}

namespace {

/// The shot with the centre of one image 10 mm off, twenty sd, in any direction: each image of either leg in
/// turn.
Frame with_gross_image(const Bounce& bounce, const Setup& setup, int shot, test::Random& random) {
  Frame frame = test::photograph(bounce, setup, random);
  const std::size_t from_end = static_cast<std::size_t>(shot / 2 % setup.incoming);
  BallImage& bad = frame.images[shot % 2 == 0 ? from_end : frame.images.size() - 1 - from_end];
  const double direction = std::uniform_real_distribution<double>(-3.2, 3.2)(random);
  bad.centre_px.x += 0.010 * setup.px_per_m * std::cos(direction);
  bad.centre_px.y += 0.010 * setup.px_per_m * std::sin(direction);
  return frame;
}

}  // namespace

TEST(TruthOf21Conditions, OneGrossImageAmongFourOrMoreIsLeftOut) {
  // Among five the stated errors stay true. Among four an end image 20 sd off, 11.0 sd from the line through
  // the other three, makes its neighbour lie 9.6 from the line through its own other three: noise turns that
  // round in up to one shot in 100, and then nothing can tell.
  test::Random own(seed() + 3);
  constexpr int kShots = repetitions(2000);
  const auto bounces = test::thesis_bounces();
  for (const int images : {4, 5}) {
    Setup setup;
    setup.incoming = setup.rebound = images;
    for (const std::size_t i : {1U, 9U, 20U}) {
      const Quantities truth = test::truth(bounces[i]);
      std::array<double, kQuantityCount> squares{};
      std::array<int, kQuantityCount> wrong{};
      for (int shot = 0; shot < kShots; ++shot) {
        setup.phase = std::uniform_real_distribution<double>(0.0, 1.0)(own);
        const auto readout = reduce(with_gross_image(bounces[i], setup, shot, own), Estimator::best);
        CHECK_TRUE(readout.has_value());
        // Where the rest of four fits badly too, by chance, the noise is doubted and not the image.
        CHECK_TRUE_TEXT(
            readout->flags.has(Flag::outlier_image) || readout->flags.has(Flag::overlaps_surface) ||
                (images == 4 && readout->flags.has(Flag::residuals_exceed_noise)),
            (bounces[i].label + " shot " + std::to_string(shot) + ", images " + std::to_string(images))
                .c_str());
        for (std::size_t k = 0; k < kQuantityCount; ++k) {
          const auto q = static_cast<Quantity>(k);
          if (!truth[q]) continue;
          const double normalized = (*readout->value[q] - *truth[q]) / *readout->sd[q];
          squares[k] += normalized * normalized;
          wrong[k] += std::abs(normalized) > 5.0 ? 1 : 0;
        }
      }
      for (std::size_t k = 0; k < kQuantityCount; ++k) {
        const double rms = std::sqrt(squares[k] / kShots);
        char text[160];
        std::snprintf(text, sizeof text, "%s %s, %d images: rms error / sd %.3f, beyond 5 sd %d of %d",
                      bounces[i].label.c_str(), kQuantityNames[k].data(), images, rms, wrong[k], kShots);
        CHECK_TRUE_TEXT(wrong[k] <= (images == 4 ? kShots / 50 : 0), text);
        // 2,000 shots know an rms to 1.6 %.
        if (truth[static_cast<Quantity>(k)] && images == 5)
          CHECK_TRUE_TEXT(std::abs(rms - 1.0) < widened(0.08), text);
      }
    }
  }
}

TEST(TruthOf21Conditions, TwoPointIsTrueToItsStatedErrorButWiderThanTheBound) {
  // Where there is neither gravity nor air for it to neglect. The slope through n equidistant points has a
  // variance of 12 / (n^3 - n), through the last two 2: an sd sqrt(n (n^2 - 1) / 6) times larger, 2 for three
  // images a leg (as the thesis has them) and 4.47 for five.
  Setup setup;
  setup.gravity_mps2 = 0.0;
  setup.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  const auto bounces = test::thesis_bounces();
  for (const std::size_t i : {1U, 9U, 18U}) {
    for (const int images : {3, 5}) {
      setup.incoming = setup.rebound = images;
      const double loss = std::sqrt(images * (images * images - 1) / 6.0);
      const auto spread = study(bounces[i], setup, {.estimator = Estimator::two_point}, random);
      check(spread, bounces[i].label, {.by_bound = loss * 1.05 - 1.0});
      const auto worse = [&](Quantity q) { return spread[static_cast<std::size_t>(q)].by_bound; };
      DOUBLES_EQUAL(loss, worse(Quantity::omega_td_radps), widened(0.05) * loss);
      for (const Quantity q : {Quantity::theta_in_deg, Quantity::e, Quantity::mu, Quantity::dwell_time_ms})
        CHECK_TRUE_TEXT(worse(q) > 1.1, std::string(name(q)).c_str());
    }
  }
}
