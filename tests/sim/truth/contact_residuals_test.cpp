// The rig's contact is the ODE, the analysis's is the damped sine: what images taken in contact show of their
// difference. A photograph's images, digitized with noise, are compared by the analysis of `strobe contact`;
// the difference that they should show is computed by neither of the two (independent_contact.hpp).
#include <array>
#include <cmath>
#include <vector>

#include "common/contact/standard_error.hpp"
#include "sim/rig/truth.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/sim/truth/independent_contact.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;
using reduction::Quantity;

constexpr std::uint64_t kSeed = 41;
constexpr int kShots = 150;
constexpr double kNoise_m = 0.1e-3;
constexpr int kSteps = 20000;

/// One ball again and again, at every phase of a fast train: 1.5 ms, some three images in contact.
Scene scene_of(ContactLaw law) {
  Scene scene;
  scene.machine.angle_rad = -23.0 * std::numbers::pi / 180.0;
  scene.machine.lag_sd_s = 1e-3;
  scene.machine.spot_sd_m = 0.0;
  scene.bounce.contact = law;
  scene.bounce.e = 0.77;
  scene.bounce.e_speed_mps = 17.0 * std::sin(23.0 * std::numbers::pi / 180.0);
  scene.bounce.top_drop_ratio = 1.0;
  scene.camera.roll_rad = 0.0;
  scene.tablet.centre_sd_m = kNoise_m;
  return scene;
}

struct Seen {
  double time_s = 0.0;  ///< since touchdown
  double x_m = 0.0, y_m = 0.0;
};

struct Photographed {
  std::vector<Seen> seen;
  reduction::Quantities truth;
  double dwell_s = 0.0;
};

/// Where the photographs show the ball in contact. The camera is level and its scale known.
Photographed photograph(const Scene& scene) {
  auto shooter = Shooter::make(scene, kSeed, Model::full().without(Effect::contact_gravity),
                               {.period = microseconds(1500)});
  Photographed out;
  for (int number = 1; number <= kShots; ++number) {
    const SimulatedShot shot = shooter->shoot(number);
    CHECK(shot.flags.none());
    const ThrownBall& ball = *shot.exposure.ball;
    out.truth = shot.truth;
    out.dwell_s = ball.path.dwell_s();
    for (std::size_t i = 0; i < shot.frame.images.size(); ++i) {
      const Pulse& pulse = shot.exposure.pulses[static_cast<std::size_t>(shot.image_pulse[i])];
      const double t = to_seconds(flash_time(pulse) - ball.touchdown);
      if (t <= 0.0 || t >= out.dwell_s) continue;
      const reduction::PointPx& p = shot.frame.images[i].centre_px;
      out.seen.push_back({t, (p.x - scene.camera.origin_x_px) / scene.camera.px_per_m,
                          (p.y - scene.camera.origin_y_px) / scene.camera.px_per_m - scene.ball.radius_m()});
    }
  }
  CHECK(out.seen.size() > 300);
  return out;
}

/// As `strobe contact` has it: the exact sine over the whole dwell time, friction at the impulse ratio.
impact::SinePulse assumed(const Photographed& p) {
  return *impact::SinePulse::make(impact::PulseForm::exact, {.vx_td_mps = *p.truth[Quantity::vx_td_mps],
                                                             .vy_td_mps = *p.truth[Quantity::vy_td_mps],
                                                             .e = *p.truth[Quantity::e],
                                                             .impulse_ratio = *p.truth[Quantity::mu],
                                                             .dwell_s = p.dwell_s});
}

contact::StandardErrors errors_of(const Photographed& p, const contact::Trajectory& motion,
                                  const Scene& scene) {
  data::ContactSet set{.name = "photographed", .rows = {}};
  const double distance_m = *p.truth[Quantity::dwell_distance_cm] / 100.0;
  for (const Seen& s : p.seen)
    set.rows.push_back(
        {s.time_s / p.dwell_s, s.x_m / distance_m, s.y_m / scene.ball.diameter_m, std::nullopt});
  const auto errors = contact::standard_errors(
      set, motion,
      {.dwell_distance_m = distance_m, .diameter_m = scene.ball.diameter_m, .total_rotation_rad = {}});
  CHECK(errors.has_value());
  return *errors;
}

