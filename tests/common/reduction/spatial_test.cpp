#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using namespace strobe::test;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kLineSd = 0.002;
constexpr double kPi = std::numbers::pi;

/// What a photographed bounce has besides its motion in the plane. Axes of the surface.
struct Space {
  Vector3d omega_td, omega_lo;
  double lens_m = 0.0;  // 0: far away
  double vz_td = 0.0, vz_lo = 0.0;
  double noise = 1.0;
};

/// The frame of a planar motion, with its lines drawn anew by quaternions and, through a lens above the
/// touchdown, its places by perspective.
Frame in_space(Frame frame, const Setup& s, const Space& space, Random& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double roll = s.roll_rad;
  const Eigen::AngleAxisd rolled(roll, Vector3d::UnitZ());
  const PointPx foot{s.origin_x_px, s.origin_y_px + 300.0};
  if (space.lens_m > 0.0) {
    frame.lens = Lens{space.lens_m, foot};
    frame.px_per_m = s.px_per_m;
    frame.px_per_m_sd = 1e-4 * s.px_per_m;
  }
  const Vector3d drawn = Vector3d(normal(random), normal(random), 0.03 * normal(random)).normalized();
  for (BallImage& image : frame.images) {
    const bool before = image.leg == Leg::incoming;
    const double t = image.time_s - s.time_origin_s, since = before ? t : t - 5.2e-3;
    if (image.leg == Leg::contact) {
      image.equator_rad.reset();
      continue;
    }
    const Vector3d omega = rolled * (before ? space.omega_td : space.omega_lo);
    // Spins decay as those of the planar motion do, by its speeds.
    const double decay_per_s = 0.01 * (before ? 17.0 : 10.55);
    const double turn = omega.norm() * -std::expm1(-decay_per_s * since) / decay_per_s;
    const Vector3d n = Eigen::AngleAxisd(turn, omega.normalized()) * drawn;
    Vector3d to_lens = Vector3d::UnitZ();
    if (space.lens_m > 0.0) {
      // On either side of the middle of the contact.
      const double z = (before ? space.vz_td : space.vz_lo) * (t - 2.6e-3), grown = 1.0 / (1.0 - z / space.lens_m);
      image.centre_px.x = foot.x + grown * (image.centre_px.x - foot.x);
      image.centre_px.y = foot.y + grown * (image.centre_px.y - foot.y);
      const Vector2d off(foot.x - image.centre_px.x, foot.y - image.centre_px.y);
      const Vector2d sight = off / (s.px_per_m * space.lens_m);
      to_lens = Vector3d(sight.x(), sight.y(), 1.0).normalized();
      image.diameter_px *= grown;
    }
    const Vector3d chord = n.cross(to_lens).normalized();
    const Vector2d seen = chord.head<2>() - to_lens.head<2>() / to_lens.z() * chord.z();
    const double tilt = -std::asin(n.dot(to_lens)), angle_sd = kLineSd / std::max(std::cos(tilt), 0.1);
    image.equator_rad = std::atan2(seen.y(), seen.x()) + space.noise * angle_sd * normal(random);
    image.equator_sd_rad = angle_sd;
    image.equator_tilt_rad = tilt + space.noise * kLineSd * normal(random);
    image.equator_tilt_sd_rad = kLineSd;
  }
  return frame;
}

/// Digitized by a program: a twentieth of a pixel of some 260.
Setup sharp() {
  Setup s;
  s.centre_sd_m = 1.25e-5;
  s.diameter_sd_m = 1.5e-5;
  s.surface_sd_m = 2.5e-5;
  s.equator_sd_rad = kLineSd;
  return s;
}

Vector3d tilted(double omega, double tilt_rad, double azimuth) {
  return omega * Vector3d(std::sin(tilt_rad) * std::cos(azimuth), std::sin(tilt_rad) * std::sin(azimuth),
                          std::cos(tilt_rad));
}

