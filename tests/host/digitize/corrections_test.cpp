#include "host/digitize/corrections.hpp"

#include <fmt/format.h>

#include <numbers>

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::digitize;
using strobe::reduction::BallImage;
using strobe::reduction::Leg;

namespace {

constexpr double kPxPerM = 4000.0;
constexpr double kDiameter_px = 260.0;
constexpr int kHeight_px = 1840;
constexpr double kPeriod_s = 0.003;

std::string complaint(const std::string& text) {
  return strobe::testing::error_of(parse_corrections(text, "fix.toml"));
}

std::vector<Correction> parsed(const std::string& text) {
  return parse_corrections(text, "fix.toml").value();
}

DigitizeSettings settings() {
  DigitizeSettings made;
  made.px_per_m = kPxPerM;
  made.map = PlaneMap::uncalibrated(kHeight_px);
  std::vector<double> times_s;
  for (int i = 0; i < 40; ++i) times_s.push_back(i * kPeriod_s);
  made.flash_times_s = times_s;
  return made;
}

/// A ball that comes in steps of 200 px and 80 px down, and leaves slower.
cv::Point2d centre_of(int image) {
  constexpr int kBefore = 4;
  if (image < kBefore) return {400.0 + 200.0 * image, 430.0 + 80.0 * (kBefore - 1 - image)};
  return {1150.0 + 150.0 * (image - kBefore), 460.0 + 65.0 * (image - kBefore)};
}

Digitization digitized() {
  constexpr int kImages = 8;
  Digitization made;
  made.frame.ball_diameter_m = kDiameter_px / kPxPerM;
  made.frame.surface_px = {{100.0, 300.0}, {2700.0, 300.0}};
  made.frame.surface_sd_px = 0.1;
  for (int i = 0; i < kImages; ++i) {
    BallImage image;
    image.time_s = kPeriod_s * i;
    image.leg = i < 4 ? Leg::incoming : Leg::rebound;
    image.centre_px = {centre_of(i).x, centre_of(i).y};
    image.centre_cov_px2 = {0.01, 0.0, 0.0, 0.01};
    image.diameter_px = kDiameter_px;
    image.diameter_sd_px = 0.1;
    image.equator_rad = 0.1 * i;
    image.equator_sd_rad = 0.002;
    image.source = "auto";
    image.probability = 0.75;
    made.frame.images.push_back(image);
    Outline outline;
    outline.centre = centre_of(i);
    outline.diameter = kDiameter_px;
    outline.covariance = cv::Matx33d::eye() * 0.01;
    outline.visible_fraction = 1.0;
    outline.probability = 0.75;
    made.outlines.push_back(outline);
  }
  return made;
}

std::string at(int image) {
  return fmt::format("at_px = [{}, {}]\n", centre_of(image).x + 3.0, centre_of(image).y);
}

Digitization corrected(const std::string& text) {
  Digitization made = digitized();
  const auto applied = apply_corrections(made, parsed(text), settings());
  CHECK_TEXT(applied.has_value(), applied ? "" : applied.error().message.c_str());
  LONGS_EQUAL(made.frame.images.size(), made.outlines.size());
  return made;
}

std::string refusal(const std::string& text) {
  Digitization made = digitized();
  const auto applied = apply_corrections(made, parsed(text), settings());
  LONGS_EQUAL(8, made.frame.images.size());
  for (const BallImage& image : made.frame.images) CHECK_EQUAL("auto", image.source);
  return applied ? "" : applied.error().message;
}

}  // namespace

TEST_GROUP(CorrectionsFile){};

TEST(CorrectionsFile, HoldsWhatIsToBeAddedMovedAndRemoved) {
  const auto read = parsed(
      "[[add]]\ncentre_image_px = [10, 20.5]\nleg = \"contact\"\ncontact_width_px = 40\ntop_px = [10, 9]\n"
      "[[remove]]\nat_px = [1, 2]\n"
      "[[move]]\nat_image_px = [3, 4]\nequator_deg = 90\nequator_sd_deg = 2\n");
  LONGS_EQUAL(3, read.size());
  CHECK_EQUAL(Correction::Kind::remove, read[0].kind);
  DOUBLES_EQUAL(2.0, read[0].at.point.y, 0.0);
  CHECK(!read[0].at.in_image);
  CHECK_EQUAL("fix.toml:6", read[0].location);
  CHECK_EQUAL(Correction::Kind::move, read[1].kind);
  CHECK(read[1].at.in_image);
  DOUBLES_EQUAL(std::numbers::pi / 2, read[1].measured.equator_rad.value(), 1e-15);
  DOUBLES_EQUAL(std::numbers::pi / 90, read[1].measured.equator_sd_rad.value(), 1e-15);
  CHECK_EQUAL(Correction::Kind::add, read[2].kind);
  CHECK(read[2].measured.centre->in_image);
  CHECK_EQUAL(Leg::contact, read[2].measured.leg);
  DOUBLES_EQUAL(9.0, read[2].measured.top->point.y, 0.0);
}

