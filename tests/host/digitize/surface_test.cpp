#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "host/digitize/surface/edge_refinement.hpp"
#include "host/digitize/surface/surface_line.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::digitize;

constexpr int kWidth = 600, kHeight = 300;

/// Light rises at each of these rows, softly, on a picture with a little noise; by less at the first, if
/// asked.
Photograph stepped(const std::vector<double>& rows, double slope = 0.0, double first = 1.0) {
  Photograph photograph;
  photograph.intensity.create(kHeight, kWidth, CV_32FC1);
  cv::RNG random(3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double light = 0.05 + random.gaussian(0.002), rise = 0.1 * first;
      for (const double row : rows) {
        light += rise * std::erfc(-(y - row - slope * (x - 300)) / 1.5);
        rise = 0.1;
      }
      photograph.intensity.at<float>(y, x) = static_cast<float>(light);
    }
  }
  return photograph;
}

/// Scratches of many lengths on the plate, up to the edge at `row`, on what stepped() paints at a slope of .013.
Photograph uneven(Photograph photograph, double row, std::uint64_t seed) {
  cv::RNG random(seed);
  for (int scratch = 0; scratch < 40; ++scratch) {
    const int from = random.uniform(0, kWidth), length = random.uniform(3, 25);
    const double lighter = random.gaussian(0.1), deep = random.uniform(0.0, 4.0);
    for (int x = from; x < std::min(kWidth, from + length); ++x) {
      const int top = static_cast<int>(std::ceil(row + 0.013 * (x - 300) + deep));
      for (int y = top; y < std::min(kHeight, top + 6); ++y)
        photograph.intensity.at<float>(y, x) += static_cast<float>(lighter);
    }
  }
  return photograph;
}

Outline ball_at(double x, double y) {
  Outline outline;
  outline.centre = {x, y};
  outline.diameter = 60.0;
  return outline;
}

Measured<SurfaceLine> found(const Photograph& photograph,
                            const PlaneMap& map = PlaneMap::uncalibrated(kHeight)) {
  const std::vector<Outline> outlines{ball_at(150.0, 180.0), ball_at(300.0, 102.0), ball_at(420.0, 160.0)};
  return find_surface_line(photograph, map, outlines);
}

/// A lens 600 px from the balls, so far above that row.
PlaneMap seen_from(double above_px, double row) {
  const cv::Matx33d upright(1.0, 0.0, 0.0, 0.0, -1.0, kHeight - 1.0, 0.0, 0.0, 1.0);
  return PlaneMap::calibrated({}, upright, Viewpoint{{300.0, kHeight - 1.0 - row + above_px}, 600.0});
}

double height_above(const SurfaceLine& line, const Eigen::Vector2d& point) {
  return surface_frame(line).from_image(point).y();
}

}  // namespace

TEST_GROUP(SurfaceLine){};

TEST(SurfaceLine, OfAPlateSeenEdgeOnIsItsEdge) {
  const auto line = found(stepped({220.3}, 0.01));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
  CHECK_TRUE(height_sd_px(*line) < 0.15);
}

TEST(SurfaceLine, OfASaturatedPlateLiesWhereItsEdgeIsAndNotWhereTheLightIsCutOff) {
  // Twice and four times as light as what saturates: the steepest rise of what is left lies .3 and .8 px too high.
  for (const double share : {2.0, 4.0}) {
    Photograph photograph = stepped({220.3}, 0.01, share * 5.0);
    cv::min(photograph.intensity, 1.0, photograph.intensity);
    const auto line = found(photograph);
    CHECK_TRUE(line.has_value());
    const double off = height_above(*line, {300.0, kHeight - 1 - 220.3});
    DOUBLES_EQUAL(0.0, off, 0.15);
    // What the lens's tails leave unknown is said.
    CHECK_TRUE(std::abs(off) < 4.0 * height_sd_px(*line));
  }
}

