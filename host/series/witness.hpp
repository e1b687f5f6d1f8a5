// What each shot says of things whose truth is known or constant, so that a drift of scale, clock, tilt, lens
// or lamp is told before numbers are believed. No I/O; thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "common/reduction/witnesses.hpp"
#include "host/session/shot.hpp"

namespace strobe::host {

enum class Witness {
  gravity_mps2,        ///< by the balls' free fall with drag
  diameters_px_per_m,  ///< the scale that the balls' diameters give
  surface_deg,         ///< inclination of the surface line on the photograph
  lamp_a_us,           ///< pulse to flash, as the sensor saw it
  lamp_b_us,           //
  clock_ppm,           ///< this computer's clock against the rig's; it gains
  path_residuals,      ///< centres' deviations from the paths over their noise
};
inline constexpr std::array<std::string_view, 7> kWitnessNames{
    "gravity_mps2", "diameters_px_per_m", "surface_deg",   "lamp_a_us",
    "lamp_b_us",    "clock_ppm",          "path_residuals"};
inline constexpr std::size_t kWitnessCount = kWitnessNames.size();
constexpr std::string_view name(Witness w) { return kWitnessNames[static_cast<std::size_t>(w)]; }
/// For a person: "gravity", "scale by the balls" ...
std::string_view words(Witness w);

struct WitnessValue {
  reduction::Estimate measured;
  /// What it ought to be, and how well that is known: the calibration's scale with the ball's tolerance, the
  /// place's gravity (kAirShareOfGravity), the rig file's delay of the lamp, clocks that agree. Absent: only
  /// earlier shots tell.
  std::optional<reduction::Estimate> reference;
};

/// Index: Witness. Of a shot without numbers, or a rejected one, all are absent.
struct ShotWitnesses {
  std::array<std::optional<WitnessValue>, kWitnessCount> of;
  bool calibrated = false;  ///< gravity's scale is the calibration's; else the balls'

  const std::optional<WitnessValue>& operator[](Witness w) const { return of[static_cast<std::size_t>(w)]; }
};

/// From Shot::witnesses, its train and clock.
ShotWitnesses witnesses(const Shot& shot);

/// A lamp's mean delay changes by this much from shot to shot, with its warmth, and nobody minds. [us]
inline constexpr double kLampWander_us = 1.0;
/// Two computers' clocks differ by this much, also while their clocks are slewed. [ppm]
inline constexpr double kClockWander_ppm = 100.0;
/// What the tolerances of drag and lift leave open of gravity, the same in all shots.
inline constexpr double kAirShareOfGravity = 0.03;

}  // namespace strobe::host