TEST(CorrectionsFile, NamesTheLineAndKeyThatIsWrong) {
  CHECK_EQUAL("fix.toml: no [[add]], [[move]], [[remove]] or [surface]", complaint(""));
  STRCMP_CONTAINS("fix.toml:1: ", complaint("[[remove]]\n").c_str());
  STRCMP_CONTAINS("at_px (or at_image_px) is missing", complaint("[[remove]]\n").c_str());
  STRCMP_CONTAINS("centre_px (or centre_image_px) is missing", complaint("[[add]]\n").c_str());
  STRCMP_CONTAINS("says nothing to change", complaint("[[move]]\nat_px = [1, 2]\n").c_str());
  STRCMP_CONTAINS("move[1].center_image_px: unknown key; did you mean centre_image_px?",
                  complaint("[[move]]\nat_px = [1, 2]\ncenter_image_px = [3, 4]\n").c_str());
  STRCMP_CONTAINS("add[1].center_px: unknown key; did you mean centre_px?",
                  complaint("[[add]]\ncenter_px = [3, 4]\n").c_str());
  STRCMP_CONTAINS("at_px: must be two numbers", complaint("[[remove]]\nat_px = [1, 2, 3]\n").c_str());
  STRCMP_CONTAINS("fix.toml:3: move",
                  complaint("[[move]]\nat_px = [1, 2]\ncenter_px = [1, 2]\nequator_deg = 1\n").c_str());
  STRCMP_CONTAINS("diameter_px", complaint("[[add]]\ncentre_px = [1, 2]\ndiameter_px = -5\n").c_str());
  STRCMP_CONTAINS("leg", complaint("[[add]]\ncentre_px = [1, 2]\nleg = \"up\"\n").c_str());
  STRCMP_CONTAINS("equator_sd_deg: is nothing without equator_deg",
                  complaint("[[add]]\ncentre_px = [1, 2]\nequator_sd_deg = 1\n").c_str());
  STRCMP_CONTAINS("no_equator: contradicts equator_deg",
                  complaint("[[move]]\nat_px = [1, 2]\nequator_deg = 1\nno_equator = true\n").c_str());
  STRCMP_CONTAINS("is there twice",
                  complaint("[[add]]\ncentre_px = [1, 2]\ncentre_image_px = [1, 2]\n").c_str());
}

TEST(CorrectionsFile, HoldsTheSurfacesLine) {
  const auto read = parsed("[surface]\nleft_px = [10, 20]\nright_image_px = [300, 1500]\nsd_px = 1.5\n");
  LONGS_EQUAL(1, read.size());
  CHECK_EQUAL(Correction::Kind::surface, read[0].kind);
  CHECK_EQUAL("fix.toml:1", read[0].location);
  DOUBLES_EQUAL(20.0, read[0].surface.left.point.y, 0.0);
  CHECK_FALSE(read[0].surface.left.in_image);
  CHECK_TRUE(read[0].surface.right.in_image);
  DOUBLES_EQUAL(1.5, read[0].surface.sd_px.value(), 0.0);
  STRCMP_CONTAINS("fix.toml:1: surface: right_px (or right_image_px) is missing",
                  complaint("[surface]\nleft_px = [1, 2]\n").c_str());
  STRCMP_CONTAINS("surface.middle_px",
                  complaint("[surface]\nleft_px = [1, 2]\nright_px = [3, 2]\nmiddle_px = 1\n").c_str());
  STRCMP_CONTAINS("sd_px", complaint("[surface]\nleft_px = [1, 2]\nright_px = [3, 2]\nsd_px = 0\n").c_str());
}

