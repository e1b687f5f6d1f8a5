// The chip of the strobe rig, as the tests and the little host program make it.
#pragma once

#include "sim/gpiochip/chip.hpp"

namespace strobe::sim {

inline ChipSpec standard_chip() {
  ChipSpec spec;
  for (const char* name :
       {"STROBE_A", "STROBE_B", "SHUTTER", "TRIGGER", "SENSOR_A", "SENSOR_B", "GATE", "KEY", "ESTOP"})
    spec.lines.push_back({.name = name});
  for (int i = 9; i < 16; ++i) spec.lines.push_back({.name = "SPARE_" + std::to_string(i)});
  spec.lines[7].idle_level = 1;  // key turned on
  spec.lines[8].idle_level = 1;  // emergency stop not pressed
  return spec;
}

}  // namespace strobe::sim
