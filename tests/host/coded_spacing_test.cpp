// The train that names its flashes by their spacing: where it is possible, what it tells, and where it stays even.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/assembly/assemble.hpp"
#include "host/assembly/coded_spacing.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::host_test;
using host::PlanFile;
using host::SpacedPlan;
using host::Spacing;

/// The shipped rig's: a ball of 260 px, stamps of 2 us.
constexpr host::SpacingNoise kShipped{.centre_sd_of_diameter = 0.1 / 260.0, .flash_time_sd_s = 2e-6};
constexpr std::size_t kFlashes = 167;  // 3 ms in half a second
constexpr Duration kPeriod = milliseconds{3};

std::vector<double> offsets_us(const std::vector<Duration>& intervals) {
  std::vector<double> offsets{0.0};
  for (const Duration interval : intervals) offsets.push_back(offsets.back() + to_microseconds(interval));
  return offsets;
}

/// Of three flashes from this one on, beside a straight line: their sum of squares is change^2 / 6.
double change_us(const std::vector<double>& offsets, std::size_t first) {
  return offsets[first + 2] - 2.0 * offsets[first + 1] + offsets[first];
}

/// Of what two places of the train have different beside a line in each leg's three images, the least sum of squares.
double least_difference_us(const std::vector<double>& offsets, std::size_t in_contact) {
  const std::size_t rebound = 3 + in_contact, places = offsets.size() - rebound - 2;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < places; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double in = change_us(offsets, i) - change_us(offsets, k);
      const double out = change_us(offsets, i + rebound) - change_us(offsets, k + rebound);
      least = std::min(least, (in * in + out * out) / 6.0);
    }
  }
  return std::sqrt(least);
}

host::RigFile shipped_rig() {
  host::RigFile rig;
  rig.camera.px_per_m = 4000.0;
  return rig;
}

PlanFile plan_of(const std::string& text) { return host::read_plan(text, "PLAN.toml", {}).value(); }

}  // namespace

TEST_GROUP(CodedSpacing){};

TEST(CodedSpacing, TellsEveryPlaceOfTheTrainByThreeImagesALeg) {
  const auto offsets = offsets_us(host::coded_intervals(kPeriod, kFlashes, kShipped).value());
  LONGS_EQUAL(kFlashes, offsets.size());
  // 0.1 px of a ball that moves 260 px in 3 ms, and a stamp.
  const double sd_us = std::hypot(3000.0 * 0.1 / 260.0, 2.0);
  // The contact takes 1.5 to 9 ms: none to three flashes of this train.
  for (const std::size_t in_contact : {0u, 1u, 2u, 3u})
    CHECK(least_difference_us(offsets, in_contact) >= 6.5 * sd_us);
}

TEST(CodedSpacing, HasNoIntervalShorterThanThePeriodAndCostsNoMoreThanAnImageInTwelve) {
  for (const Duration period : {milliseconds{2}, milliseconds{3}, milliseconds{5}, milliseconds{10}}) {
    const auto flashes = static_cast<std::size_t>(milliseconds{500} / period);
    const auto intervals = host::coded_intervals(period, flashes, kShipped).value();
    CHECK(*std::ranges::min_element(intervals) == period);
    const auto mean =
        std::accumulate(intervals.begin(), intervals.end(), Duration{}) / static_cast<int>(intervals.size());
    CHECK(mean <= period + period / 12);
    CHECK(*std::ranges::max_element(intervals) <= period + period / 2);
  }
}

TEST(CodedSpacing, IsTheSameEveryTime) {
  CHECK(host::coded_intervals(kPeriod, kFlashes, kShipped).value() ==
        host::coded_intervals(kPeriod, kFlashes, kShipped).value());
}

TEST(CodedSpacing, IsNotPossibleWhereImagesOrStampsAreTooCoarse) {
  CHECK_FALSE(host::coded_intervals(kPeriod, kFlashes, {0.008, 2e-6}).has_value());
  CHECK_FALSE(host::coded_intervals(microseconds{1500}, 334, kShipped).has_value());  // an image in ten
  CHECK_FALSE(host::coded_intervals(kPeriod, kFlashes, {0.1 / 260.0, 20e-6}).has_value());
  STRCMP_EQUAL("a coded train has at most 1024 flashes",
               host::coded_intervals(microseconds{450}, 1025, kShipped).error().message.c_str());
}

