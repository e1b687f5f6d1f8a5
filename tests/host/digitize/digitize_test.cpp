// The whole digitizer on small painted photographs: what comes out is held against what was painted.
#include "host/digitize/digitize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/reduction/reduce.hpp"
#include "tests/host/digitize/painter.hpp"
#include "tests/support/recorded.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
namespace painter = strobe::testing;
using digitize::DigitizeSettings;
using digitize::Effort;
using reduction::Leg;

constexpr double kDiameter_px = 96.0;
constexpr double kBall_m = 0.0651;
constexpr int kHeight = 420;
constexpr double kPlateRow = 360.5;

struct Placed {
  cv::Point2d centre;  // plane px
  Leg leg;
};

/// Five images down, one pressed flat, five up; to the right.
std::vector<Placed> bounce() {
  std::vector<Placed> images;
  const double surface = kHeight - 1 - kPlateRow;
  for (int k = 5; k >= 1; --k)
    images.push_back({{400.0 - 75.3 * k + 20.0, surface + 10.0 + 44.7 * k}, Leg::incoming});
  images.push_back({{408.0, surface + 39.0}, Leg::contact});
  for (int k = 1; k <= 5; ++k)
    images.push_back({{396.0 + 60.4 * k, surface + 32.0 + 35.2 * k}, Leg::rebound});
  return images;
}

painter::Painting picture(const std::vector<Placed>& images) {
  std::mt19937_64 random(11);
  painter::Painting painting;
  painting.width = 760;
  painting.height = kHeight;
  painting.bits = 16;
  painting.background = 0.04;
  painting.plate_row = kPlateRow;
  painting.plate = 0.5;
  painting.seed = 4;
  painter::PaintedBall look = painter::random_ball(random, {}, kDiameter_px);
  look.light = 0.2;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const cv::Point2d at(images[i].centre.x, kHeight - 1 - images[i].centre.y);
    look = painter::next_image(look, at, 0.13);
    look.floor_row = kPlateRow;
    painting.balls.push_back(look);
  }
  return painting;
}

DigitizeSettings settings() {
  DigitizeSettings s;
  s.ball_diameter_m = kBall_m;
  s.px_per_m = 1.02 * kDiameter_px / kBall_m;  // known to some per cent
  return s;
}

/// A camera that stands a little aside, with a lens that bends straight lines: plane px of a bounce() from
/// image px.
digitize::PlaneMap bent_map() {
  digitize::LensDistortion lens;
  lens.centre_px = {375.0, 215.0};
  lens.focal_px = 400.0;
  lens.k1 = -0.03;
  lens.p1 = 0.001;
  // At most 4 % of the scale and 2 degrees.
  const cv::Matx33d rectify(1.02, 0.02, -6.0, 0.015, -1.01, kHeight + 2.0, 2e-5, -3e-5, 1.0);
  return digitize::PlaneMap::calibrated(lens, rectify, std::nullopt);
}

/// The photograph as that camera would have taken it.
digitize::Photograph taken_through(const digitize::PlaneMap& map, const digitize::Photograph& straight) {
  cv::Mat from(straight.intensity.size(), CV_32FC2);
  for (int row = 0; row < from.rows; ++row) {
    for (int column = 0; column < from.cols; ++column) {
      const cv::Point2d plane = map.to_plane({static_cast<double>(column), static_cast<double>(row)});
      from.at<cv::Vec2f>(row, column) = {static_cast<float>(plane.x),
                                         static_cast<float>(kHeight - 1 - plane.y)};
    }
  }
  digitize::Photograph photograph = straight;
  photograph.intensity = cv::Mat();
  cv::remap(straight.intensity, photograph.intensity, from, cv::Mat(), cv::INTER_LANCZOS4,
            cv::BORDER_REPLICATE);
  return photograph;
}

