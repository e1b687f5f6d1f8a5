// What the camera says of a ball against the ball's outline, traced point by point through the lens.
#include "sim/rig/camera.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;
using reduction::PointPx;

constexpr double kPi = std::numbers::pi;

/// A camera without roll, looking at the middle of a view of ±.30 m by .35 m: axis at (0, .175).
Scene scene_of(double distance_m, double distortion) {
  Scene scene = test::plain_scene();
  scene.camera.roll_rad = 0.0;
  scene.camera.distance_m = distance_m;
  scene.camera.distortion = distortion;
  return scene;
}

struct Region {
  double area = 0.0;
  PointPx centroid;
};

/// Of the polygon through corner(0) … corner(n - 1).
Region region(int n, const std::function<PointPx(int)>& corner) {
  Region out;
  PointPx a = corner(n - 1);
  const PointPx origin = a;
  for (int i = 0; i < n; ++i) {
    const PointPx b = corner(i);
    const double cross = (a.x - origin.x) * (b.y - origin.y) - (b.x - origin.x) * (a.y - origin.y);
    out.area += 0.5 * cross;
    out.centroid.x += cross * (a.x + b.x - 2.0 * origin.x) / 6.0;
    out.centroid.y += cross * (a.y + b.y - 2.0 * origin.y) / 6.0;
    a = b;
  }
  out.centroid = {origin.x + out.centroid.x / out.area, origin.y + out.centroid.y / out.area};
  return out;
}

using Vector = std::array<double, 3>;

/// The circle in which rays from the lens touch the sphere.
Vector touching(const Vector& centre, double radius, double lens_m, double turn) {
  Vector d{-centre[0], -centre[1], lens_m - centre[2]};
  const double far = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  for (double& x : d) x /= far;
  // Two directions across d.
  Vector e{d[2], 0.0, -d[0]};
  const double norm = std::hypot(e[0], e[2]);
  for (double& x : e) x /= norm;
  const Vector f{d[1] * e[2] - d[2] * e[1], d[2] * e[0] - d[0] * e[2], d[0] * e[1] - d[1] * e[0]};
  const double along = radius * radius / far;
  const double across = radius * std::sqrt(1.0 - radius * radius / (far * far));
  Vector p{};
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = centre[i] + along * d[i] + across * (std::cos(turn) * e[i] + std::sin(turn) * f[i]);
  return p;
}

struct Place {
  double x_m, y_m, z_m;
};
constexpr std::array kPlaces{Place{0.0, 0.175, 0.0}, Place{0.28, 0.05, 0.0}, Place{-0.25, 0.30, 0.02},
                             Place{0.1, 0.0326, -0.03}, Place{-0.29, 0.34, -0.01}};

}  // namespace

TEST_GROUP(RigCamera){};

TEST(RigCamera, SeesTheEllipseThatRaysAroundTheBallCutOut) {
  for (const double distance : {0.8, 1.5, 6.0}) {
    const Scene scene = scene_of(distance, 0.0);
    const double r = scene.ball.radius_m();
    for (const Place& place : kPlaces) {
      constexpr int n = 20000;  // a polygon of n corners has 1 - 2·pi²/(3·n²) of its ellipse's area
      const Vector centre{place.x_m, place.y_m - 0.175, place.z_m};
      const Region seen = region(n, [&](int i) {
        const Vector p = touching(centre, r, distance, 2.0 * kPi * i / n);
        const double share = distance / (distance - p[2]);
        return PointPx{1500.0 + 4000.0 * share * p[0], 300.0 + 4000.0 * (0.175 + share * p[1])};
      });
      const BallView view = Camera(scene).view(place.x_m, place.y_m, place.z_m, 0.0);
      DOUBLES_EQUAL(seen.centroid.x, view.centre_px.x, 1e-6);
      DOUBLES_EQUAL(seen.centroid.y, view.centre_px.y, 1e-6);
      DOUBLES_EQUAL(2.0 * std::sqrt(std::abs(seen.area) / kPi), view.diameter_px(), 1e-5);
      // Longer towards the axis and from it, by half the square of the angle.
      const double theta = std::atan2(std::hypot(centre[0], centre[1]), distance - place.z_m);
      DOUBLES_EQUAL(1.0 + 0.5 * theta * theta, view.along_px / view.across_px, theta * theta * theta + 1e-12);
    }
  }
}

