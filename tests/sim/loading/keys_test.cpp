#include <cmath>
#include <string>

#include "sim/loading/load_scene.hpp"
#include "sim/motion/contact_path.hpp"
#include "sim/scene/spring.hpp"

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

/// Nine lines; what a test adds begins at line 10.
const std::string kSmallest =
    "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
    "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n\n";
const std::string kThrow = "[machine]\nspeed_mps = 30\nangle_deg = -16\nspin_radps = 0\n";

Scene scene_of(const std::string& text) {
  const auto scene = parse_scene(text, "some.toml");
  if (!scene) FAIL(scene.error().message.c_str());
  return *scene;
}

std::string refusal_of(const std::string& text) { return testing::error_of(parse_scene(text, "some.toml")); }

void refuses(const char* expected, const std::string& text) {
  STRCMP_CONTAINS(expected, refusal_of(text).c_str());
}

}  // namespace

TEST_GROUP(SceneKeys){};

TEST(SceneKeys, TakeTheContactsMechanicsUnlessToldOtherwise) {
  const Scene scene = scene_of(kSmallest);
  CHECK_EQUAL(ContactLaw::ode, scene.bounce.contact);
  DOUBLES_EQUAL(impact::ContactCoefficients{}.offset_share, scene.bounce.offset_share, 0.0);
  const Scene other = scene_of(kThrow +
                               "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\nstiffness_ratio = 1.1\n"
                               "stiffness_ratio_sd = 0.2\ndamping_ratio = 0\noffset_share = 0.2\n"
                               "offset_share_sd = 0.03\noffset_grip_correlation = -1\n");
  DOUBLES_EQUAL(1.1, other.bounce.stiffness_ratio, 0.0);
  DOUBLES_EQUAL(0.2, other.bounce.stiffness_ratio_sd, 0.0);
  DOUBLES_EQUAL(0.0, other.bounce.damping_ratio, 0.0);
  DOUBLES_EQUAL(0.03, other.bounce.offset_share_sd, 0.0);
  refuses("some.toml:9: bounce.damping_ratio: must be 0 or at least 0.01",
          kThrow + "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\ndamping_ratio = 0.001\n");
  refuses("some.toml:9: bounce.contact: must be one of ode, grip",
          kThrow + "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\ncontact = \"sine\"\n");
}

TEST(SceneKeys, RefuseABallThatItsWeightKeepsOnTheSurface) {
  // It comes down with 9 cm/s; in 50 ms of contact its weight adds 49.
  refuses("some.toml:2: machine.speed_mps: the mean ball cannot bounce: ",
          "[machine]\nspeed_mps = 1\nangle_deg = -5\nspin_radps = 0\n"
          "[bounce]\ne = 0.5\nmu = 0.6\ndwell_ms = 50\n");
}

TEST(SceneKeys, GiveTheBallsInertiaByNumberOrByModel) {
  const auto alpha = [](const std::string& ball) {
    return scene_of(kSmallest + "[ball]\n" + ball).ball.alpha;
  };
  DOUBLES_EQUAL(0.5, alpha("alpha = 0.5\n"), 0.0);
  DOUBLES_EQUAL(2.0 / 3.0, alpha("inertia = \"thin_shell\"\n"), 1e-15);
  DOUBLES_EQUAL(0.4, alpha("inertia = \"solid\"\n"), 1e-15);
  DOUBLES_EQUAL(0.55, alpha("inertia = \"measured\"\n"), 1e-15);
  // (2/3)·(.0284/.03255)² and 3.11e-5 kg·m² of the thick shell, whatever the mass.
  DOUBLES_EQUAL(0.5075, alpha("inertia = \"rubber_shell_mean_radius\"\nmass_kg = 0.05\n"), 1e-4);
  const Scene thick = scene_of(kSmallest + "[ball]\ninertia = \"thick_shell\"\nmass_kg = 0.0576\n");
  DOUBLES_EQUAL(3.11e-5, thick.ball.inertia_kgm2(), 0.005e-5);
  CHECK_EQUAL("some.toml:12: ball.alpha: excludes ball.inertia",
              refusal_of(kSmallest + "[ball]\ninertia = \"solid\"\nalpha = 0.4\n"));
  refuses("some.toml:11: ball.inertia: must be one of thin_shell",
          kSmallest + "[ball]\ninertia = \"cube\"\n");
  // The rubber's shell does not fit into a golf ball.
  refuses("some.toml:11: ball.inertia: makes alpha",
          kSmallest + "[ball]\ninertia = \"thick_shell\"\ndiameter_m = 0.043\n");
}

