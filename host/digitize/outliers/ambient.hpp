// The room's light on the ball between two flashes: it draws the ball's way as a band, even or, where lamps
// flicker, of many discs. A band is told from what is behind the ball by both its sides: it is brighter than
// either, where two flashes' images leave it free. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// An image of the ball on the photograph, image px.
struct ImageDisc {
  cv::Point2d centre;
  double radius = 0.0;
  bool airborne = true;  ///< unless the caller says otherwise
  double blur_px = 0.0;  ///< sd of its limb's
};

ImageDisc image_disc(const PlaneMap& map, const Outline& outline);

/// Indices of two discs of one leg, the one flash after the other; not at one place.
struct Flight {
  std::size_t from = 0, to = 0;
};

/// Light of the band over the brighter of its sides, in that of one image of the ball over the mean of its
/// sides, both as they pass a place in the middle of the way; 0 if it is darker. Absent: fewer than three
/// flights show enough of it before a background that is alike on both sides. One of three may hold an image
/// that was not found, or pass something bright.
std::optional<double> ambient_share(const Photograph& photograph, std::span<const ImageDisc> discs,
                                    std::span<const Flight> flights);

}  // namespace strobe::digitize