TEST(SurfaceLine, IsAsFarFromTheTruthAsItsSdSays) {
  // Errors over sds of 60 pictures with uneven plates: the rms of as many numbers errs by 1/sqrt(120) = 9 %, and the
  // sds themselves, of 8 and 24 blocks, by a tenth: 3 such sds are .4.
  double squares = 0.0;
  constexpr int kPictures = 60;
  for (int k = 0; k < kPictures; ++k) {
    const double row = 218.0 + 0.05 * k;
    const auto line = found(uneven(stepped({row}, 0.013), row, static_cast<std::uint64_t>(k) + 7));
    CHECK_TRUE(line.has_value());
    // Of four points, the mean's variance is a quarter of one's.
    squares += std::pow(height_above(*line, {300.0, kHeight - 1 - row}) / (0.5 * line->sd_px), 2);
  }
  DOUBLES_EQUAL(1.0, std::sqrt(squares / kPictures), 0.4);
}

TEST(SurfaceLine, IsSeenFromTheBallsAsFarAsAllOfThemAreOffAlike) {
  const Photograph photograph = stepped({220.3}, 0.01);
  std::vector<Outline> outlines{ball_at(150.0, 180.0), ball_at(300.0, 102.0), ball_at(420.0, 160.0)};
  const auto sd_px = [&] {
    return 0.5 * find_surface_line(photograph, PlaneMap::uncalibrated(kHeight), outlines)->sd_px;
  };
  const double without = sd_px();
  for (Outline& o : outlines) o.covariance(1, 1) = 0.09;
  // What each ball is off by itself averages out: a third of the variance is left.
  DOUBLES_EQUAL(std::hypot(without, 0.3 / std::sqrt(3.0)), sd_px(), 1e-9);
  for (Outline& o : outlines) {
    o.shared_diameter_sd_px = 0.8;
    o.covariance(2, 2) += 0.8 * 0.8;
  }
  DOUBLES_EQUAL(std::hypot(without, 0.3 / std::sqrt(3.0), 0.4), sd_px(), 1e-9);
}

TEST(SurfaceLine, OfAPlateSeenFromAboveLiesBetweenItsEdgesAndSaysSo) {
  const auto line = found(stepped({212.0, 236.0}));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(24.0, line->edge_separation_px, 0.2);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 224.0}), 0.2);
  // Anywhere between them alike: 24 px/sqrt(12) = 6.9; of four points as if of three: 8.
  CHECK_TRUE(height_sd_px(*line) > 6.8 && height_sd_px(*line) < 8.1);
}

TEST(SurfaceLine, OfASaturatedPlateSeenFromAboveIsAsUncertainAsItsNearEdgeIsHidden) {
  constexpr double kFar = 212.0;
  Photograph photograph = stepped({kFar}, 0.0, 15.0);
  cv::min(photograph.intensity, 1.0, photograph.intensity);
  const auto line = found(photograph, seen_from(100.0, kFar));
  CHECK_TRUE(line.has_value());
  // Balls 60 px wide bounce in the plane of flight, up to as far before the far edge: with the lens at (0, 100, 600)
  // from the line there, it is seen at 100 - (100 - 0)·600/(600 + z) above the line for an edge z behind.
  for (const double z : {0.0, 20.0, 40.0, 60.0}) {
    const double edge_above = 100.0 - 100.0 * 600.0 / (600.0 + z);
    const double off = height_above(*line, {300.0, kHeight - 1 - kFar - edge_above});
    CHECK(std::abs(off) < 2.0 * height_sd_px(*line));
  }
  // Half as wide a range would be a third of what it may be; all of it, 20 px, is 6 px of a uniform one.
  CHECK(height_sd_px(*line) > 4.0 && height_sd_px(*line) < 8.0);
  // Not from a lens level with the plate or below it, nor where the near edge would show: as one far away sees it.
  const auto sharp = [](const Photograph& seen, double above_px) {
    const auto near = found(seen, seen_from(above_px, kFar)), far = found(seen);
    CHECK_TRUE(near.has_value() && far.has_value());
    DOUBLES_EQUAL(0.0, near->hidden_px, 0.0);
    DOUBLES_EQUAL(far->sd_px, near->sd_px, 1e-9);
    DOUBLES_EQUAL(0.0, height_above(*far, {near->points.front().x, near->points.front().y}), 1e-9);
  };
  // Of one that saturates down to the picture's lower border as much is hidden.
  Photograph cut = photograph;
  cut.intensity = photograph.intensity.rowRange(0, static_cast<int>(kFar) + 12).clone();
  const auto beside_border = found(cut, seen_from(100.0, kFar));
  CHECK_TRUE(beside_border.has_value());
  CHECK(height_sd_px(*beside_border) > 4.0);
  sharp(photograph, 0.0);
  sharp(photograph, -100.0);
  sharp(stepped({kFar}), 100.0);
}

