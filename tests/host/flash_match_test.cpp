// The parts of the flash match: the track of a frame, the prior of the gate, the flashes of contact images.
#include <cmath>
#include <numbers>
#include <vector>

#include "common/messages/lcm_conversions.hpp"
#include "common/reduction/matching/contact_match.hpp"
#include "common/reduction/matching/flash_match.hpp"
#include "host/assembly/assemble.hpp"
#include "tests/host/synthetic_shot.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::host_test;
using Eigen::Vector2d;

std::vector<int> flashes_of(const host::AssembledShot& shot) {
  std::vector<int> flashes;
  for (const auto& image : shot.frame.images) flashes.push_back(image.flash_index.value_or(-1));
  return flashes;
}

}  // namespace

TEST_GROUP(ImageTracks) {
  SyntheticShot made = make_shot({});
  matching::Track track(double inclination_deg = 0.0) const {
    reduction::Frame frame = *messages::frame_from_lcm(made.frame);
    frame.ball_diameter_m = kBallDiameter_m;
    frame.surface_angle_deg = inclination_deg;
    return *matching::image_track(frame);
  }
};

TEST(ImageTracks, TakeSizeAndNoiseFromTheImagesInTheAir) {
  auto& images = made.frame.images;
  CHECK_TRUE(images.size() > 8);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const bool in_the_air = i < 2 || i + 2 >= images.size();
    if (!in_the_air) images[i].leg = strobe_msgs::ball_image_t::LEG_CONTACT;
    images[i].diameter_px = in_the_air ? 260.0 : 300.0;
    images[i].centre_xx_px2 = in_the_air ? 1.0 : 400.0;
    images[i].centre_xy_px2 = 0.0, images[i].centre_yy_px2 = 3.0;
  }
  DOUBLES_EQUAL(130.0, track().radius_px, 0.0);
  DOUBLES_EQUAL(260.0 / kBallDiameter_m, track().px_per_m, 1e-9);
  DOUBLES_EQUAL(std::sqrt(2.0), track().sd_px, 1e-12);  // of each coordinate: the mean of 1 and 3 px^2
}

TEST(ImageTracks, WithoutStatedNoiseAreAsGoodAsAHand) {
  made.frame.centre_sd_px = std::nan("");
  for (auto& image : made.frame.images) image.diameter_px = 250.0;
  DOUBLES_EQUAL(2.0, track().sd_px, 1e-12);  // 0.8 % of the diameter
  made.frame.centre_sd_px = 0.7;
  DOUBLES_EQUAL(0.7, track().sd_px, 0.0);
}

TEST(ImageTracks, PullTheBallDownThePlate) {
  const double inclination_deg = 30.0;
  for (const bool leftwards : {false, true}) {
    Scenario sc;
    sc.leftwards = leftwards;
    made = make_shot(sc);
    const auto t = track(inclination_deg);
    // A plate that rises to the right brakes a ball to the right by g sin 30.
    DOUBLES_EQUAL((leftwards ? 0.5 : -0.5) * 9.80665 * t.px_per_m, t.gravity_pxps2.x(), 1e-6);
    DOUBLES_EQUAL(-std::cos(std::numbers::pi / 6) * 9.80665 * t.px_per_m, t.gravity_pxps2.y(), 1e-6);
  }
}

TEST(ImageTracks, TouchTheSurfaceATwentiethOfTheirRadiusLowerHoweverSmallTheNoise) {
  Scenario sc;
  sc.legs_named = false;
  sc.noise_mm = 1e-6;  // no sd of a frame may be 0
  made = make_shot(sc);
  made.frame.centre_sd_px = 0.01;
  for (auto& image : made.frame.images)
    image.centre_xx_px2 = image.centre_xy_px2 = image.centre_yy_px2 = std::nan("");
  const auto in_the_air = track();
  std::size_t last = 0;
  while (in_the_air.images[last + 1].leg == Leg::incoming) ++last;
  // The surface is level: what the centre moves in the photograph it moves above the surface.
  const double height_px = in_the_air.images[last].centre_px.y();
  const double y_px = made.frame.images[last].centre_y_px;
  const auto leg_at = [&](double height_of_radius) {
    made.frame.images[last].centre_y_px = y_px + height_of_radius * in_the_air.radius_px - height_px;
    return track().images[last].leg;
  };
  CHECK_TRUE(leg_at(0.96) == Leg::incoming);
  CHECK_TRUE(leg_at(0.94) == Leg::contact);
}

