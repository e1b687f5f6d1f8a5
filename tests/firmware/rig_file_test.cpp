#include "firmware/core/rig.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <string>

#include "common/wire/lcm_url.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

std::string shipped() {
  std::ifstream file(STROBE_SHIPPED_RIG);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto place = text.find(from);
  CHECK_TEXT(place != text.npos, from.c_str());
  return text.replace(place, from.size(), to);
}

/// The number of the line that holds the text, as an error gives it.
std::string line_of(const std::string& text, const std::string& part) {
  const auto place = text.find(part);
  return std::to_string(1 +
                        std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(place), '\n'));
}

std::string error_of(const std::string& text) { return testing::error_of(read_rig(text, "rig.toml")); }

}  // namespace

TEST_GROUP(RigFile) { std::string text = shipped(); };

namespace {

/// The shipped rig with this in place of [chip] and [lines].
std::string on_sequencer(const std::string& text, const std::string& table) {
  const auto chip = text.find("[chip]\n"), lamps = text.find("[lamps]\n");
  return text.substr(0, chip) + table + "\n" + text.substr(lamps);
}

}  // namespace

TEST(RigFile, AFlashSequencerTakesThePlaceOfChipAndLines) {
  const auto rig = read_rig(on_sequencer(text, "[sequencer]\nport = \"/dev/ttyAMA0\"\n"), "rig.toml");
  CHECK_TRUE(rig.has_value());
  CHECK_TRUE(rig->flash_sequencer.fitted());
  CHECK_EQUAL(std::string("/dev/ttyAMA0"), rig->flash_sequencer.port);
  for (const Line line : {Line::strobe_a, Line::strobe_b, Line::shutter, Line::trigger, Line::key, Line::estop,
                          Line::sensor_a, Line::sensor_b, Line::gate})
    CHECK_TRUE_TEXT(rig->line(line).fitted, line_key(line));
  CHECK_FALSE(rig->line(Line::xsync).fitted);
  CHECK_FALSE(read_rig(text, "rig.toml")->flash_sequencer.fitted());
}

TEST(RigFile, AChipMayHaveTheSensorsBesideAFlashSequencer) {
  const auto rig = read_rig(on_sequencer(text, "[chip]\nname = \"pinctrl-rp1\"\n[lines]\nsensor_a = { line = 24 }\n"
                                               "[sequencer]\nport = \"/dev/ttyAMA0\"\n"),
                            "rig.toml");
  CHECK_TRUE(rig.has_value());
  CHECK_EQUAL(std::string("pinctrl-rp1"), rig->chip);
  CHECK_TRUE(rig->line(Line::sensor_b).fitted);
  const Rig witnessed = witnessed_lines(*rig);
  CHECK_TRUE(witnessed.line(Line::sensor_a).fitted);
  for (const Line line : {Line::sensor_b, Line::key, Line::estop, Line::gate, Line::trigger})
    CHECK_FALSE_TEXT(witnessed.line(line).fitted, line_key(line));
}

TEST(RigFile, SaysWhatIsWrongWithAFlashSequencer) {
  const std::string port = "[sequencer]\nport = \"/dev/ttyAMA0\"\n";
  STRCMP_CONTAINS("sequencer.port: is missing", error_of(on_sequencer(text, "[sequencer]\n")).c_str());
  STRCMP_CONTAINS("sequencer.port: must be the path of a serial line",
                  error_of(on_sequencer(text, "[sequencer]\nport = \"ttyAMA0\"\n")).c_str());
  STRCMP_CONTAINS("lines.estop: is on the flash sequencer", error_of(text + port).c_str());
  STRCMP_CONTAINS("lamps.max_flashes_per_shot: must be at most 1024",
                  error_of(replaced(on_sequencer(text, port), "max_flashes_per_shot = 400", "max_flashes_per_shot = 1025"))
                      .c_str());
  STRCMP_CONTAINS("sequencer.inputs: must have sensor_a or sensor_b",
                  error_of(on_sequencer(text, port + "inputs = [\"gate\"]\n")).c_str());
  STRCMP_CONTAINS("sequencer.inputs: must be a list of",
                  error_of(on_sequencer(text, port + "inputs = [\"sensor_a\", \"key\"]\n")).c_str());
}

