#include <array>
#include <cmath>

#include "tests/common/reduction/reduced_frames.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;

TEST_GROUP(FrameChecks){};

TEST(FrameChecks, NameTheFieldThatIsWrong) {
  struct Row {
    const char* complaint;
    void (*change)(Frame& frame);
  };
  const Row rows[] = {
      {"ball_diameter_m: must be within 0.01 and 1", [](Frame& f) { f.ball_diameter_m = 0.0; }},
      {"surface_px: needs at least two points", [](Frame& f) { f.surface_px.resize(1); }},
      {"surface_px[2]: must be two finite numbers within 1e12",
       [](Frame& f) { f.surface_px[2].y = std::nan(""); }},
      {"images[3].centre_px: must be two finite numbers within 1e12",
       [](Frame& f) { f.images[3].centre_px.x = INFINITY; }},
      {"images[1].diameter_px: must be a positive number within 1e-9 and 1e12",
       [](Frame& f) { f.images[1].diameter_px = 0.0; }},
      {"images[1].time_s: must be later than the image before, by a nanosecond or more",
       [](Frame& f) { f.images[1].time_s = 0.0; }},
      {"images[4].centre_cov_px2: must be positive definite",
       [](Frame& f) {
         f.images[4].centre_cov_px2 = std::array{1.0, 2.0, 2.0, 1.0};
       }},
      {"images[4].centre_cov_px2: must be symmetric",
       [](Frame& f) {
         f.images[4].centre_cov_px2 = std::array{2.0, 1.0, 1.0 + 1e-5, 1.0};
       }},
      {"",  // rounding of printed numbers
       [](Frame& f) {
         f.images[4].centre_cov_px2 = std::array{1.0, 0.99, 0.99 + 1e-7, 1.0};
       }},
      {"centre_sd_px: must be a positive number within 1e-9 and 1e12",
       [](Frame& f) { f.centre_sd_px = 0.0; }},
      {"ball_alpha_sd: must be within 0 and 2/3", [](Frame& f) { f.ball_alpha_sd = -0.01; }},
      {"surface_angle_deg: must be within -90 and 90", [](Frame& f) { f.surface_angle_deg = 100.0; }},
      {"images[2].equator_sd_rad: must be positive, within 1e-9 and 1e6",
       [](Frame& f) { f.images[2].equator_sd_rad = 0.0; }},
  };
  for (const Row& row : rows) {
    Frame frame = straight_frame();
    row.change(frame);
    STRCMP_EQUAL(row.complaint, complaint(frame).c_str());
  }
}
