#include "host/digitize/overlay.hpp"

#include "tests/support/pictures.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::digitize;
using strobe::reduction::BallImage;
using strobe::reduction::Leg;

namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

Photograph grey_photograph() {
  Photograph photograph;
  photograph.intensity = cv::Mat(kHeight, kWidth, CV_32FC1);
  for (int row = 0; row < kHeight; ++row)
    photograph.intensity.row(row).setTo(0.1F + 0.001F * static_cast<float>(row));
  photograph.name = "grey.png";
  return photograph;
}

BallImage image_at(double x, double y, Leg leg, const std::string& source) {
  BallImage image;
  image.centre_px = {x, y};
  image.diameter_px = 60.0;
  image.leg = leg;
  image.source = source;
  return image;
}

/// Farthest from grey within a few pixels of there (x, y up).
cv::Vec3b most_colour(const cv::Mat& picture, double x, double y, double scale = 1.0) {
  cv::Vec3b most;
  int largest = -1;
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      const auto c = picture.at<cv::Vec3b>(cvRound((kHeight - 1 - y) * scale) + dy, cvRound(x * scale) + dx);
      const int colour = std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]});
      if (colour > largest) largest = colour, most = c;
    }
  }
  return most;
}

bool is_grey(const cv::Vec3b& c) { return std::max({c[0], c[1], c[2]}) - std::min({c[0], c[1], c[2]}) <= 2; }

Digitization two_images() {
  Digitization digitization;
  digitization.frame.images = {image_at(80.0, 150.0, Leg::incoming, "auto"),
                               image_at(200.0, 150.0, Leg::rebound, "hand")};
  digitization.frame.surface_px = {{10.0, 60.0}, {300.0, 60.0}};
  return digitization;
}

}  // namespace

TEST_GROUP(Overlay) { const PlaneMap map = PlaneMap::uncalibrated(kHeight); };

TEST(Overlay, HasThePhotographsSizeAndLeavesItGreyWhereNothingWasFound) {
  const cv::Mat picture = draw_overlay(grey_photograph(), map, {});
  LONGS_EQUAL(kWidth, picture.cols);
  LONGS_EQUAL(kHeight, picture.rows);
  LONGS_EQUAL(CV_8UC3, picture.type());
  for (int row = 0; row < kHeight; ++row)
    for (int column = 0; column < kWidth; ++column) CHECK(is_grey(picture.at<cv::Vec3b>(row, column)));
}

TEST(Overlay, DrawsEachOutlineWhereItIsAndInAColourOfItsOwn) {
  const cv::Mat picture = draw_overlay(grey_photograph(), map, two_images());
  const cv::Vec3b incoming = most_colour(picture, 80.0, 180.0);
  const cv::Vec3b by_hand = most_colour(picture, 200.0, 180.0);
  CHECK(!is_grey(incoming));
  CHECK(incoming[0] > incoming[2]);  // blue rather than red
  CHECK(by_hand[2] > by_hand[1] + 50);
  CHECK(by_hand[0] > by_hand[1] + 50);  // magenta
  CHECK(!is_grey(most_colour(picture, 280.0, 60.0)));
  CHECK(is_grey(most_colour(picture, 260.0, 100.0)));
}

TEST(Overlay, DrawsWhatWasRejectedOnlyWhereAskedTo) {
  Digitization digitization;
  digitization.unmeasured.push_back({{160.0, 120.0}, 80.0, "image", {Reason::off_path, ""}});
  const cv::Vec3b there =
      most_colour(draw_overlay(grey_photograph(), map, digitization, {.rejected = true}), 160.0, 160.0);
  CHECK(there[2] > there[0] + 50);
  CHECK(is_grey(most_colour(draw_overlay(grey_photograph(), map, digitization), 160.0, 160.0)));
}

TEST(Overlay, OfALargePhotographIsMadeSmaller) {
  const cv::Mat picture = draw_overlay(grey_photograph(), map, two_images(), {.longest_side_px = 160});
  LONGS_EQUAL(160, picture.cols);
  LONGS_EQUAL(120, picture.rows);
  CHECK(!is_grey(most_colour(picture, 80.0, 180.0, 0.5)));
}

TEST(Overlay, IsDrawnOfAFrameWithPlacesFarOutsideAndOfADarkPhotograph) {
  Digitization digitization = two_images();
  digitization.frame.images[0].centre_px = {1e11, -1e11};
  digitization.frame.surface_px = {{-1e11, 60.0}, {1e11, 60.0}};
  Photograph dark = grey_photograph();
  dark.intensity.setTo(0.0F);
  LONGS_EQUAL(kWidth, draw_overlay(dark, map, digitization).cols);
}

TEST(Overlay, IsWrittenAsTheExtensionSays) {
  const strobe::testing::TemporaryFolder folder;
  const auto path = folder.path() / "out.png";
  CHECK(write_overlay(path, grey_photograph(), map, two_images()).has_value());
  const cv::Mat read = strobe::testing::read_picture(path);
  DOUBLES_EQUAL(0.0, cv::norm(read, draw_overlay(grey_photograph(), map, two_images()), cv::NORM_INF), 0.0);
}

TEST(Overlay, ThatCannotBeWrittenIsAnErrorThatNamesTheFile) {
  const strobe::testing::TemporaryFolder folder;
  for (const char* name : {"missing/out.png", "out", "out.nothing"}) {
    const auto path = folder.path() / name;
    const auto written = write_overlay(path, grey_photograph(), map, two_images());
    CHECK(!written.has_value());
    STRCMP_CONTAINS((path.string() + ": cannot be written").c_str(), written.error().message.c_str());
  }
}
