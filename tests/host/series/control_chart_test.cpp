// Run lengths against published tables and Monte Carlo; scores that learn on the way; since when.
#include <cmath>
#include <cstdio>
#include <random>

#include "host/series/control_chart.hpp"
#include "tests/support/repetitions.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using reduction::Estimate;

namespace {

constexpr unsigned kSeed = 20261201;

/// Shots until the two-sided CUSUM of normal numbers exceeds h, by its definition.
int run_length(double h, double shift, std::mt19937_64& random) {
  std::normal_distribution<double> normal(shift, 1.0);
  double upper = 0.0, lower = 0.0;
  for (int n = 1;; ++n) {
    const double x = normal(random);
    upper = std::max(0.0, upper + x - 0.5);
    lower = std::max(0.0, lower - x - 0.5);
    if (upper > h || lower > h) return n;
  }
}

void check_by_monte_carlo(double h, double shift, std::mt19937_64& random) {
  constexpr int kRuns = testing::repetitions(4000);
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    const double n = run_length(h, shift, random);
    sum += n;
    squares += n * n;
  }
  const double mean = sum / kRuns;
  const double sd = std::sqrt((squares / kRuns - mean * mean) / kRuns);
  std::printf("h %.2f shift %.2f: %.2f against %.2f +- %.2f; ", h, shift, average_run_length(h, shift), mean, sd);
  DOUBLES_EQUAL(mean, average_run_length(h, shift), 4.0 * sd);
}

}  // namespace

TEST_GROUP(ControlChart) {
  std::mt19937_64 random{kSeed};
};

// D. C. Montgomery, Introduction to Statistical Quality Control, table of run lengths of the tabular CUSUM with
// k = 1/2, to three digits.
TEST(ControlChart, RunLengthsAreThePublishedOnes) {
  DOUBLES_EQUAL(168.0, average_run_length(4.0), 0.5);
  DOUBLES_EQUAL(26.6, average_run_length(4.0, 0.5), 0.05);
  DOUBLES_EQUAL(8.38, average_run_length(4.0, 1.0), 0.005);
  DOUBLES_EQUAL(3.34, average_run_length(4.0, 2.0), 0.005);
  DOUBLES_EQUAL(465.0, average_run_length(5.0), 0.5);
  DOUBLES_EQUAL(38.0, average_run_length(5.0, 0.5), 0.05);
  DOUBLES_EQUAL(10.4, average_run_length(5.0, 1.0), 0.05);
}

TEST(ControlChart, RunLengthsAreThoseOfDraws) {
  check_by_monte_carlo(4.0, 0.0, random);
  check_by_monte_carlo(5.5, 0.75, random);
  check_by_monte_carlo(6.8, 1.5, random);
}

TEST(ControlChart, DecisionIntervalGivesTheRunLengthAskedFor) {
  for (const double run_length : {50.0, 370.0, 2590.0})
    DOUBLES_EQUAL(1.0, average_run_length(decision_interval(run_length)) / run_length, 1e-4);
}

/// Series that scatter three times as much as stated, about a mean that nobody knows: standard normal, and
/// independent of those before.
TEST(ControlChart, ScoresOfASelfStartingChartAreNormal) {
  constexpr int kSeries = testing::repetitions(4000);
  constexpr int kLength = 12;
  std::normal_distribution<double> normal;
  double squares = 0.0, products = 0.0, beyond = 0.0;
  int n = 0;
  for (int s = 0; s < kSeries; ++s) {
    ControlChart chart(1e9);
    double last = 0.0;
    for (int i = 0; i < kLength; ++i) {
      const double sd = 1.0 + 0.1 * i;
      const double score = chart.add(i, {50.0 + 3.0 * sd * normal(random), sd}).score;
      if (i < 4) continue;
      squares += score * score;
      products += score * last;
      beyond += std::abs(score) > 2.0 ? 1.0 : 0.0;
      last = score;
      ++n;
    }
  }
  const double sd = 1.0 / std::sqrt(n);
  std::printf("mean square %.4f, neighbours %.4f, beyond 2 %.4f; ", squares / n, products / n, beyond / n);
  // The stated sd is the least that is believed, and one beyond 3 counts as 3: a hundredth each.
  DOUBLES_EQUAL(1.0, squares / n, 0.02 + 4.0 * std::sqrt(2.0) * sd);
  DOUBLES_EQUAL(0.0, products / n, 0.01 + 4.0 * sd);
  DOUBLES_EQUAL(0.0455, beyond / n, 0.003 + 4.0 * std::sqrt(0.0455) * sd);
}

TEST(ControlChart, FirstShotIsHeldAgainstTheReference) {
  ControlChart chart(6.0, Estimate{100.0, 3.0});
  // 5 sds of hypot(3, 4), less the allowance.
  const ChartPoint first = chart.add(0, {125.0, 4.0});
  DOUBLES_EQUAL(5.0, first.score, 1e-12);
  DOUBLES_EQUAL(4.5, first.upper, 1e-12);
  ControlChart unknown(6.0);
  DOUBLES_EQUAL(0.0, unknown.add(0, {125.0, 4.0}).score, 0.0);
  DOUBLES_EQUAL(0.0, unknown.add(1, {100.0, 4.0}).score, 0.0);
}

TEST(ControlChart, TellsAStepAndSinceWhen) {
  ControlChart chart(6.0);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < 20; ++i) chart.add(i, {10.0 + 0.1 * normal(random), 0.1});
  CHECK_FALSE(chart.alarm().has_value());
  for (std::size_t i = 20; i < 30; ++i) chart.add(i, {9.7 + 0.1 * normal(random), 0.1});
  CHECK_TRUE(chart.alarm().has_value());
  // Of a step of 3 sds: 2.5 a shot, less what the mean follows it.
  CHECK_TRUE(*chart.alarm() >= 21 && *chart.alarm() <= 25);
  CHECK_TRUE(chart.since() >= 18 && chart.since() <= 21);
  const auto before = chart.in_control(chart.since());
  // Twenty of 0.1 each: 0.022; four sds.
  DOUBLES_EQUAL(10.0, before->mean.value, 0.09);
}

TEST(ControlChart, DoesNotLearnAStepBeforeItIsTold) {
  ControlChart chart(6.8);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < 8; ++i) chart.add(i, {normal(random), 1.0});
  for (std::size_t i = 8; i < 12; ++i) chart.add(i, {50.0 + normal(random), 1.0});
  CHECK_TRUE(chart.alarm() && *chart.alarm() <= 10);
}