/// All that was measured, a line for each thing: px, thousandths of px², mrad.
std::string in_words(const digitize::Digitization& d) {
  std::string words;
  for (const auto& p : d.frame.surface_px) words += fmt::format("surface {:.6f} {:.6f}\n", p.x, p.y);
  words += fmt::format("surface sd {:.6f}\n", d.frame.surface_sd_px.value_or(-1.0));
  for (std::size_t i = 0; i < d.frame.images.size(); ++i) {
    const auto& image = d.frame.images[i];
    const auto& o = d.outlines[i];
    const auto top = image.top_px.value_or(reduction::PointPx{-1.0, -1.0});
    const auto& cov = *image.centre_cov_px2;
    words += fmt::format("image leg {} flash {} centre {:.6f} {:.6f} cov {:.6f} {:.6f} {:.6f}",
                         image.leg ? static_cast<int>(*image.leg) : -1, image.flash_index.value_or(-1),
                         image.centre_px.x, image.centre_px.y, 1e3 * cov[0], 1e3 * cov[1], 1e3 * cov[3]);
    words += fmt::format(" diameter {:.6f} sd {:.6f} equator {:.6f} sd {:.6f}", image.diameter_px,
                         *image.diameter_sd_px, 1e3 * image.equator_rad.value_or(-1.0),
                         1e3 * image.equator_sd_rad.value_or(-1.0));
    words +=
        fmt::format(" top {:.6f} {:.6f} width {:.6f}", top.x, top.y, image.contact_width_px.value_or(-1.0));
    words += fmt::format(" visible {:.6f} of {} arcs rms {:.6f} blur {:.6f}\n", o.visible_fraction,
                         o.visible_arcs.size(), o.rms_px, o.blur_px);
  }
  for (const auto& u : d.unmeasured)
    words += fmt::format("no {} {:.6f} {:.6f} diameter {:.6f} {} {}\n", u.what, u.centre.x, u.centre.y,
                         u.diameter, digitize::name(u.why.reason), u.why.detail);
  for (const std::string& remark : d.remarks) words += "remark " + remark + "\n";
  return words;
}

}  // namespace

TEST_GROUP(Digitize){};

TEST(Digitize, FindsAllImagesOfABounceInOrderWithTheSurface) {
  const auto placed = bounce();
  const auto photograph = painter::paint(picture(placed));
  DigitizeSettings s = settings();
  std::vector<double> times;
  for (int k = 0; k < 30; ++k) times.push_back(3e-3 * k);
  s.flash_times_s = times;
  const auto result = digitize::digitize(photograph, s);
  CHECK_TRUE(result.has_value());
  const auto& frame = result->frame;
  LONGS_EQUAL(placed.size(), frame.images.size());
  for (std::size_t i = 0; i < placed.size(); ++i) {
    CHECK_EQUAL(placed[i].leg, frame.images[i].leg);
    // Half a per cent of the diameter: far below the distance of images, far above the fit's error.
    DOUBLES_EQUAL(placed[i].centre.x, frame.images[i].centre_px.x, 0.5);
    DOUBLES_EQUAL(placed[i].centre.y, frame.images[i].centre_px.y, 0.5);
    DOUBLES_EQUAL(kDiameter_px, frame.images[i].diameter_px, 1.0);
    CHECK_TRUE(frame.images[i].centre_cov_px2.has_value());
    CHECK_EQUAL("auto", frame.images[i].source);
    if (i > 0) DOUBLES_EQUAL(3e-3, frame.images[i].time_s - frame.images[i - 1].time_s, 1e-9);
  }
  LONGS_EQUAL(result->outlines.size(), frame.images.size());
  CHECK_TRUE(frame.images[5].top_px.has_value());
  CHECK_TRUE(frame.surface_px.size() >= 2);
  const double surface = kHeight - 1 - kPlateRow;
  for (const auto& p : frame.surface_px) DOUBLES_EQUAL(surface, p.y, 0.1);
}

TEST(Digitize, GivesAFrameThatCanBeReduced) {
  DigitizeSettings s = settings();
  std::vector<double> times;
  for (int k = 0; k < 30; ++k) times.push_back(3e-3 * k);
  s.flash_times_s = times;
  const auto result = digitize::digitize(painter::paint(picture(bounce())), s);
  CHECK_TRUE(result.has_value());
  const auto readout = reduction::reduce(result->frame, reduction::Estimator::best);
  CHECK_TRUE(readout.has_value());
  // 75.3 px of 96 px a ball of 65.1 mm in 3 ms.
  DOUBLES_EQUAL(75.3 / kDiameter_px * kBall_m / 3e-3, *readout->value[reduction::Quantity::vx_td_mps], 0.2);
}

