// Photographs of other balls than tennis's, on a sensor with a quarter of the usual scale, and what the digitizer
// makes of them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/digitize/digitize.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/photograph/render.hpp"
#include "sim/shoot/shoot.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

constexpr double kSmaller = 0.25;

Scene load(const std::string& name) {
  auto scene = load_scene(std::string(STROBE_SCENES_FOLDER).append("/").append(name).append(".toml"));
  if (!scene) FAIL(scene.error().message.c_str());
  scene->camera.px_per_m *= kSmaller;
  scene->camera.origin_x_px *= kSmaller;
  scene->camera.origin_y_px *= kSmaller;
  return *scene;
}

/// Flashes .3 diameters apart at least, and what the first shot shows; seed 4.
Photograph photograph_of(const Scene& scene) {
  const double period_s = std::max(1.5e-3, 0.045 * scene.ball.diameter_m);
  const auto shot = shoot(scene, 4, 1, Model::full(), {.period = from_seconds(period_s)});
  if (!shot) FAIL(shot.error().message.c_str());
  auto photograph = render(scene, 4, shot->exposure);
  if (!photograph) FAIL(photograph.error().message.c_str());
  return *photograph;
}

reduction::Frame digitized(const Photograph& photograph, const Scene& scene, bool line_drawn) {
  digitize::Photograph picture;
  picture.name = scene.name;
  photograph.pixels.convertTo(picture.intensity, CV_32F, 1.0 / 255.0);
  picture.saturation = 1.0F;
  digitize::DigitizeSettings settings;
  settings.ball_diameter_m = scene.ball.diameter_m;
  settings.px_per_m = scene.camera.px_per_m;
  settings.line_drawn = line_drawn;
  auto result = digitize::digitize(picture, settings);
  if (!result) FAIL(result.error().message.c_str());
  return result->frame;
}

/// Found within a px, and nothing else is.
void check_found(const Photograph& photograph, const reduction::Frame& frame, const std::string& name) {
  std::size_t found = 0;
  for (const ImageTruth& truth : photograph.truth.images) {
    const bool is = std::ranges::any_of(frame.images, [&](const reduction::BallImage& image) {
      return std::hypot(image.centre_px.x - truth.centre_px.x, image.centre_px.y - truth.centre_px.y) <
             (truth.leg == reduction::Leg::contact || !truth.whole ? 0.25 * truth.diameter_px : 1.0);
    });
    found += is ? 1 : 0;
    const bool must = truth.whole && truth.leg != reduction::Leg::contact;
    CHECK_TRUE_TEXT(is || !must, fmt::format("{}: image at {}", name, truth.centre_px.x).c_str());
  }
  CHECK_EQUAL_TEXT(found, frame.images.size(), name.c_str());
}

int equators(const reduction::Frame& frame) {
  return static_cast<int>(std::ranges::count_if(
      frame.images, [](const reduction::BallImage& image) { return image.equator_rad.has_value(); }));
}

}  // namespace

TEST_GROUP(BallPhotographs){};

TEST(BallPhotographs, ShowEachKindAsLargeAsATennisBall) {
  for (const char* kind : {"golf", "baseball", "softball", "table_tennis", "squash", "racquetball", "cricket",
                           "football", "basketball", "padel", "pickleball"}) {
    const Scene scene = load(std::string("ball_") + kind);
    CHECK_TRUE_TEXT(scene.kind && !scene.ball_appearance.line, kind);
    // The scales have two digits: one in 20 at most.
    DOUBLES_EQUAL_TEXT(260.0 * kSmaller, scene.ball.diameter_m * scene.camera.px_per_m, 0.05 * 65.0, kind);
  }
}

TEST(BallPhotographs, ShowImagesThatAreFoundAndNoLine) {
  for (const char* kind : {"golf", "baseball", "table_tennis", "squash", "basketball"}) {
    const Scene scene = load(std::string("ball_") + kind);
    const Photograph photograph = photograph_of(scene);
    const reduction::Frame frame = digitized(photograph, scene, false);
    check_found(photograph, frame, kind);
    CHECK_EQUAL_TEXT(0, equators(frame), kind);
  }
}

TEST(BallPhotographs, ShowTheLineThatALabDrawsOnABall) {
  Scene scene = load("ball_golf");
  scene.ball_appearance.line = true;
  scene.ball_appearance.line_contrast = 0.8;
  const Photograph photograph = photograph_of(scene);
  const reduction::Frame frame = digitized(photograph, scene, true);
  check_found(photograph, frame, "golf with a line");
  CHECK(equators(frame) > 0);
  for (const reduction::BallImage& image : frame.images) {
    if (!image.equator_rad) continue;
    const auto truth = std::ranges::min_element(photograph.truth.images, {}, [&](const ImageTruth& t) {
      return std::abs(t.centre_px.x - image.centre_px.x);
    });
    // Six stated sds: none of a dozen is farther off by chance.
    DOUBLES_EQUAL(0.0, std::remainder(*image.equator_rad - truth->equator_rad, M_PI),
                  6.0 * *image.equator_sd_rad);
  }
  LONGS_EQUAL(0, equators(digitized(photograph, scene, false)));
}
