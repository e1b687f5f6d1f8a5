// Bounces in three dimensions: against the plane's, against steps of a fixed size written from the equations with vectors
// in space, and by what stays equal: turned and mirrored contacts, angular momentum, energy.
#include "common/impact/spatial/spatial_contact.hpp"

#include <cmath>
#include <numbers>
#include <rapidcheck.h>

#include "common/impact/ode/contact_trajectory.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "tests/common/contact_ode/drawn_contacts.hpp"
#include "tests/support/property.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;
using namespace strobe::testing;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

const ball::Ball kSpatialBall = contact_ball();

SpatialMotion turned(const SpatialMotion& m, double angle_rad) {
  const Eigen::AngleAxisd turn(angle_rad, Vector3d::UnitY());
  return {turn * m.velocity_mps, turn * m.spin_radps};
}

/// z and what is odd in it, for a velocity and for a spin.
SpatialMotion mirrored(const SpatialMotion& m) {
  return {m.velocity_mps.cwiseProduct(Vector3d(1, 1, -1)), m.spin_radps.cwiseProduct(Vector3d(-1, -1, 1))};
}

SpatialMotion in_plane(const Motion& m) { return {{m.vx_mps, m.vy_mps, 0.0}, {0.0, 0.0, m.omega_radps}}; }

/// Velocity and R·spin, in m/s.
double difference(const SpatialMotion& a, const SpatialMotion& b) {
  return std::max((a.velocity_mps - b.velocity_mps).norm(), kSpatialBall.radius_m() * (a.spin_radps - b.spin_radps).norm());
}

double speed_scale(const SpatialMotion& m) {
  return m.velocity_mps.norm() + kSpatialBall.radius_m() * m.spin_radps.norm();
}

/// Shots, and spins of their order about any axis.
SpatialMotion any_spatial_touchdown() {
  const double most_radps = 2.0 * 30.0 / kSpatialBall.radius_m();
  const auto spin = [&] { return sometimes(0.0, between(-most_radps, most_radps)); };
  return {{between(-30.0, 30.0), -over_decades(0.5, 30.0), sometimes(0.0, between(-30.0, 30.0))},
          {spin(), spin(), spin()}};
}

ContactCoefficients any_spatial_coefficients() {
  ContactCoefficients c;
  c.e = sometimes(1.0, between(0.2, 1.0));
  c.dwell_s = over_decades(1e-4, 1e-2);
  c.mu = sometimes(0.0, over_decades(0.02, 2.0));
  c.stiffness_ratio = over_decades(0.2, 5.0);
  c.damping_ratio = over_decades(0.1, 2.0);
  if (one_in(50)) c.damping_ratio = 0.0;  // many steps each
  c.offset_share = sometimes(0.0, between(0.0, 0.5));
  c.offset_reference_mps = over_decades(0.1, 100.0);
  c.gravity_mps2 = sometimes(9.81, 0.0);
  return c;
}

Coefficients any_spatial_grip() {
  return {.e = between(0.0, 1.0),
          .mu = sometimes(0.0, over_decades(0.02, 2.0)),
          .e_x = between(-1.0, 1.0),
          .offset_m = sometimes(0.0, between(0.0, 0.5)) * kSpatialBall.radius_m(),
          .offset_reference_mps = over_decades(0.1, 100.0)};
}

/// The ball in space, by Euler's steps with the stretch pulled back to what friction holds: forces at the contact point,
/// their moments by cross products.
SpatialState stepped(const SpatialMotion& touchdown, const ContactCoefficients& c, int steps) {
  const double m = kSpatialBall.mass_kg, radius = kSpatialBall.radius_m();
  const NormalSpring spring = *normal_spring(m, c.e, c.dwell_s);
  const double kt = c.stiffness_ratio * spring.stiffness_npm, ct = c.damping_ratio * std::sqrt(kt * m);
  const Vector3d arm(0.0, -radius, 0.0), up = Vector3d::UnitY();
  const double h = c.dwell_s / steps;
  SpatialState z{.motion = touchdown};
  Vector3d stretch = Vector3d::Zero();
  Eigen::Matrix3d attitude = Eigen::Matrix3d::Identity();
  for (int i = 0; i < steps; ++i) {
    Vector3d& v = z.motion.velocity_mps;
    Vector3d& omega = z.motion.spin_radps;
    const double depth = -z.displacement_m.y();
    const double normal = std::max(0.0, spring.stiffness_npm * depth - spring.damping_nspm * v.y());
    Vector3d slip = v + omega.cross(arm);
    slip.y() = 0.0;
    const Vector3d tried = ct > 0.0 ? Vector3d(kt * stretch + ct * slip) : Vector3d(kt * (stretch + h * slip));
    const Vector3d friction = tried.norm() > c.mu * normal ? Vector3d(tried.normalized() * (c.mu * normal)) : tried;
    stretch = ct > 0.0 ? Vector3d(stretch + h * (friction - kt * stretch) / ct) : Vector3d(friction / kt);
    const Vector3d along_spin = omega - omega.y() * up;
    const double footprint = std::sqrt(std::max(depth, 0.0) * (2.0 * radius - depth));
    const Vector3d couple = -c.offset_share * footprint * normal * radius * along_spin /
                            std::hypot(radius * along_spin.norm(), c.offset_reference_mps);
    v += h * ((normal * up - friction) / m - c.gravity_mps2 * up);
    omega += h * (arm.cross(-friction) + couple) / kSpatialBall.inertia_kgm2();
    z.displacement_m += h * v;
    attitude = Eigen::AngleAxisd(h * omega.norm(), omega.normalized()) * attitude;
  }
  z.rotation = Eigen::Quaterniond(attitude);
  return z;
}

}  // namespace