TEST_GROUP(SpacedPlan){};

TEST(SpacedPlan, NamesItsFlashesWhereNothingIsSaidOfTheTrain) {
  const SpacedPlan spaced = host::spaced_plan(plan_of(""), shipped_rig(), true);
  CHECK(spaced.plan.coded());
  STRCMP_CONTAINS("coded train: intervals of 3000 to 3", spaced.remark.c_str());
  const ShotPlan shot = spaced.plan.shot();
  CHECK(shot.code.size() <= kFlashes && shot.code.size() >= kFlashes * 12 / 13);
  CHECK(shot.code.back().offset < shot.exposure);
  // What is stored in the session is this train.
  CHECK(plan_of(host::plan_to_toml(spaced.plan)).shot() == shot);
}

TEST(SpacedPlan, IsEvenByNameAndInFilesThatNameAPeriodAlone) {
  for (const char* text :
       {"spacing = \"even\"\n", "period_us = 3000\n", "period_us = 3000\nspacing = \"even\"\n"}) {
    const SpacedPlan spaced = host::spaced_plan(plan_of(text), shipped_rig(), true);
    CHECK(spaced.plan == plan_of(text));
    CHECK(spaced.plan.shot().code.empty() && spaced.remark.empty());
  }
  CHECK(host::spaced_plan(plan_of("period_us = 2500\nspacing = \"coded\"\n"), shipped_rig(), true)
            .plan.coded());
}

TEST(SpacedPlan, IsEvenAndSaysSoWherePhotographsAreMeasuredByHand) {
  const SpacedPlan spaced = host::spaced_plan(plan_of(""), shipped_rig(), false);
  CHECK(spaced.plan.shot().code.empty());
  STRCMP_CONTAINS("even train: the period is too short to code ", spaced.remark.c_str());
  STRCMP_CONTAINS("intervals would have to differ by 3", spaced.remark.c_str());
  STRCMP_CONTAINS("measured by hand", spaced.remark.c_str());
}

TEST(SpacedPlan, IsEvenWhereTheCodedBurstWouldOutlastTheExposure) {
  const std::string burst = "train = \"gated\"\nflash_count = 20\nspacing = \"coded\"\nshutter_open_ms = ";
  CHECK(host::spaced_plan(plan_of(burst + "100\n"), shipped_rig(), true).plan.coded());
  const SpacedPlan even = host::spaced_plan(plan_of(burst + "60\n"), shipped_rig(), true);
  CHECK_FALSE(even.plan.coded());
  STRCMP_EQUAL("even train: the coded burst would outlast the exposure", even.remark.c_str());
}

TEST(SpacedPlan, OfADropStepsByOneToTwoDiameters) {
  for (const double height_m : {0.5, 1.0, 2.54}) {
    const SpacedPlan spaced =
        host::spaced_plan(plan_of(fmt::format("drop_height_m = {}\n", height_m)), shipped_rig(), true);
    STRCMP_EQUAL("", spaced.problem.c_str());
    STRCMP_CONTAINS("for a drop from", spaced.remark.c_str());
    // Without air it lands a twentieth faster at most.
    const double step_m = to_seconds(spaced.plan.even.period) * std::sqrt(2.0 * 9.80665 * height_m);
    CHECK(step_m > 0.9 * shipped_rig().ball.diameter_m && step_m < 2.0 * shipped_rig().ball.diameter_m);
    // The top of neither flight is lit.
    CHECK(to_seconds(spaced.plan.even.impact_at) < std::sqrt(2.0 * height_m / 9.80665));
    CHECK(plan_of(host::plan_to_toml(spaced.plan)).shot() == spaced.plan.shot());
  }
}

