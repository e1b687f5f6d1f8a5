#include "sim/rig/camera.hpp"

#include <cmath>
#include <numbers>

#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::sim;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kDistance_px = 8000.0;

}  // namespace

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