TEST_GROUP(SpatialContact){};

// Over the whole range of the plane's inputs but those that take too many steps. Both are
// within the tolerance of the scale of what they change; a turn costs some roundings of the motion itself.
TEST(SpatialContact, ATurnedContactOfThePlaneIsThePlanes) {
  ContactDraws draws(35);
  int skids = 0, computed = 0;
  for (int i = 0; i < repetitions(150); ++i) {
    const ContactCase c = draw_contact(draws);
    const double angle = draws.between(-3.0, 3.0);
    const auto exact = ContactTrajectory::make(kSpatialBall, c.touchdown, c.coefficients, {.tolerance = 1e-12});
    const auto got = SpatialContact::make(kSpatialBall, turned(in_plane(c.touchdown), angle), c.coefficients);
    const auto alone = spatial_lift_off(kSpatialBall, turned(in_plane(c.touchdown), angle), c.coefficients);
    CHECK_TEXT(exact.has_value() && alone.has_value(), text_of(c).c_str());
    if (!got && got.error() == InputError::too_many_steps) continue;
    CHECK_TEXT(got.has_value(), text_of(c).c_str());
    ++computed;
    const double allowed = 1e-9 * (tangential_scale(c) - c.touchdown.vy_mps) + 2.0 * rounding_of(c);
    const double dwell = exact->summary().dwell_s;
    const SpatialMotion want = turned(in_plane(exact->summary().lift_off), angle);
    DOUBLES_EQUAL_TEXT(0.0, difference(got->lift_off().motion, want), allowed, text_of(c).c_str());
    DOUBLES_EQUAL_TEXT(0.0, difference(*alone, want), allowed, text_of(c).c_str());
    DOUBLES_EQUAL_TEXT(dwell, got->lift_off().time_s, 1e-10 * dwell, text_of(c).c_str());
    for (const double share : {0.0, 0.01, 0.3, 0.7, 1.0}) {
      const ContactState planar = exact->at(share * dwell);
      const SpatialState at = got->at(share * dwell);
      const SpatialMotion motion = turned(in_plane({planar.vx_mps, planar.vy_mps, planar.omega_radps}), angle);
      DOUBLES_EQUAL_TEXT(0.0, difference(at.motion, motion), allowed, text_of(c).c_str());
      const Vector3d way = Eigen::AngleAxisd(angle, Vector3d::UnitY()) * Vector3d(planar.x_m, planar.y_m, 0.0);
      DOUBLES_EQUAL_TEXT(0.0, (at.displacement_m - way).norm(), allowed * dwell + 1e-15 * way.norm(), text_of(c).c_str());
    }
    const Regime regime = exact->summary().regime;
    CHECK_TEXT(regime == got->lift_off().regime, text_of(c).c_str());
    if (exact->summary().skid_to_grip_s && *exact->summary().skid_to_grip_s > 0.0) ++skids;
  }
  CHECK(skids > repetitions(15) && computed > repetitions(120));
}

