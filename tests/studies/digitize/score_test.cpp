// The figures of the digitizer are only as good as how they are counted.
#include "tests/studies/digitize/score.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace strobe::studies::digitize;
using strobe::reduction::BallImage;
using strobe::reduction::Frame;
using strobe::reduction::Leg;

namespace {

TrueImage true_at(double x, double y, Leg leg = Leg::incoming) {
  TrueImage image;
  image.leg = leg;
  image.centre_px = {x, y};
  image.diameter_px = 260.0;
  return image;
}

BallImage found_at(double x, double y) {
  BallImage image;
  image.centre_px = {x, y};
  image.diameter_px = 260.0;
  return image;
}

}  // namespace

TEST_GROUP(DigitizeScore){};

TEST(DigitizeScore, CountsWhatIsFoundMissedAndInvented) {
  Frame frame;
  frame.images = {found_at(100.5, 500.0), found_at(900.0, 900.0)};
  const Score s = score({true_at(100, 500), true_at(300, 400)}, frame);
  LONGS_EQUAL(2, s.airborne);
  LONGS_EQUAL(1, s.found);
  LONGS_EQUAL(1, s.invented);
  DOUBLES_EQUAL(0.5, s.x_px.rms(), 1e-12);
}

TEST(DigitizeScore, HoldsTheSurfaceAgainstTheTrueLine) {
  Frame frame;
  frame.surface_px = {{0.0, 10.1}, {100.0, 11.3}, {200.0, 12.2}, {300.0, 13.2}};
  frame.surface_sd_px = 0.4;
  Score s;
  score_surface({{-100.0, 9.0}, {400.0, 14.0}}, frame, s);
  DOUBLES_EQUAL(0.2, s.surface_px.bias(), 1e-12);
  DOUBLES_EQUAL(1.0, s.surface_px.normalized(), 1e-12);
  score_surface({}, frame, s);
  LONGS_EQUAL(1, s.surface_px.count);
}

TEST(DigitizeScore, SeesTheSurfaceFromTheBalls) {
  Frame frame;
  frame.surface_px = {{0.0, 10.0}, {100.0, 10.0}};
  frame.images = {found_at(100.0, 500.0)};
  frame.images[0].diameter_px += 0.4;
  Score s = score({true_at(100, 500)}, frame);
  score_surface({{0.0, 10.0}, {100.0, 10.0}}, frame, s);
  // The ball's lowest point is .2 px too low.
  DOUBLES_EQUAL(0.2, s.surface_px.bias(), 1e-12);
}

TEST(DigitizeScore, ASecondImageOfTheSameOneIsInvented) {
  Frame frame;
  frame.images = {found_at(103.0, 500.0), found_at(100.0, 500.0)};
  const Score s = score({true_at(100, 500)}, frame);
  LONGS_EQUAL(1, s.invented);
  DOUBLES_EQUAL(0.0, s.x_px.rms(), 1e-12);  // the nearer one is it
}

TEST(DigitizeScore, AnImageCutByTheBorderIsNeitherMissedNorInvented) {
  TrueImage cut = true_at(100, 500);
  cut.whole = false;
  Frame frame;
  LONGS_EQUAL(0, score({cut}, frame).airborne);
  frame.images = {found_at(101.0, 500.0)};
  LONGS_EQUAL(0, score({cut}, frame).invented);
  LONGS_EQUAL(0, score({cut}, frame).x_px.count);
}

TEST(DigitizeScore, LinesAreTheSameAfterHalfATurn) {
  TrueImage truth = true_at(100, 500);
  truth.equator_rad = 0.01;
  Frame frame;
  frame.images = {found_at(100.0, 500.0)};
  frame.images[0].equator_rad = std::numbers::pi - 0.01;
  frame.images[0].equator_sd_rad = 0.01;
  truth.equator_tilt_rad = -0.5;
  frame.images[0].equator_tilt_rad = 0.52;  // of the opposite direction
  frame.images[0].equator_tilt_sd_rad = 0.01;
  const Score s = score({truth}, frame);
  DOUBLES_EQUAL(0.02, s.equator_rad.rms(), 1e-12);
  DOUBLES_EQUAL(2.0, s.equator_rad.normalized(), 1e-12);
  DOUBLES_EQUAL(0.02, s.tilt_rad.bias(), 1e-12);
  DOUBLES_EQUAL(2.0, s.tilt_rad.normalized(), 1e-12);
}

