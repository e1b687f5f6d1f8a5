#include "sim/plan/corners.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

/// Bits of a run's number whose parity is the sign of each spread: independent columns of a Hadamard matrix.
constexpr std::array<unsigned, kSpreadCount> kColumns{0b0001, 0b0010, 0b0100, 0b1000, 0b0111,
                                                      0b1011, 0b1101, 0b1110, 0b1111};
constexpr unsigned kRuns = 16;
constexpr std::array<int, kSpreadCount> kPrimes{2, 3, 5, 7, 11, 13, 17, 19, 23};

std::array<bool, kSpreadCount> spreads_of(const Scene& scene) {
  const MachineSettings& m = scene.machine;
  const BounceSettings& b = scene.bounce;
  const bool ode = b.contact == ContactLaw::ode;
  return {m.speed_sd_mps > 0.0,
          m.angle_sd_rad > 0.0,
          m.spin_sd_radps > 0.0,
          b.e_sd > 0.0,
          b.mu_sd > 0.0 || b.stiffness_ratio_sd > 0.0 || b.ex_sd > 0.0,
          ode ? b.offset_share_sd > 0.0 : b.offset_sd_m > 0.0,
          b.dwell_sd_s > 0.0,
          m.spot_sd_m > 0.0,
          scene.camera.distance_m > 0.0 && scene.camera.off_plane_sd_m > 0.0};
}

bool odd(unsigned bits) { return std::popcount(bits) % 2 == 1; }

double radical_inverse(int index, int base) {
  double share = 1.0;
  double result = 0.0;
  for (int i = index; i > 0; i /= base) {
    share /= base;
    result += share * (i % base);
  }
  return result;
}

void add(std::vector<Corner>& all, const Corner& corner) {
  const auto same = [&](const Corner& other) { return other.z == corner.z; };
  if (std::ranges::none_of(all, same)) all.push_back(corner);
}

}  // namespace

std::vector<Corner> corners(const Scene& scene) {
  const auto spread = spreads_of(scene);
  std::vector<Corner> all(1);
  for (const double z : {-kLargestNormal, kLargestNormal}) {
    for (std::size_t s = 0; s < kSpreadCount; ++s) {
      Corner face;
      if (spread[s]) face.z[s] = z;
      add(all, face);
    }
    for (unsigned run = 0; run < kRuns; ++run) {
      Corner corner;
      for (std::size_t s = 0; s < kSpreadCount; ++s) {
        if (spread[s]) corner.z[s] = odd(run & kColumns[s]) ? -z : z;
      }
      add(all, corner);
    }
  }
  return all;
}

std::vector<Corner> inside(const Scene& scene, int count) {
  const auto spread = spreads_of(scene);
  std::vector<Corner> all;
  if (std::ranges::none_of(spread, [](bool has) { return has; })) return all;
  for (int i = 1; i <= count; ++i) {
    Corner point;
    for (std::size_t s = 0; s < kSpreadCount; ++s) {
      if (spread[s]) point.z[s] = kLargestNormal * (2.0 * radical_inverse(i, kPrimes[s]) - 1.0);
    }
    all.push_back(point);
  }
  return all;
}

ShotConditions shot_conditions_at(const Scene& scene, const Corner& corner) {
  // Draws are put into the means, so that only one function turns draws into a shot.
  Scene moved = without_spread(scene);
  const MachineSettings& m = scene.machine;
  moved.machine.speed_mps += m.speed_sd_mps * corner[Spread::speed];
  moved.machine.angle_rad += m.angle_sd_rad * corner[Spread::angle];
  moved.machine.spin_radps += m.spin_sd_radps * corner[Spread::spin];
  const BounceSettings& b = scene.bounce;
  moved.bounce.e += b.e_sd * corner[Spread::e];
  moved.bounce.mu += b.mu_sd * corner[Spread::friction];
  moved.bounce.ex += b.ex_sd * corner[Spread::friction];
  moved.bounce.stiffness_ratio += b.stiffness_ratio_sd * corner[Spread::friction];
  const double rho = b.offset_grip_correlation;
  const double offset = rho * corner[Spread::friction] + std::sqrt(1.0 - rho * rho) * corner[Spread::offset];
  moved.bounce.offset_m += b.offset_sd_m * offset;
  moved.bounce.offset_share += b.offset_share_sd * offset;
  moved.bounce.dwell_s =
      std::clamp(b.dwell_s + b.dwell_sd_s * corner[Spread::dwell], 0.5 * b.dwell_s, 1.5 * b.dwell_s);
  ShotConditions thrown = draw_shot_conditions(moved, 1, 1);
  // Any angle will do; a different one at each corner.
  double turns = 0.0;
  for (std::size_t s = 0; s < kSpreadCount; ++s) turns += corner.z[s] * 0.1 * static_cast<double>(kPrimes[s]);
  thrown.equator_rad = std::numbers::pi * (turns - std::floor(turns));
  thrown.spot_m = m.spot_sd_m * corner[Spread::spot];
  thrown.off_plane_m = scene.camera.off_plane_sd_m * corner[Spread::off_plane];
  return thrown;
}

}  // namespace strobe::sim
