// Where a ball's markings are, by the share of the sphere that they cover and by what is known of single places.
#include <cmath>
#include <numbers>

#include "sim/photograph/ball_markings.hpp"
#include "sim/random/draws.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe::sim;

constexpr int kDirections = 40000;

/// Mean over directions that are uniform on the sphere; seed 11.
double covered(BallSurface surface) {
  const BallMarkings markings(surface);
  Draws draws(11, Purpose::appearance, 1);
  double sum = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 2.0 * draws.uniform() - 1.0, turn = 2.0 * std::numbers::pi * draws.uniform();
    const double flat = std::sqrt(1.0 - z * z);
    sum += markings.ink({flat * std::cos(turn), flat * std::sin(turn), z});
  }
  return sum / kDirections;
}

/// Four standard deviations of such a mean of zeros and ones.
double four_sd(double share) { return 4.0 * std::sqrt(share * (1.0 - share) / kDirections); }

void check_covered(BallSurface surface, double share) {
  DOUBLES_EQUAL(share, covered(surface), four_sd(share));
}

}  // namespace

TEST_GROUP(BallMarkings){};

// A cap out to the chord c has the share c²/4 of the sphere. Ink fades over .01 about it: as much on either side.
TEST(BallMarkings, AreFortyHolesOrTwoDozenDots) {
  check_covered(BallSurface::holes, 40 * 0.12 * 0.12 / 4.0);
  check_covered(BallSurface::dots, 24 * 0.09 * 0.09 / 4.0);
}

// Pentagons of the truncated icosahedron with edges of 1, whose corners are 2.478 from the middle: each is ten right
// spherical triangles with an angle of pi/5 in its middle and there the hypotenuse to a corner, as far as it is
// from the corners' circle, of radius 1/(2 sin(pi/5)). A third angle B has cot B = cos(hypotenuse) tan(pi/5).
TEST(BallMarkings, AreTwelvePentagonsAndTheHexagonsSeams) {
  const double fifth = std::numbers::pi / 5.0;
  const double hypotenuse = std::asin(1.0 / (2.0 * std::sin(fifth)) / 2.47802);
  const double third = std::atan2(1.0, std::cos(hypotenuse) * std::tan(fifth));
  const double pentagons = 12 * 10 * (fifth + third - 0.5 * std::numbers::pi) / (4.0 * std::numbers::pi);
  // Ninety edges, each as long as its chord of 1/2.478 is seen, have seams with an ink of .6 and a half width of .008.
  // On the sixty that border on a pentagon it is seen on the hexagon's side alone.
  const double edge = 2.0 * std::asin(0.5 / 2.47802);
  const double seams = 0.6 * 0.008 * edge * (30 * 2 + 60) / (4.0 * std::numbers::pi);
  // Beside noise: how far products differ beside a border is known to a tenth of a seam's width.
  DOUBLES_EQUAL(pentagons + seams, covered(BallSurface::panels), four_sd(pentagons) + 0.1 * seams);
}

TEST(BallMarkings, LieAlongTheSeam) {
  const BallMarkings stitches(BallSurface::stitches);
  for (int k = 0; k < 200; ++k) {
    const Vec3 p = seam_point(2.0 * std::numbers::pi * k / 200);
    DOUBLES_EQUAL(1.0, dot(p, p), 1e-12);
    CHECK(stitches.ink(p) >= 0.5);
  }
  // The farthest from the curve: the middle of a flap.
  DOUBLES_EQUAL(0.0, stitches.ink({0.0, 0.0, 1.0}), 0.0);
  const BallMarkings band(BallSurface::band);
  DOUBLES_EQUAL(0.0, band.ink({0.0, 0.0, 1.0}), 0.0);
  const BallMarkings channels(BallSurface::channels);
  DOUBLES_EQUAL(1.0, channels.ink({0.0, 0.6, 0.8}), 0.0);
  DOUBLES_EQUAL(1.0, channels.ink({0.6, 0.0, 0.8}), 0.0);
  DOUBLES_EQUAL(0.0, channels.ink({0.3, 0.3, std::sqrt(1.0 - 0.18)}), 0.0);
}

TEST(BallMarkings, NotchTheOutlineWhereAHoleIs) {
  const BallMarkings holes(BallSurface::holes);
  // The first hole's middle is at the height 1 - 1/40. Seen from where it is on the outline, its rim is acos(1 -
  // .12²/2) away: steps of .005 rad change the cosine by .005·sin(.125) at most.
  const double height = 1.0 - 1.0 / 40.0;
  const Vec3 middle{std::sqrt(1.0 - height * height), 0.0, height};
  const Vec3 across{0.0, 1.0, 0.0};
  DOUBLES_EQUAL(1.0 - 0.5 * 0.12 * 0.12, holes.edge_beyond(middle, across), 0.005 * 0.125);
  DOUBLES_EQUAL(1.0, BallMarkings(BallSurface::dots).edge_beyond(middle, across), 0.0);
}