/// Where the ball should have been.
class Expected {
 public:
  Expected(const Scene& scene, const Photographed& p)
      : dwell_s_(p.dwell_s),
        course_(strobe::testing::contact_course({.mass_kg = scene.ball.mass_kg,
                                                 .radius_m = scene.ball.radius_m(),
                                                 .alpha = scene.ball.alpha,
                                                 .vx_mps = *p.truth[Quantity::vx_td_mps],
                                                 .vy_mps = *p.truth[Quantity::vy_td_mps],
                                                 .omega_radps = *p.truth[Quantity::omega_td_radps],
                                                 .e = scene.bounce.e,
                                                 .dwell_s = p.dwell_s,
                                                 .mu = scene.bounce.mu,
                                                 .stiffness_ratio = scene.bounce.stiffness_ratio,
                                                 .damping_ratio = scene.bounce.damping_ratio,
                                                 .offset_share = scene.bounce.offset_share,
                                                 .offset_reference_mps = impact::kContactOffsetReference_mps},
                                                kSteps)) {}
  const strobe::testing::ContactPoint& at(double time_s) const {
    return course_[static_cast<std::size_t>(std::lround(time_s / dwell_s_ * kSteps))];
  }
  const strobe::testing::ContactPoint& lift_off() const { return course_.back(); }

 private:
  double dwell_s_;
  std::vector<strobe::testing::ContactPoint> course_;
};

struct Rms {
  double x = 0.0, y = 0.0;
};

/// sqrt(sum of squares/(N - 1)), as the analysis's standard error of estimate.
template <typename Difference>
Rms rms_of(const std::vector<Seen>& seen, Difference difference) {
  Rms sum;
  for (const Seen& s : seen) {
    const Rms d = difference(s);
    sum.x += d.x * d.x;
    sum.y += d.y * d.y;
  }
  const double n = static_cast<double>(seen.size()) - 1.0;
  return {std::sqrt(sum.x / n), std::sqrt(sum.y / n)};
}

/// Four standard errors of a rms of so many normal numbers.
double tolerance(std::size_t n) { return 4.0 / std::sqrt(2.0 * static_cast<double>(n)); }

}  // namespace

TEST_GROUP(ContactResiduals){};

// The spare mechanics are the product's: 20,000 steps of second order leave some 1e-7 of the speeds.
TEST(ContactResiduals, TheIndependentMechanicsMeetTheRigsTruth) {
  const Scene scene = scene_of(ContactLaw::ode);
  const Photographed p = photograph(scene);
  const Expected expected(scene, p);
  DOUBLES_EQUAL(*p.truth[Quantity::vx_lo_mps], expected.lift_off().vx_mps, 1e-4);
  DOUBLES_EQUAL(*p.truth[Quantity::omega_lo_radps], expected.lift_off().omega_radps, 1e-2);
  DOUBLES_EQUAL(*p.truth[Quantity::dwell_distance_cm], 100.0 * expected.lift_off().x_m, 1e-4);
  DOUBLES_EQUAL(0.0, expected.lift_off().y_m, 1e-9);
}

// What the analysis's standard error of estimate finds is the two mechanics' difference and the noise,
// squares added. The difference is more than the noise here, or the test would show nothing.
TEST(ContactResiduals, TheStandardErrorOfEstimateIsTheMechanicsDifferenceAndTheNoise) {
  const Scene scene = scene_of(ContactLaw::ode);
  const Photographed p = photograph(scene);
  const Expected expected(scene, p);
  const auto sine = contact::trajectory_of(assumed(p));
  const Rms difference = rms_of(p.seen, [&](const Seen& s) {
    const auto& ode = expected.at(s.time_s);
    const auto at = sine(s.time_s / p.dwell_s);
    return Rms{ode.x_m - at.x_m, ode.y_m - at.y_m};
  });
  CHECK(difference.x > 3.0 * kNoise_m);
  CHECK(difference.y > 1.5 * kNoise_m);
  const contact::StandardErrors errors = errors_of(p, sine, scene);
  // The noise adds 2·difference·noise·normal to each square besides its own: both scatters below.
  const auto check = [&](double see, double apart) {
    const double both = std::hypot(apart, kNoise_m);
    DOUBLES_EQUAL(both, see, tolerance(p.seen.size()) * std::sqrt(2.0) * kNoise_m);
  };
  check(errors.see_x_m, difference.x);
  check(errors.see_y_m, difference.y);
}