TEST(RigCamera, SeesTheEquatorBetweenTheTwoPlacesWhereItLeavesTheOutline) {
  const double distance = 0.9;
  const Scene scene = scene_of(distance, 0.0);
  const double r = scene.ball.radius_m();
  for (const Place& place : kPlaces) {
    for (const double phi : {0.0, 0.6, 1.5, 2.9}) {
      const Vector c{place.x_m, place.y_m - 0.175, place.z_m};
      // Where a point of the great circle turns from seen to hidden, by bisection.
      std::array<PointPx, 2> ends;
      const auto point = [&](double psi) {
        return Vector{c[0] + r * std::cos(psi) * std::cos(phi), c[1] + r * std::cos(psi) * std::sin(phi),
                      c[2] + r * std::sin(psi)};
      };
      const auto faces = [&](double psi) {
        const Vector p = point(psi);
        return (p[0] - c[0]) * -p[0] + (p[1] - c[1]) * -p[1] + (p[2] - c[2]) * (distance - p[2]) > 0.0;
      };
      for (std::size_t side = 0; side < 2; ++side) {
        double seen = 0.5 * kPi, hidden = side == 0 ? -0.5 * kPi : 1.5 * kPi;
        for (int i = 0; i < 60; ++i) {
          const double middle = 0.5 * (seen + hidden);
          (faces(middle) ? seen : hidden) = middle;
        }
        const Vector p = point(seen);
        ends[side] = {p[0] / (distance - p[2]), p[1] / (distance - p[2])};
      }
      const double expected = std::atan2(ends[0].y - ends[1].y, ends[0].x - ends[1].x);
      const double got = Camera(scene).view(place.x_m, place.y_m, place.z_m, phi).equator_rad;
      DOUBLES_EQUAL(0.0, std::remainder(got - expected, kPi), 1e-10);
    }
  }
}

TEST(RigCamera, BendsTheBallsImageAsItsOutlineIsBent) {
  // To first order in the distortion: what is left is its square, times the same geometry.
  const double k = 1e-4;
  const Scene scene = scene_of(0.0, k);
  const double r = scene.ball.radius_m(), r0 = 0.30 * 0.30 + 0.175 * 0.175;
  for (const Place& place : kPlaces) {
    constexpr int n = 20000;
    const auto lens = [&](double x, double y) {
      const double stretch = 1.0 + k * (x * x + y * y) / r0;
      return PointPx{1500.0 + 4000.0 * stretch * x, 300.0 + 4000.0 * (0.175 + stretch * y)};
    };
    const double x = place.x_m, y = place.y_m - 0.175;
    const Region seen = region(n, [&](int i) {
      return lens(x + r * std::cos(2.0 * kPi * i / n), y + r * std::sin(2.0 * kPi * i / n));
    });
    const BallView view = Camera(scene).view(place.x_m, place.y_m, 0.0, 0.7);
    DOUBLES_EQUAL(seen.centroid.x, view.centre_px.x, 1e-4);
    DOUBLES_EQUAL(seen.centroid.y, view.centre_px.y, 1e-4);
    DOUBLES_EQUAL(2.0 * std::sqrt(seen.area / kPi), view.diameter_px(), 1e-3);
    constexpr double h = 1e-4;
    const PointPx a = lens(x - h * std::cos(0.7), y - h * std::sin(0.7));
    const PointPx b = lens(x + h * std::cos(0.7), y + h * std::sin(0.7));
    DOUBLES_EQUAL(std::atan2(b.y - a.y, b.x - a.x), view.equator_rad, 1e-7);
  }
}

TEST(RigCamera, IsOrthographicFromFarAway) {
  for (const Place& place : kPlaces) {
    const BallView far = Camera(scene_of(1e6, 0.0)).view(place.x_m, place.y_m, place.z_m, 0.7);
    const BallView flat = Camera(scene_of(0.0, 0.0)).view(place.x_m, place.y_m, place.z_m, 0.7);
    DOUBLES_EQUAL(1500.0 + 4000.0 * place.x_m, flat.centre_px.x, 1e-9);
    DOUBLES_EQUAL(300.0 + 4000.0 * place.y_m, flat.centre_px.y, 1e-9);
    DOUBLES_EQUAL(4000.0 * 0.0651, flat.diameter_px(), 1e-9);
    DOUBLES_EQUAL(flat.centre_px.x, far.centre_px.x, 1e-4);
    DOUBLES_EQUAL(flat.centre_px.y, far.centre_px.y, 1e-4);
    DOUBLES_EQUAL(flat.diameter_px(), far.diameter_px(), 1e-4);
    DOUBLES_EQUAL(flat.equator_rad, far.equator_rad, 1e-9);
  }
}

TEST(RigCamera, SeesANearerBallLargerAndFartherOut) {
  const Camera camera(scene_of(1.5, 0.0));
  const BallView in_plane = camera.view(0.2, 0.175, 0.0, 0.0);
  const BallView nearer = camera.view(0.2, 0.175, 0.03, 0.0);
  // 1.5/1.47 of the way from the axis, at x = 1500 px; the ellipse's own share, at most (beta² + theta²)/2 or
  // .01, changes by 4 % of itself.
  DOUBLES_EQUAL(1.5 / 1.47, (nearer.centre_px.x - 1500.0) / (in_plane.centre_px.x - 1500.0), 4e-4);
  DOUBLES_EQUAL(1.5 / 1.47, nearer.diameter_px() / in_plane.diameter_px(), 4e-4);
}