TEST(SceneKeys, GiveTheReboundByRestitutionAndDwellOrBySprings) {
  const auto spring = spring_of_rebound(0.0576, {0.8, 5e-3});
  const std::string text =
      kThrow + "[bounce]\nmu = 0.6\n[ball]\nstiffness_npm = " + std::to_string(spring->stiffness_npm) +
      "\ndamping_nspm = " + std::to_string(spring->damping_nspm) + "\n";
  const Scene scene = scene_of(text);
  DOUBLES_EQUAL(0.8, scene.bounce.e, 1e-6);
  DOUBLES_EQUAL(5e-3, scene.bounce.dwell_s, 1e-8);
  // Without weight the ball is at its radius again after that time, and nothing was lost between keys and
  // ball.
  const ShotConditions thrown = draw_shot_conditions(scene, 1, 1);
  const auto end = ode_lift_off(scene, thrown, Model::full().without(Effect::contact_gravity));
  DOUBLES_EQUAL(5e-3, end->dwell_s, 1e-8);
  DOUBLES_EQUAL(-0.8 * thrown.touchdown.vy_mps, end->rebound.lift_off.vy_mps, 1e-5);
  DOUBLES_EQUAL(0.0, scene.bounce.e_slope_spm, 0.0);
  refuses("ball.damping_nspm: is missing", kThrow + "[bounce]\nmu = 0.6\n[ball]\nstiffness_npm = 20000\n");
  CHECK_EQUAL("some.toml:6: bounce.e: excludes ball.stiffness_npm and ball.damping_nspm",
              refusal_of(kSmallest + "[ball]\nstiffness_npm = 20000\ndamping_nspm = 2\n"));
  refuses("some.toml:9: ball.damping_nspm: makes the restitution",
          kThrow + "[bounce]\nmu = 0.6\n[ball]\nstiffness_npm = 20000\ndamping_nspm = 0\n");
  refuses("bounce.dwell_ms: is missing", kThrow + "[bounce]\nmu = 0.6\ne = 0.8\n");
}

TEST(SceneKeys, GiveTheFrictionByOneOfFourKeys) {
  const std::string bounce =
      kThrow + "[bounce]\ne = 0.81\ndwell_ms = 5\n[air]\ntemperature_c = 23\n[surface]\n";
  DOUBLES_EQUAL(0.7, scene_of(bounce + "friction = 0.7\n").bounce.mu, 0.0);
  // The ITF's formula at 23 degrees and e .81, where 30 m/s at 16 degrees is the machine's own: mu .63
  // rates 37.
  DOUBLES_EQUAL(0.63, scene_of(bounce + "court_pace = 37\n").bounce.mu, 1e-12);
  DOUBLES_EQUAL(0.73, scene_of(bounce + "pace_grade = \"slow\"\n").bounce.mu, 1e-12);
  DOUBLES_EQUAL(0.53, scene_of(bounce + "pace_grade = \"fast\"\n").bounce.mu, 1e-12);
  CHECK_EQUAL("some.toml:11: surface.court_pace: excludes surface.friction: one of them says the friction",
              refusal_of(bounce + "court_pace = 37\nfriction = 0.7\n"));
  CHECK_EQUAL("some.toml:11: surface.friction: excludes bounce.mu: one of them says the friction",
              refusal_of(kSmallest + "[surface]\nfriction = 0.7\n"));
  refuses("some.toml:11: surface.court_pace: needs a friction of -", bounce + "court_pace = 150\n");
  refuses("bounce.mu: is missing", bounce);
}