TEST_GROUP(ArrivalPriors){};

TEST(ArrivalPriors, TheGateTellsWhichFlashesOfAnEvenTrain) {
  // Some 150 places of the train are alike to the images; the gate, 2 m before the plate, and the speed that
  // the images show pick the one, to a few milliseconds.
  for (const double touchdown_s : {0.1007, 0.2507, 0.3507}) {
    Scenario sc;
    sc.touchdown_s = touchdown_s;
    SyntheticShot made = make_shot(sc);
    made.shot.trigger_ns = strobe_msgs::shot_t::NO_TIME;
    const double flight_s = 2.0 / std::hypot(sc.bounce.vx_td, sc.bounce.vy_td);
    made.shot.gate_ns = made.shot.flashes[0].commanded_ns + std::llround((touchdown_s - flight_s) * 1e9);
    host::AssemblySettings settings;
    settings.analysis.gate_distance_m = 2.0;
    const host::AssembledShot shot = host::assemble(made.shot, made.frame, settings);
    CHECK_EQUAL(made.image_flash, flashes_of(shot));
    // Places 3 ms apart under a Cauchy density: its half-width is the gate's 50 mm and 5 % of the way. The sum
    // of 1/(1 + (a k)^2) over all k is (pi/a) coth(pi/a); the train's ends cut off less than 0.02 of it.
    const double width_s = std::hypot(0.05, 0.05 * 2.0) / 2.0 * flight_s;
    const double places = std::numbers::pi * width_s / 3e-3;
    DOUBLES_EQUAL(1.0 - std::tanh(places) / places, shot.flashes->misassignment_probability, 0.02);
  }
}

TEST(ArrivalPriors, TheGateWeighsAsMuchAsItsDistanceIsKnown) {
  // The machine's lag says 30 ms later than the gate. Both at once: the gate counts.
  Scenario sc;
  sc.machine_error_s = -0.030;
  SyntheticShot made = make_shot(sc);
  const double flight_s = 2.0 / std::hypot(sc.bounce.vx_td, sc.bounce.vy_td);
  made.shot.gate_ns = made.shot.flashes[0].commanded_ns + std::llround((sc.touchdown_s - flight_s) * 1e9);
  host::AssemblySettings settings;
  settings.machine_lag_s = kMachineLag_s;
  settings.analysis.gate_distance_m = 2.0;
  CHECK_EQUAL(made.image_flash, flashes_of(host::assemble(made.shot, made.frame, settings)));
}

TEST(ArrivalPriors, TheMachinesLagWeighsAsMuchAsItsSdSays) {
  // Places 3 ms apart as above: 10 ms of half-width where no sd is stated, else the root of two of it.
  const SyntheticShot made = make_shot({});
  host::AssemblySettings settings;
  settings.machine_lag_s = kMachineLag_s;
  const auto probability = [&] {
    return host::assemble(made.shot, made.frame, settings).flashes->misassignment_probability;
  };
  const auto of_places = [](double places) { return 1.0 - std::tanh(places) / places; };
  DOUBLES_EQUAL(of_places(std::numbers::pi * 10.0 / 3.0), probability(), 0.02);
  settings.analysis.machine_lag_sd_s = 3e-3;
  DOUBLES_EQUAL(of_places(std::numbers::pi * std::numbers::sqrt2), probability(), 0.02);
}