TEST(SurfaceLine, OfAPlateIsNotDrawnToAFaintEdgeOfTheBackground) {
  const auto line = found(stepped({190.0, 220.3}, 0.0, 0.03));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
}

TEST(SurfaceLine, IsNotDrawnToTheTopOfAClampThatBallsReachBelow) {
  // 44 px above the plate; half-way would cut a third of the lower ball off, all of which is seen.
  std::vector<Outline> balls{ball_at(200.0, 112.0), ball_at(400.0, 116.0)};
  for (Outline& ball : balls) ball.visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  const auto line = find_surface_line(stepped({176.3, 220.3}), PlaneMap::uncalibrated(kHeight), balls);
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
}

TEST(SurfaceLine, OfABarFarBelowThePlateIsNotItsOtherEdge) {
  const auto line = found(stepped({212.0, 280.0}));
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, line->edge_separation_px, 0.0);
}

TEST(SurfaceLine, IsNotOneThatBallsAreSeenBelow) {
  // The upper edge is as clear and nearer to the balls, but both reach 20 px below it.
  std::vector<Outline> balls{ball_at(200.0, 160.0), ball_at(400.0, 160.0)};
  for (Outline& ball : balls) ball.visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  const auto lower = find_surface_line(stepped({150.0, 220.3}), PlaneMap::uncalibrated(kHeight), balls);
  CHECK_TRUE(lower.has_value());
  DOUBLES_EQUAL(0.0, height_above(*lower, {300.0, kHeight - 1 - 220.3}), 0.1);
  const auto none = find_surface_line(stepped({150.0}), PlaneMap::uncalibrated(kHeight), balls);
  CHECK_FALSE(none.has_value());
  CHECK_EQUAL(Reason::no_plate, none.error().reason);
}

TEST(SurfaceLine, IsNotVetoedByOneFalseOutlineOfManyBelow) {
  std::vector<Outline> outlines;
  for (int k = 0; k < 7; ++k) outlines.push_back(ball_at(100.0 + 60.0 * k, 112.0 + 20.0 * std::abs(k - 3)));
  outlines.push_back(ball_at(540.0, 70.0));  // a clamp's, astride the edge
  for (Outline& outline : outlines) outline.visible_arcs = {{0.0, 2.0 * std::numbers::pi}};
  const Photograph photograph = stepped({220.3});
  const auto line = find_surface_line(photograph, PlaneMap::uncalibrated(kHeight), outlines);
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
  // Of seven one is too many.
  outlines.erase(outlines.begin());
  CHECK_FALSE(find_surface_line(photograph, PlaneMap::uncalibrated(kHeight), outlines).has_value());
}

TEST(SurfaceLine, MayCutOffWhatIsNotSeenOfABall) {
  // Pressed together by a third of its radius: the outline is seen above the line alone.
  Outline pressed = ball_at(300.0, 98.7);
  pressed.visible_arcs = {{-0.6, std::numbers::pi + 1.2}};
  const auto line =
      find_surface_line(stepped({220.3}), PlaneMap::uncalibrated(kHeight), std::vector<Outline>{pressed});
  CHECK_TRUE(line.has_value());
  DOUBLES_EQUAL(0.0, height_above(*line, {300.0, kHeight - 1 - 220.3}), 0.1);
}

TEST(SurfaceLine, OfNoPlateIsNone) {
  const auto line = found(stepped({}));
  CHECK_FALSE(line.has_value());
  CHECK_EQUAL(Reason::no_plate, line.error().reason);
}

