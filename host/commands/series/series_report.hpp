// What `strobe series` prints. Single-threaded.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/reduction/readout.hpp"
#include "host/archive/stored_session.hpp"
#include "host/series/compare.hpp"
#include "host/series/select.hpp"

namespace strobe::host {

struct NamedSession {
  std::string name;  ///< the folder's
  StoredSession session;
};

struct SeriesReportSettings {
  std::vector<std::string> by;
  std::optional<reduction::Quantity> budget;
  std::optional<std::pair<std::string, std::string>> compare;  ///< names of two groups
  std::optional<double> difference;
  int draws = 0;  ///< of each shot, by Monte Carlo; 0: none
  bool all = false, json = false;
};

/// Fails if a group that is to be compared is not there.
Result<void> report_series(const std::vector<NamedSession>& sessions, const SelectedShots& selected,
                           const SeriesReportSettings& settings);

}  // namespace strobe::host
