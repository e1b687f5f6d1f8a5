// How often the 95 % intervals of series hold the truth: simulated series in pairs that share a calibration, a ball and an
// air, each of which is wrong by a draw of what is known of it. Deterministic from the seed, whatever the number of threads.
// Thread-safe; allocates.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::studies {

struct SeriesPlan {
  int series = 8000;  ///< in pairs
  int shots = 9;      ///< of each
  std::uint64_t seed = 1;
  int threads = 2;
  double scale_sd = 0.003;  ///< relative
  double ball_diameter_sd_m = 0.0003;
  std::vector<sim::Scene> scenes;  ///< conditions, two or more; a pair's are neighbours
};

/// Of one quantity: how many intervals there were, and how many held the truth.
struct Held {
  int intervals = 0, held = 0;
  double shared = 0.0;  ///< sum over the intervals of the shared part's share of the variance
  void add(double error, double half_width, double shared_share);
  void add(const Held& other);
  double share() const { return intervals > 0 ? static_cast<double>(held) / intervals : 0.0; }
};

struct SeriesCoverage {
  std::array<Held, reduction::kQuantityCount> means{}, differences{};
  /// The means with the interval that the scatter alone would have, as if nothing were shared.
  std::array<Held, reduction::kQuantityCount> by_scatter{};
  int rejected = 0;
};

/// `done` counts pairs, for a progress display. Fails only for a scene that cannot be shot.
SeriesCoverage run(const SeriesPlan& plan, std::atomic<int>& done);

/// Series that end as soon as a mean is known well enough (host/series/sequential.hpp). The wanted half widths are such
/// that so many shots would do if the scatter were known.
inline constexpr std::array<double, 4> kShotsIfKnown{3.0, 8.0, 15.0, 30.0};
inline constexpr int kMaxSequentialShots = 300;
struct SequentialSeries {
  int not_known = 0;       ///< by kMaxSequentialShots shots, or never; left out
  double shots = 0.0;      ///< sum
  Held sequential, plain;  ///< intervals by the rule, and Student's of the same shots
};

/// Index: kShotsIfKnown. Each series wants one quantity of kSequentialQuantities, in turn. `done` counts series.
inline constexpr std::array kSequentialQuantities{reduction::Quantity::e, reduction::Quantity::mu,
                                                  reduction::Quantity::vx_lo_mps, reduction::Quantity::omega_lo_radps,
                                                  reduction::Quantity::theta_out_deg};
std::array<SequentialSeries, kShotsIfKnown.size()> run_sequential(const SeriesPlan& plan, std::atomic<int>& done);

}  // namespace strobe::studies
