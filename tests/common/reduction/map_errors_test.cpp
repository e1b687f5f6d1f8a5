// What the errors of the camera's map do to a readout.
#include <cmath>
#include <random>
#include <string>

#include "tests/common/reduction/reduced_frames.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

namespace {

constexpr double kShare = 0.002;

/// A calibrated frame, its scale known to a millionth.
Frame calibrated() {
  Frame frame = noisy(vacuum(), 5);
  frame.px_per_m = 4000.0;
  frame.px_per_m_sd = 0.004;
  return frame;
}

/// The map's scale is off by kShare at `slope` 0; at another slope it grows along x by that share in 4000 px.
MapError error_of(const Frame& frame, double slope) {
  const auto share = [&](const PointPx& p) { return kShare * (1.0 + slope * p.x / 4000.0); };
  MapError error;
  for (const BallImage& image : frame.images) {
    const double s = share(image.centre_px);
    error.images.push_back(
        {{s * image.centre_px.x, s * image.centre_px.y}, s * image.diameter_px, slope * 1e-3});
  }
  for (const PointPx& p : frame.surface_px) error.surface_px.push_back({share(p) * p.x, share(p) * p.y});
  return error;
}

Frame moved(Frame frame, double sds) {
  const auto errors = frame.map_errors;
  for (const MapError& error : errors) {
    for (std::size_t i = 0; i < frame.images.size(); ++i) {
      frame.images[i].centre_px.x += sds * error.images[i].centre_px.x;
      frame.images[i].centre_px.y += sds * error.images[i].centre_px.y;
      frame.images[i].diameter_px += sds * error.images[i].diameter_px;
      if (frame.images[i].equator_rad) *frame.images[i].equator_rad += sds * error.images[i].equator_rad;
    }
    for (std::size_t i = 0; i < frame.surface_px.size(); ++i) {
      frame.surface_px[i].x += sds * error.surface_px[i].x;
      frame.surface_px[i].y += sds * error.surface_px[i].y;
    }
  }
  return frame;
}

}  // namespace

TEST_GROUP(MapErrors){};

TEST(MapErrors, OfScaleAloneAreInVelocitiesAndNotInRatios) {
  Frame frame = calibrated();
  const Readout without = reduced(frame);
  frame.map_errors = {error_of(frame, 0.0)};
  const Readout with = reduced(frame);
  // Gravity and the calibrated scale hold a little against it: within 1 % of the share.
  const double vx = *with.value[Quantity::vx_td_mps];
  equal(std::hypot(*without.sd[Quantity::vx_td_mps], kShare * vx), with.sd[Quantity::vx_td_mps],
        0.01 * kShare * vx);
  equal(*without.sd[Quantity::e], with.sd[Quantity::e], 0.01 * *without.sd[Quantity::e]);
  equal(*without.value[Quantity::mu], with.value[Quantity::mu]);
}

TEST(MapErrors, AreThoseOfTheFrameSoMoved) {
  for (const double slope : {0.0, 1.0, -3.0}) {
    Frame frame = calibrated();
    const Readout without = reduced(frame);
    frame.map_errors = {error_of(frame, slope)};
    const Readout with = reduced(frame);
    const Readout up = reduced(moved(frame, 0.01)), down = reduced(moved(frame, -0.01));
    for (const Quantity q : {Quantity::mu, Quantity::e, Quantity::vx_lo_mps, Quantity::omega_td_radps}) {
      const double part = (*up.value[q] - *down.value[q]) / 0.02;
      const double expected = std::hypot(*without.sd[q], part);
      equal(expected, with.sd[q], 1e-3 * expected);  // a full sd against a hundredth: the curvature between
    }
  }
}

TEST(MapErrors, AreInTheCovarianceAndMirroredWithTheBall) {
  Frame frame = calibrated();
  frame.map_errors = {error_of(frame, 1.0)};
  const auto of = [](const Frame& f) { return *reduce(f, Estimator::best, {.covariance = true}); };
  const Readout right = of(frame);
  equal(*right.sd[Quantity::vx_td_mps], std::sqrt((*right.covariance)[0][0]), 1e-9);
  for (BallImage& image : frame.images) {
    image.centre_px.x = -image.centre_px.x;
    *image.equator_rad = -*image.equator_rad;
  }
  for (PointPx& p : frame.surface_px) p.x = -p.x;
  for (MapError::Shift& s : frame.map_errors[0].images) {
    s.centre_px.x = -s.centre_px.x;
    s.equator_rad = -s.equator_rad;
  }
  for (PointPx& p : frame.map_errors[0].surface_px) p.x = -p.x;
  equal(*right.sd[Quantity::mu], of(frame).sd[Quantity::mu], 1e-9);
}

TEST(MapErrors, ThatDoNotBelongToTheFrameAreRefused) {
  Frame frame = calibrated();
  frame.map_errors = {error_of(frame, 0.0)};
  frame.map_errors[0].images.pop_back();
  STRCMP_EQUAL("map_errors[0].images: must be one for each image", complaint(frame).c_str());
  frame.map_errors = {error_of(frame, 0.0)};
  frame.map_errors[0].surface_px[0].x = std::nan("");
  STRCMP_EQUAL("map_errors[0].surface_px: must be two finite numbers within 1e12", complaint(frame).c_str());
  frame.map_errors.assign(65, error_of(frame, 0.0));
  STRCMP_EQUAL("map_errors: at most 64", complaint(frame).c_str());
}

TEST(MapErrors, GoWithTheSurfacePointThatIsLeftOut) {
  Frame frame = calibrated();
  frame.map_errors = {error_of(frame, 0.0)};
  frame.surface_px.push_back({frame.surface_px[1].x + 40.0, frame.surface_px[1].y + 60.0});
  frame.map_errors[0].surface_px.push_back({1.0, 1.0});
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::outlier_surface_point));
  CHECK_TRUE(r.sd[Quantity::mu].has_value());
}

TEST(MapErrors, AScaleWithoutAnSdIsToldAndOneOfZeroIsNot) {
  Frame frame = calibrated();
  CHECK_FALSE(reduced(frame).flags.has(Flag::scale_sd_unknown));
  frame.px_per_m_sd = 0.0;
  CHECK_FALSE(reduced(frame).flags.has(Flag::scale_sd_unknown));
  frame.px_per_m_sd.reset();
  CHECK_TRUE(reduced(frame).flags.has(Flag::scale_sd_unknown));
  frame.px_per_m.reset();
  CHECK_FALSE(reduced(frame).flags.has(Flag::scale_sd_unknown));
}