TEST(CorrectionsFile, NamesTheFrameOrThePhotographNotBoth) {
  STRCMP_CONTAINS("diameter_image_px: is there twice",
                  complaint("[[add]]\ncentre_px = [1, 2]\ndiameter_px = 5\ndiameter_image_px = 5\n").c_str());
  STRCMP_CONTAINS("equator_image_deg: is there twice",
                  complaint("[[add]]\ncentre_px = [1, 2]\nequator_deg = 5\nequator_image_deg = 5\n").c_str());
}

TEST_GROUP(Corrections){};

TEST(Corrections, ARemovedImageIsListedAsRemovedByHand) {
  const Digitization made = corrected("[[remove]]\n" + at(2));
  LONGS_EQUAL(7, made.frame.images.size());
  LONGS_EQUAL(1, made.unmeasured.size());
  CHECK_EQUAL(Reason::by_hand, made.unmeasured[0].why.reason);
  CHECK_EQUAL("removed by fix.toml:1", made.unmeasured[0].why.detail);
  DOUBLES_EQUAL(centre_of(2).x, made.unmeasured[0].centre.x, 0.0);
  for (const BallImage& image : made.frame.images) CHECK_EQUAL("auto", image.source);
}

TEST(Corrections, TheTimesOfTheOthersStayWhereOneIsRemoved) {
  const Digitization made = corrected("[[remove]]\n" + at(2));
  // The gap is one period longer than the others, wherever the even train is taken to begin.
  DOUBLES_EQUAL(2 * kPeriod_s, made.frame.images[2].time_s - made.frame.images[1].time_s, 1e-12);
  DOUBLES_EQUAL(kPeriod_s, made.frame.images[1].time_s - made.frame.images[0].time_s, 1e-12);
}

TEST(Corrections, AMovedImageKeepsWhatIsNotOverruledAndIsMarked) {
  const Digitization made = corrected("[[move]]\n" + at(5) + "centre_px = [1302, 526]\n");
  const BallImage& image = made.frame.images.at(5);
  CHECK_EQUAL("hand", image.source);
  DOUBLES_EQUAL(1302.0, image.centre_px.x, 0.0);
  DOUBLES_EQUAL(526.0, image.centre_px.y, 0.0);
  DOUBLES_EQUAL(0.5, image.equator_rad.value(), 0.0);
  DOUBLES_EQUAL(0.002, image.equator_sd_rad.value(), 0.0);
  // Half a millimetre at 4000 px/m is 2 px.
  DOUBLES_EQUAL(4.0, image.centre_cov_px2.value()[0], 1e-12);
  DOUBLES_EQUAL(1302.0, made.outlines.at(5).centre.x, 0.0);
  for (std::size_t i = 0; i < made.frame.images.size(); ++i)
    if (i != 5) CHECK_EQUAL("auto", made.frame.images[i].source);
}

TEST(Corrections, ALineThatIsNoneIsTakenAway) {
  const Digitization made = corrected("[[move]]\n" + at(0) + "no_equator = true\n");
  CHECK(!made.frame.images[0].equator_rad.has_value());
  DOUBLES_EQUAL(1.0, made.outlines[0].probability, 0.0);  // a person saw that it is a ball
  DOUBLES_EQUAL(0.75, made.outlines[1].probability, 0.0);
  DOUBLES_EQUAL(1.0, made.frame.images[0].probability.value(), 0.0);
  DOUBLES_EQUAL(0.75, made.frame.images[1].probability.value(), 0.0);
  CHECK(!made.frame.images[0].equator_sd_rad.has_value());
  CHECK_EQUAL("hand", made.frame.images[0].source);
}

TEST(Corrections, AnAddedImageComesIntoItsPlaceWithItsTime) {
  // The next after the last, in the photograph's own coordinates.
  const cv::Point2d next = centre_of(8);
  const Digitization made = corrected(fmt::format("[[add]]\ncentre_image_px = [{}, {}]\nequator_deg = 20\n",
                                                  next.x, kHeight_px - 1 - next.y));
  LONGS_EQUAL(9, made.frame.images.size());
  const BallImage& image = made.frame.images.back();
  CHECK_EQUAL("hand", image.source);
  DOUBLES_EQUAL(next.y, image.centre_px.y, 1e-9);
  DOUBLES_EQUAL(kDiameter_px, image.diameter_px, 1e-12);
  CHECK(image.diameter_sd_px.value() > 1.0);
  CHECK_EQUAL(Leg::rebound, image.leg);
  DOUBLES_EQUAL(kPeriod_s, image.time_s - made.frame.images[7].time_s, 1e-12);
}

