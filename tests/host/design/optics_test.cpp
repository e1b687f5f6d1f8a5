// A lens' numbers against rays traced through a thin lens, formulas of other forms, and limits.
#include "host/design/optics.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace strobe;
using host::LensSetUp;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Diameter on the sensor, m, of what a point at `object_m` makes: rays by the lens' rim meet where the lens equation
/// 1/f = 1/s + 1/v says, the sensor is where it says for the plane.
double traced_disc_m(const LensSetUp& s, double object_m) {
  const double f = 1e-3 * s.focal_length_mm, rim = 0.5 * f / s.f_number;
  const double sensor = 1.0 / (1.0 / f - 1.0 / s.distance_m), meets = 1.0 / (1.0 / f - 1.0 / object_m);
  return 2.0 * std::abs(rim * (meets - sensor) / meets);
}

}  // namespace

TEST_GROUP(Optics) {
  /// 50 mm at 2.05 m: m = 50/2000, by hand.
  LensSetUp set_up{2592, 2048, 5.0, 50.0, 8.0, 2.05};
};

TEST(Optics, ScaleAndViewAreTheThinLensNotThePinhole) {
  DOUBLES_EQUAL(0.025, magnification(set_up), 1e-15);
  DOUBLES_EQUAL(5000.0, px_per_m(set_up), 1e-9);  // a pinhole would have 4878
  DOUBLES_EQUAL(0.5184, view_size(set_up).width_m, 1e-12);
  DOUBLES_EQUAL(0.4096, view_size(set_up).height_m, 1e-12);
  set_up.distance_m = 0.1;  // at twice the focal length as large as life
  DOUBLES_EQUAL(1.0, magnification(set_up), 1e-14);
}

TEST(Optics, DepthOfFieldIsThatOfTheHyperfocalFormulas) {
  // 50 mm, f/8, 3 m, circle of 0.03 mm: H = f²/(N c) + f, s (H - f)/(H + s - 2 f), s (H - f)/(H - s); tables for
  // 35-mm film print 2.34 and 4.19 m, and 10.5 m for H.
  LensSetUp film{3600, 2400, 10.0, 50.0, 8.0, 3.0};
  const double h = 2500.0 / 0.24 + 50.0;
  const auto depth = depth_of_field(film, 3.0);
  DOUBLES_EQUAL(1e-3 * 3000.0 * (h - 50.0) / (h + 3000.0 - 100.0), depth.near_m, 1e-12);
  DOUBLES_EQUAL(1e-3 * 3000.0 * (h - 50.0) / (h - 3000.0), depth.far_m, 1e-12);
  DOUBLES_EQUAL(2.34, depth.near_m, 0.005);
  DOUBLES_EQUAL(4.19, depth.far_m, 0.005);
  film.distance_m = 1e-3 * h * 1.000001;
  DOUBLES_EQUAL(kInfinity, depth_of_field(film, 3.0).far_m, 0.0);
  DOUBLES_EQUAL(0.5e-3 * h, depth_of_field(film, 3.0).near_m, 1e-4);  // half the hyperfocal distance
}

TEST(Optics, RaysThroughTheRimMakeTheCircleAtBothEndsOfTheDepth) {
  for (const double f_number : {1.4, 4.0, 16.0}) {
    for (const double distance_m : {0.12, 0.8, 3.0}) {
      set_up.f_number = f_number;
      set_up.distance_m = distance_m;
      const auto depth = depth_of_field(set_up, 1.5);
      DOUBLES_EQUAL(7.5e-6, traced_disc_m(set_up, depth.near_m), 1e-15);
      if (std::isfinite(depth.far_m)) DOUBLES_EQUAL(7.5e-6, traced_disc_m(set_up, depth.far_m), 1e-15);
    }
  }
}

