// Motion of one ball between touchdown and lift-off (both: its centre one radius above the surface), by the
// scene's contact law and with the effects of a model. Axes as in ball_path.hpp.
//
// A scene's e and dwell time are those of the contact without the ball's weight. A scene whose law is `ode`:
//
//   grip  tangential_compliance  contact_ode
//   on    on                     on           the ODE of common/impact/ode, lift-off and motion (full model)
//   on    on                     off          the ODE's lift-off; in between the damped sine that meets it
//   on    off                    (nothing)    one number e_x for the grip: s_LO = -e_x·s_TD unless that needs
//                                             more friction than mu allows; the damped sine in between
//   off   (nothing)              (nothing)    friction at its limit throughout; the damped sine in between
//
// Each further effect needs the ones before it, so that those marked (nothing) are without one.
//   offset           off: the normal force stands under the centre
//   contact_gravity  off: no weight in contact. On: both parts of it, that towards the surface and that along
//   an
//                    inclined plate, which changes vx by up to g·dwell·sin(angle): .01 m/s at 12 degrees.
//
// The ODE's ball is released where its normal force is zero, the spring still compressed by
// y = 2·zeta·v/w (v: release speed, w = sqrt(k/m)), and then moves freely until its centre is at R: without
// weight 2·zeta/w later. The ODE's own dwell time (touchdown to release, (phase of release)/w) is therefore
// the scene's over 1 + 2·zeta/phase: touchdown to lift-off takes exactly the scene's dwell time without
// weight, and a few tenths of a percent more with it (2·g·dwell/(pi²·|vy|), .15 % at 6.7 m/s).
//
// Without the ODE, its numbers are calibrated (ReducedContact): from one run of the ODE at the scene's mean
// e_x, the offset, and the factors by which e, dwell time, the normal force's impulse and the ways gone in
// contact differ from those of the weightless sine; at the mean ball the reduced model is then the ODE, and
// differs from it as balls differ.
//
// A scene whose law is `grip`: common/impact's grip() and the damped sine; only grip and offset can be left
// out of it. (The sine's net force has the weight towards the surface in it, and nothing of the ODE is there
// to leave out; sim/effects/unmodelled.hpp bounds the weight's part along an inclined plate.)
//
// Out of the plane (spatial_course.hpp) there are the mechanics with all three of grip, tangential_compliance
// and contact_ode, or with the law `grip` that and the damped sine.
//
// Plain values, thread-safe. Only the ODE's path allocates, and that out of the plane.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>

#include "common/impact/closed_form/rebound.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "common/result.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// A rotation of the ball in the axes of the surface.
using Turn = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Conditions of one shot: the scene's means with this shot's random deviations.
struct ShotConditions {
  impact::Motion touchdown;
  double vz_mps = 0.0;  ///< at touchdown, out of the plane; with the next two all 0 for a planar shot
  double omega_x_radps = 0.0, omega_y_radps = 0.0;
  impact::Coefficients coefficients;  ///< e and mu; with contact = "grip" also e_x and the offset
  double stiffness_ratio = 1.0;       ///< with contact = "ode", as the next
  double offset_share = 0.0;
  double dwell_s = 0.0;      ///< touchdown to lift-off, the ball's weight left out
  double equator_rad = 0.0;  ///< angle of the equator line at touchdown
  double lag_s = 0.0;        ///< trigger to touchdown
  double spot_m = 0.0;       ///< point of touchdown, along the surface from where the camera has its origin
  double off_plane_m = 0.0;  ///< of the ball's path from the plane the camera is focused on, towards the lens

  bool planar() const { return vz_mps == 0.0 && omega_x_radps == 0.0 && omega_y_radps == 0.0; }
};

/// Normal draws are within kLargestNormal standard deviations of their means.
ShotConditions draw_shot_conditions(const Scene& scene, std::uint64_t seed, int shot);

/// Of the same ball where it comes down once more: it is as elastic as its speed there makes it.
ShotConditions conditions_of_next_bounce(const Scene& scene, const ShotConditions& before,
                                         const impact::Motion& touchdown);

/// The scene without any spread of machine, bounce and plane: every shot is the mean one, but for the
/// equator's angle.
Scene without_spread(Scene scene);

/// A ball at its lift-off, and its displacement since touchdown.
struct LiftOff {
  impact::Rebound rebound;
  double dwell_s = 0.0;         ///< since touchdown
  double displacement_m = 0.0;  ///< along the surface
  double rotation_rad = 0.0;    ///< counter-clockwise
  double impulse_factor = 1.0;  ///< the normal force's impulse over m·(vy_LO - vy_TD): more, by the weight's
  // Of a contact that is not planar, whose rotation_rad stays 0:
  double aside_m = 0.0;  ///< displacement towards the camera
  double vz_mps = 0.0;
  double omega_x_radps = 0.0, omega_y_radps = 0.0;
  Turn turned = Turn::Identity();  ///< since touchdown
};

