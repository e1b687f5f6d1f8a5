// Scenes with everything in them drawn over wide ranges, for what must hold in any scene.
#pragma once

#include <cstdint>
#include <string>

#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim::test {

struct RandomScene {
  Scene scene;
  ShootSettings settings;
};

/// The same number gives the same scene. Ball, throw and spreads, both contact laws, air, lamps, sensors,
/// camera with lens and pixels, tablet; a flash period with which a leg has some three to ten images.
RandomScene random_scene(std::uint64_t number);

/// The numbers of a scene that differ from the defaults' file, as a TOML file's text.
std::string as_toml(const RandomScene& random);

}  // namespace strobe::sim::test
