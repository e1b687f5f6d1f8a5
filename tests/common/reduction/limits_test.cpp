// Numbers at the edge of what a frame may hold and beyond it: a complaint that names the field, or a readout
// of finite numbers, with the floating-point exceptions of bad arithmetic trapped.
#include <rapidcheck.h>

#include <cfenv>
#include <cmath>
#include <limits>
#include <string>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::reduction;
using test::Bounce;
using test::Setup;

namespace {

/// An invalid operation, a division by zero or an overflow ends the test program.
class Trapped {
 public:
  Trapped() {
    std::feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(kExceptions);
  }
  Trapped(const Trapped&) = delete;
  Trapped& operator=(const Trapped&) = delete;
  ~Trapped() { fedisableexcept(kExceptions); }

 private:
  static constexpr int kExceptions = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;
};

Frame limiting_photograph(const Setup& setup = {}) {
  test::Random random(11);
  return test::photograph(Bounce{}, setup, random);
}

void check_finite(const Readout& r) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (r.value[q]) RC_ASSERT(std::isfinite(*r.value[q]));
    if (r.sd[q]) RC_ASSERT(std::isfinite(*r.sd[q]) && *r.sd[q] >= 0.0);
    if (r.sd_systematic[q]) RC_ASSERT(std::isfinite(*r.sd_systematic[q]) && *r.sd_systematic[q] >= 0.0);
  }
  if (!r.covariance) return;
  for (const auto& row : *r.covariance)
    for (const double x : row) RC_ASSERT(std::isfinite(x));
}

/// Reduced by every estimator, with exceptions trapped but for the legacy one, which divides as its program
/// did and drops what is no number; the complaint if there is one.
std::string tried(const Frame& frame) {
  for (const Estimator estimator : {Estimator::best, Estimator::two_point, Estimator::legacy}) {
    const auto reduced = [&] { return reduce(frame, estimator, {.covariance = true}); };
    const auto trapped = [&] {
      const Trapped traps;
      return reduced();
    };
    const Result<Readout> readout = estimator == Estimator::legacy ? reduced() : trapped();
    if (!readout) return readout.error().message;
    check_finite(*readout);
  }
  return "";
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct NamedNumber {
  const char* name;
  double* value;
};

/// Every number of a frame, with the name that a complaint gives it.
std::vector<NamedNumber> numbers_of(Frame& f) {
  BallImage& image = f.images[2];
  return {{"ball_diameter_m", &f.ball_diameter_m},
          {"ball_diameter_sd_m", &f.ball_diameter_sd_m.emplace(0.0008)},
          {"surface_px[1]", &f.surface_px[1].x},
          {"surface_px[3]", &f.surface_px[3].y},
          {"surface_sd_px", &f.surface_sd_px.emplace(2.0)},
          {"centre_sd_px", &f.centre_sd_px.emplace(2.0)},
          {"diameter_sd_px", &f.diameter_sd_px.emplace(2.0)},
          {"equator_sd_rad", &f.equator_sd_rad.emplace(0.02)},
          {"px_per_m", &f.px_per_m.emplace(4000.0)},
          {"px_per_m_sd", &f.px_per_m_sd.emplace(8.0)},
          {"surface_angle_deg", &f.surface_angle_deg},
          {"temperature_c", &f.temperature_c.emplace(20.0)},
          {"ball_mass_kg", &f.ball_mass_kg.emplace(0.0576)},
          {"ball_alpha", &f.ball_alpha.emplace(0.55)},
          {"ball_alpha_sd", &f.ball_alpha_sd.emplace(0.02)},
          {"air_density_kgpm3", &f.air_density_kgpm3.emplace(1.2)},
          {"images[2].time_s", &image.time_s},
          {"images[2].centre_px", &image.centre_px.x},
          {"images[2].centre_px", &image.centre_px.y},
          {"images[2].diameter_px", &image.diameter_px},
          {"images[2].equator_rad", &*image.equator_rad},
          {"images[2].time_sd_s", &image.time_sd_s.emplace(1e-6)},
          {"images[2].diameter_sd_px", &image.diameter_sd_px.emplace(2.0)},
          {"images[2].equator_sd_rad", &image.equator_sd_rad.emplace(0.02)},
          {"images[2].centre_cov_px2", image.centre_cov_px2.emplace(std::array{4.0, 0.0, 0.0, 4.0}).data()}};
}

/// A frame of random numbers within the limits, drawn in the middle of a property.
Frame extreme_frame() {
  const auto power = [](int least, int most) {
    return std::pow(10.0, *rc::gen::inRange(least, most + 1)) * (1.0 + *rc::gen::inRange(0, 1000) * 1e-3);
  };
  const auto sign = [] { return *rc::gen::arbitrary<bool>() ? 1.0 : -1.0; };
  const auto coordinate = [&] { return *rc::gen::inRange(0, 4) == 0 ? 0.0 : sign() * power(-12, 11); };
  const auto maybe = [] { return *rc::gen::arbitrary<bool>(); };
  Frame frame;
  frame.ball_diameter_m = 0.01 * (1 + *rc::gen::inRange(0, 99));
  if (maybe()) frame.centre_sd_px = power(-9, 11);
  if (maybe()) frame.diameter_sd_px = power(-9, 11);
  if (maybe()) frame.equator_sd_rad = power(-9, 5);
  if (maybe()) frame.surface_sd_px = power(-9, 11);
  if (maybe()) frame.px_per_m = power(-9, 11);
  if (maybe()) frame.px_per_m_sd = maybe() ? 0.0 : power(-9, 11);
  if (maybe()) frame.ball_diameter_sd_m = 0.001;
  if (maybe()) frame.temperature_c = 25.0;
  const int surface = *rc::gen::inRange(2, 5);
  for (int i = 0; i < surface; ++i) frame.surface_px.push_back({coordinate(), coordinate()});
  const int images = *rc::gen::inRange(0, 12);
  double time = 0.0;
  for (int i = 0; i < images; ++i) {
    BallImage image;
    image.time_s = time += power(-8, 6);
    const int leg = *rc::gen::inRange(0, 4);
    if (leg < 3) image.leg = static_cast<Leg>(leg);
    image.centre_px = {coordinate(), coordinate()};
    image.diameter_px = power(-9, 11);
    if (maybe()) image.equator_rad = sign() * power(-9, 5);
    if (*rc::gen::inRange(0, 4) == 0) image.time_sd_s = power(-12, -1);
    if (*rc::gen::inRange(0, 4) == 0) {
      const double x = power(-9, 11), y = power(-9, 11);
      const double correlation = *rc::gen::inRange(-999, 1000) * 1e-3;
      image.centre_cov_px2 = std::array{x * x, correlation * x * y, correlation * x * y, y * y};
    }
    frame.images.push_back(image);
  }
  return frame;
}

}  // namespace

