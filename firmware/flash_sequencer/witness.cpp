#include "firmware/flash_sequencer/witness.hpp"

namespace strobe::firmware {

namespace {

constexpr std::size_t sensor_index(Input input) { return input == Input::sensor_a ? 0 : 1; }

}  // namespace

void Witness::note(Input sensor, flash_sequencer::Ticks stamp) noexcept {
  sequencers_[sensor_index(sensor)].push(stamp);
}

void Witness::look() noexcept {
  std::array<Edge, kRoom> edges;
  const auto count = kernel_.poll(MonoTime{}, edges);  // a witness that fails is done without
  for (std::size_t i = 0; i < count.value_or(0); ++i)
    kernels_[sensor_index(edges[i].input)].push(edges[i].time);
  for (std::size_t sensor = 0; sensor < kSensors; ++sensor) pair(sensor);
}

void Witness::pair(std::size_t sensor) noexcept {
  auto& ours = sequencers_[sensor];
  auto& kernels = kernels_[sensor];
  while (ours.count > 0 && kernels.count > 0) {
    const Duration apart = kernels.front() - link_.clock_relation().to_time(ours.front());
    if (apart > kFarthest) {
      ours.pop();
    } else if (apart < -kFarthest) {
      kernels.pop();
    } else {
      link_.witness(ours.front(), kernels.front());
      ours.pop();
      kernels.pop();
    }
  }
}

}  // namespace strobe::firmware