TEST(Digitize, TakesNoEdgeForASurfaceThatTheBallFliesOnThrough) {
  // A stroke from a tee: the first image reaches 12 px below the edge of the lawn behind it.
  const double edge = kHeight - 1 - kPlateRow;
  std::vector<Placed> images;
  for (int k = 0; k < 6; ++k) images.push_back({{90.0 + 100.3 * k, edge + 36.0 + 44.7 * k}, Leg::rebound});
  painter::Painting painting = picture(images);
  for (auto& ball : painting.balls) ball.floor_row.reset();
  const digitize::Photograph photograph = painter::paint(painting);
  DigitizeSettings s = settings();
  s.flash_times_s = std::vector<double>{0.0, 0.003, 0.006, 0.009, 0.012, 0.015};
  const auto flight = digitize::digitize(photograph, s);
  CHECK(flight && flight->no_surface);
  CHECK(flight->frame.surface_px.empty());
  CHECK_EQUAL(6U, flight->frame.images.size());
  for (const auto& image : flight->frame.images) CHECK(!image.leg && !image.top_px);
  const auto readout = reduction::reduce(flight->frame, reduction::Estimator::best);
  CHECK(readout && readout->launch);
  // Steps of 109.8 px in 3 ms at 1475 px/m; half a per cent for gravity, which is not painted, and the ball's size.
  const double speed = std::hypot(100.3, 44.7) / 3e-3 / (kDiameter_px / kBall_m);
  DOUBLES_EQUAL(speed, *readout->launch->value[reduction::Quantity::v_td_mps], 0.005 * speed);
  // A surface that was given is one, whatever the path.
  s.surface = digitize::SurfaceLine{{{0.0, edge}, {759.0, edge}}, 0.3};
  const auto given = digitize::digitize(photograph, s);
  CHECK(given && given->frame.images.front().leg == Leg::contact);
}

TEST(Digitize, TakesNoEdgeForASurfaceThatLeavesOneOfTwoLegs) {
  // The ball bounces well above the edge, on something that does not show.
  std::vector<Placed> images;
  for (Placed image : bounce()) {
    image.centre.y += 60.0;
    if (image.leg != Leg::contact) images.push_back(image);
  }
  const auto found = digitize::digitize(painter::paint(picture(images)), settings());
  CHECK(found && found->no_surface);
  LONGS_EQUAL(10, found->frame.images.size());
}

TEST(Digitize, SaysThatAPhotographOfACameraOnItsSideIsNotTurned) {
  digitize::Photograph photograph = painter::paint(picture(bounce()));
  const auto upright = digitize::digitize(photograph, settings());
  photograph.orientation = 6;
  const auto turned = digitize::digitize(photograph, settings());
  CHECK_TRUE(upright.has_value() && turned.has_value());
  LONGS_EQUAL(upright->remarks.size() + 1, turned->remarks.size());
  STRCMP_CONTAINS("EXIF orientation 6", turned->remarks.back().c_str());
}

TEST(Digitize, UndoesTheLensAndTheCamerasTilt) {
  const auto placed = bounce();
  DigitizeSettings s = settings();
  s.map = bent_map();
  const auto result = digitize::digitize(taken_through(s.map, painter::paint(picture(placed))), s);
  CHECK_TRUE(result.has_value());
  const auto& frame = result->frame;
  LONGS_EQUAL(placed.size(), frame.images.size());
  for (std::size_t i = 0; i < placed.size(); ++i) {
    // As of a photograph taken straight on; the map alone moves centres by up to 20 px.
    DOUBLES_EQUAL(placed[i].centre.x, frame.images[i].centre_px.x, 0.5);
    DOUBLES_EQUAL(placed[i].centre.y, frame.images[i].centre_px.y, 0.5);
    DOUBLES_EQUAL(kDiameter_px, frame.images[i].diameter_px, 1.0);
  }
  const double surface = kHeight - 1 - kPlateRow;
  for (const auto& p : frame.surface_px) DOUBLES_EQUAL(surface, p.y, 0.3);
}

TEST(Digitize, OfAShotToTheLeftIsInOrderAndSaysTrulyWhereACutImageIs) {
  auto placed = bounce();
  for (Placed& image : placed) image.centre.x = 760.0 - 1.0 - image.centre.x;
  // The first is cut through its middle.
  placed.front().centre += cv::Point2d(44.0, 26.0);
  const auto result = digitize::digitize(painter::paint(picture(placed)), settings());
  CHECK_TRUE(result.has_value());
  const auto& images = result->frame.images;
  CHECK_TRUE(images.size() == placed.size() || images.size() + 1 == placed.size());
  const std::size_t cut = placed.size() - images.size();
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Placed& truth = placed[i + cut];
    CHECK_EQUAL(truth.leg, images[i].leg);
    const auto& cov = *images[i].centre_cov_px2;
    // Five sds, and what the tests above allow for little.
    DOUBLES_EQUAL(truth.centre.x, images[i].centre_px.x, 5.0 * std::sqrt(cov[0]) + 0.3);
    DOUBLES_EQUAL(truth.centre.y, images[i].centre_px.y, 5.0 * std::sqrt(cov[3]) + 0.3);
  }
}

