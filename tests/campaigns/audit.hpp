// Holds what a host has in its session folder against what the firmware has journalled in its own: read by
// bytes, without the product's own bookkeeping. Pure but for reading files.
//
// The newest boot may outlive the host. Of it a host must have what was journalled when the firmware sent the
// newest status that the host has heard: it could not know of more. Of earlier boots it must have everything.
#pragma once

#include <filesystem>

#include "tests/campaigns/campaign.hpp"

namespace strobe::loss {

struct Audit : campaigns::Verdict {
  int boots = 0;
  std::int64_t journalled = 0;   ///< events in the journals
  std::int64_t missing = 0;      ///< of them, on no host in the end
  std::int64_t later = 0;        ///< of them, journalled after the newest status that a host has heard
  std::int64_t torn = 0;         ///< bytes in journals that belong to no whole record
  int shots = 0;                 ///< summaries in the journals
  int shots_missing = 0;         ///< of them, on no host in the end
  int cut_off = 0;               ///< shots without a summary, since the firmware died in them
  int cut_off_reported = 0;      ///< of them, reported by the next boot's firmware, or read out with a flag
  int readouts = 0;              ///< published by a host
  int flagged = 0;               ///< of them, with events_missing
  int twice = 0;                 ///< shots that were read out more than once
  int incomplete_unflagged = 0;  ///< readouts without that flag when events of their shot were not yet here
};

/// firmware: the folder of the journals. host: that of the host's logs, in the order of their names.
Audit audit(const std::filesystem::path& firmware, const std::filesystem::path& host);

}  // namespace strobe::loss