TEST(ArrivalPriors, OneImageBeforeTheBounceTellsNoSpeedForTheGate) {
  // The gate says 30 ms too late: without the ball's speed it says nothing, and the machine's lag counts.
  Scenario sc;
  SyntheticShot made = make_shot(sc);
  auto& images = made.frame.images;
  while (images.at(1).leg == strobe_msgs::ball_image_t::LEG_INCOMING) {
    images.erase(images.begin());
    made.image_flash.erase(made.image_flash.begin());
  }
  made.frame.image_count = static_cast<std::int32_t>(images.size());
  const double speed = std::hypot(sc.bounce.vx_td, sc.bounce.vy_td);
  made.shot.gate_ns =
      made.shot.flashes[0].commanded_ns + std::llround((sc.touchdown_s - 2.0 / speed + 0.030) * 1e9);
  host::AssemblySettings settings;
  settings.machine_lag_s = kMachineLag_s;
  settings.analysis.gate_distance_m = 2.0;
  const host::AssembledShot with_gate = host::assemble(made.shot, made.frame, settings);
  settings.analysis.gate_distance_m.reset();
  const host::AssembledShot without = host::assemble(made.shot, made.frame, settings);
  CHECK_EQUAL(flashes_of(without), flashes_of(with_gate));
  DOUBLES_EQUAL(without.flashes->misassignment_probability, with_gate.flashes->misassignment_probability,
                0.0);
}

TEST_GROUP(ContactFlashes) {
  // Down at 0 s and x = 0 with (6, -5) m/s, off at 4 ms and x = 16 mm with (3, 4) m/s; 1000 px to the metre, a
  // flash every 0.5 ms.
  // Flashes without an image cost nothing unless a test says so.
  matching::Track track{
      .images = {}, .radius_px = 32.0, .px_per_m = 1000.0, .sd_px = 0.2, .missed_share = 1.0};
  std::vector<double> times_s;
  matching::LegCandidate in, out;

  void setup() override {
    for (int k = -10; k <= 20; ++k) times_s.push_back(5e-4 * k);
    in = leg({0.0, 32.0}, 0.0, {6000.0, -5000.0}, {4, 7, 9});       // the last at -0.5 ms
    out = leg({16.0, 32.0}, 4e-3, {3000.0, 4000.0}, {19, 22, 25});  // the first at 4.5 ms
  }

  matching::LegCandidate leg(Vector2d at, double at_s, Vector2d velocity, std::vector<int> flash) const {
    matching::LegCandidate candidate;
    candidate.fit = geometry::LegFit(track.gravity_pxps2);
    for (const int k : flash) {
      const double t = times_s[static_cast<std::size_t>(k)];
      candidate.fit.add(t, at + velocity * (t - at_s));
    }
    candidate.flash = std::move(flash);
    candidate.crossing = geometry::crossing(candidate.fit, track.radius_px, candidate.fit.mean_time_s());
    return candidate;
  }

  /// By the equations: a cubic along the surface, a half sine pressed into it.
  Vector2d pressed(double t) const {
    const double s = t / 4e-3, s2 = s * s, s3 = s2 * s;
    const double x =
        (s3 - 2.0 * s2 + s) * 4e-3 * 6000.0 + (3.0 * s2 - 2.0 * s3) * 16.0 + (s3 - s2) * 4e-3 * 3000.0;
    const double speed = 5000.0 * (1.0 - s) + 4000.0 * s;
    return {x, 32.0 - 4e-3 / std::numbers::pi * std::sin(std::numbers::pi * s) * speed};
  }

  matching::ContactFlashes matched(const std::vector<double>& at_s) const {
    std::vector<matching::TrackPoint> images;
    for (const double t : at_s) images.push_back({Leg::contact, pressed(t)});
    return matching::ContactMatcher(images, times_s, track).match(in, out);
  }

  /// Where the ball was at 2 ms, and `off_px` along the surface from there.
  std::vector<matching::TrackPoint> ball_and_another(double off_px, double probability) const {
    const Vector2d ball = pressed(2e-3);
    return {{Leg::contact, ball}, {Leg::contact, ball + Vector2d(off_px, 0.0), 1.0, probability}};
  }
};