// Euler's steps are wrong by their size, and less by their square when extrapolated from two sizes; changes between grip and
// slip leave a part of the size.
TEST(SpatialContact, ItIsWhatSmallStepsOfTheEquationsInSpaceCompute) {
  ContactDraws draws(36);
  for (int i = 0; i < repetitions(40); ++i) {
    ContactCoefficients c;
    c.e = draws.between(0.4, 0.95);
    c.mu = draws.over_decades(0.05, 1.0);
    c.stiffness_ratio = draws.between(0.5, 2.5);
    c.damping_ratio = draws.one_in(3) ? 0.0 : draws.between(0.2, 1.0);
    c.offset_share = draws.one_in(4) ? 0.0 : draws.between(0.05, 0.4);
    const auto spin = [&] { return draws.between(-400.0, 400.0); };
    const SpatialMotion touchdown{{draws.between(-15.0, 15.0), -draws.between(2.0, 12.0), draws.between(-15.0, 15.0)},
                                  {spin(), spin(), spin()}};
    const auto got = SpatialContact::make(kSpatialBall, touchdown, c);
    CHECK(got.has_value());
    const SpatialState coarse = stepped(touchdown, c, 20'000), fine = stepped(touchdown, c, 40'000);
    const SpatialMotion want{2.0 * fine.motion.velocity_mps - coarse.motion.velocity_mps,
                             2.0 * fine.motion.spin_radps - coarse.motion.spin_radps};
    const SpatialState& lo = got->lift_off();
    DOUBLES_EQUAL(0.0, difference(lo.motion, want), 1e-5 * speed_scale(touchdown));
    DOUBLES_EQUAL(0.0, (lo.displacement_m - 2.0 * fine.displacement_m + coarse.displacement_m).norm(),
                  1e-5 * speed_scale(touchdown) * c.dwell_s);
    DOUBLES_EQUAL(0.0, lo.rotation.angularDistance(fine.rotation),
                  2.0 * lo.rotation.angularDistance(coarse.rotation) + 1e-6);
    DOUBLES_EQUAL(0.0, lo.rotation.angularDistance(fine.rotation), 2e-4);
  }
}

// Friction acts at the contact point: about it the moment of momentum along the surface changes by the offset alone. The
// method's sums keep it to rounding. Nothing turns the ball about y.
TEST(SpatialContact, WithoutAnOffsetAngularMomentumAboutTheContactPointStays) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpatialMotion touchdown = any_spatial_touchdown();
    ContactCoefficients c = any_spatial_coefficients();
    c.offset_share = 0.0;
    const auto contact = SpatialContact::make(kSpatialBall, touchdown, c);
    RC_ASSERT(contact.has_value());
    const auto momentum = [](const SpatialMotion& m) {
      return Vector2d(kSpatialBall.alpha * kSpatialBall.radius_m() * rolling_spin(m.spin_radps) - along_surface(m.velocity_mps));
    };
    const SpatialMotion& lo = contact->lift_off().motion;
    RC_ASSERT(worst.within((momentum(lo) - momentum(touchdown)).norm(), 1e-14 * speed_scale(touchdown)));
    RC_ASSERT(lo.spin_radps.y() == touchdown.spin_radps.y());
  }));
}

// The losses' sums have the tolerance of their scale, a change of speed times the speeds that change.
TEST(SpatialContact, ItsEnergyIsAccountedForAndNoLossIsNegative) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpatialMotion touchdown = any_spatial_touchdown();
    const auto contact = SpatialContact::make(kSpatialBall, touchdown, any_spatial_coefficients());
    RC_ASSERT(contact.has_value());
    const ContactEnergy& e = contact->lift_off().energy;
    const double allowed = 1e-9 * kSpatialBall.mass_kg * std::pow(speed_scale(touchdown), 2);
    RC_ASSERT(worst.within(std::abs(e.kinetic_lost_j - e.dissipated_j()), allowed));
    for (const double loss : {e.normal_damping_j, e.sliding_j, e.tangential_damping_j, e.offset_j})
      RC_ASSERT(worst.within(-loss, 1e-3 * allowed));
  }));
}

TEST(SpatialContact, TurnedAndMirroredContactsGiveTurnedAndMirroredLiftOffs) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpatialMotion touchdown = any_spatial_touchdown();
    const ContactCoefficients c = any_spatial_coefficients();
    const double angle = between(-3.0, 3.0), allowed = 1e-9 * speed_scale(touchdown);
    const auto one = SpatialContact::make(kSpatialBall, touchdown, c);
    const auto other = SpatialContact::make(kSpatialBall, turned(touchdown, angle), c);
    const auto image = SpatialContact::make(kSpatialBall, mirrored(touchdown), c);
    RC_ASSERT(one.has_value() && other.has_value() && image.has_value());
    RC_ASSERT(worst.within(difference(other->lift_off().motion, turned(one->lift_off().motion, angle)), allowed));
    RC_ASSERT(difference(image->lift_off().motion, mirrored(one->lift_off().motion)) == 0.0);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Vector3d::UnitY()));
    const Eigen::Quaterniond expected = turn * one->lift_off().rotation * turn.conjugate();
    const double rotates = 1e-8 * (1.0 + touchdown.spin_radps.norm() * c.dwell_s);
    RC_ASSERT(worst.within(other->lift_off().rotation.angularDistance(expected), rotates));
  }));
}

