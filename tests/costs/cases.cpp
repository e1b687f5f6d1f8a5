#include "tests/costs/cases.hpp"

#include <array>
#include <memory>
#include <random>
#include <stdexcept>
#include <strobe_msgs/shot_t.hpp>

#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/impact/ode/contact_sensitivity.hpp"
#include "common/reduction/reduce.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/reduction/matching/flash_match.hpp"
#include "host/assembly/flash_times.hpp"
#include "host/assembly/assemble.hpp"
#include "host/digitize/digitize.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/host/digitize/painter.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/soak/lab.hpp"
#include "tests/support/sequencer_fixture.hpp"

namespace strobe::costs {
namespace {

/// Keeps the compiler from leaving out what made `value`.
template <typename Value>
void keep(const Value& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

/// A 23 degree bounce as a person digitizes it: five images before, one in contact, five after.
reduction::Frame typical_frame(bool noise_stated) {
  constexpr double kScale_pxpm = 4000.0, kPeriod_s = 3e-3, kRadius_m = 0.0651 / 2;
  std::mt19937_64 random(1);
  // Not std::normal_distribution, whose draws each library makes in its own way.
  const auto error = [&random](double sd) {
    return sd * (static_cast<double>(random() >> 11) * 0x1p-52 - 1.0);
  };
  reduction::Frame frame;
  frame.shot_id = 1;
  frame.ball_diameter_m = 2 * kRadius_m;
  frame.ball_diameter_sd_m = 0.0008;
  frame.temperature_c = 21.0;
  frame.fastest_spin_radps = 600.0;
  for (const double x : {-800.0, -400.0, 700.0, 1000.0}) frame.surface_px.push_back({x, error(2.0)});
  const auto add = [&](int flash, reduction::Leg leg, double x_m, double y_m, double angle_rad) {
    reduction::BallImage image;
    image.time_s = flash * kPeriod_s;
    image.leg = leg;
    image.centre_px = {x_m * kScale_pxpm + error(2.0), y_m * kScale_pxpm + error(2.0)};
    image.diameter_px = 2 * kRadius_m * kScale_pxpm + error(3.0);
    image.equator_rad = angle_rad + error(0.017);
    frame.images.push_back(image);
  };
  for (int i = 0; i < 5; ++i) {
    const double t = (i - 4.4) * kPeriod_s;
    add(i, reduction::Leg::incoming, 15.62 * t, kRadius_m - 6.71 * t, 0.3 + 2.6 * t);
  }
  add(5, reduction::Leg::contact, 0.024, kRadius_m - 0.010, 0.2);
  for (int i = 6; i < 11; ++i) {
    const double t = (i - 4.4) * kPeriod_s - 5.2e-3;
    add(i, reduction::Leg::rebound, 0.063 + 8.84 * t, kRadius_m + 5.76 * t, 0.1 - 313.0 * t);
  }
  if (noise_stated) {
    frame.centre_sd_px = 2.0;
    frame.diameter_sd_px = 3.0;
    frame.equator_sd_rad = 0.017;
  }
  return frame;
}

Case reduction_case(const std::string& name, bool noise_stated) {
  return {name, [frame = typical_frame(noise_stated)] {
            keep(reduction::reduce(frame, reduction::Estimator::best));
          }};
}

struct Bounce {
  impact::Motion touchdown;
  double e, mu, dwell_s;
};

/// Slides throughout, grips late, grips from nearly the start.
constexpr std::array<Bounce, 3> kBounces{{{{16.18, -5.08, 168.3}, 0.77, 0.55, 6.25e-3},
                                          {{14.49, -9.95, -1.1}, 0.77, 0.55, 4.84e-3},
                                          {{8.45, -15.29, -146.7}, 0.69, 0.55, 4.05e-3}}};

Case closed_form_case(const std::string& name, void (*impact)(const Bounce&)) {
  return {name, [impact] {
            for (const Bounce& bounce : kBounces) impact(bounce);
          }};
}

void rigid(const Bounce& b) { keep(impact::rigid(ball::Ball{}, b.touchdown, b.e, b.mu)); }

void grip(const Bounce& b) {
  impact::Coefficients coefficients = impact::kFittedToThesis;
  coefficients.e = b.e;
  coefficients.mu = b.mu;
  keep(impact::grip(ball::Ball{}, b.touchdown, coefficients));
}

void pulse(const Bounce& b) {
  keep(impact::pulse_rebound(impact::PulseForm::exact, ball::Ball{}, b.touchdown, b.e, b.mu, b.dwell_s));
}

impact::ContactOptions by_steps(double tolerance) {
  return {.method = impact::ContactMethod::dormand_prince, .tolerance = tolerance};
}

/// All that is computed of a contact, by a method.
Case contact_case(const std::string& name, const impact::ContactOptions& options) {
  return {name, [options] {
            const ball::Ball ball{.alpha = impact::kContactAlpha};
            for (const Bounce& b : kBounces)
              keep(impact::simulate(ball, b.touchdown, {.e = b.e, .dwell_s = b.dwell_s}, options));
          }};
}

Case lift_off_case(const std::string& name, double tolerance) {
  return {name, [tolerance] {
            const ball::Ball ball{.alpha = impact::kContactAlpha};
            for (const Bounce& b : kBounces)
              keep(impact::lift_off(ball, b.touchdown, {.e = b.e, .dwell_s = b.dwell_s},
                                    {.tolerance = tolerance}));
          }};
}

Case sensitivity_case() {
  return {"lift_off_sensitivity_1e-6", [] {
            const ball::Ball ball{.alpha = impact::kContactAlpha};
            for (const Bounce& b : kBounces)
              keep(impact::lift_off_sensitivity(ball, b.touchdown, {.e = b.e, .dwell_s = b.dwell_s},
                                                {.tolerance = 1e-6}));
          }};
}

/// A dozen images of 166 flashes.
Case flash_match_case() {
  const host_test::SyntheticShot made = host_test::make_shot({});
  auto frame = messages::frame_from_lcm(made.frame);
  frame->ball_diameter_m = host_test::kBallDiameter_m;
  const auto track = matching::image_track(*frame);
  if (!track) throw std::runtime_error("the frame has no track");
  std::vector<double> times_s;
  const host::FlashTimes times = host::flash_times(made.shot);
  for (const host::ObservedFlash& flash : times.seen)
    times_s.push_back(to_seconds(flash.time - times.seen.front().time));
  return {"flash_match",
          [times_s, track = *track] { keep(matching::match_flashes(times_s, track, std::nullopt)); }};
}

/// A painted bounce: five images down, one pressed flat on the plate, five up.
Case digitize_case() {
  constexpr double kDiameter_px = 96.0, kPlateRow = 360.5;
  std::mt19937_64 random(11);
  testing::Painting painting;
  painting.width = 760;
  painting.height = 420;
  painting.bits = 16;
  painting.background = 0.04;
  painting.plate_row = kPlateRow;
  painting.plate = 0.5;
  testing::PaintedBall look = testing::random_ball(random, {}, kDiameter_px);
  look.light = 0.2;
  const auto add = [&](double column, double above_plate_px) {
    look = testing::next_image(look, {column, kPlateRow - above_plate_px}, 0.13);
    look.floor_row = kPlateRow;
    painting.balls.push_back(look);
  };
  for (int k = 5; k >= 1; --k) add(420.0 - 75.3 * k, 10.0 + 44.7 * k);
  add(408.0, 39.0);
  for (int k = 1; k <= 5; ++k) add(396.0 + 60.4 * k, 32.0 + 35.2 * k);
  digitize::DigitizeSettings settings;
  settings.px_per_m = 1.02 * kDiameter_px / settings.ball_diameter_m;
  settings.effort = digitize::Effort::fast;
  return {"digitize_fast", [photograph = testing::paint(painting), settings] {
            const auto result = digitize::digitize(photograph, settings);
            if (!result || result->frame.images.size() != 11)
              throw std::runtime_error("images were not found");
          }};
}

Case simulated_shot_case() {
  sim::Scene scene;
  scene.name = "typical";
  scene.machine.angle_rad = -0.4;
  const auto shooter = std::make_shared<sim::Shooter>(
      *sim::Shooter::make(scene, 1, sim::Model::full().without(sim::Effect::pixels), {}));
  return {"simulated_shot", [shooter] { keep(shooter->shoot(1)); }};
}

/// Two shots, with the start of firmware and host.
Case soak_case(const std::string& name, soak::PlanKind plan) {
  const auto files = soak::read_rig_files(STROBE_SHIPPED_RIG);
  if (!files) throw std::runtime_error(files.error().message);
  return {name, [files = *files, plan] {
            soak::RunSettings settings;
            settings.run = 1;  // its scene can be gated
            settings.shots = 2;
            settings.plan = plan;
            soak::Lab lab(files, settings);
            const soak::SoakCounts counts = lab.run();
            if (counts.violations != 0 || counts.good < 2)
              throw std::runtime_error("shots of the soak do not count");
          }};
}

Case decode_case() {
  const strobe_msgs::shot_t shot = host_test::make_shot({}).shot;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(shot.getEncodedSize()));
  shot.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return {"decode_shot", [bytes] {
            strobe_msgs::shot_t decoded;
            if (decoded.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0)
              throw std::runtime_error("the message is not decoded");
            keep(decoded);
          }};
}

/// A hundred turns in the middle of a train: waits, flashes, sensor edges.
Case sequencer_case() {
  const auto rig = std::make_shared<testing::SequencerFixture>();
  rig->fire();
  return {"sequencer_100_turns", [rig] {
            for (int i = 0; i < 100; ++i) rig->step();
            if (rig->sequencer.state() != firmware::State::firing)
              throw std::runtime_error("no shot is playing");
          }};
}

}  // namespace

std::vector<Case> all_cases() {
  return {reduction_case("reduce", true),
          reduction_case("reduce_noise_estimated", false),
          closed_form_case("impact_rigid", rigid),
          closed_form_case("impact_grip", grip),
          closed_form_case("impact_pulse", pulse),
          contact_case("contact_1e-3", by_steps(1e-3)),
          contact_case("contact_1e-9", by_steps(1e-9)),
          contact_case("contact_collocation_1e-9", {.tolerance = 1e-9}),
          lift_off_case("lift_off_1e-3", 1e-3),
          lift_off_case("lift_off_1e-6", 1e-6),
          lift_off_case("lift_off_1e-9", 1e-9),
          lift_off_case("lift_off_1e-12", 1e-12),
          sensitivity_case(),
          flash_match_case(),
          digitize_case(),
          simulated_shot_case(),
          soak_case("soak_brief", soak::PlanKind::brief),
          soak_case("soak_gated", soak::PlanKind::gated),
          soak_case("soak_coded", soak::PlanKind::coded),
          soak_case("soak_mixed", soak::PlanKind::mixed),
          soak_case("soak_shipped", soak::PlanKind::shipped),
          soak_case("soak_extremes", soak::PlanKind::extremes),
          decode_case(),
          sequencer_case()};
}

}  // namespace strobe::costs
