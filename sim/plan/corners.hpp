// Representative shots of a scene: draws are bounded (kLargestNormal), so all shots lie in a box of draws.
// Its centre, the centres of its faces and a balanced choice of its corners represent it. Deterministic;
// thread-safe; allocates.
#pragma once

#include <array>
#include <vector>

#include "sim/motion/ball_path.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// The numbers drawn for a shot, in a corner's order.
enum class Spread { speed, angle, spin, e, friction, offset, dwell, spot, off_plane };
inline constexpr std::size_t kSpreadCount = 9;

/// Draws in standard deviations, -kLargestNormal…kLargestNormal.
struct Corner {
  std::array<double, kSpreadCount> z{};
  double operator[](Spread s) const { return z[static_cast<std::size_t>(s)]; }
};

/// The middle first. Spreads that the scene does not have stay 0 and add no corners. For all nine: the
/// middle, 18 faces and 32 corners, a two-level design of 16 runs and its mirror image, in which every pair
/// of spreads occurs in all four combinations.
std::vector<Corner> corners(const Scene& scene);

/// Further points of the box, spread evenly (Halton's sequence), for what need not be largest at a corner.
std::vector<Corner> inside(const Scene& scene, int count);

/// The conditions of the shot with these draws.
ShotConditions shot_conditions_at(const Scene& scene, const Corner& corner);

}  // namespace strobe::sim
