// The contact's mechanics in three dimensions: contact_ode.hpp's laws with vectors along the surface, in
// spatial_rebound.hpp's axes. With v = (vx, vz), w = R·(omega_z, -omega_x), s = v + w and the stretch u of
// the tangential spring,
//   F = k_t·u + c_t·du/dt,  |F| <= mu·N,                m·dv/dt = -F + m·(g_x, 0),
//   alpha·m·dw/dt = -F + (N/R)·d,                       d = -delta·a(y)·w/sqrt(|w|² + w0²),
//   grips: du/dt = s;   slips: |F| = mu·N and s - du/dt along F.
// The last two say that a slip's F is along the force k_t·u + c_t·s that would hold the contact point
// (without a dashpot along u, which turns towards s). omega_y stays as it was.
//
// The normal motion is the plane's. Where slip and spin w are parallel and the weight is along them or
// across the surface the tangential one is too, in axes turned to them, and spatial_lift_off() computes it
// there. Otherwise, and for the course and the attitude always, all equations are integrated: by
// Boost.odeint's Dormand-Prince 5(4) with adaptive steps along x, t = T·x²(3 - 2x), in which the footprint's
// radius is smooth; a change between grip and slip is located to rounding and begins a new step. Energy never
// grows: as in the plane each loss is >= 0.
//
// at() takes one step of the method from the stored one before it. make() allocates; a contact is thread-safe
// for reading.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "common/impact/ode/contact_system.hpp"
#include "common/impact/spatial/spatial_rebound.hpp"

namespace strobe::impact {

/// At a time after touchdown.
struct SpatialState {
  double time_s = 0.0;
  SpatialMotion motion;
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero();  ///< of the centre since touchdown; y <= 0
  /// Since touchdown: turns directions fixed to the ball, as they were then, to where they are now.
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

struct SpatialLiftOff : SpatialState {  ///< time_s: the dwell time
  /// grips: the contact point stuck, or its slip along that of touchdown came to 0, before release.
  Regime regime = Regime::slides;
  /// The first grip after slipping; 0 where the ball grips from touchdown on; nullopt where it never sticks.
  std::optional<double> skid_to_grip_s;
  ContactEnergy energy;
};

namespace detail {

/// In contact_system.hpp's units, tangential motion as changes since touchdown.
enum SpatialComponent : std::size_t {
  kSpatialDepth,
  kSpatialDepthRate,
  kSpatialVelocity,                       ///< of v
  kSpatialSpin = kSpatialVelocity + 2,    ///< of w = R·omega
  kSpatialStretch = kSpatialSpin + 2,     ///< u
  kSpatialPath = kSpatialStretch + 2,     ///< integral of the change of v
  kSpatialLosses = kSpatialPath + 2,      ///< by normal damping, sliding, tangential damping, offset
  kSpatialAttitude = kSpatialLosses + 4,  ///< quaternion, real part last
  kSpatialComponents = kSpatialAttitude + 4
};

using SpatialComponents = std::array<double, kSpatialComponents>;

struct SpatialSystem {
  System system;  ///< with the lengths of vectors in place of slip0, w0 and along
  Eigen::Vector2d v0, w0, slip0, along;
  double wy0 = 0.0;  ///< R·omega_y
  double tau = 0.0;  ///< of release
};

struct SpatialStep {
  double x = 0.0;
  bool grips = true;
  SpatialComponents start{};
};

}  // namespace detail

inline constexpr double kSpatialTolerance = 1e-9;

class SpatialContact {
 public:
  /// `tolerance`, 1e-12…1e-3: error at release, relative to the scale of each motion. Errors: those of
  /// simulate() in the plane; too_many_steps beyond 100,000 of them: the ball turns through thousands of
  /// radians, or slips without a dashpot under a small part of the slip's force; offset_out_of_range with
  /// OffsetLaw::constant_ahead, which is of the plane alone.
  static tl::expected<SpatialContact, InputError> make(const ball::Ball& ball, const SpatialMotion& touchdown,
                                                       const ContactCoefficients& coefficients,
                                                       double tolerance = kSpatialTolerance);

  const SpatialLiftOff& lift_off() const { return lift_off_; }

  /// Clamped to 0…release.
  SpatialState at(double time_s) const;

 private:
  SpatialContact() = default;
  SpatialState state_of(const detail::SpatialComponents& z, double tau) const;

  SpatialMotion touchdown_;
  detail::SpatialSystem system_;
  std::vector<detail::SpatialStep> steps_;
  SpatialLiftOff lift_off_;
};

/// The motion at lift-off alone, by the plane's collocation where the contact splits, which is the cheaper.
/// Errors as for SpatialContact::make().
tl::expected<SpatialMotion, InputError> spatial_lift_off(const ball::Ball& ball,
                                                         const SpatialMotion& touchdown,
                                                         const ContactCoefficients& coefficients,
                                                         double tolerance = kSpatialTolerance);

}  // namespace strobe::impact
