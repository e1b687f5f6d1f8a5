// A scene with the effects removed that a model leaves out: their keys take the values at which they have no
// effect. The other numbers drawn for a shot stay the same, since a spread of zero takes its draw as well.
// Effects that no key can turn off (gravity, and those of the contact) are left out by BallPath. Pure;
// thread-safe; copies the scene.
#pragma once

#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

Scene reduced_scene(const Scene& scene, const Model& model);

}  // namespace strobe::sim
