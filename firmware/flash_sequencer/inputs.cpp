#include "firmware/flash_sequencer/inputs.hpp"

#include <algorithm>

#include "firmware/flash_sequencer/input_lines.hpp"

namespace strobe::firmware {

std::optional<std::size_t> FlashSequencerInputs::wait(MonoTime until, std::span<Edge> edges) noexcept {
  link_.wait(link_.has_edges() ? MonoTime{} : until);
  return take(edges);
}

std::optional<std::size_t> FlashSequencerInputs::poll(MonoTime until, std::span<Edge> edges) noexcept {
  link_.poll(link_.has_edges() ? MonoTime{} : until);
  return take(edges);
}

std::optional<std::size_t> FlashSequencerInputs::take(std::span<Edge> edges) noexcept {
  if (!link_.take()) {
    clock_.spin_until(clock_.now() + milliseconds(1));  // what is gone never sleeps: do not turn in haste
    return std::nullopt;
  }
  std::size_t count = 0;
  flash_sequencer::InputEdge edge;
  // An edge of a clock that is not known is of no use.
  while (count < edges.size() && link_.take_edge(edge)) {
    const SequencerInput& which = kSequencerInputs[static_cast<std::size_t>(edge.line)];
    if (!rig_.line(which.line).fitted || !link_.clock_relation().known()) continue;
    const bool sensor = which.input == Input::sensor_a || which.input == Input::sensor_b;
    if (witness_ != nullptr && sensor) witness_->note(which.input, edge.time);
    edges[count++] = {which.input, link_.clock_relation().to_time(edge.time), edge.active != 0};
  }
  if (witness_ != nullptr) witness_->look();
  std::sort(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Edge& a, const Edge& b) { return a.time < b.time; });
  return count;
}

std::optional<bool> FlashSequencerInputs::level(Input input) noexcept {
  if (!link_.take() || link_.silence() > FlashSequencerLink::kFresh) return std::nullopt;
  return (link_.inputs() & flash_sequencer::bit(input_line_of(input))) != 0;
}

}  // namespace strobe::firmware
