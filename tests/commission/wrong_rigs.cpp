#include "tests/commission/wrong_rigs.hpp"

#include <algorithm>
#include <utility>

namespace strobe::commission_bench {
namespace {

using Edits = std::vector<std::pair<std::string, std::string>>;

/// Another rig than the rig file says.
WrongRig scene(std::string name, std::string text, std::vector<std::string> found_by) {
  WrongRig rig{std::move(name), {}, std::move(found_by)};
  rig.options.scene = std::move(text);
  return rig;
}

/// A rig file that says something else than the rig is.
WrongRig file(std::string name, Edits edits, std::vector<std::string> found_by) {
  WrongRig rig{std::move(name), {}, std::move(found_by)};
  rig.options.rig_edits = std::move(edits);
  return rig;
}

std::string fault(const std::string& lines) { return "[[fault]]\n" + lines; }

const std::string kEstop = "estop    = { line = \"ESTOP\", active_low = true }";
const std::string kKey = "key      = { line = \"KEY\" }";
const Edits kContact{{"\n[lamps]", "xsync = { line = \"XSYNC\" }\n\n[lamps]"}};

std::vector<WrongRig> electrical() {
  return {
      file("sensors swapped",
           {{"\"SENSOR_A\"", "\"S\""}, {"\"SENSOR_B\"", "\"SENSOR_A\""}, {"\"S\"", "\"SENSOR_B\""}},
           {"lamp_a"}),
      file("lamps swapped",
           {{"\"STROBE_A\"", "\"S\""}, {"\"STROBE_B\"", "\"STROBE_A\""}, {"\"S\"", "\"STROBE_B\""}},
           {"lamp_a"}),
      scene("lamp A dead", fault("kind = \"lamp_dead\"\nlamp = \"a\"\n"), {"lamp_a"}),
      scene("lamp B dead", fault("kind = \"lamp_dead\"\nlamp = \"b\"\n"), {"lamp_b"}),
      scene("sensor B dead", fault("kind = \"sensor_dead\"\nlamp = \"b\"\n"), {"lamp_b"}),
      scene("sensor A misses a flash", fault("kind = \"sensor_dropout\"\nlamp = \"a\"\nflash_index = 7\n"),
            {"lamp_a"}),
      scene("sensor B bounces",
            fault("kind = \"sensor_bounce\"\nlamp = \"b\"\nflash_index = 7\ndelay_us = 300\n"), {"lamp_b"}),
      scene("lamp A flashes twice",
            fault("kind = \"flash_double\"\nlamp = \"a\"\nflash_index = 3\ndelay_us = 400\n"), {"lamp_a"}),
      scene("cross-talk", "[sensors]\ncrosstalk = \"b\"\n", {"lamp_a"}),
      scene("lamp delay of 40 us", "[lamps]\ndelay_us = 40\n", {"lamp_a"}),
      scene("lamp B late by 20 us", fault("kind = \"flash_late\"\nlamp = \"b\"\ndelay_us = 20\n"),
            {"lamp_b"}),
      scene("lamps jitter by 15 us", "[lamps]\njitter_us = 15\n", {"lamp_a"}),
      scene("lamps recharge slowly", "[lamps]\nrecharge_us = 4000\n", {"lamp_a"}),
      file("e-stop inverted", {{kEstop, "estop    = { line = \"ESTOP\" }"}}, {"firmware", "key", "estop"}),
      file("key inverted", {{kKey, "key      = { line = \"KEY\", active_low = true }"}}, {"key"}),
      file("key and e-stop swapped",
           {{kKey, "key      = { line = \"ESTOP\" }"},
            {kEstop, "estop    = { line = \"KEY\", active_low = true }"}},
           {"firmware", "key"}),
      file("no pull on the key", {{kKey, "key      = { line = \"KEY\", bias = \"disabled\" }"}},
           {"key_wire"}),
      file("no pull on the e-stop",
           {{kEstop, "estop    = { line = \"ESTOP\", active_low = true, bias = \"disabled\" }"}},
           {"estop_wire"}),
  };
}

std::vector<WrongRig> shutters_and_camera() {
  std::vector<WrongRig> rigs{
      scene("shutter opens 20 ms late, without a contact", "[shutter]\nopen_lag_ms = 65\n",
            {"exposure_window"}),
      scene("shutter closes after 200 ms", "[shutter]\nlongest_open_ms = 200\n", {"exposure_window"}),
      scene("shutter stuck", fault("kind = \"shutter_stuck\"\n"), {"light", "shutter"}),
      scene("lamp A turned away", "[photograph]\nlamp_a_power = 0.0\n", {"light"}),
      scene("lamp B dim", "[photograph]\nlamp_b_power = 0.35\n", {"light"}),
      scene("a screen's curve", "[photograph]\ngamma = 0.45\n", {"light", "transfer"}),
      scene("no photographs", fault("kind = \"no_photograph\"\n"), {"light"}),
      scene("photographs too late", fault("kind = \"frame_late\"\ndelay_s = 40\n"), {"light"}),
      file("another folder of photographs", {{"folder = \"camera\"", "folder = \"elsewhere\""}}, {"light"}),
      scene("out of focus", "[photograph]\ndefocus_px = 4\n", {"focus"}),
      scene("overexposed", "[photograph]\nexposure = 4\n", {"exposure"}),
      scene("underexposed", "[photograph]\nexposure = 0.12\n", {"exposure", "light"}),
  };
  WrongRig contact =
      scene("shutter opens 20 ms late, with a contact", "[shutter]\nopen_lag_ms = 65\n", {"shutter"});
  contact.options.rig_edits = kContact;
  rigs.push_back(contact);
  return rigs;
}

std::vector<WrongRig> geometry_and_machine() {
  return {
      file("scale 1 % too large",
           {{"px_per_m = 2500.0", "px_per_m = 2525.0"}, {"px_per_m_sd = 1.25", "px_per_m_sd = 1.26"}},
           {"gravity", "scale"}),
      file("scale 1 % too small",
           {{"px_per_m = 2500.0", "px_per_m = 2475.0"}, {"px_per_m_sd = 1.25", "px_per_m_sd = 1.24"}},
           {"gravity", "scale"}),
      file("ball 1.5 % larger than stated", {{"diameter_m = 0.0651", "diameter_m = 0.06414"}}, {"scale"}),
      scene("camera turned by 1.5 degrees to the side", "[camera]\nswing_deg = 1.5\n", {"square"}),
      scene("camera turned by 2 degrees upwards", "[camera]\ntilt_deg = 2\n", {"square"}),
      file("plate inclined by 3 degrees, not told", {}, {"inclination"}),
      scene("machine 25 ms later", "[machine]\nlag_ms = 335\n", {"repeatability"}),
      scene("machine throws nothing", fault("kind = \"machine_misfire\"\n"), {"throws"}),
      scene("machine throws two", fault("kind = \"machine_double\"\ndelay_us = 60000\n"), {"throws"}),
      scene("gate dead", fault("kind = \"gate_dead\"\n"), {"throws"}),
      scene("balls miss the plate", fault("kind = \"ball_misses\"\n"), {"throws"}),
      scene("machine scatters", "[machine]\nspeed_sd_mps = 3\n", {"repeatability"}),
  };
}

}  // namespace

std::string found_by(const WrongRig& rig, const Outcome& outcome) {
  for (const std::string& id : outcome.failures())
    if (std::ranges::find(rig.found_by, id) != rig.found_by.end()) return id;
  return "";
}

const std::vector<WrongRig>& wrong_rigs() {
  static const std::vector<WrongRig> all = [] {
    std::vector<WrongRig> rigs = electrical();
    for (auto more : {shutters_and_camera(), geometry_and_machine()})
      rigs.insert(rigs.end(), more.begin(), more.end());
    for (WrongRig& rig : rigs)
      if (rig.name.starts_with("plate inclined")) rig.options.scene = "surface_angle_deg = 3\n";
    return rigs;
  }();
  return all;
}

}  // namespace strobe::commission_bench