TEST(SceneKeys, CountThePacesRestitutionAtTheTestsSpeedAndTemperature) {
  // e .81 at 30 m/s and 16 degrees, 8.27 m/s towards the surface, is .81 + .017·(8.27 - 6) at 6 m/s.
  const double e = 0.81 + 0.017 * (30.0 * std::sin(16.0 * std::numbers::pi / 180.0) - 6.0);
  const std::string text =
      "[machine]\nspeed_mps = 12\nangle_deg = -30\nspin_radps = 0\n[bounce]\ne = " + std::to_string(e) +
      "\ndwell_ms = 5\n[surface]\ncourt_pace = 37\n[air]\n";
  DOUBLES_EQUAL(0.63, scene_of(text + "temperature_c = 23\n").bounce.mu, 1e-5);
  // Ten degrees less are worth .03 of e, 4.5 points, .045 of mu.
  DOUBLES_EQUAL(0.585, scene_of(text + "temperature_c = 13\n").bounce.mu, 1e-5);
}

TEST(SceneKeys, GiveTheTiltByOneOfTwoKeys) {
  DOUBLES_EQUAL(2.0,
                scene_of("surface_angle_deg = 2\n" + kSmallest).surface_angle_rad * 180.0 / std::numbers::pi,
                1e-12);
  DOUBLES_EQUAL(
      2.0, scene_of(kSmallest + "[surface]\ntilt_deg = 2\n").surface_angle_rad * 180.0 / std::numbers::pi,
      1e-12);
  refuses("some.toml:12: surface.tilt_deg: excludes surface_angle_deg",
          "surface_angle_deg = 2\n" + kSmallest + "[surface]\ntilt_deg = 2\n");
}

TEST(SceneKeys, ReadTheLensTheFlashAndTheSpinsDecay) {
  const Scene scene =
      scene_of(kSmallest +
               "[camera]\ndistance_m = 1.5\noff_plane_sd_mm = 8\ndistortion = -0.05\n"
               "rendering = \"pixels\"\n[lamps]\nflash_us = 30\n[air]\nspin_decay_per_m = 0.02\n");
  DOUBLES_EQUAL(1.5, scene.camera.distance_m, 0.0);
  DOUBLES_EQUAL(0.008, scene.camera.off_plane_sd_m, 1e-15);
  DOUBLES_EQUAL(-0.05, scene.camera.distortion, 0.0);
  CHECK(scene.camera.pixels);
  DOUBLES_EQUAL(30e-6, scene.lamps.flash_s, 1e-18);
  DOUBLES_EQUAL(0.02, scene.air.spin_decay_per_m, 0.0);
  const Scene plain = scene_of(kSmallest);
  CHECK(plain.camera.distance_m == 0.0 && plain.camera.distortion == 0.0 && !plain.camera.pixels);
}

TEST(SceneKeys, RefuseALensThatCannotBe) {
  refuses("some.toml:11: camera.distance_m: must be at least 0.1", kSmallest + "[camera]\ndistance_m = 0\n");
  refuses("some.toml:11: camera.distance_m: must be at least 0.3",
          kSmallest + "[camera]\ndistance_m = 0.3\noff_plane_sd_mm = 50\n");
  refuses("some.toml:11: camera.distortion: must be at least -0.3",
          kSmallest + "[camera]\ndistortion = -0.4\n");
  refuses("some.toml:11: camera.rendering: must be one of points, pixels",
          kSmallest + "[camera]\nrendering = \"film\"\n");
}

TEST(SceneKeys, ReadWhatIsToBeReadOut) {
  const Scene scene =
      scene_of(kSmallest + "[readout]\ntolerance_percent = 0.5\nmu = 0.01\ncourt_pace = \"any\"\n");
  DOUBLES_EQUAL(0.005, scene.readout.tolerance, 1e-15);
  LONGS_EQUAL(2, scene.readout.absolute.size());
  CHECK_EQUAL(reduction::Quantity::mu, scene.readout.absolute[0].first);
  DOUBLES_EQUAL(0.01, scene.readout.absolute[0].second, 0.0);
  CHECK_EQUAL(reduction::Quantity::court_pace, scene.readout.absolute[1].first);
  CHECK(scene.readout.absolute[1].second < 0.0);
  CHECK_EQUAL("some.toml:11: readout.speed: unknown key", refusal_of(kSmallest + "[readout]\nspeed = 1\n"));
  refuses("some.toml:11: readout.mu: must be a tolerance or \"any\"",
          kSmallest + "[readout]\nmu = \"all\"\n");
  refuses("some.toml:11: readout.mu: must be at least", kSmallest + "[readout]\nmu = 0\n");
}

