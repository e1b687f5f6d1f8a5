#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "common/reduction/reduce.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using reduction::Quantity;

namespace {

constexpr std::array kNumbers{Quantity::v_td_mps, Quantity::v_lo_mps, Quantity::theta_out_deg, Quantity::omega_lo_radps,
                              Quantity::e, Quantity::mu};

/// Speeds at which the kind's drag and lift were measured; 16 degrees, as at court pace.
sim::Scene scene_of(const std::string& kind, double speed_mps) {
  const std::string text = "[ball]\nkind = \"" + kind + "\"\n[machine]\nspeed_mps = " + std::to_string(speed_mps) +
                           "\nangle_deg = -16\nspin_radps = 0\nspin_sd_radps = 30\nspeed_sd_mps = 0.2\n[bounce]\n[ball_appearance]\nline = true\n";
  auto scene = sim::parse_scene(text, "scene.toml");
  CHECK_TRUE_TEXT(scene.has_value(), scene ? "" : scene.error().message.c_str());
  return *std::move(scene);
}

struct Counted {
  double squares = 0.0;
  int numbers = 0, shots = 0, readable = 0;
};

/// Each shot is of another ball of the kind, which is stated as the kind's mean.
Counted shots_of(const std::string& kind, double speed_mps, int shots) {
  constexpr unsigned kSeed = 340;
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  const sim::Scene mean = scene_of(kind, speed_mps);
  const flight::AirLaw& law = mean.kind->air;
  Counted counted;
  // A small ball may spin fast: flashes every 3 ms would leave a sixth of a golf ball's spins open.
  const sim::ShootSettings settings{.period = milliseconds(2)};
  for (int shot = 1; shot <= shots; ++shot) {
    sim::Scene scene = mean;
    scene.ball.diameter_m += mean.kind->diameter_m.sd * normal(random);
    scene.air.drag_coefficient = std::max(0.0, law.drag_coefficient + law.drag_coefficient_sd * normal(random));
    scene.air.lift_factor = std::max(0.0, 1.0 + law.lift_share_sd * normal(random));
    scene.air.spin_decay_per_m = std::max(0.0, law.spin_decay_per_m + law.spin_decay_sd_per_m * normal(random));
    auto thrown = sim::shoot(scene, kSeed, shot, sim::Model::full(), settings);
    CHECK_TRUE(thrown.has_value());
    if (thrown->frame.images.empty()) continue;
    ++counted.shots;
    thrown->frame.ball_diameter_m = mean.kind->diameter_m.value;
    thrown->frame.ball_diameter_sd_m = mean.kind->diameter_m.sd;
    const auto readout = reduction::reduce(thrown->frame, reduction::Estimator::best);
    CHECK_TRUE(readout.has_value());
    if (readout->flags.has(reduction::Flag::spin_aliased) || !readout->value[Quantity::omega_lo_radps]) continue;
    ++counted.readable;
    for (const Quantity q : kNumbers) {
      if (!readout->value[q] || !readout->sd[q]) continue;
      const double sd = std::hypot(*readout->sd[q], readout->sd_systematic[q].value_or(0.0));
      const double z = (*readout->value[q] - *thrown->truth[q]) / sd;
      counted.squares += z * z;
      ++counted.numbers;
    }
  }
  return counted;
}

void check(const std::string& kind, double speed_mps) {
  constexpr int kShots = 300;
  const Counted counted = shots_of(kind, speed_mps, kShots);
  const double rms = std::sqrt(counted.squares / counted.numbers);
  std::printf("%s: errors over stated sds %.3f rms of %d numbers, %d of %d shots\n", kind.c_str(), rms, counted.numbers,
              counted.readable, counted.shots);
  CHECK_TRUE(counted.readable >= 9 * kShots / 10);
  // The rms of 300 errors is known to 1/sqrt(600) = 4.1 %, of several numbers to less: 2.4 of it.
  DOUBLES_EQUAL(1.0, rms, 0.1);
}

}  // namespace

TEST_GROUP(OtherBalls) {
  void setup() override { ::setenv("STROBE_SHARE", STROBE_BUILD_DIR "/share/strobe", 1); }
  void teardown() override { ::unsetenv("STROBE_SHARE"); }
};

TEST(OtherBalls, AGolfBallsErrorsAreAsStated) { check("golf", 30.0); }
TEST(OtherBalls, ABaseballsErrorsAreAsStated) { check("baseball", 30.0); }
TEST(OtherBalls, ATableTennisBallsErrorsAreAsStated) { check("table-tennis", 20.0); }
TEST(OtherBalls, ABasketballsErrorsAreAsStated) { check("basketball", 12.0); }

TEST(OtherBalls, AFlightBeyondItsLawsSpeedsIsFlagged) {
  const auto flagged = [](double speed_mps) {
    const auto thrown = sim::shoot(scene_of("basketball", speed_mps), 1, 1);
    return reduction::reduce(thrown->frame, reduction::Estimator::best)->flags.has(reduction::Flag::air_extrapolated);
  };
  CHECK_TRUE(flagged(30.0));
  CHECK_FALSE(flagged(12.0));
}

TEST(OtherBalls, ASceneThatNamesAKindLeavesItsParentsBall) {
  const auto parent = [](const std::string&, const std::string&) -> Result<sim::SceneText> {
    return sim::SceneText{"[ball]\nmass_kg = 0.05\nalpha = 0.6\n[air]\ndrag_coefficient = 0.6\n[machine]\nspeed_mps = 20\n"
                          "angle_deg = -20\nspin_radps = 0\n[bounce]\ne = 0.8\nmu = 0.5\ndwell_ms = 5\n",
                          "parent.toml"};
  };
  const auto scene =
      sim::parse_scene("inherits = \"parent\"\n[ball]\nkind = \"golf\"\n[bounce]\nmu = 0.2\n", "child.toml", parent);
  CHECK_TRUE_TEXT(scene.has_value(), scene ? "" : scene.error().message.c_str());
  const balls::Kind& golf = *scene->kind;
  CHECK_EQUAL(golf.mass_kg.value, scene->ball.mass_kg);
  CHECK_EQUAL(golf.alpha.value, scene->ball.alpha);
  CHECK_EQUAL(golf.air.drag_coefficient, scene->air.drag_coefficient);
  CHECK_EQUAL(golf.air.lift_offset, scene->air.lift_offset);
  CHECK_EQUAL(golf.contact.e, scene->bounce.e);
  CHECK_EQUAL(golf.contact.dwell_s, scene->bounce.dwell_s);
  CHECK_EQUAL(0.2, scene->bounce.mu);
}