TEST(Digitize, FindsTheOverlappingImagesOfASmallBallAndSaysThatItIs) {
  constexpr double kSmaller = 16.0 / kDiameter_px;
  std::vector<Placed> placed = bounce();
  // Upwards .55 of a diameter apart.
  for (std::size_t k = 6; k < placed.size(); ++k)
    placed[k].centre -= 0.2 * (placed[k].centre - placed[6].centre);
  painter::Painting painting = picture(placed);
  painting.width = static_cast<int>(kSmaller * painting.width);
  painting.height = static_cast<int>(kSmaller * painting.height);
  // Pixels' centres are at integers.
  const auto smaller = [](double at) { return kSmaller * (at + 0.5) - 0.5; };
  painting.plate_row = smaller(kPlateRow);
  for (auto& ball : painting.balls) {
    ball.centre = {smaller(ball.centre.x), smaller(ball.centre.y)};
    ball.diameter_px *= kSmaller;
    ball.grain_px *= kSmaller;
    ball.seam_width_px *= kSmaller;
    ball.floor_row = *painting.plate_row;
    if (ball.line) ball.line->width_px *= kSmaller;
  }
  DigitizeSettings s = settings();
  s.px_per_m = kSmaller * kDiameter_px / kBall_m;
  const auto result = digitize::digitize(painter::paint(painting), s);
  CHECK_TRUE(result.has_value());
  CHECK_TRUE(std::ranges::any_of(result->remarks, [](const std::string& remark) {
    return remark.find("a ball 16 px wide is small") != std::string::npos;
  }));
  int found = 0;
  for (const auto& image : result->frame.images) {
    for (const auto& ball : painting.balls) {
      const double off = std::hypot(image.centre_px.x - ball.centre.x,
                                    image.centre_px.y - (painting.height - 1 - ball.centre.y));
      // Five times what noise and texture make of such a ball's centre, .15 px in the study.
      if (off < 0.75) ++found;
    }
  }
  // The one that is pressed flat is not round.
  CHECK_TRUE(found >= 10);
  CHECK_TRUE(result->frame.images.size() <= placed.size());
}

TEST(Digitize, WithoutFlashTimesMakesNoneUp) {
  const auto result = digitize::digitize(painter::paint(picture(bounce())), settings());
  CHECK_TRUE(result.has_value());
  for (const auto& image : result->frame.images) {
    CHECK_TRUE(std::isnan(image.time_s));
    CHECK_FALSE(image.flash_index.has_value());
  }
}

TEST(Digitize, OfAnEmptyPlateIsAResultWithoutImages) {
  const auto result = digitize::digitize(painter::paint(picture({})), settings());
  CHECK_TRUE(result.has_value());
  LONGS_EQUAL(0, result->frame.images.size());
}

TEST(Digitize, WithoutAScaleFindsTheBallsSizeAndSaysHowSure) {
  const auto photograph = painter::paint(picture(bounce()));
  const auto given = digitize::digitize(photograph, settings());
  DigitizeSettings s = settings();
  s.px_per_m.reset();
  const auto found = digitize::digitize(photograph, s);
  CHECK_TRUE(found.has_value());
  LONGS_EQUAL(given->frame.images.size(), found->frame.images.size());
  CHECK_TRUE(found->scale.has_value());
  // The scale is not measured apart from the diameters: readers of the frame must not count it twice.
  CHECK_FALSE(found->frame.px_per_m.has_value());
  LONGS_EQUAL(found->frame.images.size(), found->scale->images);
  DOUBLES_EQUAL(kDiameter_px, found->scale->diameter_px, 5.0 * found->scale->diameter_sd_px);
  CHECK_TRUE(found->scale->diameter_sd_px < 0.01 * kDiameter_px);
  CHECK_TRUE(found->frame.shared_diameter_sd_px > 0.0);
  CHECK_TRUE(found->frame.shared_diameter_sd_px < found->scale->diameter_sd_px);
  DOUBLES_EQUAL(found->scale->diameter_px / kBall_m, found->scale->px_per_m, 1e-9);
}

TEST(Digitize, TheScalesSdHasTheBallsTolerance) {
  DigitizeSettings s = settings();
  s.ball_diameter_sd_m = 0.01 * kBall_m;
  const auto scale = digitize::digitize(painter::paint(picture(bounce())), s)->scale;
  CHECK_TRUE(scale->px_per_m_sd > 0.01 * scale->px_per_m);
}

