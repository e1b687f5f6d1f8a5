// The light across the limbs of the balls on a photograph, sector by sector: how wide the edge is, in which
// direction, and by how much the ball is brighter than what is behind it. Of each sector the pixels' means
// over half a pixel of depth are fitted by the digitizer's profile of a blurred limb
// (host/digitize/outline/edge_profile.hpp), with a place and a width of their own. Sectors that another
// image's limb or the border of the photograph crosses are left out; light of images adds up, so that within
// another image a limb is as good as beside it. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::light {

struct LimbSector {
  std::size_t outline = 0;   ///< index
  double normal_rad = 0.0;   ///< direction out of the ball, plane, counter-clockwise from +x
  double rise = 0.0;         ///< of light, from outside to 6 px inside, as Photograph::intensity has it
  bool clear = false;        ///< of all other images; what follows is then of the background
  double outside = 0.0;      ///< light
  double black_share = 0.0;  ///< of the pixels outside: those at the number 0
  struct Edge {
    double blur_px = 0.0, sd_px = 0.0;  ///< sd of the edge's blur, > 0; its uncertainty from the residuals
  };
  std::optional<Edge> edge;  ///< absent: too faint, or the digitizer did not see it there
};

std::vector<LimbSector> limb_sectors(const digitize::Photograph& photograph, const digitize::PlaneMap& map,
                                     std::span<const digitize::Outline> outlines);

}  // namespace strobe::light
