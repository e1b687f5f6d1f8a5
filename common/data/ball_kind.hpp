// A kind of ball as its file says it (common/data/balls/KIND.toml, or one of a user's own): size, mass,
// inertia, what the air does to it, how its restitution depends on temperature, in which range of impacts the
// contact models have been held against measurements, and how it looks. Plain values and pure functions but
// for load_ball_kind(), which reads a file; thread-safe; not real-time safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/ball/ball.hpp"
#include "common/flight/air_law.hpp"
#include "common/result.hpp"

namespace strobe::balls {

/// What turns with the ball and can be seen.
enum class Marking {
  line,      ///< a great circle drawn on it: its spin is measured
  seam,      ///< tennis ball, baseball without drawn line, cricket ball
  dimples,   ///< golf ball
  stitches,  ///< baseball, softball
  dots,      ///< drawn
  panels,    ///< football, basketball
  holes,     ///< pickleball
  plain,     ///< table tennis, squash
};

/// A number with its standard deviation and where it was read; empty: nowhere, it is assumed.
struct Sourced {
  double value = 0.0;
  double sd = 0.0;
  std::string source;
};

/// How restitution changes with the ball's temperature: e(T) = e + per_K * (T - reference).
struct Elasticity {
  double per_K = 0.0;
  double per_K_sd = 0.0;
  double reference_degC = 23.0;
  std::string source;
};

/// Impacts that others have measured with such balls: beyond them predictions of the contact models are not
/// supported by anything.
struct ContactRange {
  double least_normal_mps = 0.0, most_normal_mps = 0.0;
  double dwell_s = 0.005;  ///< usual duration of contact, for plans and scenes
  double e = 0.75;         ///< usual restitution on a hard surface, likewise
  double mu = 0.5;         ///< usual friction, likewise
  std::string source;
};

struct Kind {
  std::string name;   ///< the file's, without ending: "golf"
  std::string title;  ///< "golf ball (R&A/USGA rules)"
  Sourced diameter_m, mass_kg, alpha;
  flight::AirLaw air;
  std::string air_source;
  std::optional<Elasticity> elasticity;  ///< absent: not known
  ContactRange contact;
  Marking marking = Marking::plain;
  std::vector<std::string> remarks;  ///< for a person, a sentence each

  ball::Ball ball() const { return {diameter_m.value, mass_kg.value, alpha.value}; }
};

std::string_view name(Marking marking);

/// What of a motion lies beyond what was measured of its kind, a sentence each: its drag and lift at
/// `speed_mps`, and impacts at `normal_mps` towards the surface.
std::vector<std::string> beyond_ranges(const Kind& kind, std::optional<double> speed_mps,
                                       std::optional<double> normal_mps);

/// Fails with "FILE:LINE: key: what".
Result<Kind> read_ball_kind(std::string_view text, const std::string& file_name);

/// Where a shipped kind's file is, or the path itself. Fails with a list of the shipped names.
Result<std::string> ball_kind_path(const std::string& name_or_path);

/// `name_or_path`: a shipped kind ("golf"), or a path to a file that ends in .toml. Fails with a list of the
/// shipped names, or with the file's name.
Result<Kind> load_ball_kind(const std::string& name_or_path);

/// Names of the shipped kinds, sorted. Fails where the installed files are not found.
Result<std::vector<std::string>> shipped_ball_kinds();

}  // namespace strobe::balls