TEST(SpacedPlan, OfADropSaysWhichPeriodWouldDoWhereTheStatedOneDoesNot) {
  const SpacedPlan spaced =
      host::spaced_plan(plan_of("drop_height_m = 2.54\nperiod_us = 3000\n"), shipped_rig(), true);
  STRCMP_CONTAINS("period_us: 3.0 ms between flashes let images hide each other", spaced.problem.c_str());
  STRCMP_CONTAINS("m/s: 1", spaced.problem.c_str());  // .0651 m at 6.9 m/s take 9.5 ms
  STRCMP_CONTAINS("would do", spaced.problem.c_str());
  CHECK(host::spaced_plan(plan_of("drop_height_m = 2.54\nperiod_us = 12000\n"), shipped_rig(), true)
            .problem.empty());
}

TEST(SpacedPlan, OfADropSaysThatTooLittleOfItIsSeen) {
  host::RigFile rig = shipped_rig();
  rig.camera.px_per_m = 4000.0;
  rig.camera.height_px = 700;
  const SpacedPlan spaced = host::spaced_plan(plan_of("drop_height_m = 2.54\n"), rig, true);
  STRCMP_CONTAINS("show more of its fall", spaced.problem.c_str());
}

TEST(SpacedPlan, TellsTheFlashesOfAFastBallWithThreeImagesALeg) {
  host::AssemblySettings settings;
  Scenario court_pace;
  court_pace.bounce = {28.8, -8.3, 0.0, 18.6, 7.2, -500.0, 4.6e-3, 0.105};
  court_pace.noise_mm = 0.025;  // 0.1 px of 4,000 a metre
  const auto intervals = host::coded_intervals(kPeriod, kFlashes, kShipped).value();
  for (const Duration interval : intervals) court_pace.intervals_s.push_back(to_seconds(interval));
  court_pace.flash_count = 155;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    court_pace.seed = seed;
    court_pace.touchdown_s = 0.02 * seed + 0.0007 * (seed % 4);
    const SyntheticShot made = make_shot(court_pace);
    CHECK(made.image_flash.size() <= 10);
    const auto shot = host::assemble(made.shot, made.frame, settings);
    std::vector<int> flashes;
    for (const auto& image : shot.frame.images) flashes.push_back(image.flash_index.value_or(-1));
    CHECK(flashes == made.image_flash);
    CHECK_FALSE(shot.flags.has(reduction::Flag::flash_index_ambiguous));
  }
}

TEST(SpacedPlan, TellsAnImageThatNoFlashMade) {
  host::AssemblySettings settings;
  Scenario scenario;
  scenario.noise_mm = 0.025;
  scenario.flash_count = 155;
  const auto intervals = host::coded_intervals(kPeriod, kFlashes, kShipped).value();
  for (const Duration interval : intervals) scenario.intervals_s.push_back(to_seconds(interval));
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    scenario.seed = seed;
    scenario.touchdown_s = 0.2 + 0.0007 * seed;
    SyntheticShot made = make_shot(scenario);
    const auto readout_before = host::shot_readout(made.shot, made.frame, settings).readout;
    // A step before the first rebound image, near a ball in contact: an even train would take it for a flash's.
    auto& images = made.frame.images;
    const auto rebound =
        std::ranges::find(images, strobe_msgs::ball_image_t::LEG_REBOUND, &strobe_msgs::ball_image_t::leg);
    auto invented = *rebound;
    invented.centre_x_px -= (rebound + 1)->centre_x_px - rebound->centre_x_px;
    invented.centre_y_px -= 0.9 * ((rebound + 1)->centre_y_px - rebound->centre_y_px);
    images.insert(rebound, invented);
    ++made.frame.image_count;
    const auto shot = host::assemble(made.shot, made.frame, settings);
    CHECK(shot.flags.has(reduction::Flag::outlier_image));
    std::vector<int> flashes;
    for (const auto& image : shot.frame.images) flashes.push_back(image.flash_index.value_or(-1));
    CHECK(flashes == made.image_flash);
    const auto readout = host::shot_readout(made.shot, made.frame, settings).readout;
    // The same images; only the weights of what is dropped as implausible may differ.
    for (const auto q : {reduction::Quantity::vx_td_mps, reduction::Quantity::dwell_time_ms})
      DOUBLES_EQUAL(*readout_before.value[q], *readout.value[q], 0.01 * *readout.sd[q]);
  }
}
