// The rebound of one shot: the numbers, their uncertainty, and flags.
// Signs: x along the surface in the direction of travel, y up from it, spin counter-clockwise positive as the
// camera sees it (backspin positive). Touchdown (TD) and lift-off (LO): the centre is one radius above the
// surface. Plain values, thread-safe.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/ball/regime.hpp"
#include "common/flight/effects.hpp"
#include "common/reduction/flags.hpp"
#include "common/reduction/frame.hpp"

namespace strobe::reduction {

enum class Quantity {
  theta_in_deg,
  theta_out_deg,
  vx_td_mps,
  vy_td_mps,
  v_td_mps,
  omega_td_radps,
  vx_lo_mps,
  vy_lo_mps,
  v_lo_mps,
  omega_lo_radps,
  slip_lo_mps,
  e,
  mu,
  dwell_time_ms,
  dwell_distance_cm,
  court_pace,
};

/// Names as in the JSON object and on the screen, in the order of Quantity.
inline constexpr std::array<std::string_view, 16> kQuantityNames{
    "theta_in_deg", "theta_out_deg", "vx_td_mps",         "vy_td_mps",      "v_td_mps",    "omega_td_radps",
    "vx_lo_mps",    "vy_lo_mps",     "v_lo_mps",          "omega_lo_radps", "slip_lo_mps", "e",
    "mu",           "dwell_time_ms", "dwell_distance_cm", "court_pace"};
inline constexpr std::size_t kQuantityCount = kQuantityNames.size();

constexpr std::string_view name(Quantity q) { return kQuantityNames[static_cast<std::size_t>(q)]; }

/// One number for each quantity; absent if it could not be computed.
class Quantities {
 public:
  std::optional<double>& operator[](Quantity q) { return values_[static_cast<std::size_t>(q)]; }
  const std::optional<double>& operator[](Quantity q) const { return values_[static_cast<std::size_t>(q)]; }
  bool operator==(const Quantities&) const = default;

 private:
  std::array<std::optional<double>, kQuantityCount> values_{};
};

/// a - b; 0 where one is absent.
inline double difference(const std::optional<double>& a, const std::optional<double>& b) {
  return a && b ? *a - *b : 0.0;
}

/// One contact image as the thesis's program reports it. Fractions: of the dwell time, of the distance along
/// the surface, of the rotation; y: drop of the top of the ball over the diameter, negative in contact.
struct ContactImage {
  double height_cm = 0.0;  ///< centre above the surface
  double time_fraction = 0.0;
  double x_fraction = 0.0;
  double y_fraction = 0.0;
  double rotation_fraction = 0.0;
};

/// What only the legacy estimator gives: the numbers from the first two and last two images, and contact.
struct LegacyDetail {
  Quantities far;
  std::vector<ContactImage> contact;
};

/// Covariance of the numbers that the others follow from, in this order: vx_td_mps, vy_td_mps,
/// omega_td_radps, touchdown [s], then the same four at lift-off. Statistical, given the ball's diameter;
/// where the noise was estimated it is that of the estimated variances, without Student's factor.
inline constexpr std::size_t kPrimaryCount = 8;
using PrimaryCovariance = std::array<std::array<double, kPrimaryCount>, kPrimaryCount>;

/// Which flashes of the train, numbered as fired from 0, made the first and the last image of the ball.
struct ImagedFlashes {
  int first = 0;
  int last = 0;
  /// Probability that it was other flashes, 0 to 1: close to 1 in an even train, where one flash is like the
  /// next and no number depends on which it was; a coded train's intervals tell.
  double misassignment_probability = 0.0;
  bool coded = false;  ///< the train has a code

  bool operator==(const ImagedFlashes&) const = default;
};

/// What it adds to the numbers' uncertainty that several assignments of flashes to images are plausible.
/// See mixture.hpp.
struct Assignments {
  int hypotheses = 1;
  Quantities sd;  ///< between the hypotheses; contained in Readout::sd

