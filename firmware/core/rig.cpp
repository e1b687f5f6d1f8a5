#include "firmware/core/rig.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/config/toml_reader.hpp"
#include "common/messages/channels.hpp"
#include "common/wire/lcm_url.hpp"
#include "firmware/core/pulse_schedule.hpp"

namespace strobe::firmware {

namespace {

using config::TomlTable;

constexpr double kNsPerUs = 1e3;
constexpr double kNsPerMs = 1e6;
constexpr double kNsPerS = 1e9;

Duration rounded(double value, double ns_per_unit) { return nanoseconds(std::llround(value * ns_per_unit)); }

/// Two edges each in a track of 2048.
constexpr std::int32_t kMaxFlashesOfChip = 1024;

std::string shortest(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

bool is_output(Line which) {
  return which == Line::strobe_a || which == Line::strobe_b || which == Line::shutter ||
         which == Line::trigger;
}

void read_bias(TomlTable& table, Line which, LineConfig& line) {
  line.bias_chosen = table.has("bias");
  if (is_output(which)) {
    if (line.bias_chosen)
      table.error_at("bias", "is for inputs: an output that nobody drives is held by a resistor outside");
    return;
  }
  const std::optional<Bias> safe = fail_safe_bias(which, line.active_low);
  const std::string chosen =
      table.choice_or("bias", name(safe.value_or(Bias::as_is)), {kBiasNames.begin(), kBiasNames.end()});
  const auto found = std::find(kBiasNames.begin(), kBiasNames.end(), chosen);
  if (found != kBiasNames.end()) line.bias = static_cast<Bias>(found - kBiasNames.begin());
  if (safe && line.bias == opposite(*safe))
    table.error_at(
        "bias", "must not be \"" + chosen + "\": " +
                    (which == Line::key ? "the key would read as on" : "the e-stop would read as released") +
                    " when its wire breaks");
}

void read_line(TomlTable& lines, Line which, bool required, Rig& rig) {
  const char* key = line_key(which);
  LineConfig& line = rig.line(which);
  if (!lines.has(key)) {
    if (required) lines.error_at(key, "is missing");
    return;
  }
  TomlTable table = lines.table(key);
  line.fitted = true;
  line.file_line = lines.line_of(key);
  if (table.is_integer("line")) {
    line.offset = table.integer("line", {0, 1023});
  } else if (table.is_string("line")) {
    line.name = table.string("line");
    if (line.name.empty() || line.name.size() > 31) table.error_at("line", "must be 1 to 31 characters");
  } else {
    table.error_at("line", table.has("line") ? "must be an offset or a name in quotes" : "is missing");
  }
  line.active_low = table.boolean_or("active_low", false);
  if (line.active_low && is_output(which))
    table.error_at("active_low",
                   "must not be true for an output: while strobed does not drive it, the resistor to ground "
                   "would hold it active; invert it after the resistor, by the opto-coupler or relay driver");
  read_bias(table, which, line);
}

/// A machine of the PIO block writes a span of pins.
void check_span(TomlTable& lines, const Rig& rig, std::array<Line, 2> span, std::array<Line, 2> others) {
  const std::int64_t one = rig.line(span[0]).offset, other = rig.line(span[1]).offset;
  for (const Line which : others) {
    const std::int64_t pin = rig.line(which).offset;
    if (std::min(one, other) < pin && pin < std::max(one, other))
      lines.error_at(line_key(which), std::string("must not lie between lines.") + line_key(span[0]) +
                                          " and lines." + line_key(span[1]) + " with chip.pio");
  }
}

void check_pio_lines(TomlTable& lines, const Rig& rig) {
  constexpr std::int64_t kPins = 28;
  for (std::size_t i = 1; i < kLineCount; ++i) {
    const auto which = static_cast<Line>(i);
    const LineConfig& line = rig.line(which);
    if (line.fitted && (line.offset < 0 || line.offset >= kPins))
      lines.error_at(line_key(which), "must be given by its GPIO number, 0 to 27, with chip.pio");
  }
  check_span(lines, rig, {Line::shutter, Line::trigger}, {Line::strobe_a, Line::strobe_b});
  check_span(lines, rig, {Line::strobe_a, Line::strobe_b}, {Line::shutter, Line::trigger});
  if (rig.line(Line::key).active_low)
    lines.error_at("key",
                   "must not be active_low with chip.pio, which lets outputs through while it is high");
  if (!rig.line(Line::estop).active_low)
    lines.error_at("estop", "must be active_low with chip.pio, which lets outputs through while it is high");
}

void read_lines(TomlTable lines, Rig& rig) {
  for (const Line which :
       {Line::strobe_a, Line::strobe_b, Line::shutter, Line::trigger, Line::key, Line::estop}) {
    read_line(lines, which, true, rig);
  }
  for (const Line which : {Line::sensor_a, Line::sensor_b, Line::gate, Line::xsync})
    read_line(lines, which, false, rig);
  if (!rig.line(Line::sensor_a).fitted && !rig.line(Line::sensor_b).fitted) {
    lines.error_at("sensor_a", "at least one of sensor_a and sensor_b is needed");
  }
  for (std::size_t i = 1; i < kLineCount; ++i) {
    for (std::size_t k = 1; k < i; ++k) {
      const LineConfig &a = rig.lines[k], &b = rig.lines[i];
      if (a.fitted && b.fitted && a.offset == b.offset && a.name == b.name) {
        lines.error_at(line_key(static_cast<Line>(i)),
                       std::string("is the same line as lines.") + line_key(static_cast<Line>(k)));
      }
    }
  }
  if (rig.pio.fitted()) check_pio_lines(lines, rig);
}

void read_chip(TomlTable root, Rig& rig) {
  TomlTable chip = root.table("chip");
  rig.chip = chip.string("name");
  rig.chip_file_line = chip.line_of("name");
  if (!chip.has("pio")) return;
  rig.pio = {chip.string("pio"), chip.line_of("pio")};
  if (rig.flash_sequencer.fitted()) chip.error_at("pio", "must not be beside a flash sequencer");
  if (!rig.pio.device.starts_with("/"))
    chip.error_at("pio", "must be the path of a PIO block, such as /dev/pio0");
}

/// Flash sensors that a chip has besides.
void read_witnessed_lines(TomlTable root, Rig& rig) {
  if (!root.has("chip") && !root.has("lines")) return;
  read_chip(root, rig);
  TomlTable lines = root.table("lines");
  for (const std::string& key : lines.keys())
    if (key != "sensor_a" && key != "sensor_b")
      lines.error_at(key, "is on the flash sequencer: a chip may have sensor_a and sensor_b besides");
  for (const Line sensor : {Line::sensor_a, Line::sensor_b}) read_line(lines, sensor, false, rig);
}

/// Its lines are where its pins are; of the inputs some may not be wired.
void read_flash_sequencer(TomlTable root, Rig& rig) {
  TomlTable table = root.table("sequencer");
  rig.flash_sequencer = {table.string("port"), table.line_of("port")};
  read_witnessed_lines(root, rig);
  for (LineConfig& line : rig.lines) line.fitted = false;
  if (table.is_string("port") && !rig.flash_sequencer.port.starts_with("/"))
    table.error_at("port", "must be the path of a serial line, such as /dev/serial/by-id/...");
  for (const Line always :
       {Line::strobe_a, Line::strobe_b, Line::shutter, Line::trigger, Line::key, Line::estop})
    rig.line(always).fitted = true;
  for (const std::string& name : table.strings_or("inputs", {"sensor_a", "sensor_b", "gate"})) {
    const std::array optional{Line::sensor_a, Line::sensor_b, Line::gate, Line::xsync};
    const auto found =
        std::find_if(optional.begin(), optional.end(), [&name](Line line) { return name == line_key(line); });
    if (found == optional.end()) {
      table.error_at("inputs", "must be a list of sensor_a, sensor_b, gate and xsync");
    } else {
      rig.line(*found).fitted = true;
    }
  }
  if (!rig.line(Line::sensor_a).fitted && !rig.line(Line::sensor_b).fitted)
    table.error_at("inputs", "must have sensor_a or sensor_b");
}

void read_lamps(TomlTable table, Rig& rig) {
  auto& lamps = rig.lamps;
  lamps.max_on = rounded(table.number("max_on_us", {1, 10'000}), kNsPerUs);
  lamps.pulse = rounded(table.number("pulse_us", {1, 10'000}), kNsPerUs);
  if (lamps.pulse > lamps.max_on) table.error_at("pulse_us", "must not be longer than lamps.max_on_us");
  const double delay_us = table.number_or("delay_us", 0.0, {0, 10'000});
  lamps.delay_a_us = table.number_or("delay_a_us", delay_us, {0, 10'000});
  lamps.delay_b_us = table.number_or("delay_b_us", delay_us, {0, 10'000});
  lamps.min_period = rounded(table.number("min_period_us", {100, 1e6}), kNsPerUs);
  if (lamps.max_on >= lamps.min_period)
    table.error_at("max_on_us", "must be shorter than lamps.min_period_us");
  lamps.max_flashes = static_cast<std::int32_t>(table.integer("max_flashes_per_shot", {1, kMaxFlashes}));
  if (rig.played_by_chip() && lamps.max_flashes > kMaxFlashesOfChip)
    table.error_at("max_flashes_per_shot",
                   std::string("must be at most 1024: ") +
                       (rig.pio.fitted() ? "with chip.pio there is" : "a flash sequencer has") +
                       " no room for more");
}

void read_sensors(TomlTable table, Rig& rig) {
  const double delay_us = table.number_or("delay_us", 0.0, {-10'000, 10'000});
  rig.sensors.delay_a = rounded(table.number_or("delay_a_us", delay_us, {-10'000, 10'000}), kNsPerUs);
  rig.sensors.delay_b = rounded(table.number_or("delay_b_us", delay_us, {-10'000, 10'000}), kNsPerUs);
}

void read_movers(TomlTable shutter, TomlTable machine, Rig& rig) {
  rig.shutter.lag = rounded(shutter.number("lag_ms", {0, 5'000}), kNsPerMs);
  rig.shutter.max_open = rounded(shutter.number("max_open_s", {0.001, 60}), kNsPerS);
  rig.shutter.late = rounded(shutter.number_or("late_ms", 20.0, {0.1, 1'000}), kNsPerMs);
  rig.machine.lag = rounded(machine.number("lag_ms", {0, 60'000}), kNsPerMs);
  rig.machine.max_on = rounded(machine.number("max_on_ms", {0.01, 10'000}), kNsPerMs);
  rig.machine.pulse = rounded(machine.number("pulse_ms", {0.01, 10'000}), kNsPerMs);
  if (rig.machine.pulse > rig.machine.max_on) {
    machine.error_at("pulse_ms", "must not be longer than machine.max_on_ms");
  }
}

void read_plan(TomlTable& root, Rig& rig) {
  TomlTable table = root.table("plan");
  ShotPlan& plan = rig.plan;
  plan.train = table.choice_or("train", "free", {"free", "gated"}) == "gated" ? Train::gated : Train::free;
  // What the host makes of a drop is its own; here any period will do.
  const bool dropped = table.number_or("drop_height_m", 0.0, {0, 20}) > 0.0;
  plan.period =
      rounded(dropped ? table.number_or("period_us", 10'000, {1, 1e7}) : table.number("period_us", {1, 1e7}),
              kNsPerUs);
  plan.exposure = rounded(table.number("shutter_open_ms", {0.001, 60'000}), kNsPerMs);
  plan.gate_delay = rounded(table.number_or("gate_delay_ms", 0.0, {0, 60'000}), kNsPerMs);
  plan.flash_count = static_cast<std::int32_t>(table.integer_or("flash_count", 0, {0, kMaxFlashes}));
  // A coded train is the host's to make; what comes with a FIRE is checked like any plan.
  table.choice_or("spacing", "even", {"even", "coded"});
  for (const char* key : {"intervals_us", "omit", "only_a", "only_b"}) table.numbers_or(key, {});
  plan.impact_at = rounded(table.number("impact_at_ms", {0.001, 60'000}), kNsPerMs);
  if (auto checked = check_plan(plan, rig); !checked) root.error_at("plan", checked.error().message);
}

void read_timing(TomlTable tolerance, TomlTable arming, TomlTable real_time, Rig& rig) {
  rig.tolerance.late = rounded(tolerance.number("late_us", {1, 1e6}), kNsPerUs);
  rig.tolerance.abort_late = rounded(tolerance.number("abort_late_us", {1, 1e6}), kNsPerUs);
  if (rig.tolerance.abort_late < rig.tolerance.late) {
    tolerance.error_at("abort_late_us", "must not be less than tolerance.late_us");
  }
  if (rig.tolerance.late + rig.lamps.max_on >= rig.lamps.min_period) {
    // Else what is tolerated would excuse a flash of a lamp that has not recharged.
    tolerance.error_at("late_us", "together with lamps.max_on_us must be shorter than lamps.min_period_us");
  }
  rig.tolerance.spin = rounded(tolerance.number("spin_us", {0, 400}), kNsPerUs);
  if (rig.tolerance.spin + rig.lamps.max_on >= rig.lamps.min_period) {
    // Else the loop would go from spin to spin and never look at the e-stop.
    tolerance.error_at("spin_us", "together with lamps.max_on_us must be shorter than lamps.min_period_us");
  }
  const double as_it_is_us = static_cast<double>(rig.tolerance.wake_ahead.count()) / kNsPerUs;
  rig.tolerance.wake_ahead =
      rounded(tolerance.number_or("wake_ahead_us", as_it_is_us, {0, 20'000}), kNsPerUs);
  rig.arming_expires = rounded(arming.number("expires_s", {1, 3600}), kNsPerS);
  rig.real_time.priority = static_cast<int>(real_time.integer_or("priority", 80, {1, 98}));
  rig.real_time.cpu = static_cast<int>(real_time.integer_or("cpu", -1, {-1, 1023}));
}

void read_record(TomlTable& root, Rig& rig) {
  TomlTable table = root.table("record");
  constexpr std::size_t kMaxNotes = 64;
  for (const std::string& key : table.keys()) {
    const bool well_formed = !key.empty() && key.size() <= 64 &&
                             key.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == key.npos;
    if (!well_formed) table.error_at(key, "must be 1 to 64 characters of [a-z0-9_]");
    Note note{key, table.is_string(key) ? table.string(key) : shortest(table.number(key))};
    if (note.value.size() > 1024) table.error_at(key, "must be at most 1024 bytes");
    rig.record.push_back(std::move(note));
  }
  if (rig.record.size() > kMaxNotes) root.error_at("record", "must have at most 64 entries");
}

std::string read_lcm_url(TomlTable root) {
  const std::string url = root.string("lcm_url");
  if (const auto problem = wire::lcm_url_problem(url); !problem.empty()) root.error_at("lcm_url", problem);
  return url;
}

}  // namespace

Rig witnessed_lines(const Rig& rig) {
  Rig witnessed = rig;
  for (LineConfig& line : witnessed.lines) line.fitted = line.offset >= 0 || !line.name.empty();
  return witnessed;
}

const char* line_key(Line line) {
  constexpr std::array<const char*, kLineCount> kKeys{"none",    "strobe_a", "strobe_b", "shutter",
                                                      "trigger", "sensor_a", "sensor_b", "gate",
                                                      "key",     "estop",    "xsync"};
  return kKeys[static_cast<std::size_t>(line)];
}

Result<Rig> read_rig(std::string_view text, const std::string& file_name) {
  config::TomlReader reader(text, file_name);
  TomlTable root = reader.root();
  Rig rig;
  rig.file_name = file_name;
  rig.name = root.string("rig");
  if (!messages::valid_rig_name(rig.name))
    root.error_at("rig", "must be 1 to 24 characters of [A-Za-z0-9_-]");
  if (root.has("lcm_url")) rig.lcm_url = read_lcm_url(root);
  rig.key_file = root.table("commands").string_or("key_file", "");
  if (root.has("sequencer")) {
    read_flash_sequencer(root, rig);
  } else {
    read_chip(root, rig);
    read_lines(root.table("lines"), rig);
  }
  read_lamps(root.table("lamps"), rig);
  read_sensors(root.table("sensors"), rig);
  TomlTable machine = root.table("machine");
  machine.number_or("flashes_before_ms", 0.0, {0, 60'000});
  read_movers(root.table("shutter"), machine, rig);
  read_timing(root.table("tolerance"), root.table("arming"), root.table("real_time"), rig);
  read_record(root, rig);
  root.table("ball").accept_all();
  root.table("analysis").accept_all();
  root.table("camera").accept_all();
  root.table("laboratory").accept_all();
  root.table("commission").accept_all();
  root.table("report").accept_all();
  read_plan(root, rig);  // last: it is checked against the other tables' limits
  if (auto bad = reader.error()) return tl::unexpected(*bad);
  return rig;
}

}  // namespace strobe::firmware