void mirror_frame(Frame& frame) {
  for (PointPx& p : frame.surface_px) p.x = -p.x;
  for (BallImage& image : frame.images) {
    image.centre_px.x = -image.centre_px.x;
    if (!image.equator_rad) continue;
    image.equator_rad = -*image.equator_rad;
  }
  if (frame.lens) frame.lens->foot_px.x = -frame.lens->foot_px.x;
}

/// Root mean square of errors over their stated sds.
struct Normalized {
  double sum = 0.0;
  int count = 0;
  void add(double error, double sd) { sum += error * error / (sd * sd), ++count; }
  double rms() const { return std::sqrt(sum / count); }
};

}  // namespace

TEST_GROUP(ThirdDimension) {
  Random random{seed_or(4)};
  Bounce bounce;
  Setup setup = sharp();

  Readout read(const Space& space) {
    const Frame frame = in_space(photograph(bounce, setup, random), setup, space, random);
    const auto readout = reduce(frame, Estimator::best);
    CHECK_TRUE(readout.has_value());
    return *readout;
  }

  Space about(double tilt_td_rad, double tilt_lo_rad) {
    std::uniform_real_distribution<double> azimuth(0.0, 2.0 * kPi);
    bounce.omega_td = 180.0;
    bounce.omega_lo = -260.0;
    // omega_z is the planar motion's: lift follows it.
    return {tilted(bounce.omega_td / std::cos(tilt_td_rad), tilt_td_rad, azimuth(random)),
            tilted(bounce.omega_lo / std::cos(tilt_lo_rad), tilt_lo_rad, azimuth(random))};
  }
};

TEST(ThirdDimension, ASpinAboutTheCamerasAxisIsReadAsIfTiltsWereNotThere) {
  int other = 0;
  for (int i = 0; i < 200; ++i) {
    Space space = about(0.0, 0.0);
    Frame frame = in_space(photograph(bounce, setup, random), setup, space, random);
    const auto with = reduce(frame, Estimator::best);
    for (BallImage& image : frame.images)
      image.equator_tilt_rad.reset(), image.equator_tilt_sd_rad.reset();
    const auto without = reduce(frame, Estimator::best);
    CHECK_FALSE(with->flags.has(Flag::axis_tilted));
    CHECK_TRUE(with->spatial.has_value());
    CHECK_FALSE(without->spatial.has_value());
    if (!(with->value == without->value && with->sd == without->sd)) ++other;
  }
  // Two tests a shot, each rejected once in ten thousand by chance.
  CHECK_TRUE(other <= 2);
}

TEST(ThirdDimension, ErrorsOfATiltedSpinAreAsLargeAsStated) {
  for (const double tilt : {0.1, 0.5, 1.0}) {
    Normalized omega_z, across, axis;
    constexpr int kShots = 300;
    for (int i = 0; i < kShots; ++i) {
      const Space space = about(tilt, 0.8 * tilt);
      const Readout r = read(space);
      CHECK_TRUE(r.flags.has(Flag::axis_tilted));
      CHECK_FALSE(r.flags.has(Flag::spin_aliased));
      const Spatial& s = *r.spatial;
      omega_z.add(*r.value[Quantity::omega_td_radps] - space.omega_td.z(), *r.sd[Quantity::omega_td_radps]);
      omega_z.add(*r.value[Quantity::omega_lo_radps] - space.omega_lo.z(), *r.sd[Quantity::omega_lo_radps]);
      const auto add = [&](SpatialQuantity q, double truth, Normalized& to) {
        to.add(s[q]->value - truth, s[q]->sd);
      };
      add(SpatialQuantity::omega_x_td_radps, space.omega_td.x(), across);
      add(SpatialQuantity::omega_y_td_radps, space.omega_td.y(), across);
      add(SpatialQuantity::omega_x_lo_radps, space.omega_lo.x(), across);
      add(SpatialQuantity::omega_y_lo_radps, space.omega_lo.y(), across);
      add(SpatialQuantity::spin_axis_tilt_td_deg, tilt * 180.0 / kPi, axis);
      add(SpatialQuantity::spin_axis_tilt_lo_deg, 0.8 * tilt * 180.0 / kPi, axis);
    }
    // Of 600 numbers the rms over the sd scatters by 1/sqrt(1200) = .029; four sd. The spin's decay, whose
    // tolerance is stated apart, bends the angles by a few tenths of their sds.
    DOUBLES_EQUAL(1.0, across.rms(), 0.13);
    DOUBLES_EQUAL(1.0, axis.rms(), 0.13);
  }
}