  bool operator==(const Assignments&) const = default;
};

/// Of each number, by the time of one image: its unit per second. Index: Quantity; 0 where the number is
/// absent.
using TimeDerivatives = std::array<double, kQuantityCount>;

enum class MeasurementKind { centre, equator, diameter, surface };
inline constexpr std::array<std::string_view, 4> kMeasurementKindNames{"centre", "equator", "diameter",
                                                                       "surface"};
inline constexpr std::size_t kMeasurementKindCount = kMeasurementKindNames.size();

/// Residuals over the noise that the frame states: root of chi squared over its degrees of freedom, about 1.
/// Absent where no noise is stated or nothing is left to residuals. Of few degrees of freedom nu it scatters
/// by 1 / sqrt(2 nu).
struct ResidualRatios {
  std::optional<double> all;
  std::array<std::optional<double>, kMeasurementKindCount> by_kind;  ///< index: MeasurementKind
};

/// What was stated or assumed of a photograph, and may be the one thing that was wrong.
enum class Cause {
  air,            ///< drag and lift
  scale,          ///< calibrated
  ball_diameter,  //
  inclination,    ///< of surface or camera, against the vertical
  flash_period,   ///< the clock's rate
};
inline constexpr std::array<std::string_view, 5> kCauseNames{"air", "scale", "ball_diameter", "inclination",
                                                             "flash_period"};
inline constexpr std::size_t kCauseCount = kCauseNames.size();
constexpr std::string_view name(Cause cause) { return kCauseNames[static_cast<std::size_t>(cause)]; }

/// Why measurements contradict each other. `value` would explain it: of the air the factor to drag and lift
/// as assumed, of the inclination degrees more than stated, of the others percent.
struct LikelyCause {
  Cause cause = Cause::air;
  double value = 0.0;
  double sd = 0.0;
};

/// What tells the spins from all others that explain the equators as well.
enum class SpinEvidence {
  train,         ///< there are none: the intervals between the images differ, or are short
  friction,      ///< those others contradict friction, or add energy, in the bounce
  lift,          ///< the air would have bent the paths otherwise
  assumed_limit  ///< they are faster than kFastestRim_mps, which nobody stated
};
inline constexpr std::array<std::string_view, 4> kSpinEvidenceNames{"train", "friction", "lift",
                                                                    "assumed_limit"};
using SpinEvidenceSet = EnumSet<SpinEvidence, kSpinEvidenceNames.size()>;

struct Numbers {
  Quantities value;
  Quantities sd;             ///< statistical standard deviation, given the ball's diameter
  Quantities sd_systematic;  ///< sd from the tolerances of the ball, of all diameters and of the air
  /// Of sd, where noise was estimated: effective ones (Welch-Satterthwaite). Absent: infinitely many.
  Quantities degrees_of_freedom;
};

/// Velocity and spin at the first image in use, of a photograph of one flight without a surface. x as the
/// photograph's in the direction of travel, y up. The numbers stand where those at touchdown would.
struct Launch : Numbers {
  double time_s = 0.0;  ///< of that image, as in the frame
};

/// Velocity along the surface over that across it, at most, of a ball that is dropped.
inline constexpr double kDropSlope = 0.1;

/// Names of a launch's numbers, and where they stand.
struct LaunchQuantity {
  std::string_view name;
  Quantity quantity;
};
inline constexpr std::array<LaunchQuantity, 5> kLaunchQuantities{{{"speed_mps", Quantity::v_td_mps},
                                                                  {"angle_deg", Quantity::theta_in_deg},
                                                                  {"vx_mps", Quantity::vx_td_mps},
                                                                  {"vy_mps", Quantity::vy_td_mps},
                                                                  {"omega_radps", Quantity::omega_td_radps}}};

/// A number that follows from the readout's, with its standard deviations as in Numbers.
struct DerivedNumber {
  double value = 0.0;
  double sd = 0.0;
  double sd_systematic = 0.0;
};

/// Of a ball that fell straight down on a level surface, in the air as fitted: heights of its lowest point
/// above the surface (common/flight/vertical.hpp).
struct Drop {
  DerivedNumber fall_height_m;     ///< from which a fall from rest ends with vy at touchdown
  DerivedNumber rebound_height_m;  ///< to which a ball rises that leaves with vy at lift-off
};

/// What a planar motion does not have. Axes of the surface, as for the other numbers: x along it in the
/// direction of travel, y up from it, z towards the camera; spins are right-handed, so that omega_z is the
/// spin of the other numbers. _td at touchdown, _lo at lift-off.
enum class SpatialQuantity {
  omega_x_td_radps,
  omega_y_td_radps,
  omega_z_td_radps,
  spin_axis_tilt_td_deg,  ///< of the spin's axis against the camera's, 0 to 90
  vz_td_mps,
  omega_x_lo_radps,
  omega_y_lo_radps,
  omega_z_lo_radps,
  spin_axis_tilt_lo_deg,
  vz_lo_mps,
  off_plane_mm  ///< of the centre from the calibrated plane at touchdown, towards the camera
};
inline constexpr std::array<std::string_view, 11> kSpatialNames{
    "omega_x_td_radps", "omega_y_td_radps", "omega_z_td_radps", "spin_axis_tilt_td_deg", "vz_td_mps",
    "omega_x_lo_radps", "omega_y_lo_radps", "omega_z_lo_radps", "spin_axis_tilt_lo_deg", "vz_lo_mps",
    "off_plane_mm"};
inline constexpr std::size_t kSpatialCount = kSpatialNames.size();
constexpr std::string_view name(SpatialQuantity q) { return kSpatialNames[static_cast<std::size_t>(q)]; }

/// Of a photograph whose lines' tilts or whose diameters tell it.
struct Spatial {
  std::array<std::optional<DerivedNumber>, kSpatialCount> number;  ///< absent: not told

  std::optional<DerivedNumber>& operator[](SpatialQuantity q) { return number[static_cast<std::size_t>(q)]; }
  const std::optional<DerivedNumber>& operator[](SpatialQuantity q) const {
    return number[static_cast<std::size_t>(q)];
  }
};

struct Readout : Numbers {
  int shot_id = 0;
  std::optional<Spatial> spatial;  ///< absent where nothing of it is told
  std::optional<Drop> drop;        ///< absent unless both velocities are within kDropSlope of the vertical
  std::optional<Launch> launch;    ///< only of a frame without a surface, which has no other numbers
  std::optional<Regime> regime;
  bool court_pace_conforming = false;
  std::string method;  ///< "best", "two-point", "legacy"
  /// The ball travelled to the left, by more than a twentieth of its way across the surface (3 degrees); x
  /// points to the left. Otherwise x points to the right, and vx is negative where it yet went left.
  bool mirrored = false;
  FlagSet flags;
  ResidualRatios residual_ratios;           ///< only with method "best"
  SpinEvidenceSet spin_told_by;             ///< none: no spin is known, or it may be another
  std::optional<LikelyCause> likely_cause;  ///< of flags that say that measurements disagree
  Record record;
  std::optional<ImagedFlashes> flashes;    ///< only of a photograph that a host matched with its shot
  std::optional<Assignments> assignments;  ///< likewise; absent where no steady flight fits the flashes
  flight::Effects flight_effects = flight::kNoEffects;  ///< what the paths were fitted with
  std::optional<PrimaryCovariance> covariance;          ///< only if asked for
  std::vector<TimeDerivatives> by_time;                 ///< of each image; empty unless asked for
  std::optional<LegacyDetail> legacy;                   ///< only with method "legacy"
};

}  // namespace strobe::reduction
