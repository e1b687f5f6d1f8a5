// Photographs rendered with one deliberate fault each: it must be named, and nothing else that is wrong; of
// sound ones nothing must be said. The renderer knows nothing of the measures.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "host/light/advice.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/photograph/render.hpp"
#include "sim/shoot/shoot.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using light::Advice;
using light::LightMeasures;
using light::Verdict;

constexpr double kSpeed_mps = 17.0, kPxPerM = 2000.0;

sim::Scene scene_of(const std::string& photograph, const std::string& tables) {
  auto scene = sim::parse_scene(
      "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
      "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n"
      "[camera]\npx_per_m = 2000\norigin_x_px = 750\norigin_y_px = 150\nhalf_width_m = 0.25\nheight_m = 0.2\n"
      "[ball_appearance]\ngrain = 0.04\n[background]\nclutter = 0\nwall = 0.02\nplate_brightness = 0.5\n" +
          tables + "[photograph]\nbits = 16\nblur_px = 0.8\n" + photograph,
      "picture.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  return std::move(*scene);
}

cv::Mat rendered(const sim::Scene& scene, double period_s) {
  sim::ShootSettings settings;
  settings.period = from_seconds(period_s);
  const auto shot = sim::shoot(scene, 11, 1, sim::Model::full(), settings);
  return sim::render(scene, 11, shot->exposure)->pixels;
}

cv::Mat rendered(const std::string& photograph, const std::string& tables) {
  return rendered(scene_of(photograph, tables), 3e-3);
}

digitize::Photograph photograph_of(const cv::Mat& pixels) {
  digitize::Photograph picture;
  pixels.convertTo(picture.intensity, CV_32F, 1.0 / 65535.0);
  picture.bits = 16;
  picture.name = "picture.tif";
  picture.saturation = static_cast<float>(digitize::saturation_level(pixels) / 65535.0);
  return picture;
}

LightMeasures measured(const digitize::Photograph& picture) {
  digitize::DigitizeSettings settings;
  settings.px_per_m = kPxPerM;
  settings.map = digitize::PlaneMap::uncalibrated(picture.height());
  const auto found = digitize::digitize(picture, settings);
  if (!found) FAIL(found.error().message.c_str());
  return light::measure_light(picture, settings.map, *found);
}

LightMeasures measures_of(const std::string& photograph = "", const std::string& tables = "") {
  return measured(photograph_of(rendered(photograph, tables)));
}

/// "exposure wrong, focus look at"
std::string said(const LightMeasures& measures) {
  std::string words;
  for (const Advice& each : light::advise(measures)) {
    CHECK_EQUAL(each.verdict == Verdict::ok, each.remedy.empty());
    if (each.verdict == Verdict::ok) continue;
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", each.what, name(each.verdict));
  }
  return words;
}

}  // namespace

TEST_GROUP(Light){};

TEST(Light, OfASoundPhotographNothingIsSaid) {
  const LightMeasures sound = measures_of();
  CHECK(sound.images > 6);
  CHECK_EQUAL("", said(sound));
  CHECK_EQUAL("", light::in_short(light::advise(sound)));
  // The scene's lightest felt has .45; nine tenths of a ball are darker than its 90 % quantile.
  CHECK(sound.felt > 0.25 && sound.felt < 0.5);
  // The lens' .8 px, a pixel's own .3 px, and what felt adds.
  CHECK(sound.blur_px > 0.7 && sound.blur_px < 1.3);
}

TEST(Light, TooMuchAndTooLittleAreNamed) {
  STRCMP_CONTAINS("clipping wrong", said(measures_of("exposure = 3\n")).c_str());
  STRCMP_CONTAINS("exposure wrong", said(measures_of("exposure = 0.125\n")).c_str());
  STRCMP_CONTAINS("exposure look at", said(measures_of("exposure = 0.35\n")).c_str());
}

TEST(Light, ALensOutOfFocusIsNamed) {
  // A disc of 4 px radius has an sd of 2 px along each axis.
  CHECK_EQUAL("focus look at", said(measures_of("defocus_px = 4\n")));
  STRCMP_CONTAINS("focus wrong", said(measures_of("defocus_px = 7\n")).c_str());
}

TEST(Light, APictureSharpOnOneSideAloneSaysWhichSideIsNot) {
  const cv::Mat pixels = rendered("", "");
  cv::Mat soft, mixed = pixels.clone();
  for (int column = 0; column < pixels.cols; column += 4) {
    const double sigma = 0.1 + 3.0 * column / pixels.cols;
    const cv::Rect around(std::max(0, column - 16), 0,
                          std::min(pixels.cols, column + 20) - std::max(0, column - 16), pixels.rows);
    cv::GaussianBlur(pixels(around), soft, {}, sigma);
    const int width = std::min(4, pixels.cols - column);
    soft.colRange(column - around.x, column - around.x + width)
        .copyTo(mixed.colRange(column, column + width));
  }
  const LightMeasures measures = measured(photograph_of(mixed));
  CHECK(measures.blur_at_px.has_value());
  CHECK(measures.blur_at_px->right > measures.blur_at_px->left + 0.5);
  STRCMP_CONTAINS("focus", said(measures).c_str());
  STRCMP_CONTAINS("right", light::in_short(light::advise(measures)).c_str());
}

