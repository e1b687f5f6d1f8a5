// The scenes for what makes photographs hard: each shows what it is named for. A quarter of the usual scale
// or less.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <string>

#include "sim/loading/load_scene.hpp"
#include "sim/photograph/render.hpp"
#include "sim/shoot/shoot.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

constexpr double kSmaller = 0.125;

Result<SceneText> read(const std::string& name, const std::string&) {
  const std::string path = std::string(STROBE_SCENES_FOLDER).append("/").append(name).append(".toml");
  std::ifstream file(path);
  if (!file) return fail("no scene " + name);
  return SceneText{std::string{std::istreambuf_iterator<char>(file), {}}, path};
}

/// On a sensor so much smaller that it is quick.
Scene load(const std::string& name) {
  const auto text = read(name, "");
  auto scene = parse_scene(text->text, text->file_name, read);
  if (!scene) FAIL(scene.error().message.c_str());
  scene->camera.px_per_m *= kSmaller;
  scene->camera.origin_x_px *= kSmaller;
  scene->camera.origin_y_px *= kSmaller;
  return *scene;
}

/// The second shot: each scene's flashes, ball and look are those of the scene that it inherits from.
Exposure shot_of(const Scene& scene) {
  auto shot = shoot(scene, 3, 2);
  if (!shot) FAIL(shot.error().message.c_str());
  return shot->exposure;
}

Photograph rendered(const Scene& scene, const Exposure& exposure) {
  auto photograph = render(scene, 3, exposure);
  if (!photograph) FAIL(photograph.error().message.c_str());
  return *photograph;
}

Photograph rendered(const Scene& scene) { return rendered(scene, shot_of(scene)); }

Photograph rendered(const std::string& name) { return rendered(load(name)); }

/// Share of pixels whose number is the largest.
double saturated_share(const Photograph& photograph) {
  return static_cast<double>(cv::countNonZero(photograph.pixels == 255)) /
         static_cast<double>(photograph.pixels.total());
}

/// Sum of the light within the ball's left half over that within its right half, image by image added up.
double left_over_right(const std::string& name) {
  Scene scene = load(name);
  scene.background.clutter = 0.0;
  scene.background.plate = false;
  scene.background.wall = 0.0;
  scene.photograph.black_level = 0.0;
  Exposure exposure = shot_of(scene);
  const ImageTruth image = rendered(scene, exposure).truth.images.at(4);
  for (std::size_t i = 0; i < exposure.pulses.size(); ++i)
    if (static_cast<int>(i) != image.flash_index) exposure.pulses[i].flashes = {};
  const cv::Mat pixels = rendered(scene, exposure).pixels;
  const int middle = cvRound(image.centre_px.x);
  return cv::sum(pixels.colRange(0, middle))[0] / cv::sum(pixels.colRange(middle, pixels.cols))[0];
}

}  // namespace

TEST_GROUP(PhotographScenes){};

TEST(PhotographScenes, AreFarDarkerOrBrighterThanUsual) {
  const cv::Mat usual = rendered("zero_41").pixels;
  const cv::Mat dim = rendered("photo_dim").pixels;
  const double black = 0.005 * 255.0;
  // Without what saturates in the usual one. Noise, of .5 numbers at most, and rounding average out over
  // 40000 pixels; the black level's noise is cut off at 0, which adds less than .05.
  const cv::Mat unsaturated = usual < 230;
  const double share = (cv::mean(dim, unsaturated)[0] - black) / (cv::mean(usual, unsaturated)[0] - black);
  DOUBLES_EQUAL(0.125, share, 0.005);
  CHECK(saturated_share(rendered("photo_saturated")) > saturated_share(rendered("zero_41")) + 0.05);
}

TEST(PhotographScenes, LoseTheLightFromTheRightWithTheirLamp) {
  CHECK(left_over_right("photo_one_lamp") > 1.5 * left_over_right("zero_41"));
}

