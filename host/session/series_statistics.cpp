#include "host/session/series_statistics.hpp"

namespace strobe::host {

void SeriesStatistics::add(const reduction::Readout& readout) {
  ++shots_;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    if (const auto& value = readout.value[static_cast<reduction::Quantity>(i)]) series_[i].add(*value);
  }
}

}  // namespace strobe::host