TEST(ContactFlashes, AreThoseWhereTheBallWas) {
  // Flash 10 is at 0 s. Every pair of the seven flashes within the contact.
  for (int a = 1; a <= 7; ++a) {
    for (int b = a + 1; b <= 7; ++b) {
      const auto found = matched({a * 5e-4, b * 5e-4});
      CHECK_EQUAL((std::vector<int>{10 + a, 10 + b}), found.flash);
      DOUBLES_EQUAL(0.0, found.penalty, 1e-12);
    }
  }
}

TEST(ContactFlashes, CostMoreTheFurtherTheyAreFromThere) {
  // Between two flashes: 1 px along and the model's 3 mm, 3 px; 0.2 px of noise. The height: see below.
  const auto found = matched({2.25e-3});
  CHECK_TRUE(found.flash[0] == 14 || found.flash[0] == 15);
  const Vector2d ball = pressed(2.25e-3), flash = pressed(found.flash[0] == 14 ? 2e-3 : 2.5e-3);
  const double variance = 0.2 * 0.2 + 3.0 * 3.0, depth = 32.0 - flash.y();
  const double expected = std::pow(ball.x() - flash.x(), 2) / variance +
                          std::pow(ball.y() - flash.y(), 2) / (variance + std::pow(0.15 * depth, 2));
  DOUBLES_EQUAL(expected, found.penalty, 1e-9);
}

TEST(ContactFlashes, WithoutAnImageCostByTheShareThatIsMissed) {
  track.missed_share = 0.01;  // of the nine flashes between the legs two have an image
  DOUBLES_EQUAL(-2.0 * 7.0 * std::log(0.01), matched({1e-3, 2e-3}).penalty, 1e-9);
}

TEST(ContactFlashes, OfADoubtfulImageFarFromWhereTheBallWasAreNone) {
  // The next flash found the ball 2 mm on, this one is 15 mm on: five sds.
  const auto images = ball_and_another(15.0, 0.6);
  const auto found = matching::ContactMatcher(images, times_s, track).match(in, out);
  CHECK_EQUAL((std::vector<int>{14, matching::kNoFlash}), found.flash);
  // An image of the ball would have cost two in the mean.
  DOUBLES_EQUAL(2.0 - 2.0 * std::log(0.4), found.penalty, 1e-9);
}

TEST(ContactFlashes, OfAnImageWhereTheBallWasAreSomeThoughItIsDoubtful) {
  const auto images = ball_and_another(pressed(2.5e-3).x() - pressed(2e-3).x(), 0.6);
  CHECK_EQUAL((std::vector<int>{14, 15}),
              matching::ContactMatcher(images, times_s, track).match(in, out).flash);
}

TEST(ContactFlashes, OfACertainImageAreSomeHoweverFarOffItIs) {
  const auto images = ball_and_another(100.0, 1.0);
  const auto found = matching::ContactMatcher(images, times_s, track).match(in, out);
  CHECK_TRUE(found.flash[1] > found.flash[0]);
  CHECK_TRUE(found.penalty > 50.0);
}

TEST(ContactFlashes, AreNotSharedByTwoImages) {
  const matching::LegCandidate before = leg({0.0, 32.0}, 0.0, {6000.0, -5000.0}, {4, 7, 13});
  const matching::LegCandidate after = leg({16.0, 32.0}, 4e-3, {3000.0, 4000.0}, {15, 22, 25});
  const auto likely = ball_and_another(1.0, 0.9), certain = ball_and_another(1.0, 1.0);
  CHECK_EQUAL((std::vector<int>{14, matching::kNoFlash}),
              matching::ContactMatcher(likely, times_s, track).match(before, after).flash);
  CHECK_TRUE(std::isinf(matching::ContactMatcher(certain, times_s, track).match(before, after).penalty));
}

