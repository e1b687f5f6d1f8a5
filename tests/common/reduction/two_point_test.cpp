// The numbers from two images a leg, worked out by hand in the comments.
#include <cmath>

#include "tests/common/reduction/reduced_frames.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

TEST_GROUP(TwoPoint){};

TEST(TwoPoint, GivesTheNumbersWorkedOutByHand) {
  Frame frame = straight_frame();
  frame.temperature_c = 13.0;
  const Readout r = reduced(frame, Estimator::two_point);
  LONGS_EQUAL(7, r.shot_id);
  CHECK_EQUAL("two-point", r.method);
  equal(15.0, r.value[Quantity::vx_td_mps]);
  equal(-6.0, r.value[Quantity::vy_td_mps]);
  equal(std::sqrt(261.0), r.value[Quantity::v_td_mps]);
  equal(-21.80140948635181, r.value[Quantity::theta_in_deg]);  // atan(6 / 15)
  equal(29.05460409907715, r.value[Quantity::theta_out_deg]);  // atan(5 / 9)
  equal(-100.0, r.value[Quantity::omega_td_radps]);
  equal(150.0, r.value[Quantity::omega_lo_radps]);
  equal(9.0, r.value[Quantity::vx_lo_mps]);
  equal(5.0, r.value[Quantity::vy_lo_mps]);
  equal(9.0 + 0.0325 * 150.0, r.value[Quantity::slip_lo_mps]);
  equal(5.0 / 6.0, r.value[Quantity::e]);
  equal(6.0 / 11.0, r.value[Quantity::mu]);
  equal(5.0, r.value[Quantity::dwell_time_ms]);
  equal(5.0, r.value[Quantity::dwell_distance_cm]);
  // e at 23 degrees: 5/6 + 0.003 * 10; 100 (1 - 6/11) + 150 (0.81 - 0.8633...) = 45.4545... - 8
  equal(500.0 / 11.0 - 8.0, r.value[Quantity::court_pace]);
  CHECK_FALSE(r.court_pace_conforming);
  CHECK_FALSE(r.mirrored);
  CHECK_TRUE(r.flags.has(Flag::no_redundancy));
}

TEST(TwoPoint, StandardDeviationsFollowFromTheTwoImages) {
  const Readout r = reduced(straight_frame(), Estimator::two_point);
  // Spin: two angles of 0.01 rad over 2 ms.
  equal(0.01 * std::sqrt(2.0) / 2e-3, r.sd[Quantity::omega_td_radps]);
  // vx = 30 px / 2 ms / scale. Positions: 0.5 px each, so 0.5 sqrt 2 / 2 ms = 0.353553 m/s; scale: four
  // diameters of 0.5 px in 65 give 0.384615 %, of 15 m/s 0.0576923; tilt: points at -150, -50, 50, 150 from
  // their mean have a moment of 50000 px^2, so 0.5 / sqrt(50000) = 2.23607e-3 rad, times vy of 6 gives
  // 0.0134164.
  equal(std::sqrt(0.35355339059327 * 0.35355339059327 + 0.05769230769231 * 0.05769230769231 +
                  0.01341640786500 * 0.01341640786500),
        r.sd[Quantity::vx_td_mps]);
}

TEST(TwoPoint, IgnoresAllButTheImagesNextToTheImpact) {
  Frame frame = straight_frame();
  BallImage far = ball_image(-2, Leg::incoming, 70, 190, 2.0);
  frame.images.insert(frame.images.begin(), far);
  const Readout r = reduced(frame, Estimator::two_point);
  equal(15.0, r.value[Quantity::vx_td_mps]);
  equal(-100.0, r.value[Quantity::omega_td_radps]);
}