namespace {

/// The shipped rig on a Raspberry Pi 5 with this in place of one of its lines.
std::string on_pio(const std::string& text, const std::string& from = "", const std::string& to = "") {
  const std::string wiring = "[chip]\nname = \"pinctrl-rp1\"\npio = \"/dev/pio0\"\n[lines]\n"
                             "strobe_a = { line = 17 }\nstrobe_b = { line = 18 }\nshutter = { line = 22 }\n"
                             "trigger = { line = 23 }\nsensor_a = { line = 24 }\ngate = { line = 12 }\n"
                             "key = { line = 16 }\nestop = { line = 20, active_low = true }\n";
  return on_sequencer(text, replaced(wiring, from, to));
}

}  // namespace

TEST(RigFile, TheChipsPioMayPlayTheOutputs) {
  const auto rig = read_rig(on_pio(text), "rig.toml");
  CHECK_EQUAL(std::string(), error_of(on_pio(text)));
  CHECK_TRUE(rig->pio.fitted());
  CHECK_EQUAL(std::string("/dev/pio0"), rig->pio.device);
  CHECK_EQUAL(line_of(on_pio(text), "pio ="), std::to_string(rig->pio.file_line));
  CHECK_TRUE(rig->played_by_chip());
  CHECK_FALSE(rig->flash_sequencer.fitted());
  const auto without = read_rig(on_pio(text, "pio = \"/dev/pio0\"\n"), "rig.toml");
  CHECK_FALSE(without->pio.fitted());
  CHECK_FALSE(without->played_by_chip());
}

TEST(RigFile, SaysWhichLinesTheChipsPioCannotPlay) {
  const auto refused = [&](const char* key, const char* words, const std::string& from, const std::string& to) {
    const std::string error = error_of(on_pio(text, from, to));
    STRCMP_CONTAINS((std::string(key) + ": " + words).c_str(), error.c_str());
    const std::string name = std::string(key).substr(std::string(key).find('.') + 1);
    const std::string line = line_of(on_pio(text, from, to), "\n" + name + " = ");
    STRCMP_CONTAINS(("rig.toml:" + std::to_string(std::stoi(line) + 1) + ": ").c_str(), error.c_str());
  };
  refused("chip.pio", "must be the path of a PIO block", "pio = \"/dev/pio0\"", "pio = \"pio0\"");
  refused("lines.trigger", "must be given by its GPIO number", "trigger = { line = 23 }", "trigger = { line = \"GPIO23\" }");
  refused("lines.gate", "must be given by its GPIO number", "gate = { line = 12 }", "gate = { line = 28 }");
  refused("lines.shutter", "must not lie between lines.strobe_a and lines.strobe_b", "strobe_b = { line = 18 }",
          "strobe_b = { line = 27 }");
  refused("lines.strobe_a", "must not lie between lines.shutter and lines.trigger", "shutter = { line = 22 }",
          "shutter = { line = 13 }");
  refused("lines.key", "must not be active_low", "key = { line = 16 }", "key = { line = 16, active_low = true }");
  refused("lines.estop", "must be active_low", "estop = { line = 20, active_low = true }", "estop = { line = 20 }");
  STRCMP_CONTAINS("chip.pio: must not be beside a flash sequencer",
                  error_of(on_sequencer(text, "[chip]\nname = \"pinctrl-rp1\"\npio = \"/dev/pio0\"\n[lines]\n"
                                              "sensor_a = { line = 24 }\n[sequencer]\nport = \"/dev/ttyAMA0\"\n"))
                      .c_str());
  STRCMP_CONTAINS(
      "lamps.max_flashes_per_shot: must be at most 1024: with chip.pio",
      error_of(replaced(on_pio(text), "max_flashes_per_shot = 400", "max_flashes_per_shot = 1025")).c_str());
}