TEST_GROUP(FrameLimits){};

TEST(FrameLimits, NotANumberInfinityAndHugeNumbersAreRefusedByName) {
  Frame frame = limiting_photograph();
  const std::size_t count = numbers_of(frame).size();
  for (std::size_t i = 0; i < count; ++i) {
    for (const double bad : {std::nan(""), kInfinity, -kInfinity, 1e308, -1e308, 1e100}) {
      Frame changed = limiting_photograph();
      const NamedNumber number = numbers_of(changed)[i];
      *number.value = bad;
      const std::string complaint = tried(changed);
      CHECK_TRUE_TEXT(complaint.rfind(number.name, 0) == 0,
                      (std::string(number.name) + " = " + std::to_string(bad) + ": " + complaint).c_str());
    }
  }
}

TEST(FrameLimits, TinyAndSubnormalNumbersAreRefusedByNameOrHarmless) {
  Frame frame = limiting_photograph();
  const std::size_t count = numbers_of(frame).size();
  for (std::size_t i = 0; i < count; ++i) {
    for (const double tiny : {5e-324, -5e-324, 1e-310, 1e-200, -1e-200, 0.0, 1e-30}) {
      Frame changed = limiting_photograph();
      const NamedNumber number = numbers_of(changed)[i];
      *number.value = tiny;
      const std::string complaint = tried(changed);
      // A time that is out of order is reported at the image where the order breaks.
      const bool time = std::string(number.name) == "images[2].time_s";
      CHECK_TRUE_TEXT(complaint.empty() || time || complaint.rfind(number.name, 0) == 0, complaint.c_str());
    }
  }
}

TEST(FrameLimits, ImagesWithinANanosecondAreRefused) {
  Frame frame = limiting_photograph();
  frame.images[3].time_s = frame.images[2].time_s + 1e-12;
  STRCMP_CONTAINS("images[3].time_s: must be later", tried(frame).c_str());
}

TEST(FrameLimits, NoFrameWithinThemGivesANumberThatIsNone) {
  CHECK_TRUE(rc::check("extreme frames", [] {
    for (int i = 0; i < 20; ++i) RC_ASSERT(tried(extreme_frame()) == "");
  }));
}

TEST(FrameLimits, IdenticalImagesAndExactDataGiveNoSpreadAndNoCrash) {
  // Exact data whose noise is to be estimated: what is left is rounding, some 1e-12 of the ball.
  Setup setup;
  setup.noise_factor = 0.0;
  setup.state_noise = false;
  setup.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  Frame frame = limiting_photograph(setup);
  frame.air_density_kgpm3 = 0.0;
  CHECK_EQUAL("", tried(frame));
  const auto r = reduce(frame, Estimator::best);
  DOUBLES_EQUAL(0.0, *r->sd[Quantity::vx_td_mps], 1e-7);
  DOUBLES_EQUAL(0.0, *r->sd[Quantity::e], 1e-7);
  DOUBLES_EQUAL(0.0, *r->sd[Quantity::omega_td_radps], 1e-6);
  // A ball that stands still, and one whose images are all one.
  for (BallImage& image : frame.images)
    image = {image.time_s, image.leg, {0, 500}, 260.0, 0.3, {}, {}, {}, {}, {}, {}, {}, ""};
  STRCMP_EQUAL("", tried(frame).c_str());
  const auto still = reduce(frame, Estimator::best);
  CHECK_TRUE(still->flags.has(Flag::degenerate_geometry));
  CHECK_FALSE(still->mirrored);
}
