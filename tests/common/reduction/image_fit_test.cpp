// What a person is told of each image of a photograph.
#include "common/reduction/reduce.hpp"

#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

Frame exact_frame() {
  Setup setup = vacuum();
  setup.noise_factor = 0.0;
  Frame frame = noisy(setup);
  frame.air_density_kgpm3 = 0.0;
  return frame;
}

std::vector<ImageFit> fits_of(const Frame& frame) {
  const auto fits = image_fits(frame);
  CHECK_TRUE(fits.has_value());
  CHECK_EQUAL(frame.images.size(), fits->size());
  return *fits;
}

}  // namespace

TEST_GROUP(ImageFits){};

TEST(ImageFits, OfExactAirborneImagesLieOnTheirLegsPathAndAreUsedThoseInContactNot) {
  const Frame frame = exact_frame();
  for (std::size_t i = 0; const ImageFit& fit : fits_of(frame)) {
    const auto leg = frame.images[i++].leg;
    CHECK_TRUE(fit.leg == leg);
    const bool airborne = leg != Leg::contact;
    CHECK_TRUE(fit.centre_used == airborne && fit.diameter_used == airborne && fit.equator_used == airborne);
    CHECK_EQUAL(airborne, fit.residual_px.has_value());
    DOUBLES_EQUAL(0.0, fit.residual_px.value_or(0.0),
                  1e-8);  // rounding of 1e3 px, through a condition below 1e4
  }
}

TEST(ImageFits, TellHowFarFromItsPathAnImageIsThatWasLeftOut) {
  Frame frame = exact_frame();
  frame.images[1].centre_px.x += 30.0;
  frame.images[1].centre_px.y += 40.0;
  const std::vector<ImageFit> fits = fits_of(frame);
  CHECK_FALSE(fits[1].centre_used);
  equal(50.0, fits[1].residual_px, 1e-8);  // without noise the others' path is the true one
  for (const std::size_t i : {0U, 2U, 3U}) CHECK_TRUE(fits[i].centre_used);
}

TEST(ImageFits, WithoutASurfaceAreUsedForNothing) {
  Frame frame = exact_frame();
  for (auto& point : frame.surface_px) point = frame.surface_px.front();
  for (const ImageFit& fit : fits_of(frame)) {
    CHECK_FALSE(fit.centre_used || fit.diameter_used || fit.equator_used);
    CHECK_FALSE(fit.residual_px.has_value());
  }
}
