// The rig as configured: lines, limits and times of rig.toml, in the firmware's units. Plain values, read
// once before the loop starts, then only looked at.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

/// What a chip's own resistor does to an input.
enum class Bias {
  as_is,  ///< as whoever had the line before left it; after a reset, as the chip's maker chose for that line
  pull_up,
  pull_down,
  disabled,
};

/// As in the rig file.
inline constexpr std::array<std::string_view, 4> kBiasNames{"as_is", "pull_up", "pull_down", "disabled"};
constexpr std::string_view name(Bias bias) { return kBiasNames[static_cast<std::size_t>(bias)]; }

constexpr bool pulls(Bias bias) { return bias == Bias::pull_up || bias == Bias::pull_down; }
/// Of one that pulls.
constexpr Bias opposite(Bias bias) { return bias == Bias::pull_up ? Bias::pull_down : Bias::pull_up; }

/// Pulls an open wire to where the e-stop reads as pressed, or the key as off; nullopt for a line whose
/// broken wire stops nothing.
constexpr std::optional<Bias> fail_safe_bias(Line line, bool active_low) {
  if (line == Line::estop) return active_low ? Bias::pull_down : Bias::pull_up;
  if (line == Line::key) return active_low ? Bias::pull_up : Bias::pull_down;
  return std::nullopt;
}

struct LineConfig {
  bool fitted = false;
  std::string name;          ///< empty: by offset
  std::int64_t offset = -1;  ///< -1: by name
  bool active_low = false;
  Bias bias = Bias::as_is;      ///< of an input
  bool bias_chosen = false;     ///< the file says so; else it is the default
  std::uint32_t file_line = 0;  ///< in the rig file, for messages
};

struct Note {
  std::string key;
  std::string value;
};

struct Rig {
  std::string file_name;
  std::string name = "bench";
  std::string lcm_url;   ///< empty: the default
  std::string key_file;  ///< the lab's key; empty: the usual places
  std::string chip = "gpiochip0";
  std::uint32_t chip_file_line = 0;
  std::array<LineConfig, kLineCount> lines;  ///< indexed by Line

  /// Of the chip, a Raspberry Pi 5's: its PIO block plays the outputs. Their lines are pins then, the pins of
  /// shutter and trigger not between those of the lamps nor the other way round; key and e-stop are high when
  /// they allow.
  struct Pio {
    std::string device;  ///< empty: strobed sets the outputs itself
    std::uint32_t file_line = 0;
    bool fitted() const { return !device.empty(); }
  } pio;

  /// All lines are on it, where its pins are (firmware/sequencer/README.md). A chip may have the flash
  /// sensors besides, so that the kernel stamps their edges, too.
  struct FlashSequencer {
    std::string port;  ///< of its serial line; empty: there is none
    std::uint32_t port_file_line = 0;
    bool fitted() const { return !port.empty(); }
  } flash_sequencer;

  struct Lamps {
    Duration pulse = microseconds(50);
    double delay_a_us = 12.0;  ///< mean, from the trigger pulse to the flash
    double delay_b_us = 12.0;
    Duration min_period = microseconds(1500);
    std::int32_t max_flashes = 400;
    Duration max_on = microseconds(200);
  } lamps;
  struct Sensors {
    Duration delay_a{};  ///< subtracted from the stamps
    Duration delay_b{};
  } sensors;
  struct Shutter {
    Duration lag = milliseconds(45);
    Duration max_open = milliseconds(2000);
    Duration late = milliseconds(20);  ///< how far off the lag its contact may switch
  } shutter;
  struct Machine {
    Duration lag = milliseconds(310);
    Duration pulse = milliseconds(20);
    Duration max_on = milliseconds(100);
  } machine;
  ShotPlan plan;  ///< default shot; its impact_at serves plans that have none
  struct Tolerance {
    Duration late = microseconds(100);
    Duration abort_late = microseconds(1500);
    Duration spin = microseconds(200);
    Duration wake_ahead = microseconds(4000);  ///< awake for so long before a pulse, if longer than spin
  } tolerance;
  Duration arming_expires = milliseconds(30'000);
  struct RealTime {
    int priority = 80;
    int cpu = -1;
  } real_time;
  std::vector<Note> record;

  /// Whether a chip plays a shot's train, which it was given before: how exactly is not up to this computer.
  bool played_by_chip() const { return flash_sequencer.fitted() || pio.fitted(); }
  const LineConfig& line(Line which) const { return lines[static_cast<std::size_t>(which)]; }
  LineConfig& line(Line which) { return lines[static_cast<std::size_t>(which)]; }
};

/// Of a rig with a flash sequencer: with the lines alone that a chip has besides.
Rig witnessed_lines(const Rig& rig);

/// The key of a line in [lines], e.g. "strobe_a".
const char* line_key(Line line);

/// Reads rig.toml. Every value is checked; the first error names file, line and key. [ball], [analysis] and
/// [camera] belong to the host and are not checked. file_name: for errors. Pure; allocates; thread-safe.
Result<Rig> read_rig(std::string_view text, const std::string& file_name);

}  // namespace strobe::firmware
