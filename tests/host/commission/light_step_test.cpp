#include "host/commission/light_step.hpp"

#include <cmath>
#include <functional>


#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;

/// A dark wall and a bright plate below, as a file of 8 bits has them.
LitPhotograph photograph(
    int a, int b, double light_of_a, double light_of_b,
    const std::function<double(double)>& curve = [](double light) { return light; }) {
  LitPhotograph lit;
  lit.flashes = std::max(a, b);
  lit.photograph.intensity = cv::Mat(60, 80, CV_32FC1);
  for (int row = 0; row < 60; ++row) {
    for (int column = 0; column < 80; ++column) {
      const double brightness = row < 40 ? 1e-5 : 2e-3 + 1e-5 * column;
      const double light = 0.01 + brightness * (a * light_of_a + b * light_of_b);
      lit.photograph.intensity.at<float>(row, column) =
          static_cast<float>(std::round(255.0 * std::min(1.0, curve(light))) / 255.0);
    }
  }
  return lit;
}

struct Lamps {
  double a = 1.0, b = 1.0;
  double early = 1.0, late = 1.0;  ///< share of the flashes that the shutter lets in
  std::function<double(double)> curve = [](double light) { return light; };
};

LampPhotographs photographs(const Lamps& l) {
  LampPhotographs p{photograph(100, 0, l.a, l.b, l.curve), photograph(0, 100, l.a, l.b, l.curve),
                    photograph(100, 100, l.a, l.b, l.curve),
                    photograph(16, 16, l.early * l.a, l.early * l.b, l.curve),
                    photograph(16, 16, l.late * l.a, l.late * l.b, l.curve)};
  return p;
}

LampLight light_of(const Lamps& lamps) {
  const auto light = measure_lamp_light(photographs(lamps));
  if (!light) FAIL(light.error().message.c_str());
  return *light;
}

std::string fault_of(const Lamps& lamps) { return judge_light(light_of(lamps), {}).fault; }
std::string window_fault_of(const Lamps& lamps) { return judge_exposure_window(light_of(lamps)).fault; }

}  // namespace

TEST_GROUP(LampLight){};

TEST(LampLight, IsMeasuredOverTheDark) {
  const LampLight light = light_of({.a = 0.9, .b = 0.6});
  // Steps of 1/255 over 1,600 pixels, of which the plate has some 40 different ones: .02 / 255 of a mean of .2.
  DOUBLES_EQUAL(1.5, light.a / light.b, 0.01);
  DOUBLES_EQUAL(0.01, light.dark, 0.002);
  DOUBLES_EQUAL(0.0, light.excess, 0.01);
  DOUBLES_EQUAL(1.0, light.early, 0.05);
  DOUBLES_EQUAL(1.0 / 3.0, light.lit_share, 1e-9);
  CHECK_EQUAL("", fault_of({}));
  CHECK_EQUAL("", window_fault_of({}));
}

TEST(LampLight, NamesTheLampThatLightsNothingOrTooLittle) {
  CHECK_EQUAL("lamp_a_unlit", fault_of({.a = 0.0}));
  CHECK_EQUAL("lamp_b_unlit", fault_of({.b = 0.01}));
  CHECK_EQUAL("lamp_b_dim", fault_of({.b = 0.5}));
  CHECK_EQUAL("lamp_a_dim", fault_of({.a = 0.5}));
  CHECK_EQUAL("", fault_of({.a = 0.8}));
}

TEST(LampLight, MustAddUp) {
  CHECK_EQUAL("light_does_not_add_up",
              fault_of({.curve = [](double light) { return std::pow(light, 0.45); }}));
}

TEST(LampLight, TellsAShutterThatOpensLateOrClosesEarly) {
  CHECK_EQUAL("shutter_opens_late", window_fault_of({.early = 0.7}));
  CHECK_EQUAL("shutter_closes_early", window_fault_of({.late = 0.0}));
  CHECK_EQUAL("", fault_of({.late = 0.0}));
  // A shutter that closes after a third of the long trains, too.
  LampPhotographs cut = photographs({.late = 0.0});
  cut.of_a = photograph(33, 0, 1.0, 1.0), cut.of_b = photograph(0, 33, 1.0, 1.0),
  cut.of_both = photograph(33, 33, 1.0, 1.0);
  cut.of_a.flashes = cut.of_b.flashes = cut.of_both.flashes = 100;
  const auto light = measure_lamp_light(cut);
  CHECK(light.has_value());
  CHECK_EQUAL("shutter_closes_early", judge_exposure_window(*light).fault);
  CHECK_EQUAL("", judge_light(*light, {}).fault);
}

TEST(LampLight, NeedsSomethingThatReflects) {
  LampPhotographs dark = photographs({});
  for (LitPhotograph* lit : {&dark.of_a, &dark.of_b, &dark.of_both, &dark.early, &dark.late})
    lit->photograph.intensity = cv::Mat(60, 80, CV_32FC1, cv::Scalar(0.01));
  STRCMP_CONTAINS("white sheet", measure_lamp_light(dark).error().message.c_str());
  dark.of_b.photograph.intensity = cv::Mat(60, 81, CV_32FC1, cv::Scalar(0.01));
  CHECK_EQUAL("the photographs differ in size", measure_lamp_light(dark).error().message);
}