TEST(ContactFlashes, CostNoLessThanTheirNumberSays) {
  track.missed_share = 0.1;
  for (const double probability : {0.3, 0.9, 1.0}) {
    for (const double off_px : {0.0, 3.0, 30.0}) {
      const auto images = ball_and_another(off_px, probability);
      for (const int last : {14, 15, 19}) {
        const matching::LegCandidate after = leg({16.0, 32.0}, 4e-3, {3000.0, 4000.0}, {last, 22, 25});
        for (const int first : {9, 13}) {
          const matching::LegCandidate before = leg({0.0, 32.0}, 0.0, {6000.0, -5000.0}, {4, 7, first});
          matching::ContactMatcher matcher(images, times_s, track);
          CHECK_TRUE(matcher.least_penalty(last - first - 1) <= matcher.match(before, after).penalty + 1e-9);
        }
      }
    }
  }
}

TEST(ContactFlashes, BesideOneLegAloneAreNextToIt) {
  const matching::LegCandidate none;
  const std::vector<matching::TrackPoint> two{{Leg::contact, pressed(1e-3)}, {Leg::contact, pressed(2e-3)}};
  CHECK_EQUAL((std::vector<int>{10, 11}),
              matching::ContactMatcher(two, times_s, track).match(in, none).flash);
  CHECK_EQUAL((std::vector<int>{17, 18}),
              matching::ContactMatcher(two, times_s, track).match(none, out).flash);
}

TEST(ContactFlashes, ABallCanHaveThisContactButNotOneThatGivesEnergy) {
  DOUBLES_EQUAL(0.0, matching::contact_penalty(matching::estimate_bounce(in, out, track)), 1e-9);
  // e beyond 0.2 to 1, in units of its sd; velocities of either leg have those of three images, see below.
  const double v_in = 0.2 / std::sqrt(19.0 / 6.0 * 1e-6), v_out = 0.2 / std::sqrt(4.5e-6);
  for (const auto& [e, outside] : {std::pair{1.2, 0.2}, std::pair{0.1, 0.1}}) {
    const matching::LegCandidate other = leg({16.0, 32.0}, 4e-3, {3000.0, e * 5000.0}, {19, 22, 25});
    const double sd = std::hypot(v_out, e * v_in) / 5000.0;
    DOUBLES_EQUAL(std::pow(outside / sd, 2),
                  matching::contact_penalty(matching::estimate_bounce(in, other, track)), 1e-6);
  }
  const matching::LegCandidate far = leg({60.0, 32.0}, 4e-3, {3000.0, 4000.0}, {19, 22, 25});
  CHECK_TRUE(matching::contact_penalty(matching::estimate_bounce(in, far, track)) >
             10.0);  // 15 m/s between 6 and 3
  const matching::LegCandidate falls = leg({16.0, 32.0}, 4e-3, {3000.0, -4000.0}, {19, 22, 25});
  CHECK_TRUE(std::isinf(matching::contact_penalty(matching::estimate_bounce(in, falls, track))));
}

TEST(ContactFlashes, OfASetOfLegsKnowTheirSd) {
  const matching::BounceEstimate r = matching::estimate_bounce(in, out, track);
  DOUBLES_EQUAL(4e-3, r.value[4], 1e-12);
  DOUBLES_EQUAL(16.0, r.value[5], 1e-9);
  // Times -3, -1.5, -0.5 ms: mean -5/3 ms, squares about it 3.1667e-6. Noise 0.2 px.
  const double v = 0.2 / std::sqrt(19.0 / 6.0 * 1e-6);
  DOUBLES_EQUAL(v, r.sd[0], 1e-6);
  DOUBLES_EQUAL(v, r.sd[1], 1e-6);
  const double down = 0.2 * std::sqrt(1.0 / 3.0 + std::pow(5e-3 / 3.0, 2) / (19.0 / 6.0 * 1e-6));
  // Times 4.5, 6, 7.5 ms: mean 6 ms, squares 4.5e-6.
  const double off = 0.2 * std::sqrt(1.0 / 3.0 + 4e-6 / 4.5e-6);
  DOUBLES_EQUAL(std::hypot(down / 5000.0, off / 4000.0), r.sd[4], 1e-12);
  // The height's error moves the instant, and with it the place.
  DOUBLES_EQUAL(std::hypot(std::hypot(down, down / 5000.0 * 6000.0), std::hypot(off, off / 4000.0 * 3000.0)),
                r.sd[5], 1e-9);
}
