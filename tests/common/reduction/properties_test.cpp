// What must hold for any photograph. A failure prints the RC_PARAMS that repeat it.
#include <cfenv>
#include <cmath>
#include <limits>
#include <numbers>
#include <rapidcheck.h>
#include <string>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using test::Bounce;
using test::Setup;

namespace {

double real(double least, double most) {
  return least + (most - least) * *rc::gen::inRange(0, 1'000'001) * 1e-6;
}

Bounce any_bounce() {
  Bounce b;
  b.vx_td = real(3.0, 40.0), b.vy_td = real(-20.0, -3.0), b.omega_td = real(-400.0, 400.0);
  b.vx_lo = real(1.0, 30.0), b.vy_lo = real(2.0, 15.0), b.omega_lo = real(-400.0, 400.0);
  b.dwell_s = real(3e-3, 7e-3), b.dwell_x_m = real(0.01, 0.1);
  return b;
}

Setup any_setup() {
  Setup s;
  s.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  s.phase = real(0.06, 0.94);  // with the jitter below no image slips past touchdown or lift-off
  s.roll_rad = real(-0.3, 0.3);
  s.incoming = *rc::gen::inRange(2, 8);
  s.rebound = *rc::gen::inRange(2, 8);
  s.incline_rad = real(-0.5, 0.5);
  s.flash_jitter_s = real(0.0, 3e-5);
  return s;
}

Frame photograph(const Bounce& b, const Setup& s) {
  test::Random random(*rc::gen::arbitrary<std::uint64_t>());
  return test::photograph(b, s, random);
}

Frame photograph() {
  const Bounce b = any_bounce();
  return photograph(b, any_setup());
}

/// These photographs are of flight without air.
Readout reduced(const Frame& frame, Estimator estimator = Estimator::best) {
  const auto readout = reduce(frame, estimator, {.effects = flight::kGravityOnly});
  RC_ASSERT(readout.has_value());
  return *readout;
}

/// Values agree to a share of their sd: `share` covers rounding and where the iteration stops (1e-5 sd and
/// better).
void same(const Readout& a, const Readout& b, double share = 1e-4) {
  RC_ASSERT(a.flags == b.flags);
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    RC_ASSERT(a.value[q].has_value() == b.value[q].has_value());
    if (!a.value[q]) continue;
    RC_ASSERT(std::abs(*a.value[q] - *b.value[q]) <= share * *a.sd[q]);
    RC_ASSERT(std::abs(*a.sd[q] - *b.sd[q]) <= share * *a.sd[q]);
  }
}

void check(const char* what, void (*property)()) { CHECK_TRUE_TEXT(rc::check(what, property), what); }

}  // namespace

TEST_GROUP(ReductionProperties){};

TEST(ReductionProperties, TheMirrorImageReadsTheSame) {
  check("mirror", [] {
    Frame frame = photograph();
    const Readout right = reduced(frame);
    for (PointPx& p : frame.surface_px) p.x = -p.x;
    for (BallImage& i : frame.images) i.centre_px.x = -i.centre_px.x, i.equator_rad = -*i.equator_rad;
    frame.surface_angle_deg = -frame.surface_angle_deg;
    const Readout left = reduced(frame);
    RC_ASSERT(left.mirrored != right.mirrored);
    same(right, left);
  });
}

TEST(ReductionProperties, TurningShiftingAndScalingThePhotographChangesNothing) {
  check("similarity", [] {
    Frame frame = photograph();
    const Readout before = reduced(frame);
    // with the roll: less than the quarter turn at which up becomes down
    const double turn = real(-1.0, 1.0);
    const double scale = std::pow(10.0, real(-3.0, 3.0)), dx = real(-1e4, 1e4) * scale;
    const double dy = real(-1e4, 1e4) * scale;
    const auto move = [&](PointPx& p) {
      p = {scale * (std::cos(turn) * p.x - std::sin(turn) * p.y) + dx,
           scale * (std::sin(turn) * p.x + std::cos(turn) * p.y) + dy};
    };
    for (PointPx& p : frame.surface_px) move(p);
    for (BallImage& i : frame.images) {
      move(i.centre_px);
      i.diameter_px *= scale;
      *i.equator_rad += turn;
    }
    *frame.centre_sd_px *= scale;
    *frame.diameter_sd_px *= scale;
    same(before, reduced(frame));
  });
}

TEST(ReductionProperties, AnotherOriginOfTimeChangesNothing) {
  check("time", [] {
    Frame frame = photograph();
    const Readout before = reduced(frame);
    const double shift = real(-1e4, 1e4);  // rounding of 1 ps: 1e-4 of an sd needs 10 ns at 40 m/s and 0.5 mm
    for (BallImage& i : frame.images) i.time_s += shift;
    same(before, reduced(frame));
  });
}

TEST(ReductionProperties, WithoutNoiseTheBestEstimatorIsExact) {
  check("exact", [] {
    const Bounce b = any_bounce();
    Setup setup = any_setup();
    setup.noise_factor = 0.0;
    const Readout r = reduced(photograph(b, setup));
    const Quantities truth = test::truth(b);
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (truth[q])
        RC_ASSERT(std::abs(*r.value[q] - *truth[q]) <= 1e-6 * *r.sd[q] + 1e-9 * std::abs(*truth[q]));
    }
  });
}

