// Scores between laboratories against numbers worked by hand, against the equations that define Algorithm A, solved
// another way, and against how often chance alone exceeds their limits.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/interlaboratory/scores.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::interlaboratory;

/// The root of a function that falls through 0 between low and high.
template <typename Function>
double root_of(const Function& function, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (function(middle) > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double clamped(double x, double mean, double sd) { return std::clamp(x, mean - 1.5 * sd, mean + 1.5 * sd); }

/// The mean for which the drawn-in values have that mean: their sum's excess over it falls with it.
double mean_for(const std::vector<double>& values, double sd) {
  const auto [least, most] = std::ranges::minmax(values);
  return root_of(
      [&](double mean) {
        double sum = 0.0;
        for (const double x : values) sum += clamped(x, mean, sd) - mean;
        return sum;
      },
      least, most);
}

/// Both equations of ISO 13528:2015, C.3.1, at once, by bisection instead of iteration.
RobustMean solved(const std::vector<double>& values) {
  const auto excess = [&](double sd) {
    const double mean = mean_for(values, sd);
    double squares = 0.0;
    for (const double x : values) squares += std::pow(clamped(x, mean, sd) - mean, 2);
    return 1.134 * std::sqrt(squares / (static_cast<double>(values.size()) - 1.0)) - sd;
  };
  const double sd = root_of(excess, 1e-6, 1e3);
  return {mean_for(values, sd), sd};
}

// Means of nine laboratories, softening point of creosote, ISO 5725-5:1998, as in the example of R's metRology::algA().
const std::vector<double> kCreosote{24.140, 20.155, 19.500, 20.300, 20.705, 17.570, 20.100, 20.940, 21.185};

}  // namespace

TEST_GROUP(LaboratoryScores){};

TEST(LaboratoryScores, RobustMeanSolvesTheEquationsOfAlgorithmA) {
  for (std::vector<double> values : {kCreosote, {0.2640, 0.2670, 0.2960, 0.3110, 0.3310, 0.4246}}) {
    const auto found = robust_mean(values);
    CHECK(found.has_value());
    const RobustMean expected = solved(values);
    // Both end where steps are below 1e-12 of the sd; a contraction of at most 1/2 a step leaves as much again.
    DOUBLES_EQUAL(expected.mean, found->mean, 4e-12 * expected.sd + 1e-13);
    DOUBLES_EQUAL(expected.sd, found->sd, 1e-10 * expected.sd);
  }
}

TEST(LaboratoryScores, RobustMeanIsHardlyMovedByOneThatIsFarOff) {
  const auto before = robust_mean(kCreosote);
  std::vector<double> values = kCreosote;
  values[0] = 1e6;
  const auto after = robust_mean(values);
  // 24.14 was drawn in already: how far off it is does not matter.
  DOUBLES_EQUAL(before->mean, after->mean, 1e-9);
  DOUBLES_EQUAL(before->sd, after->sd, 1e-9);
}

TEST(LaboratoryScores, RobustMeanNeedsThreeValuesThatAreNotAllAlike) {
  CHECK_FALSE(robust_mean(std::vector{1.0, 2.0}).has_value());
  CHECK_FALSE(robust_mean(std::vector{1.0, 1.0, 1.0, 1.0, 2.0}).has_value());
}

TEST(LaboratoryScores, RobustSdIsThatOfNormalDrawsWithoutOutliers) {
  std::mt19937 draw(17);  // 1.134 makes it so: within 0.01 at 1e5 draws, whose own sd is 0.0024
  std::normal_distribution<double> normal(5.0, 2.0);
  std::vector<double> values;
  for (int i = 0; i < 100'000; ++i) values.push_back(normal(draw));
  const auto found = robust_mean(values);
  DOUBLES_EQUAL(5.0, found->mean, 0.03);
  DOUBLES_EQUAL(2.0, found->sd, 0.02);
}

TEST(LaboratoryScores, OfTwoTheFirstIsTheReference) {
  const std::vector<LaboratoryResult> results{{"a", 10.0, 0.15, 0.3}, {"b", 10.3, 0.2, 0.4}};
  const auto agreement = compare(results, {});
  CHECK_EQUAL(std::string("a"), agreement->assigned.reference);
  CHECK_FALSE(agreement->scores[0].en.has_value() || agreement->scores[0].zeta.has_value());
  DOUBLES_EQUAL(0.6, *agreement->scores[1].en, 1e-12);    // 0.3 / sqrt(0.3^2 + 0.4^2)
  DOUBLES_EQUAL(1.2, *agreement->scores[1].zeta, 1e-12);  // 0.3 / sqrt(0.15^2 + 0.2^2)
  CHECK_FALSE(agreement->scores[1].z.has_value());
}

TEST(LaboratoryScores, ManyAreHeldAgainstTheirRobustMean) {
  std::vector<LaboratoryResult> results;
  for (std::size_t i = 0; i < kCreosote.size(); ++i)
    results.push_back({std::to_string(i), kCreosote[i], 0.3, 0.6});
  const auto agreement = compare(results, {});
  const RobustMean expected = solved(kCreosote);
  DOUBLES_EQUAL(expected.mean, agreement->assigned.value, 1e-9);
  const double u = 1.25 * expected.sd / 3.0;
  DOUBLES_EQUAL(u, agreement->assigned.standard_uncertainty, 1e-9);
  CHECK(agreement->with_uncertainty);  // 1.25 / 3 of the sd is more than 0.3 of it
  DOUBLES_EQUAL((24.14 - expected.mean) / std::hypot(expected.sd, u), *agreement->scores[0].z, 1e-8);
  DOUBLES_EQUAL((24.14 - expected.mean) / std::hypot(0.3, u), *agreement->scores[0].zeta, 1e-8);
  CHECK_FALSE(agreement->scores[0].en.has_value());

  const auto asked = compare(results, {"", 2.0});
  CHECK_FALSE(asked->with_uncertainty);
  DOUBLES_EQUAL((24.14 - expected.mean) / 2.0, *asked->scores[0].z, 1e-8);
}

TEST(LaboratoryScores, AReferenceIsNotPartOfWhatItIsHeldAgainst) {
  std::vector<LaboratoryResult> results{{"national", 100.0, 0.01, 0.02}};
  for (const double value : {99.0, 100.0, 101.0, 102.0}) results.push_back({std::to_string(value), value, 1.0, 2.0});
  const auto agreement = compare(results, {"national", {}});
  DOUBLES_EQUAL(100.0, agreement->assigned.value, 0.0);
  DOUBLES_EQUAL(solved({99.0, 100.0, 101.0, 102.0}).sd, *agreement->assessment_sd, 1e-9);
  CHECK_FALSE(agreement->scores[0].z.has_value());
  CHECK_FALSE(compare(results, {"nobody", {}}).has_value());
}

TEST(LaboratoryScores, AreJudgedByTheLimitsOfTheStandards) {
  CHECK(judge_en(-1.0) == Performance::satisfactory && judge_en(1.01) == Performance::unsatisfactory);
  CHECK(judge_z(2.0) == Performance::satisfactory && judge_z(-2.01) == Performance::questionable);
  CHECK(judge_z(3.0) == Performance::unsatisfactory);
}

TEST(LaboratoryScores, ExceedTheirLimitsByChanceAsOftenAsTheyShould) {
  // Right laboratories whose uncertainties are as stated: |E_n| > 1 is |normal| > 2, 4.55 %; of 20,000 pairs
  // that is 910 with an sd of 29.
  std::mt19937 draw(23);
  std::normal_distribution<double> normal;
  int exceeded = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::vector<LaboratoryResult> results{{"a", 3.0 * normal(draw), 3.0, 6.0}, {"b", normal(draw), 1.0, 2.0}};
    exceeded += judge_en(*compare(results, {})->scores[1].en) == Performance::unsatisfactory;
  }
  DOUBLES_EQUAL(910, exceeded, 4 * 29);
}
