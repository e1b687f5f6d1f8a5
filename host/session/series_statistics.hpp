// Mean, spread and number of each quantity over the shots of a series that are not rejected, as the thesis's
// Tables 2-10 give them. No I/O; single-threaded.
#pragma once

#include <array>

#include "common/reduction/readout.hpp"
#include "common/reduction/running_statistics.hpp"

namespace strobe::host {

class SeriesStatistics {
 public:
  /// A number that a readout does not have is left out of that quantity's n.
  void add(const reduction::Readout& readout);

  int shots() const { return shots_; }
  const reduction::RunningStatistics& of(reduction::Quantity quantity) const {
    return series_[static_cast<std::size_t>(quantity)];
  }

 private:
  int shots_ = 0;
  std::array<reduction::RunningStatistics, reduction::kQuantityCount> series_;
};

}  // namespace strobe::host
