#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>

#include "sim/loading/tables.hpp"
#include "sim/motion/flight.hpp"
#include "sim/scene/spring.hpp"

namespace strobe::sim::tables {

namespace {

using config::Range;
using config::TomlTable;

constexpr Range kRestitution{0.05, 0.99};
constexpr Range kDwell_ms{0.1, 50.0};
constexpr Range kFriction{0.0, 2.0};
constexpr Range kStiffness_npm{1.0, 1e9};
constexpr Range kDamping_nspm{0.0, 1e6};
constexpr Range kRatio{0.01, 100.0};

double alpha_of_inertia(double inertia_kgm2, const ball::Ball& ball) {
  return inertia_kgm2 / (ball.mass_kg * ball.radius_m() * ball.radius_m());
}

/// Of the named model; the shells are those of the thesis's balls, whatever the felt around them.
double alpha_of(const std::string& inertia, const ball::Ball& ball) {
  if (inertia == "thin_shell") return ball::kThinShellAlpha;
  if (inertia == "solid") return 0.4;
  if (inertia == "measured") return ball::kMeasuredAlpha;
  if (inertia == "rubber_shell_mean_radius")
    return alpha_of_inertia(ball::thin_shell_inertia_kgm2(ball.mass_kg, ball::kShellMeanRadius_m), ball);
  return alpha_of_inertia(
      *ball::thick_shell_inertia_kgm2(ball.mass_kg, ball::kShellOuterRadius_m, ball::kShellInnerRadius_m),
      ball);
}

void read_law(TomlTable& table, BounceSettings& b) {
  b.contact =
      table.choice_or("contact", "ode", {"ode", "grip"}) == "ode" ? ContactLaw::ode : ContactLaw::grip;
  const bool ode = b.contact == ContactLaw::ode;
  for (const std::string_view key : keys_of(ode ? ContactLaw::grip : ContactLaw::ode)) {
    if (table.has(key))
      table.error_at(key, fmt::format("belongs to contact = \"{}\", and this scene's is \"{}\"",
                                      ode ? "grip" : "ode", ode ? "ode" : "grip"));
  }
  if (ode) {
    b.stiffness_ratio = table.number_or("stiffness_ratio", b.stiffness_ratio, kRatio);
    b.stiffness_ratio_sd = table.number_or("stiffness_ratio_sd", 0.0, {0.0, 10.0});
    b.damping_ratio = table.number_or("damping_ratio", b.damping_ratio, {0.0, 10.0});
    if (b.damping_ratio > 0.0 && b.damping_ratio < 0.01)
      table.error_at("damping_ratio", "must be 0 or at least 0.01");
    b.offset_share = table.number_or("offset_share", b.offset_share, {0.0, 1.0});
    b.offset_share_sd = table.number_or("offset_share_sd", 0.0, {0.0, 1.0});
  } else {
    b.ex = table.number("ex", {-1.0, 1.0});
    b.ex_sd = table.number_or("ex_sd", 0.0, {0.0, 1.0});
    b.offset_m = table.number("offset_mm", {0.0, 20.0}) * kMilli;
    b.offset_sd_m = table.number_or("offset_sd_mm", 0.0, {0.0, 20.0}) * kMilli;
  }
  b.offset_grip_correlation = table.number_or("offset_grip_correlation", 0.0, {-1.0, 1.0});
}

/// A linear spring's restitution and dwell time do not depend on the speed.
void read_springs(TomlTable& ball, TomlTable& bounce, const Scene& scene, BounceSettings& b) {
  for (const std::string_view key : {"e", "dwell_ms"}) {
    if (bounce.has(key)) bounce.error_at(key, "excludes ball.stiffness_npm and ball.damping_nspm");
  }
  const double stiffness_npm = ball.number("stiffness_npm", kStiffness_npm);
  const double damping_nspm = ball.number("damping_nspm", kDamping_nspm);
  const SpringRebound rebound = rebound_of_spring(scene.ball.mass_kg, stiffness_npm, damping_nspm);
  b.e = rebound.e;
  b.dwell_s = rebound.dwell_s;
  b.e_slope_spm = 0.0;
  if (!(b.e >= kRestitution.least && b.e <= kRestitution.most)) {
    ball.error_at("damping_nspm", fmt::format("makes the restitution {:.3g}; must be {} to {}", b.e,
                                              kRestitution.least, kRestitution.most));
  }
  if (!(b.dwell_s >= kDwell_ms.least * kMilli && b.dwell_s <= kDwell_ms.most * kMilli)) {
    ball.error_at("stiffness_npm", fmt::format("makes the dwell time {:.3g} ms; must be {} to {}",
                                               b.dwell_s / kMilli, kDwell_ms.least, kDwell_ms.most));
  }
}

double e_of_height(TomlTable& bounce, const Scene& scene) {
  if (bounce.has("e")) bounce.error_at("e", "excludes bounce.rebound_height_m");
  const MachineSettings& m = scene.machine;
  const VerticalFlight rise = rising(scene, bounce.number("rebound_height_m", {0.01, 20.0}));
  const double e = rise.speed_mps / std::abs(m.speed_mps * std::sin(m.angle_rad));
  if (!(e >= kRestitution.least && e <= kRestitution.most))
    bounce.error_at("rebound_height_m", fmt::format("makes the restitution {:.3g}; must be {} to {}", e,
                                                    kRestitution.least, kRestitution.most));
  return e;
}

void read_rebound(TomlTable& root, const Scene& scene, BounceSettings& b) {
  TomlTable ball = root.table("ball");
  TomlTable bounce = root.table("bounce");
  if (ball.has("stiffness_npm") || ball.has("damping_nspm")) {
    read_springs(ball, bounce, scene, b);
  } else {
    const auto usual = [&](const char* key, double of_kind, Range range) {
      return scene.kind ? bounce.number_or(key, of_kind, range) : bounce.number(key, range);
    };
    const double usual_e = scene.kind ? scene.kind->contact.e : 0.0;
    const double usual_dwell_ms = scene.kind ? scene.kind->contact.dwell_s / kMilli : 0.0;
    b.e = bounce.has("rebound_height_m") ? e_of_height(bounce, scene) : usual("e", usual_e, kRestitution);
    b.dwell_s = usual("dwell_ms", usual_dwell_ms, kDwell_ms) * kMilli;
  }
  const MachineSettings& m = scene.machine;
  b.e_speed_mps = bounce.number_or("e_speed_mps", m.speed_mps * std::abs(std::sin(m.angle_rad)), {0.0, 60.0});
  b.e_slope_spm = bounce.number_or("e_slope_s_per_m", b.e_slope_spm, {-0.1, 0.1});
  b.e_sd = bounce.number_or("e_sd", 0.0, {0.0, 0.3});
  b.dwell_sd_s = bounce.number_or("dwell_sd_ms", 0.0, {0.0, 10.0}) * kMilli;
  b.count = static_cast<int>(bounce.integer_or("count", b.count, {1, 20}));
}

/// Middle of each of the ITF's classes; of the open ones as far from their edge.
double court_pace_of(const std::string& grade) {
  if (grade == "slow") return 27.0;         // up to 29
  if (grade == "medium_slow") return 32.0;  // 30 to 34
  if (grade == "medium") return 37.0;       // 35 to 39
  if (grade == "medium_fast") return 42.0;  // 40 to 44
  return 47.0;                              // fast: 45 and more
}

/// The friction that gives a surface its court pace rating by ITF CS 01/02,
/// 100·(1 - mu) + 150·(0.81 - e_T), e_T = e + 0.003·(23 - T), at the test's 30 m/s and 16 degrees.
double friction_of_pace(double court_pace, const BounceSettings& b, double temperature_c) {
  const double test_speed_mps = 30.0 * std::sin(16.0 * kDegree);
  const double e = b.e + b.e_slope_spm * (test_speed_mps - b.e_speed_mps);
  const double e_at_23 = e + 0.003 * (23.0 - temperature_c);
  return 1.0 - (court_pace - 150.0 * (0.81 - e_at_23)) / 100.0;
}

double read_pace(TomlTable& surface, const char* key, double court_pace, const Scene& scene,
                 const BounceSettings& b) {
  const double mu = friction_of_pace(court_pace, b, scene.air.temperature_c);
  if (!(mu >= kFriction.least && mu <= kFriction.most)) {
    surface.error_at(key, fmt::format("needs a friction of {:.3g} with this restitution; must be {} to {}",
                                      mu, kFriction.least, kFriction.most));
  }
  return mu;
}

double read_friction(TomlTable& root, const Scene& scene, const BounceSettings& b) {
  TomlTable bounce = root.table("bounce");
  TomlTable surface = root.table("surface");
  std::string first = bounce.has("mu") ? "bounce.mu" : "";
  for (const char* key : {"friction", "court_pace", "pace_grade"}) {
    if (!surface.has(key)) continue;
    if (!first.empty()) surface.error_at(key, "excludes " + first + ": one of them says the friction");
    if (first.empty()) first = std::string("surface.") + key;
  }
  if (surface.has("friction")) return surface.number("friction", kFriction);
  if (surface.has("court_pace"))
    return read_pace(surface, "court_pace", surface.number("court_pace", {-100.0, 200.0}), scene, b);
  if (surface.has("pace_grade")) {
    const std::string grade =
        surface.choice_or("pace_grade", "medium", {"slow", "medium_slow", "medium", "medium_fast", "fast"});
    return read_pace(surface, "pace_grade", court_pace_of(grade), scene, b);
  }
  return scene.kind ? bounce.number_or("mu", scene.kind->contact.mu, kFriction)
                    : bounce.number("mu", kFriction);
}

}  // namespace

std::span<const std::string_view> keys_of(ContactLaw law) {
  static constexpr std::array<std::string_view, 5> ode{"stiffness_ratio", "stiffness_ratio_sd",
                                                       "damping_ratio", "offset_share", "offset_share_sd"};
  static constexpr std::array<std::string_view, 4> grip{"ex", "ex_sd", "offset_mm", "offset_sd_mm"};
  return law == ContactLaw::ode ? std::span<const std::string_view>(ode) : grip;
}

void read_ball(TomlTable& root, const std::filesystem::path& folder, Scene& scene) {
  TomlTable table = root.table("ball");
  ball::Ball& ball = scene.ball;
  if (table.has("kind")) {
    const std::string kind = table.string("kind");
    auto read = balls::load_ball_kind(kind.ends_with(".toml") ? (folder / kind).string() : kind);
    if (read) {
      ball = read->ball();
      scene.kind = *std::move(read);
      scene.kind_name = kind.ends_with(".toml")
                            ? std::filesystem::absolute(folder / kind).lexically_normal().string()
                            : kind;
    } else {
      table.error_at("kind", read.error().message);
    }
  }
  ball.diameter_m = table.number_or("diameter_m", ball.diameter_m, {0.01, 1.0});
  ball.mass_kg = table.number_or("mass_kg", ball.mass_kg, {0.001, 10.0});
  const Range alphas{0.01, ball::kThinShellAlpha};
  if (!table.has("inertia")) {
    ball.alpha = table.number_or("alpha", ball.alpha, alphas);
    return;
  }
  if (table.has("alpha")) table.error_at("alpha", "excludes ball.inertia");
  const std::string inertia = table.choice_or(
      "inertia", "measured", {"thin_shell", "rubber_shell_mean_radius", "thick_shell", "solid", "measured"});
  const double alpha = alpha_of(inertia, ball);
  if (alpha < alphas.least || alpha > alphas.most) {
    table.error_at("inertia", fmt::format("makes alpha {:.3g} of this diameter; must be {} to 2/3", alpha,
                                          alphas.least));
    return;
  }
  ball.alpha = alpha;
}

namespace {

constexpr Range kSpin_radps{-1000.0, 1000.0};
constexpr Range kSpinSd_radps{0.0, 200.0};

void read_drop(TomlTable& table, Scene& scene) {
  MachineSettings& m = scene.machine;
  for (const std::string_view key : {"speed_mps", "angle_deg", "lateral_deg", "lateral_sd_deg"})
    if (table.has(key)) table.error_at(key, "excludes machine.drop_height_m");
  m.drop_height_m = table.number("drop_height_m", {0.06, 20.0});
  const VerticalFlight fall = falling(scene, m.drop_height_m);
  m.speed_mps = fall.speed_mps;
  m.lag_s = fall.time_s;
  m.angle_rad = -90.0 * kDegree;
  m.spin_radps = table.number_or("spin_radps", 0.0, kSpin_radps);
}

}  // namespace

void read_machine(TomlTable& root, Scene& scene) {
  TomlTable table = root.table("machine");
  MachineSettings& m = scene.machine;
  if (table.has("drop_height_m")) {
    read_drop(table, scene);
  } else {
    m.speed_mps = table.number("speed_mps", {1.0, 60.0});
    m.angle_rad = table.number("angle_deg", {-90.0, -5.0}) * kDegree;
    m.spin_radps = table.number("spin_radps", kSpin_radps);
    m.lateral_rad = table.number_or("lateral_deg", 0.0, {-45.0, 45.0}) * kDegree;
    m.lateral_sd_rad = table.number_or("lateral_sd_deg", 0.0, {0.0, 10.0}) * kDegree;
  }
  m.speed_sd_mps = table.number_or("speed_sd_mps", 0.0, {0.0, 5.0});
  m.angle_sd_rad = table.number_or("angle_sd_deg", 0.0, {0.0, 10.0}) * kDegree;
  m.spin_sd_radps = table.number_or("spin_sd_radps", 0.0, kSpinSd_radps);
  m.sidespin_radps = table.number_or("sidespin_radps", 0.0, kSpin_radps);
  m.sidespin_sd_radps = table.number_or("sidespin_sd_radps", 0.0, kSpinSd_radps);
  m.gyrospin_radps = table.number_or("gyrospin_radps", 0.0, kSpin_radps);
  m.gyrospin_sd_radps = table.number_or("gyrospin_sd_radps", 0.0, kSpinSd_radps);
  m.lag_s = table.number_or("lag_ms", m.lag_s / kMilli, {1.0, 10000.0}) * kMilli;
  m.lag_sd_s = table.number_or("lag_sd_ms", m.lag_sd_s / kMilli, {0.0, 1000.0}) * kMilli;
  m.spot_sd_m = table.number_or("spot_sd_mm", m.spot_sd_m / kMilli, {0.0, 1000.0}) * kMilli;
}

void read_impact(TomlTable& root, Scene& scene) {
  TomlTable table = root.table("bounce");
  BounceSettings& b = scene.bounce;
  read_law(table, b);
  read_rebound(root, scene, b);
  b.mu = read_friction(root, scene, b);
  b.mu_sd = table.number_or("mu_sd", 0.0, {0.0, 0.5});
  b.top_drop_ratio = table.number_or("top_drop_ratio", b.top_drop_ratio, {0.5, 2.0});
}

void read_tilt(TomlTable& root, Scene& scene) {
  const Range tilts{-89.0, 89.0};
  TomlTable surface = root.table("surface");
  if (root.has("surface_angle_deg") && surface.has("tilt_deg"))
    surface.error_at("tilt_deg", "excludes surface_angle_deg: one of them says the inclination");
  const double fallback = surface.number_or("tilt_deg", 0.0, tilts);
  scene.surface_angle_rad = root.number_or("surface_angle_deg", fallback, tilts) * kDegree;
}

}  // namespace strobe::sim::tables