TEST(RigFile, ReadsTheShippedRig) {
  const auto rig = read_rig(text, "rig.toml");
  CHECK_EQUAL(std::string(), error_of(text));
  CHECK_EQUAL(std::string("bench"), rig->name);
  CHECK_EQUAL(std::string("gpiochip0"), rig->chip);
  CHECK_EQUAL(std::string("STROBE_A"), rig->line(Line::strobe_a).name);
  CHECK_FALSE(rig->line(Line::key).active_low);
  CHECK_TRUE(rig->line(Line::estop).active_low);
  CHECK_EQUAL(microseconds(50), rig->lamps.pulse);
  CHECK_EQUAL(microseconds(1500), rig->lamps.min_period);
  CHECK_EQUAL(milliseconds(45), rig->shutter.lag);
  CHECK_EQUAL(milliseconds(2000), rig->shutter.max_open);
  CHECK_EQUAL(milliseconds(310), rig->machine.lag);
  CHECK_EQUAL(microseconds(3000), rig->plan.period);
  CHECK_EQUAL(milliseconds(500), rig->plan.exposure);
  CHECK_EQUAL(milliseconds(250), rig->plan.impact_at);
  CHECK_EQUAL(microseconds(1500), rig->tolerance.abort_late);
  CHECK_EQUAL(milliseconds(30'000), rig->arming_expires);
  CHECK_EQUAL(80, rig->real_time.priority);
}

TEST(RigFile, PullsKeyAndEStopToWhereABrokenWireStopsTheRig) {
  const auto rig = read_rig(text, "rig.toml");
  CHECK_TRUE(Bias::pull_down == rig->line(Line::key).bias);    // open: low, off
  CHECK_TRUE(Bias::pull_down == rig->line(Line::estop).bias);  // open: low, pressed
  CHECK_FALSE(rig->line(Line::key).bias_chosen);
  for (const Line other : {Line::sensor_a, Line::gate, Line::strobe_a})
    CHECK_TRUE(Bias::as_is == rig->line(other).bias);
  text = replaced(text, "{ line = \"KEY\" }", "{ line = \"KEY\", active_low = true }");
  text = replaced(text, "{ line = \"ESTOP\", active_low = true }", "{ line = \"ESTOP\" }");
  const auto inverted = read_rig(text, "rig.toml");
  CHECK_TRUE(Bias::pull_up == inverted->line(Line::key).bias);
  CHECK_TRUE(Bias::pull_up == inverted->line(Line::estop).bias);
}

TEST(RigFile, ReadsABiasOfEachInput) {
  for (const auto& [word, bias] : {std::pair{"as_is", Bias::as_is}, std::pair{"disabled", Bias::disabled},
                                   std::pair{"pull_down", Bias::pull_down}}) {
    const auto rig = read_rig(
        replaced(text, "{ line = \"KEY\" }", "{ line = \"KEY\", bias = \"" + std::string(word) + "\" }"),
        "rig.toml");
    CHECK_TRUE(bias == rig->line(Line::key).bias);
    CHECK_TRUE(rig->line(Line::key).bias_chosen);
  }
  const auto gate =
      read_rig(replaced(text, "{ line = \"GATE\" }", "{ line = \"GATE\", bias = \"pull_up\" }"), "rig.toml");
  CHECK_TRUE(Bias::pull_up == gate->line(Line::gate).bias);
}

TEST(RigFile, RefusesABiasThatLetsABrokenWirePassOrThatAnOutputCannotHave) {
  const auto with = [&](const std::string& line, const std::string& bias) {
    return error_of(replaced(text, "\"" + line + "\"", "\"" + line + "\", bias = \"" + bias + "\""));
  };
  STRCMP_CONTAINS("lines.key.bias: must not be \"pull_up\": the key would read as on when its wire breaks",
                  with("KEY", "pull_up").c_str());
  STRCMP_CONTAINS(
      "lines.estop.bias: must not be \"pull_up\": the e-stop would read as released when its wire breaks",
      with("ESTOP", "pull_up").c_str());
  STRCMP_CONTAINS("lines.trigger.bias: is for inputs", with("TRIGGER", "pull_down").c_str());
  STRCMP_CONTAINS("lines.gate.bias", with("GATE", "up").c_str());
}

TEST(RigFile, RefusesOutputsThatWouldBeActiveWhileNobodyDrivesThem) {
  for (const std::string line : {"STROBE_A", "STROBE_B", "SHUTTER", "TRIGGER"}) {
    const std::string bad = replaced(text, "\"" + line + "\"", "\"" + line + "\", active_low = true");
    std::string key = line;
    for (char& letter : key) letter = static_cast<char>(std::tolower(letter));
    CHECK_EQUAL(
        "rig.toml:" + line_of(bad, "\"" + line + "\", active_low") + ": lines." + key +
            ".active_low: must not be true for an output: while strobed does not drive it, the resistor to "
            "ground would hold it active; invert it after the resistor, by the opto-coupler or relay driver",
        error_of(bad));
  }
}

TEST(RigFile, ReadsEveryNumberIntoItsPlace) {
  const std::array<std::array<const char*, 2>, 22> rows{
      {{"pulse_us = 50", "pulse_us = 51"},
       {"min_period_us = 1500", "min_period_us = 1600"},
       {"max_flashes_per_shot = 400", "max_flashes_per_shot = 401"},
       {"max_on_us = 200", "max_on_us = 201"},
       {"lag_ms = 45", "late_ms = 21\nlag_ms = 46"},
       {"max_open_s = 2.0", "max_open_s = 2.1"},
       {"lag_ms = 310", "lag_ms = 311"},
       {"pulse_ms = 20", "pulse_ms = 22"},
       {"max_on_ms = 100", "max_on_ms = 101"},
       {"train = \"free\"", "train = \"gated\""},
       {"period_us = 3000", "period_us = 3001\nflash_count = 12\ngate_delay_ms = 4"},
       {"shutter_open_ms = 500", "shutter_open_ms = 502"},
       {"impact_at_ms = 250", "impact_at_ms = 251"},
       {"late_us = 100 ", "late_us = 102 "},
       {"abort_late_us = 1500", "abort_late_us = 1501"},
       {"spin_us = 200", "spin_us = 202"},
       {"wake_ahead_us = 4000", "wake_ahead_us = 4001"},
       {"expires_s = 30", "expires_s = 31"},
       {"priority = 80", "priority = 81"},
       {"cpu = -1", "cpu = 3"},
       {"[commands]", "[commands]\nkey_file = \"lab.key\""},
       {"[chip]", "lcm_url = \"udpm://239.1.2.3:7000\"\n[chip]"}}};
  for (const auto& [from, to] : rows) text = replaced(text, from, to);
  const auto read = read_rig(text, "rig.toml");
  CHECK_EQUAL(std::string(), error_of(text));
  const Rig& rig = *read;
  CHECK(rig.lamps.pulse == microseconds(51) && rig.lamps.max_on == microseconds(201));
  CHECK(rig.lamps.min_period == microseconds(1600) && rig.lamps.max_flashes == 401);
  CHECK(rig.shutter.late == milliseconds(21) && rig.shutter.lag == milliseconds(46));
  CHECK(rig.shutter.max_open == milliseconds(2100));
  CHECK(rig.machine.lag == milliseconds(311) && rig.machine.pulse == milliseconds(22));
  CHECK(rig.machine.max_on == milliseconds(101));
  CHECK(rig.plan.train == Train::gated && rig.plan.flash_count == 12 &&
        rig.plan.gate_delay == milliseconds(4));
  CHECK(rig.plan.period == microseconds(3001) && rig.plan.exposure == milliseconds(502));
  CHECK(rig.plan.impact_at == milliseconds(251));
  CHECK(rig.tolerance.late == microseconds(102) && rig.tolerance.abort_late == microseconds(1501));
  CHECK(rig.tolerance.spin == microseconds(202) && rig.tolerance.wake_ahead == microseconds(4001));
  CHECK(rig.arming_expires == milliseconds(31'000));
  CHECK(rig.real_time.priority == 81 && rig.real_time.cpu == 3);
  CHECK_EQUAL(std::string("lab.key"), rig.key_file);
  CHECK_EQUAL(std::string("udpm://239.1.2.3:7000"), rig.lcm_url);
  CHECK_EQUAL(std::string("rig.toml"), rig.file_name);
}

TEST(RigFile, RemembersTheLinesOfTheFileForLaterErrors) {
  const auto rig = read_rig(text, "rig.toml");
  CHECK_EQUAL(line_of(text, "shutter  ="), std::to_string(rig->line(Line::shutter).file_line));
  CHECK_EQUAL(line_of(text, "name = \"gpiochip0\""), std::to_string(rig->chip_file_line));
}

TEST(RigFile, KeepsTheRecordAsShortText) {
  const auto rig =
      read_rig(replaced(text, "temperature_c = 21.0", "temperature_c = 21.3\nframe_number = 12"), "rig.toml");
  std::string all;
  for (const Note& note : rig->record) all += note.key + "=" + note.value + ";";
  STRCMP_CONTAINS("temperature_c=21.3;", all.c_str());
  STRCMP_CONTAINS("frame_number=12;", all.c_str());
  STRCMP_CONTAINS("surface_name=hard court;", all.c_str());
}

TEST(RigFile, TakesLinesByOffsetAndLeavesTheOptionalOnesOut) {
  text = replaced(text, "strobe_a = { line = \"STROBE_A\" }", "strobe_a = { line = 17, active_low = false }");
  text = replaced(text, "sensor_b = { line = \"SENSOR_B\" }\n", "");
  text = replaced(text, "gate     = ", "# gate     = ");
  const auto rig = read_rig(text, "rig.toml");
  CHECK_EQUAL(17, rig->line(Line::strobe_a).offset);
  CHECK_FALSE(rig->line(Line::sensor_b).fitted);
  CHECK_FALSE(rig->line(Line::gate).fitted || rig->line(Line::gate).active_low);
}

TEST(RigFile, GivesLampsAndSensorsOneDelayOrEachItsOwn) {
  const auto one = read_rig(text, "rig.toml");
  DOUBLES_EQUAL(12.0, one->lamps.delay_a_us, 0.0);
  DOUBLES_EQUAL(12.0, one->lamps.delay_b_us, 0.0);
  text = replaced(text, "delay_us = 12.0", "delay_a_us = 12.25\ndelay_b_us = 13.5");
  text = replaced(text, "delay_us = 0.0", "delay_us = 1.5\ndelay_b_us = 2");
  const auto own = read_rig(text, "rig.toml");
  CHECK_EQUAL(std::string(), error_of(text));
  DOUBLES_EQUAL(12.25, own->lamps.delay_a_us, 0.0);
  DOUBLES_EQUAL(13.5, own->lamps.delay_b_us, 0.0);
  CHECK_EQUAL(nanoseconds(1500), own->sensors.delay_a);
  CHECK_EQUAL(nanoseconds(2000), own->sensors.delay_b);
}

TEST(RigFile, TakesTheShuttersContactWhereThereIsOne) {
  CHECK_FALSE(read_rig(text, "rig.toml")->line(Line::xsync).fitted);
  text = replaced(text, "#xsync = ", "xsync = ");
  text = replaced(text, "#late_ms = ", "late_ms = ");
  const auto rig = read_rig(text, "rig.toml");
  CHECK_EQUAL(std::string(), error_of(text));
  CHECK_EQUAL(std::string("XSYNC"), rig->line(Line::xsync).name);
  CHECK_EQUAL(milliseconds(20), rig->shutter.late);
}

TEST(RigFile, LeavesACodedTrainOfThePlanToTheHost) {
  text =
      replaced(text, "shutter_open_ms = 500", "shutter_open_ms = 500\nomit = [7]\nonly_a = [3]\nonly_b = []");
  CHECK_EQUAL(std::string(), error_of(text));
}

TEST(RigFile, AcceptsWhatIsTheHosts) {
  text = replaced(text, "[analysis]", "[analysis]\nanything = [1, 2, { x = true }]\n[analysis.more]");
  text = replaced(text, "[camera]", "[camera]\nrectify = [1, 2]");
  CHECK_EQUAL(std::string(), error_of(text));
}

TEST(RigFile, NamesFileLineAndKeyOfEveryMistake) {
  struct Row {
    const char* from;
    const char* to;
    std::string error;  // without "rig.toml:LINE: "
  };
  const Row rows[] = {
      {"rig = \"bench\"", "rig = \"be nch\"", "rig: must be 1 to 24 characters of [A-Za-z0-9_-]"},
      {"rig = \"bench\"", "rig = 7", "rig: must be text in quotes"},
      {"rig = \"bench\"", "rig = \"bench\"\nlcm_url = 5", "lcm_url: must be text in quotes"},
      {"rig = \"bench\"", "rig = \"bench\"\nlcm_url = \"udpm://239.1.2.3\"",
       "lcm_url: " + wire::lcm_url_problem("udpm://239.1.2.3")},
      {"rig = \"bench\"", "rig = \"bench\"\nlcm_url = \"\"", "lcm_url: " + wire::lcm_url_problem("")},
      {"rig = \"bench\"", "rig = \"bench\"\nspeed = 3", "speed: unknown key"},
      {"name = \"gpiochip0\"", "name = 0", "chip.name: must be text in quotes"},
      {"trigger  = { line = \"TRIGGER\" }", "trigger = { line = 2.5 }",
       "lines.trigger.line: must be an offset or a name in quotes"},
      {"trigger  = { line = \"TRIGGER\" }", "trigger = { active_low = false }",
       "lines.trigger.line: is missing"},
      {"trigger  = { line = \"TRIGGER\" }", "trigger = \"TRIGGER\"", "lines.trigger: must be a table"},
      {"trigger  = { line = \"TRIGGER\" }", "trigger = { line = \"SHUTTER\" }",
       "lines.trigger: is the same line as lines.shutter"},
      {"trigger  = { line = \"TRIGGER\" }", "trigger = { line = -1 }",
       "lines.trigger.line: must be at least 0, is -1"},
      {"active_low = true", "active_low = 1", "lines.estop.active_low: must be true or false"},
      {"active_low = true", "activelow = true", "lines.estop.activelow: unknown key; did you mean active_low?"},
      {"pulse_us = 50", "pulse_us = 0", "lamps.pulse_us: must be at least 1, is 0"},
      {"pulse_us = 50", "pulse_us = \"50\"", "lamps.pulse_us: must be a number"},
      {"pulse_us = 50", "pulse_us = 201", "lamps.pulse_us: must not be longer than lamps.max_on_us"},
      {"pulse_us = 50", "pulse_us = nan", "lamps.pulse_us: must be a finite number"},
      {"max_flashes_per_shot = 400", "max_flashes_per_shot = 0",
       "lamps.max_flashes_per_shot: must be at least 1, is 0"},
      {"max_on_us = 200", "max_on_us = 1500", "lamps.max_on_us: must be shorter than lamps.min_period_us"},
      {"lag_ms = 45", "lag_ms = -1", "shutter.lag_ms: must be at least 0, is -1"},
      {"pulse_ms = 20", "pulse_ms = 101", "machine.pulse_ms: must not be longer than machine.max_on_ms"},
      {"train = \"free\"", "train = \"fast\"", "plan.train: must be one of free, gated, is \"fast\""},
      {"spacing = \"coded\"", "spacing = \"odd\"", "plan.spacing: must be one of even, coded, is \"odd\""},
      {"late_us = 100 ", "late_us = 1300 ",
       "tolerance.late_us: together with lamps.max_on_us must be shorter than lamps.min_period_us"},
      {"abort_late_us = 1500", "abort_late_us = 99",
       "tolerance.abort_late_us: must not be less than tolerance.late_us"},
      {"spin_us = 200", "spin_us = 401", "tolerance.spin_us: must be at most 400, is 401"},
      {"wake_ahead_us = 4000", "wake_ahead_us = -1", "tolerance.wake_ahead_us: must be at least 0, is -1"},
      {"expires_s = 30", "expires_s = 0", "arming.expires_s: must be at least 1, is 0"},
      {"priority = 80", "priority = 99", "real_time.priority: must be at most 98, is 99"},
      {"priority = 80", "priority = 80.5", "real_time.priority: must be a whole number"},
      {"operator = \"\"", "Operator = \"\"", "record.Operator: must be 1 to 64 characters of [a-z0-9_]"},
      {"operator = \"\"", "operator = true", "record.operator: must be a number"},
  };
  for (const Row& row : rows) {
    const std::string bad = replaced(text, row.from, row.to);
    const std::string last_line = std::string(row.to).substr(std::string(row.to).rfind('\n') + 1);
    CHECK_EQUAL("rig.toml:" + line_of(bad, last_line) + ": " + row.error, error_of(bad));
  }
}

TEST(RigFile, NamesTheTableWhereAKeyIsMissing) {
  const std::string without = replaced(text, "pulse_us = 50 ", "# pulse_us = 50 ");
  CHECK_EQUAL("rig.toml:" + line_of(text, "[lamps]") + ": lamps.pulse_us: is missing", error_of(without));
  CHECK_EQUAL(std::string("rig.toml:1: rig: is missing"), error_of("[chip]\nname = \"gpiochip0\"\n"));
  CHECK_EQUAL(std::string("rig.toml: chip.name: is missing"), error_of("rig = \"bench\"\n"));
}

TEST(RigFile, ChecksThePlanAgainstTheLimits) {
  STRCMP_CONTAINS(": plan: a period of 1000 us is shorter than the lamps' 1500 us",
                  error_of(replaced(text, "period_us = 3000", "period_us = 1000")).c_str());
}

TEST(RigFile, GivesTheLineOfASyntaxError) {
  STRCMP_CONTAINS("rig.toml:2: ", error_of("rig = \"bench\"\n[chip\n").c_str());
}

TEST(RigFile, NeedsAtLeastOneSensor) {
  text = replaced(text, "sensor_a = ", "# sensor_a = ");
  text = replaced(text, "sensor_b = ", "# sensor_b = ");
  STRCMP_CONTAINS("at least one of sensor_a and sensor_b is needed", error_of(text).c_str());
}