TEST(Optics, ABallOffThePlaneIsBlurredAsTracedRaysSpread) {
  for (const double z : {-0.1, -0.01, 0.02, 0.3}) {
    const double disc_px = traced_disc_m(set_up, set_up.distance_m + z) / 5e-6;
    // The sd of a disc along a line by summing its chords: the midpoint rule's error at 2000 is below 1e-4 of it.
    double squares = 0.0, area = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const double x = -1.0 + (i + 0.5) / 1000.0, chord = std::sqrt(1.0 - x * x);
      squares += x * x * chord;
      area += chord;
    }
    DOUBLES_EQUAL(0.5 * disc_px * std::sqrt(squares / area), defocus_sd_px(set_up, z), 1e-4 * disc_px);
  }
  DOUBLES_EQUAL(0.0, defocus_sd_px(set_up, 0.0), 0.0);
}

TEST(Optics, LimitsOfDistanceAndFNumber) {
  set_up.distance_m = kInfinity;
  CHECK_TRUE(check(set_up).has_value());
  DOUBLES_EQUAL(0.0, px_per_m(set_up), 0.0);
  DOUBLES_EQUAL(kInfinity, view_size(set_up).width_m, 0.0);
  DOUBLES_EQUAL(kInfinity, depth_of_field(set_up, 2.0).far_m, 0.0);
  DOUBLES_EQUAL(2.5e-3 / (8.0 * 10e-6), depth_of_field(set_up, 2.0).near_m, 1e-9);  // f²/(N c)
  set_up.distance_m = 2.05;
  // Twice the f-number: half the blur off the plane, twice the diffraction.
  LensSetUp closed = set_up;
  closed.f_number *= 2.0;
  DOUBLES_EQUAL(0.5 * defocus_sd_px(set_up, 0.05), defocus_sd_px(closed, 0.05), 1e-12);
  DOUBLES_EQUAL(2.0 * diffraction_sd_px(set_up), diffraction_sd_px(closed), 1e-12);
}

TEST(Optics, DiffractionIsAsWideAsTheAiryDiscsMiddle) {
  // The Airy disc is half as bright 0.5145 λN from its middle (tables of J1): a Gaussian of that width has an sd of
  // 0.437 λN; one of the same curvature is 3 % wider. Here f/8.2, 0.55 µm and 5 µm.
  DOUBLES_EQUAL(0.5145 / std::sqrt(2.0 * std::log(2.0)) * 0.55 * 8.2 / 5.0, diffraction_sd_px(set_up), 0.03);
}

TEST(Optics, PerspectiveAndMotionByHand) {
  // 1 mm of 2.05 m; 30 m/s for 20 µs are 0.6 mm, 3 px.
  DOUBLES_EQUAL(1.0 / 2050.0, perspective_per_mm(set_up), 1e-15);
  DOUBLES_EQUAL(3.0, motion_px(set_up, 30.0, 20e-6), 1e-12);
}

TEST(Optics, DistanceForAScaleHasThatScale) {
  DOUBLES_EQUAL(2.05, distance_for_scale_m(set_up, 5000.0), 1e-12);
  for (const double wanted : {100.0, 2500.0, 100'000.0}) {
    set_up.distance_m = distance_for_scale_m(set_up, wanted);
    DOUBLES_EQUAL(wanted, px_per_m(set_up), 1e-9 * wanted);
  }
}

TEST(Optics, TheLongestUsualLensThatSeesEnough) {
  // At 2.05 m 50 mm sees .5184 m x .4096 m, the next longer one, 60 mm, .4299 m.
  DOUBLES_EQUAL(50.0, *focal_length_for_view_mm(set_up, {0.5, 0.4}), 0.0);
  DOUBLES_EQUAL(60.0, *focal_length_for_view_mm(set_up, {0.42, 0.3}), 0.0);
  DOUBLES_EQUAL(40.0, *focal_length_for_view_mm(set_up, {0.5, 0.5}), 0.0);  // the height decides
  CHECK_FALSE(focal_length_for_view_mm(set_up, {100.0, 1.0}).has_value());
}

TEST(Optics, NamesTheFieldThatIsOutOfRange) {
  set_up.f_number = 0.1;
  STRCMP_EQUAL("f_number: must be 0.5 to 128", check(set_up).error().message.c_str());
  set_up.f_number = 8.0;
  set_up.distance_m = 0.05;
  STRCMP_EQUAL("distance_m: must be above the focal length", check(set_up).error().message.c_str());
  set_up.distance_m = std::nan("");
  CHECK_FALSE(check(set_up).has_value());
}
