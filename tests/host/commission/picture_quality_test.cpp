#include "host/commission/picture_quality.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include "sim/loading/load_scene.hpp"
#include "sim/photograph/render.hpp"
#include "sim/shoot/shoot.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;

/// A rendered photograph of a bounce, measured.
PictureQuality quality_of(const std::string& photograph) {
  const auto scene = sim::parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
      "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
      "[camera]\npx_per_m = 2000\norigin_x_px = 750\norigin_y_px = 150\nhalf_width_m = 0.25\nheight_m = 0.2\n"
      "[ball_appearance]\ngrain = 0.04\n[background]\nclutter = 0\nwall = 0.02\nplate_brightness = 0.5\n"
      "[photograph]\nbits = 16\nblur_px = 0.8\n" +
          photograph,
      "picture.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  const auto shot = sim::shoot(*scene, 11, 1);
  const auto rendered = sim::render(*scene, 11, shot->exposure);
  digitize::Photograph picture;
  rendered->pixels.convertTo(picture.intensity, CV_32F, 1.0 / 65535.0);
  picture.bits = 16;
  picture.name = "picture";
  picture.saturation = static_cast<float>(digitize::saturation_level(rendered->pixels) / 65535.0);
  digitize::DigitizeSettings settings;
  settings.px_per_m = 2000.0;
  settings.ball_diameter_m = scene->ball.diameter_m;
  settings.map = digitize::PlaneMap::uncalibrated(picture.height());
  const auto found = digitize::digitize(picture, settings);
  if (!found) FAIL(found.error().message.c_str());
  return picture_quality(picture, settings.map, *found);
}

/// Two that are alike: what is not known of one is how much they scatter.
std::vector<PictureQuality> two_of(const std::string& photograph) {
  return std::vector<PictureQuality>(2, quality_of(photograph));
}

std::string fault(const StepResult& result) { return result.fault; }

}  // namespace

TEST_GROUP(PictureQuality){};

TEST(PictureQuality, OfASharpWellExposedPhotographIsGood) {
  std::vector<PictureQuality> one = two_of("");
  CHECK(one[0].images > 6);
  // The lens' .8 px, a pixel's own .3 px, and what felt adds.
  CHECK(one[0].blur_px > 0.7 && one[0].blur_px < 1.3);
  CHECK(judge_focus(one).state == StepState::passed);
  CHECK(judge_exposure(one).state == StepState::passed);
  one.pop_back();
  CHECK(judge_focus(one).state == StepState::not_told);
}

TEST(PictureQuality, OfADefocusedPhotographFailsByItsBlur) {
  // A disc of 4 px radius has an sd of 2 px.
  const std::vector<PictureQuality> one = two_of("defocus_px = 4\n");
  CHECK_EQUAL("out_of_focus", fault(judge_focus(one)));
}

TEST(PictureQuality, OfAnOverexposedOrDarkPhotographFailsByItsExposure) {
  const std::vector<PictureQuality> bright = two_of("exposure = 3\n");
  CHECK_EQUAL("overexposed", fault(judge_exposure(bright)));
  const std::vector<PictureQuality> dim = two_of("exposure = 0.12\n");
  CHECK_EQUAL("underexposed", fault(judge_exposure(dim)));
  const std::vector<PictureQuality> lit = two_of("exposure = 0.6\nambient = 0.2\n");
  CHECK_EQUAL("not_dark", fault(judge_exposure(lit)));
}

TEST(PictureQuality, PoolsTheTransferCurves) {
  std::vector<PictureQuality> pictures(3);
  CHECK(judge_transfer(pictures).state == StepState::skipped);
  for (PictureQuality& picture : pictures) picture.transfer = digitize::TransferCurve{0.98, 0.03, 12};
  CHECK(judge_transfer(pictures).state == StepState::passed);
  for (PictureQuality& picture : pictures) picture.transfer = digitize::TransferCurve{0.45, 0.03, 12};
  CHECK_EQUAL("not_proportional", fault(judge_transfer(pictures)));
}

TEST(PictureQuality, WithoutBallsSaysSo) {
  const std::vector<PictureQuality> none(2);
  CHECK_EQUAL("no_images", fault(judge_focus(none)));
  CHECK_EQUAL("no_images", fault(judge_exposure(none)));
}