TEST(PhotographScenes, HaveBlobsThatAreNoBalls) {
  Scene scene = load("photo_blobs");
  Exposure empty = shot_of(scene);
  empty.ball.reset();
  const Photograph with = rendered(scene, empty);
  LONGS_EQUAL(0, with.truth.images.size());
  scene.background.blobs = 0;
  cv::Mat difference;
  cv::absdiff(with.pixels, rendered(scene, empty).pixels, difference);
  // A blob's half axes are .15 to 1 and .06 to 1 of a ball's, which is 33 px wide here: 7 px² and more each.
  CHECK(cv::countNonZero(difference > 20) > 20);
}

TEST(PhotographScenes, BlurTheirEdges) {
  // The steepest step between neighbours: over an sd of 3 px it is 1/(3·sqrt(2 pi)) = .13 of the edge's
  // height.
  const auto steepest = [](const std::string& name) {
    const cv::Mat pixels = rendered(name).pixels;
    cv::Mat numbers, step;
    pixels.convertTo(numbers, CV_32F);
    cv::absdiff(numbers.colRange(1, numbers.cols), numbers.colRange(0, numbers.cols - 1), step);
    double most = 0.0;
    cv::minMaxLoc(step, nullptr, &most);
    return most;
  };
  CHECK(steepest("photo_blurred") < 0.4 * steepest("zero_41"));
}

TEST(PhotographScenes, MissOneFlashBeforeTheBounce) {
  const PhotographTruth truth = rendered("photo_missing_flash").truth;
  int gaps = 0;
  for (std::size_t i = 1; i < truth.images.size(); ++i) {
    const int flash = truth.images[i].flash_index, before = truth.images[i - 1].flash_index;
    if (flash == before + 1) continue;
    LONGS_EQUAL(before + 2, flash);
    CHECK_FALSE(truth.flash_times_s.at(static_cast<std::size_t>(before) + 1).has_value());
    CHECK_EQUAL(reduction::Leg::incoming, truth.images[i].leg);
    ++gaps;
  }
  LONGS_EQUAL(1, gaps);
}

TEST(PhotographScenes, ShowTheBallFromTheOtherSide) {
  const PhotographTruth truth = rendered("photo_mirrored").truth;
  CHECK(truth.images.back().centre_px.x < truth.images.front().centre_px.x - 50.0);
}

TEST(PhotographScenes, ShowBallsLargerAwayFromTheAxisOfACloseLens) {
  // At an angle a off the axis a sphere's outline is an ellipse whose axes are 1/cos² and 1/cos of that on
  // the axis.
  const PhotographTruth truth = rendered("photo_close_lens").truth;
  const auto [least, most] = std::ranges::minmax(truth.images, {}, &ImageTruth::diameter_px);
  CHECK(most.diameter_px > 1.02 * least.diameter_px);
  CHECK(std::abs(truth.px_per_m_of_ball / truth.px_per_m - 1.0) > 1e-5);
}

TEST(PhotographScenes, HaveTheBallsThatTheyTellOf) {
  const Appearance tilted = draw_appearance(load("photo_tilted"), 3, 2);
  DOUBLES_EQUAL(5.0 * M_PI / 180.0, tilted.ball.line_tilt_rad, 1e-12);
  DOUBLES_EQUAL(0.1, draw_appearance(load("photo_faint_line"), 3, 2).ball.line_contrast, 0.0);
  DOUBLES_EQUAL(0.45, load("photo_screen").photograph.gamma, 0.0);
  CHECK_FALSE(draw_appearance(load("photo_shiny"), 3, 2).ball.line);
  DOUBLES_EQUAL(0.0427 * 4000.0 * kSmaller, rendered("photo_shiny").truth.images.at(3).diameter_px, 1e-9);
  // Of the usual scale a quarter.
  DOUBLES_EQUAL(0.0651 * 1000.0 * kSmaller, rendered("photo_small").truth.images.at(3).diameter_px, 1e-9);
}