TEST(SceneKeys, SayWhatResistorsTheChipHas) {
  const ChipSettings usual = scene_of(kSmallest).chip;
  CHECK_TRUE(usual.bias == ChipSettings::Bias::set);
  CHECK_TRUE(usual.reset_pull == ChipSettings::Pull::none);
  const ChipSettings chip = scene_of(kSmallest + "[chip]\nbias = \"ignored\"\nreset_pull = \"up\"\n").chip;
  CHECK_TRUE(chip.bias == ChipSettings::Bias::ignored);
  CHECK_TRUE(chip.reset_pull == ChipSettings::Pull::up);
  refuses("some.toml:11: chip.bias: must be one of set, ignored, refused",
          kSmallest + "[chip]\nbias = \"none\"\n");
}

TEST(SceneKeys, OfARigThatIsToBeCommissioned) {
  const Scene plain = scene_of(kSmallest);
  CHECK_FALSE(plain.camera.turned());
  CHECK_FALSE(plain.photograph.steady);
  const Scene scene =
      scene_of(kSmallest +
               "[camera]\ndistance_m = 2\nswing_deg = 3\ntilt_deg = -2\n"
               "[sensors]\ncrosstalk = \"b\"\n[shutter]\nlongest_open_ms = 100\n"
               "[hand]\ndrop_height_m = 1\ntouchdown_s = 0.75\nspot_sd_mm = 5\n"
               "[photograph]\nsetup = \"steady\"\n[background]\nflashes = 166\n"
               "[[fault]]\nkind = \"machine_double\"\ndelay_us = 8e4\n[[fault]]\nkind = \"gate_dead\"\n");
  DOUBLES_EQUAL(3.0 * M_PI / 180.0, scene.camera.swing_rad, 1e-15);
  DOUBLES_EQUAL(-2.0 * M_PI / 180.0, scene.camera.tilt_rad, 1e-15);
  CHECK(scene.sensors.b_sees_a && !scene.sensors.a_sees_b);
  DOUBLES_EQUAL(0.1, scene.shutter.longest_open_s, 1e-15);
  DOUBLES_EQUAL(1.0, scene.hand.drop_height_m, 0.0);
  DOUBLES_EQUAL(0.005, scene.hand.spot_sd_m, 1e-15);
  CHECK(scene.photograph.steady);
  LONGS_EQUAL(166, scene.background.flashes);
  CHECK_EQUAL(milliseconds(80), scene.faults[0].delay);
  refuses("camera.distance_m: is needed with swing_deg or tilt_deg", kSmallest + "[camera]\nswing_deg = 3\n");
  refuses("camera.distortion: excludes swing_deg and tilt_deg",
          kSmallest + "[camera]\ndistance_m = 2\ntilt_deg = 3\ndistortion = 0.01\n");
}

