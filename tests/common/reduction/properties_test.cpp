// What must hold for any photograph. A failure prints the RC_PARAMS that repeat it.
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

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