// Reversing the sidespin mirrors the bounce, so that what happens in the plane is even in it.
TEST(SpatialContact, ALittleSidespinChangesTheBounceInThePlaneByItsSquare) {
  const auto bounced = [](double omega_x) {
    const SpatialMotion td{{14.0, -8.0, 0.0}, {omega_x, 0.0, 100.0}};
    return spatial_lift_off(kSpatialBall, td, {}, 1e-12)->velocity_mps;
  };
  const double one = bounced(10.0).x() - bounced(0.0).x(), half = bounced(5.0).x() - bounced(0.0).x();
  DOUBLES_EQUAL(4.0, one / half, 0.05);
  DOUBLES_EQUAL(2.0, bounced(10.0).z() / bounced(5.0).z(), 0.01);
}

TEST(SpatialContact, ItSaysWhatItDoesNotCompute) {
  const SpatialMotion fine{{10.0, -8.0, 1.0}, {5.0, 6.0, 7.0}};
  SpatialMotion rising = fine, infinite = fine;
  rising.velocity_mps.y() = 1.0;
  infinite.spin_radps.y() = HUGE_VAL;
  CHECK(SpatialContact::make(kSpatialBall, rising, {}).error() == InputError::not_approaching);
  CHECK(SpatialContact::make(kSpatialBall, infinite, {}).error() == InputError::not_finite);
  CHECK(SpatialContact::make(kSpatialBall, fine, {}, 1.0).error() == InputError::tolerance_out_of_range);
  CHECK(spatial_lift_off(kSpatialBall, fine, {.offset_law = OffsetLaw::constant_ahead}).error() ==
        InputError::offset_out_of_range);
  CHECK(grip(kSpatialBall, infinite, Coefficients{}).error() == InputError::not_finite);
}

TEST_GROUP(SpatialRebound){};

TEST(SpatialRebound, ATurnedBounceOfThePlaneIsThePlanes) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpatialMotion drawn = any_spatial_touchdown();
    const Motion planar{drawn.velocity_mps.x(), drawn.velocity_mps.y(), drawn.spin_radps.z()};
    const Coefficients c = any_spatial_grip();
    const double angle = sometimes(0.0, between(-3.0, 3.0));
    const auto want = grip(kSpatialBall, planar, c);
    const auto got = grip(kSpatialBall, turned(in_plane(planar), angle), c);
    RC_ASSERT(want.has_value() && got.has_value());
    const double rounding = 2e-14 * speed_scale(drawn);
    RC_ASSERT(worst.within(difference(got->lift_off, turned(in_plane(want->lift_off), angle)), rounding));
    RC_ASSERT(worst.within(std::abs(got->impulse_ratio - std::abs(want->impulse_ratio)), 1e-13 * (1.0 + c.mu)));
    RC_ASSERT(worst.within(std::abs(got->slip_lo_mps.norm() - std::abs(want->slip_lo_mps)), rounding));
  }));
}

// Angular momentum about the contact point changes by the normal force's offset alone; the energy along the surface never
// grows; what is across the slip of a bounce without offset stays.
TEST(SpatialRebound, MomentumIsKeptAndEnergyNeverGrows) {
  CHECK(holds_of_all([](Worst& worst) {
    const SpatialMotion td = any_spatial_touchdown();
    const Coefficients c = any_spatial_grip();
    const auto out = grip(kSpatialBall, td, c);
    RC_ASSERT(out.has_value());
    const double radius = kSpatialBall.radius_m(), alpha = kSpatialBall.alpha, scale = speed_scale(td);
    const auto w = [&](const SpatialMotion& m) { return Vector2d(radius * rolling_spin(m.spin_radps)); };
    const auto v = [](const SpatialMotion& m) { return along_surface(m.velocity_mps); };
    const double impulse = out->lift_off.velocity_mps.y() - td.velocity_mps.y();
    const Vector2d dv = v(out->lift_off) - v(td), dw = w(out->lift_off) - w(td);
    RC_ASSERT(worst.within((alpha * dw - dv - out->offset_m * impulse / radius).norm(), 1e-13 * scale));
    const auto energy = [&](const SpatialMotion& m) { return v(m).squaredNorm() + alpha * w(m).squaredNorm(); };
    RC_ASSERT(worst.within(energy(out->lift_off) - energy(td), 1e-13 * scale * scale));
    RC_ASSERT(worst.within(dv.norm(), c.mu * impulse * (1.0 + 1e-14) + 1e-13 * scale));
    const Vector2d slip = slip_mps(kSpatialBall, td);
    if (c.offset_m == 0.0) RC_ASSERT(worst.within(std::abs(slip.x() * dv.y() - slip.y() * dv.x()), 1e-13 * scale * slip.norm()));
    RC_ASSERT(out->lift_off.spin_radps.y() == td.spin_radps.y());
  }));
}
