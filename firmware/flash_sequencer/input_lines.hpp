// Which of the rig's inputs each of a flash sequencer's is.
#pragma once

#include <algorithm>
#include <array>

#include "common/flash_sequencer/protocol.hpp"
#include "firmware/ports/edge_source.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

struct SequencerInput {
  Input input;
  Line line;
};

/// By InputLine.
inline constexpr std::array<SequencerInput, flash_sequencer::kInputCount> kSequencerInputs{
    {{Input::key, Line::key},
     {Input::estop, Line::estop},
     {Input::sensor_a, Line::sensor_a},
     {Input::sensor_b, Line::sensor_b},
     {Input::gate, Line::gate},
     {Input::xsync, Line::xsync}}};

constexpr flash_sequencer::InputLine input_line_of(Input input) {
  const auto* const found = std::find_if(kSequencerInputs.begin(), kSequencerInputs.end(),
                                         [input](const SequencerInput& each) { return each.input == input; });
  return static_cast<flash_sequencer::InputLine>(found - kSequencerInputs.begin());
}

}  // namespace strobe::firmware
