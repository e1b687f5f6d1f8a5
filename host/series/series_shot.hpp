// One shot as a series takes it: its readout, what its uncertainty is made of, and whose errors it shares. Plain values;
// thread-safe.
#pragma once

#include <optional>
#include <string>

#include "common/reduction/uncertainty.hpp"
#include "common/reduction/readout.hpp"

namespace strobe::host {

struct SeriesShot {
  std::string name;     ///< StoredShot::name
  std::string session;  ///< its folder's name; empty where there is one session only
  reduction::Readout readout;
  reduction::Budget budget;
  /// What its scale and map came from, and its ball: shots with the same text share the errors of it. Empty: likewise.
  std::string calibration, ball;
  std::optional<std::string> rejected;  ///< why it does not count

  /// "3", or "run1:3" where there are several sessions.
  std::string full_name() const { return session.empty() ? name : session + ":" + name; }
};

}  // namespace strobe::host