TEST(SceneKeys, OfACameraOnTheNetwork) {
  const CameraLinkSettings sound = scene_of(kSmallest).camera_link;
  CHECK_TRUE(sound.pixels == CameraPixels::mono8 && sound.hostile == CameraLinkSettings::Hostile::none);
  DOUBLES_EQUAL(0.0, sound.loss + sound.resend_loss + sound.drop + sound.clock_drift_ppm, 0.0);
  const Scene scene =
      scene_of(kSmallest +
               "[camera_link]\npixel_format = \"BayerRG12\"\nrate_mbps = 1000\nreadout_ms = 20\n"
               "exposure_step_us = 50\nloss = 0.01\nresend_loss = 0.1\ndrop = 0.02\nclock_offset_s = 9\n"
               "clock_drift_ppm = -50\nhostile = \"endless\"\n"
               "[[fault]]\nkind = \"camera_vanishes\"\nshot = 3\ndelay_s = 2.5\n");
  const CameraLinkSettings& link = scene.camera_link;
  CHECK_TRUE(link.pixels == CameraPixels::bayer_rg12 && link.hostile == CameraLinkSettings::Hostile::endless);
  DOUBLES_EQUAL(1e9, link.rate_bps, 1e-3);
  DOUBLES_EQUAL(0.02, link.readout_s, 1e-15);
  DOUBLES_EQUAL(50e-6, link.exposure_step_s, 1e-18);
  DOUBLES_EQUAL(0.01, link.loss, 0.0);
  DOUBLES_EQUAL(0.1, link.resend_loss, 0.0);
  DOUBLES_EQUAL(0.02, link.drop, 0.0);
  DOUBLES_EQUAL(9.0, link.clock_offset_s, 0.0);
  DOUBLES_EQUAL(-50.0, link.clock_drift_ppm, 0.0);
  CHECK_EQUAL(milliseconds(2500), scene.faults[0].delay);
  refuses("camera_link.loss: must be", kSmallest + "[camera_link]\nloss = 1.5\n");
  refuses("camera_link.pixel_format: must be one of", kSmallest + "[camera_link]\npixel_format = \"RGB8\"\n");
  refuses("delay_s: is missing", kSmallest + "[[fault]]\nkind = \"camera_vanishes\"\n");
}

TEST(SceneKeys, GiveWhatIsOutOfThePlane) {
  const std::string throws = "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 50\n";
  const std::string bounce = "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\n";
  CHECK(scene_of(kSmallest).machine.planar());
  CHECK(scene_of(throws + "lateral_deg = 0\nsidespin_radps = 0\ngyrospin_radps = 0\n" + bounce).machine.planar());
  const Scene scene =
      scene_of(throws + "lateral_deg = 2\nlateral_sd_deg = 0.1\nsidespin_radps = -300\nsidespin_sd_radps = 5\n"
                        "gyrospin_radps = 40\ngyrospin_sd_radps = 3\n" + bounce +
               "[ball_appearance]\nline_offset = -0.03\nline_tilt_deg = 60\n[tablet]\nequator_tilt_sd_deg = 0.4\n");
  CHECK(!scene.machine.planar());
  DOUBLES_EQUAL(2.0 * M_PI / 180.0, scene.machine.lateral_rad, 1e-15);
  DOUBLES_EQUAL(0.1 * M_PI / 180.0, scene.machine.lateral_sd_rad, 1e-15);
  DOUBLES_EQUAL(-300.0, scene.machine.sidespin_radps, 0.0);
  DOUBLES_EQUAL(5.0, scene.machine.sidespin_sd_radps, 0.0);
  DOUBLES_EQUAL(40.0, scene.machine.gyrospin_radps, 0.0);
  DOUBLES_EQUAL(3.0, scene.machine.gyrospin_sd_radps, 0.0);
  DOUBLES_EQUAL(-0.03, scene.ball_appearance.line_offset, 0.0);
  DOUBLES_EQUAL(0.4 * M_PI / 180.0, scene.tablet.equator_tilt_sd_rad, 1e-15);
  refuses("some.toml:5: machine.lateral_deg: must be", throws + "lateral_deg = 46\n" + bounce);
  refuses("some.toml:5: machine.sidespin_radps: must be", throws + "sidespin_radps = 1001\n" + bounce);
  refuses("some.toml:5: machine.gyrospin_sd_radps: must be", throws + "gyrospin_sd_radps = -1\n" + bounce);
  refuses("ball_appearance.line_offset: must be", kSmallest + "[ball_appearance]\nline_offset = 0.2\n");
  refuses("tablet.equator_tilt_sd_deg: must be", kSmallest + "[tablet]\nequator_tilt_sd_deg = 0\n");
  refuses("some.toml:3: machine.lateral_deg: excludes machine.drop_height_m",
          "[machine]\ndrop_height_m = 2\nlateral_deg = 2\n" + bounce);
}
