// Held against known truth: shots of all 21 conditions of the thesis, digitized with known noise.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/reduction/reduce.hpp"
#include "common/reduction/series.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using test::Bounce;
using test::Setup;

namespace {

/// STROBE_SEED repeats a run.
std::uint64_t seed() {
  const char* text = std::getenv("STROBE_SEED");
  return text ? std::strtoull(text, nullptr, 10) : 20240611;
}

struct Spread {
  double by_sd = 0.0;     // rms error over stated sd
  double by_bound = 0.0;  // rms error over the Cramer-Rao bound
  double bias = 0.0;      // mean error over stated sd
};

struct Study {
  int phases = 20;
  int shots_per_phase = 500;
  Estimator estimator = Estimator::best;
};

/// Over all phases of the flash train: where the images lie relative to the impact decides how much they
/// tell.
std::array<Spread, kQuantityCount> study(const Bounce& bounce, Setup setup, const Study& plan,
                                         test::Random& random) {
  std::array<Spread, kQuantityCount> spread{};
  const Quantities truth = test::truth(bounce);
  int shots = 0;
  for (int phase = 0; phase < plan.phases; ++phase) {
    setup.phase = (phase + 0.5) / plan.phases;
    setup.roll_rad = std::uniform_real_distribution<double>(-0.02, 0.02)(random);
    const Quantities bound = test::cramer_rao(bounce, setup);
    for (int shot = 0; shot < plan.shots_per_phase; ++shot, ++shots) {
      const auto readout = reduce(test::photograph(bounce, setup, random), plan.estimator);
      CHECK_TRUE(readout.has_value());
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (!truth[q]) continue;
        CHECK_TRUE_TEXT(readout->value[q] && readout->sd[q], std::string(name(q)).c_str());
        const double error = *readout->value[q] - *truth[q];
        spread[i].by_sd += std::pow(error / *readout->sd[q], 2);
        spread[i].by_bound += std::pow(error / *bound[q], 2);
        spread[i].bias += error / *readout->sd[q];
      }
    }
  }
  for (Spread& s : spread) s = {std::sqrt(s.by_sd / shots), std::sqrt(s.by_bound / shots), s.bias / shots};
  return spread;
}

}  // namespace

TEST_GROUP(TruthOf21Conditions) {
  test::Random random{seed()};
  void setup() override {
    std::printf("(seed %llu: repeat with STROBE_SEED)", static_cast<unsigned long long>(seed()));
  }
};

namespace {

void check(const std::array<Spread, kQuantityCount>& spread, const std::string& label,
           double largest_by_bound) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    if (spread[i].by_sd == 0.0) continue;  // court pace: not asked for
    char text[160];
    std::snprintf(text, sizeof text, "%s %s: rms error / sd %.3f, / bound %.3f, bias / sd %.3f",
                  label.c_str(), kQuantityNames[i].data(), spread[i].by_sd, spread[i].by_bound,
                  spread[i].bias);
    // 10,000 shots know an rms to 0.7 % (one sd): 5 % is what the design asks for and seven of those.
    CHECK_TRUE_TEXT(std::abs(spread[i].by_sd - 1.0) < 0.05, text);
    CHECK_TRUE_TEXT(spread[i].by_bound <= largest_by_bound, text);
    // The mean of 10,000 is known to 0.01 sd; second-order bias of ratios and angles is of that order too.
    CHECK_TRUE_TEXT(std::abs(spread[i].bias) < 0.06, text);
  }
}

}  // namespace

TEST(TruthOf21Conditions, ErrorsReachTheCramerRaoBoundAndAreAsStated) {
  for (const Bounce& b : test::thesis_bounces()) check(study(b, {}, {}, random), b.label, 1.05);
}

TEST(TruthOf21Conditions, LegsThatMustBeFoundKeepTheStatedErrorsTrue) {
  Setup setup;
  setup.labels = false;
  for (const Bounce& b : test::thesis_bounces()) check(study(b, setup, {}, random), b.label, 1.05);
}

TEST(TruthOf21Conditions, AnInclinedPlateTakesItsGravityFromTheInclinometer) {
  Setup setup;
  setup.incline_rad = 0.35;
  const auto bounces = test::thesis_bounces();
  for (const std::size_t i : {0U, 10U, 20U})
    check(study(bounces[i], setup, {}, random), bounces[i].label, 1.05);
}

TEST(TruthOf21Conditions, ErrorsOfFlashTimesMoveImagesAlongTheirPath) {
  // 60 us at 17 m/s is a millimetre, twice the digitizing noise: without it in the weights the sd would be
  // half.
  test::Random own(seed() + 1);
  Setup setup;
  const Bounce b;
  double sum = 0.0;
  constexpr int kShots = 10000;
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
  DOUBLES_EQUAL(1.0, std::sqrt(sum / kShots), 0.05);
}

TEST(TruthOf21Conditions, SdFromResidualsCoversAsOften) {
  // What must hold with Student's t is the share of errors within one sd: 68.27 %, of 10,000 known to 0.47 %.
  // Pooled levels with unlike degrees of freedom (Welch-Satterthwaite) are good to a percent or two.
  test::Random own(seed() + 2);
  Setup setup;
  setup.state_noise = false;
  const Bounce b;
  const Quantities truth = test::truth(b);
  std::array<int, kQuantityCount> within{};
  constexpr int kShots = 10000;
  for (int i = 0; i < kShots; ++i) {
    setup.phase = std::uniform_real_distribution<double>(0.0, 1.0)(own);
    const auto readout = reduce(test::photograph(b, setup, own), Estimator::best);
    CHECK_TRUE(readout.has_value());
    for (std::size_t k = 0; k < kQuantityCount; ++k) {
      const auto q = static_cast<Quantity>(k);
      if (truth[q] && std::abs(*readout->value[q] - *truth[q]) < *readout->sd[q]) ++within[k];
    }
  }
  for (std::size_t k = 0; k < kQuantityCount; ++k) {
    if (!truth[static_cast<Quantity>(k)]) continue;
    const std::string text = std::string(kQuantityNames[k]) + " " + std::to_string(within[k]);
    CHECK_TRUE_TEXT(std::abs(static_cast<double>(within[k]) / kShots - 0.6827) < 0.025, text.c_str());
  }
}

TEST(TruthOf21Conditions, TwoPointIsTrueToItsStatedErrorButWiderThanTheBound) {
  // Where there is no gravity for it to neglect. The slope through n equidistant points has a variance of
  // 12 / (n^3 - n), through the last two 2: an sd sqrt(n (n^2 - 1) / 6) times larger, 2 for three images a
  // leg (as the thesis has them) and 4.47 for five.
  Setup setup;
  setup.gravity_mps2 = 0.0;
  const auto bounces = test::thesis_bounces();
  for (const std::size_t i : {1U, 9U, 18U}) {
    for (const int images : {3, 5}) {
      setup.incoming = setup.rebound = images;
      const double loss = std::sqrt(images * (images * images - 1) / 6.0);
      const auto spread = study(bounces[i], setup, {.estimator = Estimator::two_point}, random);
      check(spread, bounces[i].label, loss * 1.05);
      const auto worse = [&](Quantity q) { return spread[static_cast<std::size_t>(q)].by_bound; };
      DOUBLES_EQUAL(loss, worse(Quantity::omega_td_radps), 0.05 * loss);
      for (const Quantity q : {Quantity::theta_in_deg, Quantity::e, Quantity::mu, Quantity::dwell_time_ms}) {
        CHECK_TRUE_TEXT(worse(q) > 1.1, std::string(name(q)).c_str());
      }
    }
  }
}
