#include "sim/photograph/ball_markings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace strobe::sim {

namespace {

// Lengths over the ball's radius.
constexpr double kSoft = 0.01;         // over which ink ends
constexpr double kGroove = 0.008;      // half width of a seam
constexpr double kStitchReach = 0.11;  // of a stitch, from the seam: 4 mm
constexpr double kThread = 0.18;       // half width over the stitches' spacing
constexpr int kSeamPoints = 400;
constexpr int kStitches = 108;
constexpr double kBandRow = 0.014;                     // half width of a row of stitches
constexpr double kBandRows[] = {0.035, 0.105, 0.175};  // and so on either side
constexpr int kBandStitches = 80;                      // of a row
constexpr double kChannel = 0.026;                     // half width: 6.35 mm are the most on a basketball
constexpr double kOval_rad = 0.85;
constexpr int kHoles = 40;
constexpr double kHole = 0.12;  // 9 mm across
constexpr int kDots = 24;
constexpr double kDot = 0.09;

double soft(double distance, double half_width) {
  return std::clamp(0.5 - (distance - half_width) / kSoft, 0.0, 1.0);
}

double length(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// Whether a place along a row is within a stitch.
double dash(double turns, double half_share) {
  return std::abs(turns - std::floor(turns) - 0.5) < half_share ? 1.0 : 0.0;
}

std::vector<Vec3> evenly_spread(int count) {
  std::vector<Vec3> places;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int k = 0; k < count; ++k) {
    const double height = 1.0 - (2.0 * k + 1.0) / count;
    const double flat = std::sqrt(1.0 - height * height);
    places.push_back({flat * std::cos(golden * k), flat * std::sin(golden * k), height});
  }
  return places;
}

/// Over their planes' distances from the centre, so that the nearest panel is that of the largest product. Of
/// the truncated icosahedron with edges of 1 these are 2.3274 for the twelve pentagons, 2.2673 for the
/// hexagons.
std::vector<Vec3> panel_middles() {
  std::vector<Vec3> middles;
  const double golden = std::numbers::phi, vertex = std::sqrt(1.0 + golden * golden);
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-golden, golden}) {
      const double f = 1.0 / (2.3274 * vertex);
      middles.push_back({0.0, f * s, f * t});
      middles.push_back({f * s, f * t, 0.0});
      middles.push_back({f * t, 0.0, f * s});
    }
  }
  const double f = 1.0 / (2.2673 * std::sqrt(3.0));
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-1.0, 1.0}) {
      for (const double u : {-1.0, 1.0}) middles.push_back({f * s, f * t, f * u});
      const double a = f / golden * s, b = f * golden * t;
      middles.push_back({0.0, b, a});
      middles.push_back({b, a, 0.0});
      middles.push_back({a, 0.0, b});
    }
  }
  return middles;
}

double band(const Vec3& p) {
  const double off = std::abs(p.z);
  if (off > 0.3) return 0.0;
  const double along = kBandStitches * std::atan2(p.y, p.x) / (2.0 * std::numbers::pi);
  double ink = 0.0;
  for (const double row : kBandRows) ink = std::max(ink, soft(std::abs(off - row), kBandRow));
  return ink * dash(along, 0.3);
}

/// Two great circles and two ovals, as on a ball of eight panels.
double channels(const Vec3& p) {
  const double oval = std::abs(std::acos(std::min(1.0, std::abs(p.x))) - kOval_rad);
  return soft(std::min({std::abs(p.x), std::abs(p.y), oval}), kChannel);
}

}  // namespace

Vec3 seam_point(double t_rad) {
  constexpr double a = 0.75, b = 0.25;
  return {a * std::cos(t_rad) + b * std::cos(3.0 * t_rad), a * std::sin(t_rad) - b * std::sin(3.0 * t_rad),
          2.0 * std::sqrt(a * b) * std::sin(2.0 * t_rad)};
}

BallMarkings::BallMarkings(BallSurface surface) : surface_(surface) {
  if (surface == BallSurface::panels) places_ = panel_middles();
  if (surface == BallSurface::holes) places_ = evenly_spread(kHoles);
  if (surface == BallSurface::dots) places_ = evenly_spread(kDots);
  if (surface != BallSurface::stitches) return;
  for (int k = 0; k < kSeamPoints; ++k)
    places_.push_back(seam_point(2.0 * std::numbers::pi * k / kSeamPoints));
}

double BallMarkings::ink(const Vec3& direction) const {
  switch (surface_) {
    case BallSurface::stitches:
      return stitches(direction);
    case BallSurface::band:
      return band(direction);
    case BallSurface::panels:
      return panels(direction);
    case BallSurface::channels:
      return channels(direction);
    case BallSurface::holes:
    case BallSurface::dots:
      return spots(direction);
    case BallSurface::felt:
    case BallSurface::plain:
    case BallSurface::dimples:
      break;
  }
  return 0.0;
}

double BallMarkings::stitches(const Vec3& p) const {
  std::size_t nearest = 0;
  double least = 4.0;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const Vec3 off = p - places_[k];
    const double square = dot(off, off);
    if (square >= least) continue;
    least = square;
    nearest = k;
  }
  const Vec3& at = places_[nearest];
  const Vec3& next = places_[(nearest + 1) % places_.size()];
  const Vec3 along = next - at, off = p - at;
  const double step = dot(off, along) / dot(along, along);
  const double aside = length(off - step * along);
  if (aside > kStitchReach + kSoft) return 0.0;
  // They lean, and meet at the seam as a V does.
  const double place = (static_cast<double>(nearest) + step) * kStitches / kSeamPoints;
  const double stitch = dash(place + 0.6 * aside / kStitchReach, kThread) * soft(aside, kStitchReach);
  return std::max(stitch, 0.5 * soft(aside, kGroove));
}

double BallMarkings::panels(const Vec3& p) const {
  constexpr std::size_t kPentagons = 12;
  double most = -1.0, second = -1.0;
  std::size_t panel = 0;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const double nearness = dot(p, places_[k]);
    second = std::max(second, std::min(nearness, most));
    if (nearness <= most) continue;
    most = nearness;
    panel = k;
  }
  if (panel < kPentagons) return 1.0;
  // Two middles are some .7 apart, and as far as that products differ with the distance from their border.
  return 0.6 * soft((most - second) / (0.7 * most), kGroove);
}

double BallMarkings::spots(const Vec3& p) const {
  const double size = surface_ == BallSurface::holes ? kHole : kDot;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& place : places_) nearest = std::min(nearest, length(p - place));
  return soft(nearest, size);
}

double BallMarkings::edge_beyond(const Vec3& on_outline, const Vec3& to_lens) const {
  if (surface_ != BallSurface::holes) return 1.0;
  constexpr double kStep_rad = 0.005;
  for (double angle = 0.0; angle < 2.5 * kHole; angle += kStep_rad) {
    const Vec3 out = std::cos(angle) * on_outline, towards = std::sin(angle) * to_lens;
    if (ink(out + towards) < 0.5 || ink(out - towards) < 0.5) return std::cos(angle);
  }
  return 1.0;
}

}  // namespace strobe::sim
