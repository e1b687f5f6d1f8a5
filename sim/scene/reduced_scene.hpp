// What a model leaves of a scene: the keys of the effects that are off take the values at which they do
// nothing. Numbers drawn for a shot stay the same, since a spread of zero takes its draw as well. The effects
// that no key can turn off (gravity, and those of the contact) are for BallPath to leave out.
// Pure; thread-safe; copies the scene.
#pragma once

#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

Scene reduced_scene(const Scene& scene, const Model& model);

}  // namespace strobe::sim
