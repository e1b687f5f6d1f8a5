// A calibration board seen by a scene's camera, as a lab photographs one before its balls. Pure; thread-safe.
#pragma once

#include "sim/photograph/board.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

struct BoardView {
  BoardCamera camera;  ///< the scene's: size, scale, the lens's place and distortion
  BoardPlace place;    ///< in the balls' plane, in the middle of the photograph
};

/// A scene whose lens is infinitely far away gets one that is 100 m away: perspective then moves a ball's outline by less
/// than a thousandth of its diameter.
BoardView board_view(const Scene& scene);

}  // namespace strobe::sim
