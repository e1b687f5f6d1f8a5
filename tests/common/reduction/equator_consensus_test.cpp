#include <cmath>
#include <random>

#include "common/reduction/equator_consensus.hpp"
#include "common/units/angles.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;

namespace {

constexpr double kSd_rad = 0.0175, kWindow_radps = 523.0, kFalse = 1e-3;

/// Every 3 ms, with noise.
std::vector<EquatorReading> spinning(double omega, int count, std::mt19937_64& random,
                                     bool estimated = false) {
  std::normal_distribution<double> noise(0.0, kSd_rad);
  std::vector<EquatorReading> all;
  for (int i = 0; i < count; ++i) {
    const double t = 0.003 * i;
    all.push_back({.time_s = t,
                   .angle_rad = wrap_half_turn(0.4 + omega * t + noise(random)),
                   .sd_rad = kSd_rad,
                   .estimated_noise = estimated});
  }
  return all;
}

}  // namespace

TEST_GROUP(EquatorConsensus) {
  std::mt19937_64 random{5};
  std::vector<std::size_t> outside(const std::vector<EquatorReading>& readings) const {
    return outside_consensus(readings, kWindow_radps, kSd_rad, kFalse);
  }
};

TEST(EquatorConsensus, FindsTheReadingsThatShareNoSpinWithTheRest) {
  for (const bool estimated : {false, true}) {
    auto readings = spinning(258.5, 9, random, estimated);
    readings[2].angle_rad += 0.8;
    readings[5].angle_rad += 0.8;
    readings[6].angle_rad -= 0.5;
    const auto found = outside(readings);
    LONGS_EQUAL(3, found.size());
    LONGS_EQUAL(2, found[0]);
    LONGS_EQUAL(5, found[1]);
    LONGS_EQUAL(6, found[2]);
  }
}

TEST(EquatorConsensus, LeavesCleanReadingsWhateverTheirNoise) {
  // Stated to a third of what it is: the consensus's own scatter tells.
  int lost = 0;
  for (int shot = 0; shot < 500; ++shot) {
    auto readings = spinning(-300.0, 8, random);
    if (shot % 2 == 0) {
      for (EquatorReading& r : readings) r.sd_rad /= 3.0;
    }
    lost += outside(readings).empty() ? 0 : 1;
  }
  CHECK_TRUE(lost <= 5);
}

TEST(EquatorConsensus, NeedsAMajorityOfThreeAndNoOtherAsGood) {
  auto readings = spinning(100.0, 4, random);
  readings[0].angle_rad += 0.8;
  readings[2].angle_rad += 0.4;
  CHECK_TRUE(outside(readings).empty());
  // Four and four.
  readings = spinning(100.0, 8, random);
  for (const std::size_t i : {1U, 3U, 5U, 7U}) readings[i].angle_rad += 0.7;
  CHECK_TRUE(outside(readings).empty());
}

TEST(EquatorConsensus, AgreeingReadingsNeedNoSearch) {
  auto readings = spinning(100.0, 8, random);
  CHECK_TRUE(equators_agree(readings, *fit_spin(readings), kSd_rad));
  readings[3].angle_rad += 0.5;
  CHECK_FALSE(equators_agree(readings, *fit_spin(readings), kSd_rad));
  for (EquatorReading& r : readings) r.estimated_noise = true, r.sd_rad = 0.1;
  CHECK_FALSE(equators_agree(readings, *fit_spin(readings), kSd_rad));
}