TEST(Corrections, OneThatMeansNoImageIsRefusedAndChangesNothing) {
  CHECK_EQUAL("fix.toml:1: no image within 130 px of (50.0, 60.0)",
              refusal("[[remove]]\nat_px = [50, 60]\n"));
}

TEST(Corrections, TwoThatMeanTheSameImageAreRefused) {
  CHECK_EQUAL("fix.toml:3: means the same image as fix.toml:1",
              refusal("[[remove]]\n" + at(1) + "[[move]]\n" + at(1) + "diameter_px = 250\n"));
}

TEST(Corrections, TheSurfaceLineByHandIsTheFramesAndMarked) {
  const Digitization made = corrected(
      fmt::format("[surface]\nright_image_px = [100, {}]\nleft_px = [2700, 312]\n", kHeight_px - 1 - 305));
  CHECK_TRUE(made.surface_by_hand);
  LONGS_EQUAL(2, made.frame.surface_px.size());
  DOUBLES_EQUAL(100.0, made.frame.surface_px[0].x, 0.0);  // from left to right, however they were given
  DOUBLES_EQUAL(305.0, made.frame.surface_px[0].y, 1e-9);
  DOUBLES_EQUAL(312.0, made.frame.surface_px[1].y, 0.0);
  DOUBLES_EQUAL(2.0, made.frame.surface_sd_px.value(), 1e-12);  // half a millimetre
  for (const BallImage& image : made.frame.images) CHECK_EQUAL("auto", image.source);
}

TEST(Corrections, ByAnotherSurfaceLineOtherImagesAreInContact) {
  const auto legs = [](const Digitization& d, Leg leg) {
    return std::ranges::count_if(d.frame.images, [leg](const BallImage& image) { return image.leg == leg; });
  };
  LONGS_EQUAL(0, legs(corrected("[surface]\nleft_px = [100, 300]\nright_px = [2700, 300]\n"), Leg::contact));
  // 50 px higher: the lowest ball, whose centre is at 430, touches it; its top is a radius above its centre.
  const Digitization raised =
      corrected("[surface]\nleft_px = [100, 350]\nright_px = [2700, 350]\nsd_px = 0.5\n");
  CHECK_TRUE(legs(raised, Leg::contact) > 0);
  for (const BallImage& image : raised.frame.images) {
    CHECK_EQUAL(image.leg == Leg::contact, image.top_px.has_value());
    if (image.top_px) DOUBLES_EQUAL(image.centre_px.y + 0.5 * kDiameter_px, image.top_px->y, 1e-6);
  }
  // What a person says of an image holds against the line.
  const Digitization told =
      corrected("[[move]]\n" + at(3) + "leg = \"incoming\"\n" +
                "[surface]\nleft_px = [100, 350]\nright_px = [2700, 350]\nsd_px = 0.5\n");
  CHECK_EQUAL(Leg::incoming, told.frame.images.at(3).leg);
}

TEST(Corrections, ASurfaceLineOfOnePointIsRefused) {
  CHECK_EQUAL("fix.toml:1: surface: left and right are the same point",
              refusal("[surface]\nleft_px = [100, 350]\nright_px = [100.2, 350]\n"));
}

TEST(Corrections, OnThePhotographAreAsATiltedCameraShowsThem) {
  // The photograph shows the plane a quarter turn on and half as large: column = y / 2, row = x / 2.
  DigitizeSettings turned = settings();
  turned.map = PlaneMap::calibrated({}, cv::Matx33d(0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0), {});
  Digitization made = digitized();
  const cv::Point2d at = turned.map.to_image(centre_of(5));
  const std::string text = fmt::format(
      "[[move]]\nat_image_px = [{}, {}]\ndiameter_image_px = 125\nequator_image_deg = 30\n", at.x, at.y);
  CHECK_TRUE(apply_corrections(made, parsed(text), turned).has_value());
  const BallImage& image = made.frame.images.at(5);
  DOUBLES_EQUAL(250.0, image.diameter_px, 1e-9);
  // (cos 30, -sin 30) in columns and rows is (-sin 30, cos 30) in the plane.
  DOUBLES_EQUAL(2.0 * std::numbers::pi / 3.0, image.equator_rad.value(), 1e-12);
}