TEST(Digitize, OfAWrongScaleSaysWhichSizeTheBallsHaveAndMeasuresNothing) {
  DigitizeSettings s = settings();
  for (const double factor : {0.7, 1.35}) {
    s.px_per_m = factor * kDiameter_px / kBall_m;
    const auto result = digitize::digitize(painter::paint(picture(bounce())), s);
    LONGS_EQUAL(0, result->frame.images.size());
    CHECK_TRUE(std::ranges::any_of(result->remarks, [](const std::string& remark) {
      return remark.starts_with("the photograph's balls are about 9") &&
             remark.ends_with("nothing was measured");
    }));
  }
}

TEST(Digitize, RefusesSettingsOutOfRangeByName) {
  const auto photograph = painter::paint(picture({}));
  DigitizeSettings s = settings();
  s.px_per_m = std::nan("");
  STRCMP_CONTAINS("px_per_m", digitize::digitize(photograph, s).error().message.c_str());
  s = settings();
  s.flash_times_s = std::vector<double>{0.0, 0.0};
  STRCMP_CONTAINS("flash_times_s[1]", digitize::digitize(photograph, s).error().message.c_str());
}

TEST(Digitize, IsTheSameForAnyNumberOfThreads) {
  const auto photograph = painter::paint(picture(bounce()));
  DigitizeSettings s = settings();
  s.effort = Effort::fast;
  const auto several = digitize::digitize(photograph, s);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const auto one = digitize::digitize(photograph, s);
  cv::setNumThreads(threads);
  LONGS_EQUAL(several->frame.images.size(), one->frame.images.size());
  for (std::size_t i = 0; i < one->frame.images.size(); ++i) {
    CHECK_EQUAL(several->frame.images[i].centre_px.x, one->frame.images[i].centre_px.x);
    CHECK_EQUAL(several->frame.images[i].diameter_px, one->frame.images[i].diameter_px);
    CHECK_EQUAL(several->frame.images[i].equator_rad, one->frame.images[i].equator_rad);
  }
}

// What the other tests' tolerances let pass: on record are the numbers of scenes between them seen by every stage.
// Rounding changes them by less than 1e-6; a hundredth of the least sd is 2e-4 px.
TEST(Digitize, GivesTheNumbersOnRecord) {
  std::string found;
  const auto add = [&found](const char* name, const painter::Painting& painting, const DigitizeSettings& s,
                            const digitize::PlaneMap* through = nullptr) {
    const auto photograph = painter::paint(painting);
    const auto result = digitize::digitize(through ? taken_through(*through, photograph) : photograph, s);
    CHECK_TRUE(result.has_value());
    found += fmt::format("# {}\n{}", name, in_words(*result));
  };
  std::vector<double> times;
  for (int k = 0; k < 14; ++k) times.push_back(3e-3 * k);

  DigitizeSettings s = settings();
  s.flash_times_s = times;
  add("bounce", picture(bounce()), s);

  painter::Painting bright = picture(bounce());
  bright.bits = 8;
  bright.blur_px = 1.7;
  for (auto& ball : bright.balls) {
    ball.centre.x = 759.0 - ball.centre.x;
    ball.light = 0.75;
  }
  s = settings();
  s.effort = Effort::fast;
  add("to the left, bright and blurred, fast", bright, s);

  painter::Painting uneven = picture(bounce());
  uneven.bits = 12;
  uneven.background_slope_px = {4e-4, -6e-4};
  uneven.vignetting = 0.3;
  uneven.electrons = 4000.0;
  for (auto& ball : uneven.balls) ball.fuzz_px = 0.5;
  s = settings();
  s.map = bent_map();
  s.effort = Effort::thorough;
  add("uneven light through a bent lens, thorough", uneven, s, &s.map);

  // Images that overlap and are cut off, a round thing that is no ball, no plate.
  std::vector<Placed> close;
  for (int k = 0; k < 9; ++k)
    close.push_back({{20.0 + 70.0 * k + 2.0 * k * k, 330.0 - 25.0 * k}, Leg::incoming});
  painter::Painting crowd = picture(close);
  crowd.plate_row.reset();
  for (auto& ball : crowd.balls) ball.floor_row.reset();
  painter::PaintedBall other = crowd.balls.front();
  other.centre = {500.0, 350.0};
  other.diameter_px = 101.0;
  crowd.balls.push_back(other);
  s = settings();
  s.flash_times_s = times;
  add("close together, without a plate", crowd, s);

  // Without AVX a centre differs by 1e-4 px and a variance by 2e-3.
  STRCMP_EQUAL("", painter::difference_from_record("digitizations", found, 5e-3).c_str());
}