TEST(Light, TheBallsWayInAFlashIsTheOneSimulated) {
  // 200 µs at 17 m/s and 2000 px/m: 6.8 px before the impact and less after it; a tenth of chance in it.
  const double way_px = kSpeed_mps * 200e-6 * kPxPerM;
  const LightMeasures measures = measures_of("", "[lamps]\nflash_us = 200\n");
  CHECK(measures.smear_px.has_value());
  DOUBLES_EQUAL(way_px, *measures.smear_px, 0.25 * way_px);
  STRCMP_CONTAINS("motion", said(measures).c_str());
}

TEST(Light, ALitRoomAndCutBlacksAreNamed) {
  CHECK_EQUAL("background look at", said(measures_of("exposure = 0.8\nambient = 0.2\n")));
  STRCMP_CONTAINS("background wrong", said(measures_of("exposure = 0.6\nambient = 0.4\n")).c_str());
  cv::Mat cut = rendered("", "");
  cut -= cv::Scalar(0.02 * 65535.0);  // saturates at 0
  STRCMP_CONTAINS("black look at", said(measured(photograph_of(cut))).c_str());
}

TEST(Light, RoomLightThatDrawsTheBallBetweenFlashesIsNamed) {
  // Flashes 6 ms apart leave the way free between images. The room's lamps flicker ten times as fast; on the
  // band so many discs lie on each other as there are in the time in which the ball flies by its own width:
  // 65 mm at 17 m/s, and at 12 to 14 m/s after the bounce.
  constexpr double kApart_s = 6e-3, kFlicker_s = 0.6e-3, kBall_m = 0.065;
  sim::Scene scene = scene_of("", "");
  const double black = 65535.0 * scene.photograph.black_level;
  const cv::Mat dark_room = rendered(scene, kApart_s);
  const LightMeasures dark = measured(photograph_of(dark_room));
  CHECK(dark.ambient.has_value());
  CHECK(*dark.ambient < 0.02);
  CHECK_EQUAL("", said(dark));
  scene.lamps.recharge_s = 0.0;
  for (const double share : {0.1, 0.2}) {
    scene.photograph.exposure = share * kFlicker_s * kSpeed_mps / kBall_m;
    const cv::Mat room = rendered(scene, kFlicker_s) - cv::Scalar(black);
    const LightMeasures lit = measured(photograph_of(dark_room + room));
    CHECK(lit.ambient.has_value());
    CHECK(*lit.ambient > 0.8 * share && *lit.ambient < 1.2 * share * kSpeed_mps / 12.0);
    CHECK_EQUAL("ambient look at", said(lit));
  }
}

TEST(Light, AScreensCurveAndAJpegAreNamed) {
  // Flashes every 3 ms: images overlap.
  LightMeasures measures = measures_of();
  measures.transfer = digitize::TransferCurve{0.45, 0.03, 12};
  CHECK_EQUAL("numbers wrong", said(measures));
  measures.transfer = digitize::TransferCurve{0.98, 0.03, 12};
  CHECK_EQUAL("", said(measures));
  measures.jpeg = true;
  CHECK_EQUAL("numbers look at", said(measures));
}

TEST(Light, TheLampThatHasFailedIsNamedBySide) {
  const std::string right = light::in_short(light::advise(measures_of("lamp_b_power = 0\n")));
  STRCMP_CONTAINS("lamp to the right", right.c_str());
  const std::string left = light::in_short(light::advise(measures_of("lamp_a_power = 0\n")));
  STRCMP_CONTAINS("lamp to the left", left.c_str());
}

TEST(Light, AFlashOfOneLampAloneIsNamed) {
  STRCMP_CONTAINS(
      "flashes",
      said(measures_of("", "[[fault]]\nkind = \"flash_missing\"\nflash_from_impact = -3\nlamp = \"b\"\n"))
          .c_str());
}

TEST(Light, APictureWithoutABallSaysWhy) {
  digitize::Photograph picture;
  picture.name = "dark.tif";
  const auto said_of = [&](double value) {
    picture.intensity = cv::Mat(480, 640, CV_32F, cv::Scalar(value));
    const LightMeasures measures = light::measure_light(picture, digitize::PlaneMap::uncalibrated(480), {});
    const auto advice = light::advise(measures);
    LONGS_EQUAL(1, advice.size());
    CHECK(Verdict::wrong == light::worst(advice));
    return advice[0].words;
  };
  STRCMP_CONTAINS("nothing is brighter than 2 %", said_of(0.02).c_str());
  STRCMP_CONTAINS("nothing is darker than 90 %", said_of(0.9).c_str());
  CHECK_EQUAL("no ball is seen", said_of(0.3));
}

TEST(Light, AsJsonHoldsEachAdvice) {
  LightMeasures measures;
  measures.images = 9;
  measures.felt = 0.05;
  const auto advice = light::advise(measures);
  const auto json = nlohmann::json::parse(light::advice_json(measures, advice));
  CHECK_EQUAL("wrong", json["verdict"].get<std::string>());
  LONGS_EQUAL(9, json["images"].get<int>());
  LONGS_EQUAL(advice.size(), json["advice"].size());
  CHECK_EQUAL("exposure", json["advice"][0]["what"].get<std::string>());
  DOUBLES_EQUAL(5.0, json["advice"][0]["value"].get<double>(), 1e-9);
}