TEST(ReductionProperties, WithoutNoiseAndGravityTwoPointIsExact) {
  check("two-point", [] {
    const Bounce b = any_bounce();
    Setup setup = any_setup();
    setup.noise_factor = 0.0;
    setup.gravity_mps2 = 0.0;
    const Readout r = reduced(photograph(b, setup), Estimator::two_point);
    const Quantities truth = test::truth(b);
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (truth[q])
        RC_ASSERT(std::abs(*r.value[q] - *truth[q]) <= 1e-6 * *r.sd[q] + 1e-9 * std::abs(*truth[q]));
    }
  });
}

TEST(ReductionProperties, LessNoiseMeansASmallerSdOfEveryNumber) {
  check("noise", [] {
    const Bounce b = any_bounce();
    Setup setup = any_setup();
    setup.noise_factor = 0.0;
    Frame frame = photograph(b, setup);
    const Readout wide = reduced(frame);
    *frame.centre_sd_px *= 0.5;
    *frame.diameter_sd_px *= 0.5;
    *frame.equator_sd_rad *= 0.5;
    const Readout narrow = reduced(frame);
    for (std::size_t i = 0; i < kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (wide.sd[q]) RC_ASSERT(std::abs(*narrow.sd[q] - 0.5 * *wide.sd[q]) <= 1e-6 * *wide.sd[q]);
    }
  });
}

TEST(ReductionProperties, NoFrameOfNumbersBreaksIt) {
  check("any numbers", [] {
    Frame frame;
    frame.ball_diameter_m = real(0.01, 1.0);
    const auto coordinate = [] { return real(-1.0, 1.0) * std::pow(10.0, real(-3.0, 6.0)); };
    const int surface = *rc::gen::inRange(2, 6);
    for (int i = 0; i < surface; ++i) frame.surface_px.push_back({coordinate(), coordinate()});
    const int images = *rc::gen::inRange(0, 12);
    double time = 0.0;
    for (int i = 0; i < images; ++i) {
      BallImage image;
      image.time_s = time += real(1e-6, 1.0);
      const int leg = *rc::gen::inRange(0, 4);
      if (leg < 3) image.leg = static_cast<Leg>(leg);
      image.centre_px = {coordinate(), coordinate()};
      image.diameter_px = std::pow(10.0, real(-3.0, 6.0));
      if (*rc::gen::arbitrary<bool>()) image.equator_rad = real(-10.0, 10.0);
      frame.images.push_back(image);
    }
    for (const Estimator estimator : {Estimator::best, Estimator::two_point, Estimator::legacy}) {
      const Readout r = reduced(frame, estimator);
      for (std::size_t i = 0; i < kQuantityCount; ++i) {
        const auto q = static_cast<Quantity>(i);
        if (r.value[q]) RC_ASSERT(std::isfinite(*r.value[q]));
        if (r.sd[q]) RC_ASSERT(std::isfinite(*r.sd[q]) && *r.sd[q] >= 0.0);
      }
    }
  });
}

// Numbers at the edge of what a frame may hold and beyond it: a complaint that names the field, or a readout
// of finite numbers, with the floating-point exceptions of bad arithmetic trapped.

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

void check_finite(const Numbers& r) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (r.value[q]) RC_ASSERT(std::isfinite(*r.value[q]));
    if (r.sd[q]) RC_ASSERT(std::isfinite(*r.sd[q]) && *r.sd[q] >= 0.0);
    if (r.sd_systematic[q]) RC_ASSERT(std::isfinite(*r.sd_systematic[q]) && *r.sd_systematic[q] >= 0.0);
  }
}

void check_finite(const Readout& r) {
  check_finite(static_cast<const Numbers&>(r));
  if (r.launch) check_finite(static_cast<const Numbers&>(*r.launch));
  if (r.likely_cause) RC_ASSERT(std::isfinite(r.likely_cause->value) && std::isfinite(r.likely_cause->sd));
  if (!r.covariance) return;
  for (const auto& row : *r.covariance)
    for (const double x : row) RC_ASSERT(std::isfinite(x));
}

/// Reduced by every estimator, with exceptions trapped but for the legacy one, which divides as its program
/// did and drops what is no number; the complaint if there is one.
std::string tried(const Frame& frame) {
  for (const Estimator estimator : {Estimator::best, Estimator::two_point, Estimator::legacy}) {
    if (frame.surface_px.empty() && estimator != Estimator::best) continue;
    const auto reduced = [&] { return reduce(frame, estimator, {.covariance = true, .likely_cause = true}); };
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
  const int surface = *rc::gen::element(0, 2, 3, 4);
  for (int i = 0; i < surface; ++i) frame.surface_px.push_back({coordinate(), coordinate()});
  const int images = *rc::gen::inRange(0, 12);
  double time = 0.0;
  for (int i = 0; i < images; ++i) {
    BallImage image;
    image.time_s = time += power(-8, 6);
    const int leg = *rc::gen::inRange(0, 4);
    if (leg < 3 && surface > 0) image.leg = static_cast<Leg>(leg);
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
