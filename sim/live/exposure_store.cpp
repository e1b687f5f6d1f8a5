#include "sim/live/exposure_store.hpp"

namespace strobe::sim {

void ExposureStore::add(Exposure exposure) {
  auto kept = std::make_shared<const Exposure>(std::move(exposure));
  const std::lock_guard lock(mutex_);
  exposures_.push_back(std::move(kept));
}

void ExposureStore::set_exposing(std::optional<MonoTime> since) {
  const std::lock_guard lock(mutex_);
  exposing_since_ = since;
}

ExposureStore::Found ExposureStore::begun_within(MonoTime earliest, MonoTime latest) const {
  const std::lock_guard lock(mutex_);
  for (const auto& exposure : exposures_) {
    if (exposure->line_on >= earliest && exposure->line_on <= latest) return {exposure, false};
  }
  const bool under_way = exposing_since_ && *exposing_since_ >= earliest && *exposing_since_ <= latest;
  return {nullptr, under_way};
}

std::vector<std::shared_ptr<const Exposure>> ExposureStore::all() const {
  const std::lock_guard lock(mutex_);
  return exposures_;
}

}  // namespace strobe::sim
