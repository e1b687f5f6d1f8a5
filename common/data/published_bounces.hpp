// Bounces that others have published, in this project's axes (x along the surface in the direction of travel,
// y up from it, spin counter-clockwise positive: topspin of a ball travelling to +x is negative).
// common/data/bounces/README.md cites the publications and says how their numbers became these. Parsing is
// pure; load_bounces() reads files. Thread-safe; allocates.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::published {

struct Measured {
  double value = 0.0;
  double sd = 0.0;  ///< >= 0; as published, or as balls of that publication are known (README)
};

enum class Build {
  shell,  ///< a hollow ball under felt: a tennis ball
  solid,  ///< elastic throughout: rubber, ceramics
};

/// What it bounces on, by which models are valid.
enum class Ground {
  hard,  ///< deforms no more than the ball
  pad,   ///< elastic, and gives way
  strings,
  turf,  ///< earth under grass or clay, which yields: its contact plane tilts
         ///< (impact::contact_plane_tilt_rad)
};

struct Ball {
  std::string name;
  Build build = Build::shell;
  double diameter_m = 0.0;
  double mass_kg = 0.0;
  Measured alpha{};                       ///< I = alpha·m·R²
  std::optional<double> poisson_ratio{};  ///< of a solid ball
  std::string source{};
};

/// Ball against surface.
struct Bounce {
  std::string name;
  std::string ball;
  std::string surface;
  /// Of the surface to the horizontal, falling towards +x; absent: not published.
  std::optional<double> incline_deg{};
  Measured vx_td_mps{}, vy_td_mps{}, omega_td_radps{};
  std::optional<Measured> vx_lo_mps{}, vy_lo_mps{}, omega_lo_radps{};  ///< absent: not published

  /// -vy_LO/vy_TD; absent without vy_lo_mps.
  std::optional<double> restitution() const;
  /// (vx_TD - vx_LO)/(vy_LO - vy_TD); absent without the velocities at lift-off.
  std::optional<double> impulse_ratio() const;
};

/// What is taken as the coefficient of friction of a surface.
struct Friction {
  std::string surface;
  std::string row;                      ///< the bounce whose impulse ratio it is; empty: `mu`
  double mu = 0.0;                      ///< where no bounce tells it
  std::optional<Measured> elsewhere{};  ///< measured by others, or by the author on another day
  std::string reason{};
  Ground ground = Ground::hard;
};

struct Set {
  std::string name;
  std::string publication{};
  std::string read_from{};  ///< where the numbers were read
  std::vector<Bounce> bounces{};
  std::vector<Friction> frictions{};

  const Bounce* bounce(std::string_view name) const;         ///< nullptr if there is none of that name
  const Friction* friction(std::string_view surface) const;  ///< nullptr if there is none
};

struct Bounces {
  std::vector<Ball> balls;
  std::vector<Set> sets;

  const Ball* ball(std::string_view name) const;  ///< nullptr if there is none
  const Set* set(std::string_view name) const;    ///< nullptr if there is none
};

/// `name`.csv of a set. Fails, with source, line and column, on a missing or other header, no rows, a name
/// given twice, an sd below 0, vy_td_mps not below 0, vy_lo_mps not above 0 or above that of touchdown,
/// neither vx nor spin at lift-off, a value without its sd, an incline outside 0…90.
Result<std::vector<Bounce>> parse_bounces(std::string_view text, std::string_view source);

/// balls.csv. Fails on sizes and masses that are not positive, alpha outside 0…2/3, a build that is neither
/// `shell` nor `solid`, a Poisson's ratio outside 0…0.5 or of a shell, a name given twice.
Result<std::vector<Ball>> parse_balls(std::string_view text, std::string_view source);

/// friction.csv, into the sets that it names. Fails on an unknown set, surface or row, a row without
/// velocities at lift-off, neither or both of row and mu, a surface given twice, a surface of which it says
/// nothing, an unknown ground.
Result<void> parse_frictions(std::string_view text, std::string_view source, std::span<Set> sets);

/// Reads `folder`/balls.csv, sets.csv, friction.csv and each set's file. Fails besides on a ball that
/// balls.csv lacks.
Result<Bounces> load_bounces(const std::filesystem::path& folder);

}  // namespace strobe::published