TEST(DigitizeScore, TheCentresErrorIsNormalizedByItsWholeCovariance) {
  // Errors of one sd along each of the ellipse's axes, at 45 degrees: a squared distance of 2, halved.
  Frame frame;
  frame.images = {found_at(100.0 + (2.0 - 1.0) / std::sqrt(2.0), 500.0 + (2.0 + 1.0) / std::sqrt(2.0))};
  frame.images[0].centre_cov_px2 = {2.5, 1.5, 1.5, 2.5};  // variances 4 along (1, 1), 1 across
  DOUBLES_EQUAL(1.0, score({true_at(100, 500)}, frame).mahalanobis.normalized(), 1e-12);
}

TEST(DigitizeScore, OfContactImagesTheTopAndTheWidthCount) {
  TrueImage truth = true_at(100, 500, Leg::contact);
  truth.top_px = {100.0, 620.0};
  truth.contact_width_px = 80.0;
  Frame frame;
  frame.images = {found_at(110.0, 540.0)};
  frame.images[0].top_px = {104.0, 620.3};
  frame.images[0].contact_width_px = 81.0;
  const Score s = score({truth}, frame);
  LONGS_EQUAL(1, s.contact_found);
  DOUBLES_EQUAL(0.3, s.top_px.rms(), 1e-9);
  DOUBLES_EQUAL(1.0, s.contact_width_px.rms(), 1e-12);
  LONGS_EQUAL(0, s.x_px.count);
}

TEST(DigitizeScore, AMissedImageIsToldWhereItWasSaidToBeUnmeasurable) {
  const std::vector<TrueImage> truth{true_at(100, 500), true_at(800, 500), true_at(1500, 500)};
  const Score s = score(truth, Frame{},
                        {{{120.0, 510.0}, "image"}, {{810.0, 500.0}, "equator"}, {{1600.0, 500.0}, "image"}});
  LONGS_EQUAL(3, s.airborne - s.found);
  LONGS_EQUAL(1, s.reported);
}

TEST(DigitizeScore, AMissedLineIsToldWhereItWasSaidToBeUnmeasurable) {
  TrueImage first = true_at(100, 500), second = true_at(800, 500);
  first.equator_rad = second.equator_rad = 0.3;
  Frame frame;
  frame.images = {found_at(100.0, 500.0), found_at(800.0, 500.0)};
  const Score s = score({first, second}, frame, {{{800.0, 500.0}, "equator"}});
  LONGS_EQUAL(2, s.lines);
  LONGS_EQUAL(0, s.lines_found);
  LONGS_EQUAL(1, s.lines_reported);
}

TEST(DigitizeScore, WildErrorsAreThoseFarBeyondTheirStatedSd) {
  Frame frame;
  frame.images = {found_at(100.0, 500.0), found_at(800.0, 500.0)};
  frame.images[0].diameter_px = 261.0;
  frame.images[0].diameter_sd_px = 0.1;
  frame.images[1].diameter_px = 261.0;
  frame.images[1].diameter_sd_px = 0.5;
  const Score s = score({true_at(100, 500), true_at(800, 500)}, frame);
  LONGS_EQUAL(1, s.diameter_px.wild);
  LONGS_EQUAL(1, s.wild());
}

TEST(DigitizeScore, TimesAreHeldAgainstEachOtherSinceTheFirstFlashCannotBeKnown) {
  const std::vector<TrueImage> truth{true_at(100, 500), true_at(800, 500), true_at(1500, 500)};
  Frame frame;
  frame.images = {found_at(100.0, 500.0), found_at(800.0, 500.0), found_at(1500.0, 500.0)};
  const double late_s = 0.006;
  frame.images[0].time_s = late_s;
  frame.images[1].time_s = 0.003 + late_s;
  frame.images[2].time_s = 0.009 + late_s;
  TimeCount times = count_times(truth, {0.0, 0.003, 0.009}, frame);
  LONGS_EQUAL(3, times.measured);
  LONGS_EQUAL(0, times.wrong);
  frame.images[2].time_s = 0.006 + late_s;
  times = count_times(truth, {0.0, 0.003, 0.009}, frame);
  LONGS_EQUAL(1, times.wrong);
}
