// What the digitizer's noise is predicted to be, and the geometry that it depends on.
#include <cmath>
#include <numbers>
#include <vector>

#include "host/design/digitizer_noise.hpp"
#include "host/design/overlap.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::host;

namespace {

constexpr double kRounding = 1e-12;

PictureConditions usual(double diameter_px) {
  PictureConditions conditions;
  conditions.ball_diameter_px = diameter_px;
  return conditions;
}

DigitizerSds sds_of(const PictureConditions& conditions) {
  const auto sds = digitizer_sds(conditions);
  CHECK(sds.has_value());
  return *sds;
}

}  // namespace

TEST_GROUP(Overlap){};

TEST(Overlap, OfTwoDiscsIsTheArcBetweenTheirCrossings) {
  // Circles of diameter d at a distance s cross where cos(angle) = s/d, from the line of centres.
  for (const double step : {0.05, 0.3, 0.5, 0.9, 0.999}) {
    const double angle_rad = 0.7;
    const auto shares = overlap_shares(
        {{10.0, 20.0}, {10.0 + 80.0 * step * std::cos(angle_rad), 20.0 + 80.0 * step * std::sin(angle_rad)}},
        80.0);
    for (const double share : shares) DOUBLES_EQUAL(std::acos(step) / std::numbers::pi, share, kRounding);
  }
}

TEST(Overlap, IsNothingBeyondADiameter) {
  for (const double share : overlap_shares({{0.0, 0.0}, {80.0, 0.0}, {0.0, 200.0}}, 80.0))
    DOUBLES_EQUAL(0.0, share, kRounding);
}

TEST(Overlap, IsToldByDepth) {
  // In a row with steps of a quarter of the diameter the middle one of five lies within two others on either
  // side where the farther one's arc, of half angle acos(.5), is, and within one where only the nearer one's
  // is.
  const auto all = overlaps({{0.0, 0.0}, {20.0, 0.0}, {40.0, 0.0}, {60.0, 0.0}, {80.0, 0.0}}, 80.0);
  const double nearer = 2.0 * std::acos(0.25) / std::numbers::pi,
               farther = 2.0 * std::acos(0.5) / std::numbers::pi;
  DOUBLES_EQUAL(1.0 - nearer, all[2].shares[0], kRounding);
  DOUBLES_EQUAL(nearer - farther, all[2].shares[1], kRounding);
  DOUBLES_EQUAL(farther, all[2].shares[2], kRounding);
  DOUBLES_EQUAL(nearer, all[2].share(), kRounding);
}

TEST(Overlap, OfTwoAtOnePlaceIsWhole) {
  for (const double share : overlap_shares({{3.0, 4.0}, {3.0, 4.0}}, 80.0))
    DOUBLES_EQUAL(1.0, share, kRounding);
}

TEST_GROUP(DigitizerNoise){};

TEST(DigitizerNoise, OfLargerBallsIsASmallerShareOfThem) {
  DigitizerSds last = sds_of(usual(kBallDiameter_px.least));
  double last_px = kBallDiameter_px.least;
  for (const double diameter_px : {60.0, 100.0, 200.0, kBallDiameter_px.most}) {
    const DigitizerSds sds = sds_of(usual(diameter_px));
    CHECK(sds.centre_along_px / diameter_px < last.centre_along_px / last_px);
    CHECK(sds.centre_across_px / diameter_px < last.centre_across_px / last_px);
    CHECK(sds.diameter_px / diameter_px < last.diameter_px / last_px);
    CHECK(sds.surface_px / diameter_px < last.surface_px / last_px);
    CHECK(sds.equator_rad < last.equator_rad);
    CHECK(sds.found > 0.95 && sds.equator_found > last.equator_found);
    last = sds;
    last_px = diameter_px;
  }
}

TEST(DigitizerNoise, GrowsWithBlurAndOverlap) {
  PictureConditions blurred = usual(130.0), hidden = usual(130.0);
  blurred.blur_px = 2.0;
  hidden.overlap.shares = {0.4, 0.6};
  for (const PictureConditions& worse : {blurred, hidden}) {
    const DigitizerSds good = sds_of(usual(130.0)), bad = sds_of(worse);
    CHECK(bad.centre_px() > good.centre_px());
    CHECK(bad.diameter_px > good.diameter_px);
    CHECK(bad.equator_rad > good.equator_rad);
    CHECK(bad.found < good.found && bad.equator_found < good.equator_found);
  }
}

TEST(DigitizerNoise, FindsFewerImagesInShorterSteps) {
  double last = 1.0;
  for (const double step : {0.7, 0.5, 0.35, kMinStep}) {
    PictureConditions conditions = usual(130.0);
    conditions.step = step;
    CHECK(sds_of(conditions).found < last);
    last = sds_of(conditions).found;
  }
}

TEST(DigitizerNoise, OfAFaintLineIsLargerForTheEquatorAlone) {
  PictureConditions faint = usual(130.0);
  faint.line_contrast = 0.3;
  CHECK(sds_of(faint).equator_rad > sds_of(usual(130.0)).equator_rad);
  CHECK(sds_of(faint).equator_found < sds_of(usual(130.0)).equator_found);
  DOUBLES_EQUAL(sds_of(usual(130.0)).centre_px(), sds_of(faint).centre_px(), kRounding);
}

TEST(DigitizerNoise, SaturatedOverlapsTellNothing) {
  const Overlap overlap{{0.4, 0.0, 0.6}};
  // The limbs of three images have a light of .81 at an exposure of 1, and of 1.62 at 2.
  CHECK(readable_share(overlap, 1.0) > 0.4);
  DOUBLES_EQUAL(0.4, readable_share(overlap, 2.0), kRounding);
  DOUBLES_EQUAL(1.0, readable_share(Overlap{}, 2.0), kRounding);
}

TEST(DigitizerNoise, IsNotKnownOutsideOfWhatWasMeasured) {
  const auto not_known = [](auto member, double value) {
    PictureConditions conditions = usual(130.0);
    conditions.*member = value;
    return !digitizer_sds(conditions);
  };
  CHECK(not_known(&PictureConditions::ball_diameter_px, 39.0));
  CHECK(not_known(&PictureConditions::ball_diameter_px, 451.0));
  CHECK(not_known(&PictureConditions::blur_px, 0.3));
  CHECK(not_known(&PictureConditions::blur_px, 3.1));
  CHECK(not_known(&PictureConditions::motion_px, 3.1));
  CHECK(not_known(&PictureConditions::exposure, 0.1));
  CHECK(not_known(&PictureConditions::exposure, 2.1));
  CHECK(not_known(&PictureConditions::full_well_e, 2e3));
  CHECK(not_known(&PictureConditions::read_noise_e, 40.0));
  CHECK(not_known(&PictureConditions::line_contrast, 0.1));
  CHECK(not_known(&PictureConditions::line_width, 0.1));
  CHECK(not_known(&PictureConditions::step, 0.2));
  CHECK(not_known(&PictureConditions::exposure, std::nan("")));
  PictureConditions hidden = usual(130.0);
  hidden.overlap.shares = {0.1, 0.0, 0.0, 0.0, 0.9};
  hidden.exposure = 1.0;
  CHECK(!digitizer_sds(hidden));
}
