// The ball's size on a photograph of unknown scale: circles of any size are sought, and those that are seen for
// more than half of their circumference vote for theirs. Arcs of several things, texture and what is drawn on a
// ball support less than that of a circle. Deterministic for any number of threads; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// A circle's vote: 0 for half of it seen or less, 1 for all.
double whole_circle_vote(const Candidate& circle);

/// Circles that have a vote, best first, with diameters from `least_px` or less to `most_px` [image px], but at least
/// 20 px and at most .6 of the photograph's shorter side. Radii are good to 3 %.
std::vector<Candidate> find_whole_circles(const Photograph& photograph, double least_px = 0.0,
                                          double most_px = 1e9);

struct SizeVotes {
  double diameter_px = 0.0;              ///< plane px
  double votes = 0.0;                    ///< of the circles whose size is within kSizeSpread of it
  int circles = 0;                       ///< that voted for it
  double least_px = 0.0, most_px = 0.0;  ///< their diameters
};

/// Real sizes on one photograph differ by ±10 %, as the path comes nearer.
inline constexpr double kSizeSpread = 0.12;

/// The size with the most votes. Returns nullopt if none has as many as one circle seen for three quarters.
std::optional<SizeVotes> most_voted_size(std::span<const Candidate> circles, const PlaneMap& map);

/// Votes for diameters from `min_px` to `max_px` [plane px] by circles that did not vote for the other size.
double votes_beside(const SizeVotes& other, std::span<const Candidate> circles, const PlaneMap& map,
                    double min_px, double max_px);

}  // namespace strobe::digitize
