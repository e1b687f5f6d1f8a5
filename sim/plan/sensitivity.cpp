#include "sim/plan/sensitivity.hpp"

#include <cmath>
#include <limits>

namespace strobe::sim {

namespace {

constexpr std::array<double, kCoordinateCount> kSteps{1e-5, 1e-5, 1e-5, 1e-4, 1e-6};

std::array<double, kCoordinateCount> members(const Displacement& d) {
  return {d.x_m, d.y_m, d.diameter_m, d.equator_rad, d.time_s};
}

/// Unit vector along the surface, the sign of its direction, and the scale.
struct Axes {
  double cos = 1.0;
  double sin = 0.0;
  double side = 1.0;
  double px_per_m = 1.0;
};

Axes axes_of(const reduction::Frame& frame, bool mirrored) {
  const reduction::PointPx& a = frame.surface_px.front();
  const reduction::PointPx& b = frame.surface_px.back();
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  return {(b.x - a.x) / length, (b.y - a.y) / length, mirrored ? -1.0 : 1.0,
          frame.images.front().diameter_px / frame.ball_diameter_m};
}

void move(reduction::PointPx& point, double along_m, double across_m, const Axes& axes) {
  const double right_m = axes.side * along_m;
  point.x += (axes.cos * right_m - axes.sin * across_m) * axes.px_per_m;
  point.y += (axes.sin * right_m + axes.cos * across_m) * axes.px_per_m;
}

void displace(reduction::BallImage& image, Coordinate coordinate, const Axes& axes) {
  const double step = kSteps[static_cast<std::size_t>(coordinate)];
  switch (coordinate) {
    case Coordinate::x:
      return move(image.centre_px, step, 0.0, axes);
    case Coordinate::y:
      return move(image.centre_px, 0.0, step, axes);
    case Coordinate::diameter:
      image.diameter_px += step * axes.px_per_m;
      return;
    case Coordinate::equator:
      if (image.equator_rad) *image.equator_rad += axes.side * step;
      return;
    case Coordinate::time:
      image.time_s += step;
      return;
  }
}

using Derivatives = std::array<double, reduction::kQuantityCount>;

Derivatives slopes(const reduction::Frame& moved, const reduction::Quantities& from, double step) {
  const reduction::Quantities to = readout_of(moved);
  Derivatives result{};
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto q = static_cast<reduction::Quantity>(i);
    if (to[q] && from[q]) result[i] = (*to[q] - *from[q]) / step;
    if (to[q].has_value() != from[q].has_value()) result[i] = std::numeric_limits<double>::quiet_NaN();
  }
  return result;
}

/// What is known of one coordinate's displacement adds up with the others', the rest at its worst.
struct Sum {
  Derivatives known{};
  Derivatives rest{};

  void add(const Derivatives& slopes, double by, double within) {
    if (by == 0.0 && within == 0.0) return;
    for (std::size_t q = 0; q < slopes.size(); ++q) {
      if (slopes[q] == 0.0) continue;
      known[q] += slopes[q] * by;
      rest[q] += std::abs(slopes[q]) * within;
    }
  }

  PerQuantity total() const {
    PerQuantity result;
    for (std::size_t q = 0; q < known.size(); ++q) {
      const double size = std::abs(known[q]) + rest[q];
      result[q] = std::isnan(size) ? std::numeric_limits<double>::infinity() : size;
    }
    return result;
  }
};

}  // namespace

Sensitivity::Sensitivity(const reduction::Frame& frame, bool mirrored, const CoordinateMask& wanted)
    : readout_(readout_of(frame)), images_(frame.images.size()), surface_(frame.surface_px.size()) {
  if (frame.images.empty()) return;
  const Axes axes = axes_of(frame, mirrored);
  reduction::Frame moved = frame;
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    if (frame.images[i].leg == reduction::Leg::contact) continue;
    for (std::size_t c = 0; c < kCoordinateCount; ++c) {
      if (!wanted[c]) continue;
      displace(moved.images[i], static_cast<Coordinate>(c), axes);
      images_[i][c] = slopes(moved, readout_, kSteps[c]);
      moved.images[i] = frame.images[i];
    }
  }
  for (std::size_t i = 0; i < frame.surface_px.size(); ++i) {
    for (std::size_t c = 0; c < 2; ++c) {
      move(moved.surface_px[i], c == 0 ? kSteps[c] : 0.0, c == 1 ? kSteps[c] : 0.0, axes);
      surface_[i][c] = slopes(moved, readout_, kSteps[c]);
      moved.surface_px[i] = frame.surface_px[i];
    }
  }
}

PerQuantity Sensitivity::propagated(std::span<const BoundedDisplacement> images,
                                    std::span<const BoundedDisplacement> surface) const {
  Sum sum;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const auto by = members(images[i].by);
    const auto within = members(images[i].within);
    for (std::size_t c = 0; c < kCoordinateCount; ++c) sum.add(images_[i][c], by[c], within[c]);
  }
  for (std::size_t i = 0; i < surface.size(); ++i) {
    sum.add(surface_[i][0], surface[i].by.x_m, surface[i].within.x_m);
    sum.add(surface_[i][1], surface[i].by.y_m, surface[i].within.y_m);
  }
  return sum.total();
}

}  // namespace strobe::sim