TEST(ThirdDimension, NumbersOfAPlanarReaderWouldHaveBeenWrong) {
  Normalized planar, spatial;
  for (int i = 0; i < 50; ++i) {
    const Space space = about(0.6, 0.5);
    Frame frame = in_space(photograph(bounce, setup, random), setup, space, random);
    const Readout read = *reduce(frame, Estimator::best);
    for (BallImage& image : frame.images) image.equator_tilt_rad.reset(), image.equator_tilt_sd_rad.reset();
    const Readout plane = *reduce(frame, Estimator::best);
    spatial.add(*read.value[Quantity::omega_td_radps] - space.omega_td.z(), 1.0);
    planar.add(plane.value[Quantity::omega_td_radps].value_or(0.0) - space.omega_td.z(), 1.0);
  }
  CHECK_TRUE(planar.rms() > 10.0 * spatial.rms());
}

TEST(ThirdDimension, OfABallToTheLeftIsThatOfItsMirrorImage) {
  const Space space = about(0.4, 0.3);
  Frame frame = in_space(photograph(bounce, setup, random), setup, space, random);
  const Readout right = *reduce(frame, Estimator::best);
  mirror_frame(frame);
  const Readout left = *reduce(frame, Estimator::best);
  CHECK_TRUE(left.mirrored);
  for (std::size_t i = 0; i < kSpatialCount; ++i) {
    CHECK_EQUAL(right.spatial->number[i].has_value(), left.spatial->number[i].has_value());
    if (!right.spatial->number[i]) continue;
    // Iterations stop within a millionth of an sd.
    DOUBLES_EQUAL(right.spatial->number[i]->value, left.spatial->number[i]->value,
                  1e-4 * right.spatial->number[i]->sd + 1e-9);
  }
}

TEST(ThirdDimension, ABallThatComesNearerHasItsScaleCorrectedImageByImage) {
  Normalized vz, vx;
  int flagged = 0;
  constexpr int kShots = 300;
  for (int i = 0; i < kShots; ++i) {
    Space space = about(0.0, 0.0);
    space.lens_m = 1.2;
    space.vz_td = 0.8;
    space.vz_lo = 0.5;
    const Readout r = read(space);
    if (r.flags.has(Flag::out_of_plane)) ++flagged;
    const Spatial& s = *r.spatial;
    vz.add(s[SpatialQuantity::vz_td_mps]->value - space.vz_td, s[SpatialQuantity::vz_td_mps]->sd);
    vz.add(s[SpatialQuantity::vz_lo_mps]->value - space.vz_lo, s[SpatialQuantity::vz_lo_mps]->sd);
    vx.add(*r.value[Quantity::vx_td_mps] - bounce.vx_td, *r.sd[Quantity::vx_td_mps]);
  }
  CHECK_EQUAL(kShots, flagged);
  // Of 600 and 300 numbers: .029 and .041, four sd.
  DOUBLES_EQUAL(1.0, vz.rms(), 0.13);
  DOUBLES_EQUAL(1.0, vx.rms(), 0.17);
}

TEST(ThirdDimension, ABallInThePlaneIsNotCorrectedAndItsDepthIsToldWithinItsSd) {
  int flagged = 0;
  Normalized depth;
  for (int i = 0; i < 200; ++i) {
    Space space = about(0.0, 0.0);
    space.lens_m = 1.2;
    const Readout r = read(space);
    if (r.flags.has(Flag::out_of_plane)) ++flagged;
    const DerivedNumber& off = *(*r.spatial)[SpatialQuantity::off_plane_mm];
    depth.add(off.value, std::hypot(off.sd, off.sd_systematic));
  }
  CHECK_TRUE(flagged <= 1);
  // The calibrated scale is exact here but states an sd: the errors are within it.
  CHECK_TRUE(depth.rms() < 1.0);
}