class SpatialCourse;

/// Constants of the contact without the ODE.
struct ReducedContact {
  double ex = 0.0;
  double offset_m = 0.0;            ///< impulse-weighted, along +x, of a ball with the mean offset_share
  double e_factor = 1.0;            ///< restitution over the coefficient e
  double impulse_factor = 1.0;      ///< as in LiftOff
  double dwell_factor = 1.0;        ///< touchdown to lift-off, over the scene's
  double displacement_shift = 0.0;  ///< way beyond the sine's, over (1 + e)·|vy|·dwell
  double rotation_shift = 0.0;      ///< likewise R times the angle
};

/// From the scene's mean ball. Fails if the mean ball does not leave the surface.
Result<ReducedContact> calibrate(const Scene& scene, const Model& model);

/// Whether a shot of the scene in this model needs constants from calibrate().
bool needs_calibration(const Scene& scene, const Model& model);

/// Lift-off by the ODE, offset and weight as the model has them. Fails if the weight holds the ball.
Result<LiftOff> ode_lift_off(const Scene& scene, const ShotConditions& thrown, const Model& model,
                             impact::ContactMethod method = impact::ContactMethod::collocation);

/// What the contact's mechanics are computed with.
struct MechanicsInput {
  impact::ContactCoefficients coefficients;
  double still_compressed_s = 0.0;  ///< depth at release over the release speed
};
Result<MechanicsInput> mechanics_input(const Scene& scene, const ShotConditions& thrown, const Model& model);

/// From the release, `depth_m` below, moving freely, to the centre at R. Fails if the weight holds the ball.
Result<LiftOff> risen(const Scene& scene, const impact::Motion& touchdown,
                      const impact::ContactLiftOff& release, double depth_m,
                      const impact::ContactCoefficients& coefficients);

/// Why a shot out of the plane cannot be simulated by the model; nullopt: it can.
std::optional<std::string> refusal_in_space(const Scene& scene, const Model& model);

/// A damped sine that ends with a given lift-off: the net force is the sine's; displacement and rotation get
/// a smooth correction so that they end with the given values.
class SinePath {
 public:
  static Result<SinePath> make(const Scene& scene, const impact::Motion& touchdown, const LiftOff& end);

  /// End of the uncorrected sine with that rebound and dwell time: its displacement and rotation.
  LiftOff plain_end() const;

 private:
  friend class ContactPath;
  SinePath(const impact::Motion& touchdown, const LiftOff& end, const impact::SinePulse& pulse)
      : touchdown_(touchdown), end_(end), pulse_(pulse) {}

  struct Plain {
    impact::PulseState pulse;
    double free_s = 0.0;
    double displacement_m = 0.0;
    double rotation_rad = 0.0;
  };
  Plain plain_at(double time_s) const;

  impact::Motion touchdown_;
  LiftOff end_;
  impact::SinePulse pulse_;
  double displacement_correction_m_ = 0.0;
  double rotation_correction_rad_ = 0.0;
};

class ContactPath {
 public:
  struct State {
    double displacement_m = 0.0;
    double drop_m = 0.0;  ///< of the centre below its height at touchdown, >= 0
    double vx_mps = 0.0;
    double vy_mps = 0.0;
    double omega_radps = 0.0;
    double rotation_rad = 0.0;
    double aside_m = 0.0;  ///< this and the rest as in LiftOff
    double vz_mps = 0.0;
    double omega_x_radps = 0.0, omega_y_radps = 0.0;
    Turn turned = Turn::Identity();
  };

  /// `reduced`: of calibrate(), where the model needs it; nullptr: calibrated here.
  static Result<ContactPath> make(const Scene& scene, const ShotConditions& thrown, const Model& model,
                                  const ReducedContact* reduced);

  /// From touchdown (0) to lift-off.
  State at(double time_s) const;
  const LiftOff& lift_off() const { return end_; }

 private:
  friend class SpatialCourse;
  struct Release {
    double time_s = 0.0;
    double vy_mps = 0.0;
    double depth_m = 0.0;
    double gravity_mps2 = 0.0;
    double along_mps2 = 0.0;
  };

  ContactPath() = default;
  static Result<ContactPath> by_ode(const Scene& scene, const ShotConditions& thrown, const Model& model);
  static Result<ContactPath> by_sine(const Scene& scene, const ShotConditions& thrown, const LiftOff& end);
  static Result<ContactPath> in_space(const Scene& scene, const ShotConditions& thrown, const Model& model);
  State ode_at(double time_s) const;
  State sine_at(double time_s) const;

  LiftOff end_;
  std::optional<impact::ContactCourse> ode_;
  Release release_;  ///< of the ODE
  std::optional<SinePath> sine_;
  std::shared_ptr<const SpatialCourse> spatial_;
};

}  // namespace strobe::sim