// A flattened ball against the geometry of a circle cut by a line, and its uncertainty against numerical
// derivatives.
namespace {

constexpr double kRadius_px = 130.0;
constexpr double kTilt_rad = 0.06;

/// Two points, so that the line's height is as uncertain as one of them.
SurfaceLine surface(double sd_px) {
  SurfaceLine line;
  const cv::Point2d along(std::cos(kTilt_rad), std::sin(kTilt_rad));
  line.points = {cv::Point2d(500.0, 200.0) - 400.0 * along, cv::Point2d(500.0, 200.0) + 400.0 * along};
  line.sd_px = sd_px;
  return line;
}

cv::Point2d up() { return {-std::sin(kTilt_rad), std::cos(kTilt_rad)}; }

/// `height_px`: of the centre above the surface.
Outline ball(double height_px) {
  Outline outline;
  outline.centre = cv::Point2d(500.0, 200.0) + height_px * up();
  outline.diameter = 2.0 * kRadius_px;
  outline.covariance = cv::Matx33d(0.05, 0.01, -0.02, 0.01, 0.08, 0.03, -0.02, 0.03, 0.12);
  return outline;
}

/// Propagates the outline's covariance through a function by central differences.
double sd_by_differences(const Outline& outline, const std::function<double(const Outline&)>& value) {
  constexpr double kStep = 1e-4;
  cv::Vec3d gradient;
  for (int a = 0; a < 3; ++a) {
    std::array<double, 2> ends{};
    for (const int side : {0, 1}) {
      Outline moved = outline;
      const double by = side == 0 ? -kStep : kStep;
      if (a == 0) moved.centre.x += by;
      if (a == 1) moved.centre.y += by;
      if (a == 2) moved.diameter += by;
      ends[static_cast<std::size_t>(side)] = value(moved);
    }
    gradient[a] = (ends[1] - ends[0]) / (2.0 * kStep);
  }
  return std::sqrt(gradient.dot(outline.covariance * gradient));
}

}  // namespace

TEST_GROUP(ContactImage){};

TEST(ContactImage, HasItsTopARadiusAboveTheCentreAndTheChordsWidth) {
  const auto contact = measure_contact(ball(80.0), surface(0.0));
  CHECK_TRUE(contact.has_value());
  const cv::Point2d top = cv::Point2d(500.0, 200.0) + (80.0 + kRadius_px) * up();
  DOUBLES_EQUAL(top.x, contact->top.x, 1e-9);
  DOUBLES_EQUAL(top.y, contact->top.y, 1e-9);
  DOUBLES_EQUAL(2.0 * std::sqrt(kRadius_px * kRadius_px - 80.0 * 80.0), *contact->width_px, 1e-9);
}

TEST(ContactImage, HasTheSdOfTheGeometry) {
  const SurfaceLine line = surface(0.0);
  const auto contact = measure_contact(ball(80.0), line);
  // Central differences of a smooth function over 1e-4 px err by some 1e-10 relative.
  const double top_sd = sd_by_differences(
      ball(80.0), [&](const Outline& o) { return measure_contact(o, line)->top.dot(up()); });
  const double width_sd = sd_by_differences(ball(80.0), [&](const Outline& o) {
    const double height = (o.centre - cv::Point2d(500.0, 200.0)).dot(up());
    return 2.0 * std::sqrt(0.25 * o.diameter * o.diameter - height * height);
  });
  DOUBLES_EQUAL(top_sd, contact->top_sd_px, 1e-6);
  DOUBLES_EQUAL(width_sd, *contact->width_sd_px, 1e-6);
}

TEST(ContactImage, WidthIsAsUncertainAsTheSurfaceToo) {
  const double without = *measure_contact(ball(80.0), surface(0.0))->width_sd_px;
  const double with = *measure_contact(ball(80.0), surface(1.5))->width_sd_px;
  // d(width)/d(height) of width = 2·sqrt(r² - h²).
  const double slope = 2.0 * 80.0 / std::sqrt(kRadius_px * kRadius_px - 80.0 * 80.0);
  DOUBLES_EQUAL(std::hypot(without, 1.5 * slope), with, 1e-9);
}

TEST(ContactImage, OfABallAboveTheSurfaceHasNoWidth) {
  const auto contact = measure_contact(ball(kRadius_px + 0.5), surface(0.1));
  CHECK_TRUE(contact.has_value());
  CHECK_FALSE(contact->width_px.has_value());
}