// Not only as large but of the same course: bin by bin the mean residual is the mean difference.
TEST(ContactResiduals, TheResidualsFollowTheMechanicsDifferenceThroughTheContact) {
  const Scene scene = scene_of(ContactLaw::ode);
  const Photographed p = photograph(scene);
  const Expected expected(scene, p);
  const auto sine = contact::trajectory_of(assumed(p));
  constexpr std::size_t kBins = 8;
  std::array<double, kBins> n{}, x{}, y{}, apart{};
  for (const Seen& s : p.seen) {
    const auto bin = static_cast<std::size_t>(s.time_s / p.dwell_s * kBins);
    const auto& ode = expected.at(s.time_s);
    n[bin] += 1.0;
    x[bin] += s.x_m - ode.x_m;
    y[bin] += s.y_m - ode.y_m;
    apart[bin] += ode.x_m - sine(s.time_s / p.dwell_s).x_m;
  }
  double largest = 0.0, least = 0.0;
  for (std::size_t i = 0; i < kBins; ++i) {
    CHECK(n[i] > 10.0);
    // Four standard errors of the noise; a flash's jitter of 1 µs is 16 µm of the way for each image.
    const double allowed = 4.0 * std::hypot(kNoise_m, 16e-6) / std::sqrt(n[i]);
    DOUBLES_EQUAL(0.0, x[i] / n[i], allowed);
    DOUBLES_EQUAL(0.0, y[i] / n[i], allowed);
    largest = std::max(largest, apart[i] / n[i]);
    least = std::min(least, apart[i] / n[i]);
  }
  // The course is no noise: a hump of several times what a bin's mean scatters.
  CHECK(largest - least > 4.0 * kNoise_m);
}

// With the reducer's own law in the rig, released while still flattened as the sine ends, the residuals are
// the noise and nothing else.
TEST(ContactResiduals, WithTheSineInTheRigTheyAreTheNoise) {
  const Scene scene = scene_of(ContactLaw::grip);
  const Photographed p = photograph(scene);
  const impact::SinePulse whole = assumed(p);
  // y at the end of a unit pulse, in |vy|·dwell: the pulse is that much shorter, the rest is free motion.
  const double left_s = -whole.at_fraction(1.0).y_m / *p.truth[Quantity::vy_lo_mps];
  impact::PulseInput input = whole.input();
  input.dwell_s *= p.dwell_s / (p.dwell_s + left_s);
  const auto pulse = *impact::SinePulse::make(impact::PulseForm::exact, input);
  const contact::Trajectory motion = [&](double fraction) {
    const double t = fraction * p.dwell_s, free_s = std::max(0.0, t - input.dwell_s);
    const impact::PulseState s = pulse.at_time(std::min(t, input.dwell_s));
    return contact::TrajectoryPoint{s.x_m + free_s * *p.truth[Quantity::vx_lo_mps],
                                    s.y_m + free_s * *p.truth[Quantity::vy_lo_mps], 0.0};
  };
  const contact::StandardErrors errors = errors_of(p, motion, scene);
  DOUBLES_EQUAL(kNoise_m, errors.see_x_m, (tolerance(p.seen.size()) + 0.02) * kNoise_m);
  DOUBLES_EQUAL(kNoise_m, errors.see_y_m, (tolerance(p.seen.size()) + 0.02) * kNoise_m);
}
