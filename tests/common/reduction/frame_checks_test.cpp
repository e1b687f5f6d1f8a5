// Frames that are refused, and why.
#include <array>
#include <cmath>

#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

TEST_GROUP(FrameChecks){};

TEST(FrameChecks, NameTheFieldThatIsWrong) {
  Frame frame = straight_frame();
  frame.ball_diameter_m = 0.0;
  STRCMP_CONTAINS("ball_diameter_m", complaint(frame).c_str());
  frame = straight_frame();
  frame.surface_px.resize(1);
  STRCMP_CONTAINS("surface_px: needs at least two points", complaint(frame).c_str());
  frame = straight_frame();
  frame.surface_px[2].y = std::nan("");
  STRCMP_CONTAINS("surface_px[2]", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[3].centre_px.x = INFINITY;
  STRCMP_CONTAINS("images[3].centre_px", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[1].diameter_px = 0.0;
  STRCMP_CONTAINS("images[1].diameter_px", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[1].time_s = 0.0;
  STRCMP_CONTAINS("images[1].time_s: must be later", complaint(frame).c_str());
  frame = straight_frame();
  frame.images[4].centre_cov_px2 = std::array{1.0, 2.0, 2.0, 1.0};
  STRCMP_CONTAINS("images[4].centre_cov_px2: must be positive definite", complaint(frame).c_str());
  frame.images[4].centre_cov_px2 = std::array{2.0, 1.0, 1.0 + 1e-5, 1.0};
  STRCMP_CONTAINS("images[4].centre_cov_px2: must be symmetric", complaint(frame).c_str());
  frame.images[4].centre_cov_px2 = std::array{2.0, 1.0, 1.0 + 1e-7, 1.0};  // rounding of printed numbers
  STRCMP_EQUAL("accepted", complaint(frame).c_str());
  frame = straight_frame();
  frame.centre_sd_px = 0.0;
  STRCMP_CONTAINS("centre_sd_px", complaint(frame).c_str());
  frame = straight_frame();
  frame.surface_angle_deg = 100.0;
  STRCMP_CONTAINS("surface_angle_deg", complaint(frame).c_str());
}
