// What the simulated rig is and does, its chip's lines included. Values only.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/ball/ball.hpp"
#include "common/data/ball_kind.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/reduction/readout.hpp"
#include "common/units/time.hpp"
#include "sim/scene/faults.hpp"
#include "sim/scene/photograph_settings.hpp"

namespace strobe::sim {

/// Offsets of the wired lines. All are active high but ESTOP, which is low while pressed or disconnected.
enum class RigLine : std::uint32_t {
  strobe_a,
  strobe_b,
  shutter,
  trigger,
  sensor_a,
  sensor_b,
  gate,
  key,
  estop,
  xsync,
};

inline constexpr std::array<std::string_view, 16> kLineNames{
    "STROBE_A", "STROBE_B", "SHUTTER",  "TRIGGER",  "SENSOR_A", "SENSOR_B", "GATE",     "KEY",
    "ESTOP",    "XSYNC",    "SPARE_10", "SPARE_11", "SPARE_12", "SPARE_13", "SPARE_14", "SPARE_15"};
inline constexpr std::size_t kWiredLines = 10;

constexpr std::string_view name(RigLine line) { return kLineNames[static_cast<std::size_t>(line)]; }

constexpr std::optional<RigLine> rig_line(std::uint32_t offset) {
  if (offset >= kWiredLines) return std::nullopt;
  return static_cast<RigLine>(offset);
}

constexpr std::optional<RigLine> rig_line(std::string_view line_name) {
  for (std::size_t i = 0; i < kWiredLines; ++i) {
    if (kLineNames[i] == line_name) return static_cast<RigLine>(i);
  }
  return std::nullopt;
}

// A scene: everything that the simulated rig is and does, as sim/loading reads it from a TOML file. Each
// field below is a key of the table of its struct's name; a key's unit is in its name (…_ms, _us, _mm, _deg),
// fields here are SI. Keys that a file leaves out take the defaults given here; an unknown key is an error.
// Plain values.

/// [machine] The pitching machine. What the ball does is what it does at touchdown.
struct MachineSettings {
  /// Instead of speed_mps, angle_deg and spin_radps: dropped from there, of its lowest point over the
  /// surface, 0.05…20. The machine then lets it go, and lag_ms is as long as the fall unless it is said. 0
  /// (key absent): thrown.
  double drop_height_m = 0.0;
  double speed_mps = 17.0;  ///< required; 1…60
  double speed_sd_mps = 0.0;
  double angle_rad = -0.4;  ///< required; angle_deg -90…-5, against the surface
  double angle_sd_rad = 0.0;
  double spin_radps = 0.0;  ///< required; backspin positive
  double spin_sd_radps = 0.0;
  /// Out of the plane that the others are in, all 0 unless they are said: the direction of travel,
  /// lateral_deg -45…45, towards the camera; the spin about y, the surface's normal, and about x, the
  /// direction of travel.
  double lateral_rad = 0.0, lateral_sd_rad = 0.0;
  double sidespin_radps = 0.0, sidespin_sd_radps = 0.0;
  double gyrospin_radps = 0.0, gyrospin_sd_radps = 0.0;
  /// Whether every ball stays in that plane and spins across it.
  bool planar() const {
    return lateral_rad == 0.0 && lateral_sd_rad == 0.0 && sidespin_radps == 0.0 && sidespin_sd_radps == 0.0 &&
           gyrospin_radps == 0.0 && gyrospin_sd_radps == 0.0;
  }
  double lag_s = 0.310;  ///< from the trigger to touchdown
  double lag_sd_s = 0.003;
  double spot_sd_m = 0.010;  ///< key spot_sd_mm: where along the surface the ball touches down
};

/// Model of the contact between ball and surface.
enum class ContactLaw {
  ode,   ///< common/impact/ode: spring, dashpot, Coulomb friction, tangential spring, offset; the default
  grip,  ///< common/impact's grip() between touchdown and lift-off, and the exact damped sine in between
};

/// [bounce] Restitution and friction, with their spread from shot to shot. One draw moves mu and what goes
/// with it (ode: stiffness_ratio, grip: e_x) together: a shot with more grip. A key of the other law is an
/// error. Alternative keys, one at a time:
///  - for e: rebound_height_m, to which the ball rises in the scene's air, of its lowest point over a level
///  surface;
///  - for e and dwell_ms: [ball] stiffness_npm and damping_nspm (common/impact/ode/normal_spring.hpp); a
///    spring's e does not change with the speed, so that e_slope_s_per_m then defaults to 0;
///  - for mu: [surface] friction, court_pace (the ITF's rating: mu from it and e at 30 m/s, 16 degrees), or
///    pace_grade = "slow" | "medium_slow" | "medium" | "medium_fast" | "fast" (27, 32, 37, 42, 47).
struct BounceSettings {
  ContactLaw contact = ContactLaw::ode;  ///< key contact = "ode" | "grip"
  double e = 0.75;                       ///< required; at e_speed_mps
  double e_speed_mps = 0.0;              ///< |vy| at which e holds; default: the machine's mean
  double e_slope_spm = -0.017;           ///< de/d|vy|; key e_slope_s_per_m
  double e_sd = 0.0;
  double mu = 0.57;  ///< required
  double mu_sd = 0.0;
  double dwell_s = 0.005;  ///< required, key dwell_ms; touchdown to lift-off
  double dwell_sd_s = 0.0;
  // contact = "ode"
  double stiffness_ratio = impact::ContactCoefficients{}.stiffness_ratio;  ///< tangential over normal
  double stiffness_ratio_sd = 0.0;                                     ///< moved by the draw that moves mu
  double damping_ratio = impact::ContactCoefficients{}.damping_ratio;  ///< c_t/sqrt(k_t·m)
  double offset_share = impact::ContactCoefficients{}.offset_share;    ///< of the footprint's radius
  double offset_share_sd = 0.0;
  // contact = "grip"
  double ex = 0.087;  ///< required; -1…1
  double ex_sd = 0.0;
  double offset_m = 0.003;  ///< required, key offset_mm; of the normal force at full rolling speed
  double offset_sd_m = 0.0;
  // either
  /// -1…1, between one shot's offset (or its share) and its draw of mu.
  double offset_grip_correlation = 0.0;
  int count = 1;                 ///< 1…20, bounces on the photograph; readouts and frames are of the first
  double top_drop_ratio = 1.27;  ///< drop of the ball's top over that of its centre (measured at 23 degrees)
};

/// [air] Drag and lift in flight.
struct AirSettings {
  double temperature_c = 21.0;     ///< -50…80; of the air's density and the court pace's correction
  double density_kgpm3 = -1.0;     ///< < 0 (key absent): dry air of that temperature at 101.325 kPa
  double drag_coefficient = 0.55;  ///< of the area pi·R²; 0: no drag
  bool lift = true;                ///< key lift_law = "spin_ratio" (sim/motion/flight.hpp) | "none"
  double lift_factor = 1.0;        ///< 0…3, of the lift over that law's: balls differ
  /// Of that law; a tennis ball's, or those of [ball] kind.
  double lift_offset = 1.0, lift_slope = 2.0;
  /// domega/dt = -spin_decay_per_m·|v|·omega; .05 % in 3 ms at 17 m/s. Key absent: in proportion to
  /// density_kgpm3, and .01 where that is absent too.
  double spin_decay_per_m = 0.01;
};

/// [lamps] Both alike.
struct LampSettings {
  double delay_s = 12e-6;  ///< rising edge of the line to flash
  double jitter_s = 1e-6;
  double recharge_s = 1.4e-3;  ///< a pulse sooner after a flash gives no flash
  double flash_s = 1e-6;       ///< key flash_us: duration; the image is the mean over it
};

/// [sensors] Both alike.
struct SensorSettings {
  double delay_s = 0.0;  ///< flash to edge
  double jitter_s = 0.2e-6;
  double pulse_s = 100e-6;
  /// Key crosstalk = "none" | "a" | "b" | "both": which of them sees the other lamp's flashes as well.
  bool a_sees_b = false, b_sees_a = false;
};

/// [shutter]
struct ShutterSettings {
  double open_lag_s = 0.045;   ///< line active to open
  double close_lag_s = 0.045;  ///< line inactive to closed
  double lag_sd_s = 0.1e-3;
  /// Key longest_open_ms 1…60,000; 0 (key absent): the line alone closes it. A camera that is not set to
  /// bulb.
  double longest_open_s = 0.0;
};

/// [hand] A ball that a person drops onto the plate, in every exposure for which the machine throws none.
/// Only an exposure that lasts until touchdown_s shows it.
struct HandSettings {
  double drop_height_m =
      0.0;  ///< 0.01…10, of its lowest point over the plate; 0 (key absent): nobody drops one
  double touchdown_s = 1.0;  ///< 0…60, after the shutter has opened
  double spot_sd_m = 0.01;   ///< key spot_sd_mm 0…500
};

/// [gate]
struct GateSettings {
  double distance_m = 1.0;  ///< from the light beam to the point of touchdown, along the surface
};

/// [camera] A side view. The photograph's x is to the right, y up. Without distance_m a true (orthographic)
/// one.
struct CameraSettings {
  double px_per_m = 4000.0;  ///< in the plane that the ball is to fly in
  double roll_rad = 0.3 * std::numbers::pi / 180.0;
  double origin_x_px = 1500.0;  ///< where the point of touchdown is on the photograph
  double origin_y_px = 300.0;
  double half_width_m = 0.30;   ///< centres within ±half_width_m of the point of touchdown are seen ...
  double height_m = 0.35;       ///< ... up to this height over the surface
  bool mirrored = false;        ///< seen from the other side: the ball travels to the left
  double distance_m = 0.0;      ///< lens to that plane; 0 (key absent): infinitely far
  double off_plane_sd_m = 0.0;  ///< key off_plane_sd_mm: how far from that plane balls fly, towards the lens
  /// The camera turned about the middle of its view, to its right (swing_deg) and then up (tilt_deg), -30…30:
  /// lengths in the plane then have another scale at either end of the photograph. They need a distance_m,
  /// without distortion.
  double swing_rad = 0.0;
  double tilt_rad = 0.0;
  double distortion = 0.0;  ///< radial: displaced by distortion·(r/half diagonal of the view)²·r, outwards
  bool turned() const { return swing_rad != 0.0 || tilt_rad != 0.0; }
  bool pixels = false;  ///< key rendering = "pixels" | "points": images are rendered and measured there
};

enum class CameraPixels { mono8, mono12, mono16, bayer_rg12 };

/// [camera_link] The camera as a device on a network (sim/gev), and what is wrong with it.
struct CameraLinkSettings {
  CameraPixels pixels =
      CameraPixels::mono8;         ///< key pixel_format, as it is switched on: "Mono8" | "Mono12" ...
  double rate_bps = 1e10;          ///< key rate_mbps 10…100,000: of the link; a fast camera's is 10 GigE
  double readout_s = 0.005;        ///< key readout_ms 0…1000: from the exposure's end to the first packet
  double exposure_step_s = 10e-6;  ///< key exposure_step_us 0.1…100,000: exposure times are rounded to it
  double loss = 0.0;               ///< 0…1, share of packets that are lost
  double resend_loss = 0.0;        ///< 0…1, likewise of those that are sent again
  double drop = 0.0;               ///< 0…1, share of frames of which nothing is sent
  double clock_offset_s = 0.0;     ///< 0…1e6, what the camera's clock shows when it is switched on
  double clock_drift_ppm = 0.0;    ///< -1000…1000, how much faster than the rig's it runs
  /// Key hostile = "none" | "xml" (a description that explodes) | "sizes" (frames larger than they are told
  /// to be) | "payload" (told to be of 4 GB) | "endless" (frames without an end).
  enum class Hostile { none, xml, sizes, payload, endless } hostile = Hostile::none;
};

/// [tablet] Hand measurement of the photograph. Standard deviations of one coordinate on the object's scale.
struct TabletSettings {
  double centre_sd_m = 0.0003;
  double equator_sd_rad = 0.5 * std::numbers::pi / 180.0;
  double digitize_delay_s = 0.1;        ///< shot announced to frame published
  double visible_flattening_m = 0.001;  ///< a drop of the ball's top from which an image is called "contact"
  /// Key equator_tilt_sd_deg 0.001…45; 0 (key absent): the lines' tilts are not measured.
  double equator_tilt_sd_rad = 0.0;
  /// Relative sd of a scale handed over with the frame; < 0: none (key absent).
  double calibration_sd = -1.0;
};

/// [readout] Which numbers of the readout matter, and to what tolerance.
struct ReadoutSettings {
  double tolerance = 0.0;  ///< key tolerance_percent; relative, see sim/effects; 0 (key absent): none stated
  /// Absolute ones by a quantity's name, in its unit; < 0: not wanted (key = "any"), absent: the relative
  /// one.
  std::vector<std::pair<reduction::Quantity, double>> absolute;
};

/// [chip]
struct ChipSettings {
  std::string name = "gpiochip0";
  std::string label = "strobe-sim-rig";
  bool keep_on_release = true;  ///< key on_release = "keep" | "input"
  int key_level = 1;            ///< 1: on
  int estop_level = 1;          ///< 1: not pressed
  /// Key bias = "set" | "ignored" | "refused": what becomes of a request for a resistor of the chip.
  enum class Bias { set, ignored, refused } bias = Bias::set;
  /// Key reset_pull = "none" | "up" | "down": of every line, before a bias was asked for.
  enum class Pull { none, up, down } reset_pull = Pull::none;
};

/// [[operator]] An action of the operator: key turned, e-stop pressed, gate interrupted.
struct OperatorAction {
  double at_s = 0.0;  ///< after the rig's start
  RigLine line = RigLine::key;
  int level = 0;
};

struct Scene {
  std::string name;    ///< the file's, without its extension
  std::string title;   ///< one line of text
  std::string parent;  ///< key inherits: the scene it inherits from; empty: none
  /// Inclination of the plate, counter-clockwise positive: key surface_angle_deg or [surface] tilt_deg.
  double surface_angle_rad = 0.0;
  /// [ball] diameter_m, mass_kg, and alpha or inertia = "thin_shell" | "rubber_shell_mean_radius" |
  /// "thick_shell" | "solid" | "measured" (common/ball).
  ball::Ball ball;
  /// [ball] kind: what the keys of [ball], of [air] and of [bounce] (e, dwell_ms, mu) that are absent take.
  std::optional<balls::Kind> kind;
  std::string kind_name;  ///< as a rig file names it, wherever that is
  MachineSettings machine;
  BounceSettings bounce;
  AirSettings air;
  LampSettings lamps;
  SensorSettings sensors;
  ShutterSettings shutter;
  GateSettings gate;
  HandSettings hand;
  CameraSettings camera;
  CameraLinkSettings camera_link;
  TabletSettings tablet;
  PhotographSettings photograph;  ///< sim/scene/photograph_settings.hpp, as the next two
  BallAppearanceSettings ball_appearance;
  BackgroundSettings background;
  ReadoutSettings readout;
  ChipSettings chip;
  std::vector<OperatorAction> operator_actions;
  std::vector<Fault> faults;
};

/// What the lab knows of its machine's spins: no rim is faster than those in play, 20.5 m/s; nothing where it
/// is set for more.
inline std::optional<double> known_fastest_spin_radps(const Scene& scene) {
  const double fastest = 20.5 / scene.ball.radius_m();
  const MachineSettings& m = scene.machine;
  const double mean = std::hypot(m.spin_radps, m.sidespin_radps, m.gyrospin_radps);
  const double sd = std::hypot(m.spin_sd_radps, m.sidespin_sd_radps, m.gyrospin_sd_radps);
  const bool less = mean + 6.0 * sd < fastest;
  return less ? std::optional(fastest) : std::nullopt;
}

}  // namespace strobe::sim