TEST(ContactImage, OfAGrazingCutHasNoWidth) {
  // 0.5 px into the surface: half the width is 11 px, and its sd 2·h/half = 23 times that of the height.
  const auto contact = measure_contact(ball(kRadius_px - 0.5), surface(2.0));
  CHECK_TRUE(contact.has_value());
  CHECK_FALSE(contact->width_px.has_value());
}

TEST(ContactImage, OfAnUncertainOutlineIsRejected) {
  Outline outline = ball(80.0);
  outline.covariance = cv::Matx33d::eye() * 200.0;  // sd of the top: sqrt(200·1.25) = 15.8 px of 260
  const auto contact = measure_contact(outline, surface(0.0));
  CHECK_FALSE(contact.has_value());
  CHECK_EQUAL(Reason::imprecise, contact.error().reason);
}

namespace {

constexpr double kNoSaturation = 1e9;

/// 21 pixels of a step of `height` at `at` above a background of .1, by 200 points over each pixel.
std::vector<double> samples(double at, double height, double sd_px) {
  std::vector<double> intensity;
  for (int k = 0; k < 21; ++k) {
    double sum = 0.0;
    for (int i = 0; i < 200; ++i)
      sum += 0.5 * std::erfc(-(k - 0.5 + (i + 0.5) / 200.0 - at) / (sd_px * std::numbers::sqrt2));
    intensity.push_back(0.1 + height * sum / 200.0);
  }
  return intensity;
}

}  // namespace

TEST_GROUP(StepFit){};

TEST(StepFit, FindsTheEdgeBetweenPixels) {
  for (double at = 9.0; at < 11.0; at += 0.13) {
    const auto fit = fit_step(samples(at, 0.5, 0.9), kNoSaturation, 10.0, {Blur::normal, 0.9});
    CHECK_TRUE(fit.has_value());
    // It ends below steps of 1e-3 px, where a quadratically converging fit is off by 1e-6; the points' sum errs by
    // as much.
    DOUBLES_EQUAL(at, fit->at, 1e-4);
    DOUBLES_EQUAL(0.5, fit->step, 1e-3);
  }
}

TEST(StepFit, NeedsNoLightAboveSaturation) {
  for (const double saturation : {0.4, 0.9}) {
    std::vector<double> intensity = samples(10.3, 1.7, 0.9);
    for (double& light : intensity) light = std::min(light, saturation);
    const auto fit = fit_step(intensity, saturation, 9.6, {Blur::normal, 0.9});
    CHECK_TRUE(fit.has_value());
    DOUBLES_EQUAL(10.3, fit->at, 1e-2);
    // Cut off as if it were the whole step, the edge lies at half of what is left.
    const auto cut_off = fit_step(intensity, kNoSaturation, 9.6, {Blur::normal, 0.9});
    CHECK_TRUE(!cut_off || cut_off->at < 10.1);
  }
}

TEST(StepFit, SaysHowMuchNoiseMovesTheEdge) {
  // By the derivative: one sample by a small amount at a time.
  const std::vector<double> exact = samples(10.2, 0.5, 0.9);
  const StepShape shape{Blur::normal, 0.9};
  double squares = 0.0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    std::vector<double> moved = exact;
    moved[k] += 1e-3;
    squares += std::pow((fit_step(moved, kNoSaturation, 10.0, shape)->at - 10.2) / 1e-3, 2);
  }
  // The fit ends within 1e-6 px, 1e-3 of these shifts.
  DOUBLES_EQUAL(1.0, std::sqrt(squares / fit_step(exact, kNoSaturation, 10.0, shape)->variance), 0.02);
}

TEST(StepFit, OfEvenLightOrOfAFallIsNone) {
  const std::vector<double> even(21, 0.3);
  CHECK_FALSE(fit_step(even, kNoSaturation, 10.0, {Blur::normal, 1.0}).has_value());
  std::vector<double> fall = samples(10.0, 0.5, 0.9);
  std::ranges::reverse(fall);
  CHECK_FALSE(fit_step(fall, kNoSaturation, 10.0, {Blur::normal, 0.9}).has_value());
  CHECK_FALSE(fit_step(std::vector<double>(4, 0.3), kNoSaturation, 2.0, {Blur::normal, 1.0}).has_value());
}
