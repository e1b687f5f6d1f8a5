// What the camera says of a ball against the ball's outline, traced point by point through the lens.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "sim/random/draws.hpp"
#include "sim/rig/camera.hpp"
#include "sim/rig/pixels.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sim;
using reduction::PointPx;
using Vector = std::array<double, 3>;

namespace {

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

constexpr std::uint64_t kSeed = 5;

BallView random_view(Draws& draws, double half_px, double flattening) {
  BallView view;
  view.centre_px = {1000.0 * draws.uniform() - 200.0, 1000.0 * draws.uniform() - 200.0};
  view.along_px = half_px * (1.0 + flattening * draws.uniform());
  view.across_px = half_px;
  view.axis_rad = 6.28 * draws.uniform();
  view.equator_rad = 6.28 * draws.uniform();
  return view;
}

double turned(double a, double b) { return std::abs(std::remainder(a - b, std::numbers::pi)); }

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kDistance_px = 8000.0;

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

TEST_GROUP(PixelGrid) { PixelGrid grid; };

TEST(PixelGrid, MeasuresWhatItDrewFarBelowAPixel) {
  // Rounding to 8 bits errs by up to 1/440 of a pixel at each of some 8·r pixels of the outline, at random:
  // sqrt(8·r)/440/sqrt(3)·r/(pi·r²) or 1e-4 px for r = 130 px. The eight lines a row err at the outline's
  // flat top and bottom, by about .2·sqrt(2·r)/8^1.5 px² at each or .004/sqrt(r) px of the centre. Five times
  // that.
  Draws draws(kSeed, Purpose::tablet, 1);
  for (const double half_px : {15.0, 40.0, 130.0}) {
    const double bound = 0.02 / std::sqrt(half_px);
    for (int i = 0; i < 60; ++i) {
      const BallView view = random_view(draws, half_px, 0.05);
      const PixelMeasurement seen = grid.measure(view, {});
      DOUBLES_EQUAL(view.centre_px.x, seen.centre_px.x, bound);
      DOUBLES_EQUAL(view.centre_px.y, seen.centre_px.y, bound);
      DOUBLES_EQUAL(view.diameter_px(), seen.diameter_px, 2.0 * bound);
      CHECK(turned(view.equator_rad, *seen.equator_rad) < 0.1 / half_px);
      CHECK(bound < PixelGrid::error_px(half_px));
    }
  }
}

TEST(PixelGrid, FindsTheMiddleOfABallThatMovedWhileItWasLit) {
  Draws draws(kSeed, Purpose::tablet, 2);
  for (int i = 0; i < 30; ++i) {
    const BallView view = random_view(draws, 60.0, 0.0);
    const PixelMeasurement seen = grid.measure(view, {7.0 * draws.uniform(), -5.0 * draws.uniform(), 0.02});
    DOUBLES_EQUAL(view.centre_px.x, seen.centre_px.x, 1e-3);
    DOUBLES_EQUAL(view.centre_px.y, seen.centre_px.y, 1e-3);
    DOUBLES_EQUAL(view.diameter_px(), seen.diameter_px, 2e-3);  // the light is spread, not lost
    CHECK(turned(view.equator_rad, *seen.equator_rad) < 0.01);
  }
}

TEST(PixelGrid, SpreadsTheEdgeOverTheWayThatTheBallMoves) {
  BallView view{.centre_px = {100.0, 100.0}, .along_px = 30.0, .across_px = 30.0};
  const auto grey = [&] {
    return std::ranges::count_if(grid.picture(), [](std::uint8_t p) { return p > 2 && p < 218; });
  };
  view.equator_rad = 0.0;
  grid.measure(view, {});
  const auto still = grey();
  grid.measure(view, {8.0, 0.0, 0.0});
  // Each row's two edges become 8 px wide.
  CHECK(grey() > still + 2 * 50 * 6);
}

TEST(PixelGrid, DrawsABrightDiscWithADarkBar) {
  const BallView view{.centre_px = {0.0, 0.0}, .along_px = 50.0, .across_px = 50.0, .equator_rad = 0.0};
  grid.measure(view, {});
  const auto& picture = grid.picture();
  LONGS_EQUAL(PixelGrid::kBall, *std::ranges::max_element(picture));
  const auto at = [&](int x, int y) {
    const int left = -grid.width() / 2, bottom = -grid.height() / 2;
    return static_cast<int>(picture[static_cast<std::size_t>((y - bottom) * grid.width() + (x - left))]);
  };
  LONGS_EQUAL(PixelGrid::kBar, at(0, 0));
  LONGS_EQUAL(PixelGrid::kBar, at(25, 0));
  LONGS_EQUAL(PixelGrid::kBall, at(40, 0));
  LONGS_EQUAL(PixelGrid::kBall, at(0, 10));
  LONGS_EQUAL(0, at(52, 0));
  LONGS_EQUAL(0, at(40, 40));
}

TEST(PixelGrid, SeesNoLineOnATinyBall) {
  const BallView view{.centre_px = {0.3, 0.0}, .along_px = 4.0, .across_px = 4.0, .equator_rad = 0.5};
  const PixelMeasurement seen = grid.measure(view, {});
  CHECK(!seen.equator_rad.has_value());
  DOUBLES_EQUAL(0.3, seen.centre_px.x, 0.02);
}

TEST_GROUP(Slant){};

TEST(Slant, IsTheProjectionOntoATurnedSensor) {
  const double a = 0.04;
  const Slant slant(a, 0.0, kDistance_px);
  const double x = 700.0, y = -400.0;
  const double nearer = 1.0 + x * std::tan(a) / kDistance_px;
  const Eigen::Vector2d seen = slant.apply(Eigen::Vector2d(x, y));
  DOUBLES_EQUAL(x / (std::cos(a) * std::cos(a) * nearer), seen.x(), 1e-9);
  DOUBLES_EQUAL(y / (std::cos(a) * nearer), seen.y(), 1e-9);
}

TEST(Slant, LeavesTheFootAndIsUndone) {
  const Slant slant(0.1, -0.07, kDistance_px);
  DOUBLES_EQUAL(0.0, slant.apply(Eigen::Vector2d(0.0, 0.0)).norm(), 1e-9);
  const Eigen::Vector2d place(900.0, 500.0);
  DOUBLES_EQUAL(0.0, (slant.undo(slant.apply(place)) - place).norm(), 1e-9);
  DOUBLES_EQUAL(0.0, (Slant().apply(place) - place).norm(), 0.0);
}

TEST(Slant, TellsTheDerivative) {
  const Slant slant(0.1, -0.07, kDistance_px);
  const Eigen::Vector2d place(900.0, 500.0);
  const double step = 1e-3;  // the second derivative is some 1e-5 a px
  for (const Eigen::Vector2d& way : {Eigen::Vector2d(step, 0.0), Eigen::Vector2d(0.0, step)}) {
    const Eigen::Vector2d difference =
        (slant.apply(Eigen::Vector2d(place + way)) - slant.apply(Eigen::Vector2d(place - way))) /
        (2.0 * step);
    DOUBLES_EQUAL(0.0, (difference - slant.jacobian(place) * way / step).norm(), 1e-7);
  }
}

TEST(Slant, MapsAnEllipseToTheOneThroughItsPointsImages) {
  const Slant slant(0.1, -0.07, kDistance_px);
  const Slant::Ellipse square{{900.0, 500.0}, 140.0, 120.0, 0.5};
  const Slant::Ellipse image = slant.apply(square);
  CHECK(image.along >= image.across);
  for (double t = 0.0; t < 6.28; t += 0.3) {
    const double u = square.along * std::cos(t), v = square.across * std::sin(t);
    const Eigen::Vector2d at = square.centre + Eigen::Vector2d(u * std::cos(0.5) - v * std::sin(0.5),
                                                               u * std::sin(0.5) + v * std::cos(0.5));
    const Eigen::Vector2d from = slant.apply(at) - image.centre;
    const double c = std::cos(image.axis_rad), s = std::sin(image.axis_rad);
    const double p = (from.x() * c + from.y() * s) / image.along,
                 q = (from.y() * c - from.x() * s) / image.across;
    DOUBLES_EQUAL(1.0, p * p + q * q, 1e-9);
  }
}

TEST(Slant, GivesTheSidesOfThePhotographDifferentScales) {
  Scene scene = test::plain_scene();
  scene.camera.distance_m = 2.0;
  const Camera square(scene);
  scene.camera.swing_rad = 2.0 * kDegree;
  const Camera turned(scene);
  const double left =
      turned.view(-0.25, 0.2, 0.0, 0.0).diameter_px() / square.view(-0.25, 0.2, 0.0, 0.0).diameter_px();
  const double right =
      turned.view(0.25, 0.2, 0.0, 0.0).diameter_px() / square.view(0.25, 0.2, 0.0, 0.0).diameter_px();
  // Areas go as (1 + x·tan(a)/L)^-3, diameters as its root.
  DOUBLES_EQUAL(3.0 * 0.25 * std::tan(2.0 * kDegree) / 2.0, std::log(left / right), 1e-4);
  DOUBLES_EQUAL(square.project(0.0, 0.175).x, turned.project(0.0, 0.175).x, 1e-9);
}
