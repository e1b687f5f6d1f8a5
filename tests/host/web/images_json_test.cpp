#include "host/web/images_json.hpp"

#include <CppUTest/TestHarness.h>

#include <nlohmann/json.hpp>

#include "tests/support/string_from.hpp"

using namespace strobe::digitize;
using nlohmann::ordered_json;
using strobe::web::corrections_json;

namespace {

constexpr int kHeight_px = 1000;

ordered_json json_of(const std::string& text, const PlaneMap& map) {
  return corrections_json(parse_corrections(text, "fix.toml").value(), map);
}

/// Seen obliquely: the scale differs over the photograph, lines turn.
PlaneMap tilted() {
  LensDistortion lens;
  lens.centre_px = {640.0, 500.0};
  lens.focal_px = 2600.0;
  return PlaneMap::calibrated(lens, cv::Matx33d(1.1, 0.03, -20.0, -0.02, -1.15, 1100.0, 2e-5, -4e-5, 1.0),
                              std::nullopt);
}

constexpr const char* kInFrame = R"(
[[remove]]
at_px = [400, 300]
[[move]]
at_px = [600, 420]
centre_px = [602.5, 421]
diameter_px = 130
equator_deg = 25
[[add]]
centre_px = [800, 500]
diameter_px = 128
diameter_sd_px = 0.3
leg = "rebound"
top_px = [800, 564]
[surface]
left_px = [100, 80]
right_px = [1100, 90]
sd_px = 0.5
)";

/// What the page makes of the list.
std::string on_photograph(const ordered_json& list) {
  std::string text;
  for (const ordered_json& each : list) {
    const std::string kind = each["kind"];
    text += kind == "surface" ? "[surface]\n" : "[[" + kind + "]]\n";
    for (const auto& [key, value] : each.items()) {
      if (key == "kind") continue;
      const bool is_frames = key.find("_sd_") != std::string::npos || key == "sd_px";
      const auto unit = key.rfind('_');
      const bool is_word = unit == std::string::npos;
      text += (is_frames || is_word ? key : key.substr(0, unit) + "_image" + key.substr(unit)) + " = " +
              value.dump() + "\n";
    }
  }
  return text;
}

Digitization digitized() {
  Digitization made;
  made.frame.ball_diameter_m = 0.065;
  made.frame.surface_px = {{0.0, 80.0}, {1200.0, 80.0}};
  for (const cv::Point2d at :
       {cv::Point2d(400.0, 300.0), cv::Point2d(600.0, 420.0), cv::Point2d(1000.0, 560.0)}) {
    strobe::reduction::BallImage image;
    image.centre_px = {at.x, at.y};
    image.diameter_px = 130.0;
    image.centre_cov_px2 = {0.01, 0.0, 0.0, 0.01};
    made.frame.images.push_back(image);
    Outline outline;
    outline.centre = at;
    outline.diameter = 130.0;
    made.outlines.push_back(outline);
  }
  return made;
}

Digitization corrected(const std::string& text) {
  DigitizeSettings settings;
  settings.map = tilted();
  settings.px_per_m = 2000.0;
  Digitization made = digitized();
  const auto applied = apply_corrections(made, parse_corrections(text, "fix.toml").value(), settings);
  CHECK_TEXT(applied.has_value(), applied ? "" : applied.error().message.c_str());
  return made;
}

}  // namespace

TEST_GROUP(CorrectionsJson){};

TEST(CorrectionsJson, RowsCountFromTheTopOfThePhotograph) {
  const ordered_json list =
      json_of("[[move]]\nat_px = [400, 300]\ncentre_px = [401.5, 299]\n", PlaneMap::uncalibrated(kHeight_px));
  CHECK_EQUAL(std::string(R"([{"kind":"move","at_px":[400.0,699.0],"centre_px":[401.5,700.0]}])"),
              list.dump());
}

TEST(CorrectionsJson, OnlyWhatTheFileSaysIsThere) {
  const PlaneMap map = PlaneMap::uncalibrated(kHeight_px);
  CHECK_EQUAL(std::string(R"([{"kind":"remove","at_px":[4.0,5.0]}])"),
              json_of("[[remove]]\nat_image_px = [4, 5]\n", map).dump());
  CHECK_EQUAL(std::string(R"([{"kind":"move","at_px":[4.0,5.0],"no_equator":true,"leg":"contact"}])"),
              json_of("[[move]]\nat_image_px = [4, 5]\nno_equator = true\nleg = \"contact\"\n", map).dump());
}

TEST(CorrectionsJson, WhatIsOfThePhotographAlreadyStaysAsItIs) {
  const ordered_json list = json_of(
      "[[move]]\nat_image_px = [400, 300]\ndiameter_image_px = 131.5\nequator_image_deg = 31.0\n", tilted());
  DOUBLES_EQUAL(131.5, list[0]["diameter_px"].get<double>(), 0.0);
  DOUBLES_EQUAL(31.0, list[0]["equator_deg"].get<double>(), 1e-12);
}

/// The text that is made of the list does what the file did, though the camera is tilted. Tolerance: the map and its
/// inverse agree to some 1e-10 px.
TEST(CorrectionsJson, TakenUpOnThePhotographTheyDoWhatTheFileDid) {
  const Digitization expected = corrected(kInFrame);
  const Digitization again = corrected(on_photograph(json_of(kInFrame, tilted())));
  LONGS_EQUAL(3, expected.frame.images.size());
  LONGS_EQUAL(expected.frame.images.size(), again.frame.images.size());
  for (std::size_t i = 0; i < expected.frame.images.size(); ++i) {
    const auto& a = expected.frame.images[i];
    const auto& b = again.frame.images[i];
    CHECK_EQUAL(a.source, b.source);
    DOUBLES_EQUAL(a.centre_px.x, b.centre_px.x, 1e-6);
    DOUBLES_EQUAL(a.centre_px.y, b.centre_px.y, 1e-6);
    DOUBLES_EQUAL(a.diameter_px, b.diameter_px, 1e-6);
    CHECK_EQUAL(a.equator_rad.has_value(), b.equator_rad.has_value());
    if (a.equator_rad) DOUBLES_EQUAL(0.0, std::sin(*a.equator_rad - *b.equator_rad), 1e-9);
  }
  LONGS_EQUAL(2, again.frame.surface_px.size());
  DOUBLES_EQUAL(80.0, again.frame.surface_px[0].y, 1e-6);
  DOUBLES_EQUAL(90.0, again.frame.surface_px[1].y, 1e-6);
  DOUBLES_EQUAL(0.5, *again.frame.surface_sd_px, 0.0);
}
