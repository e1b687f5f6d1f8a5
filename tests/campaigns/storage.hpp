// One fault of the disk, drawn from a seed, while a host stores something; and the verdict: nothing that was told
// as stored is missing, nothing stored before is lost, every loss was told, within a second, and no shot was fired
// after that. Deterministic in the seed. One at a time.
#pragma once

#include <filesystem>
#include <string>

#include "tests/campaigns/campaign.hpp"
#include "tests/campaigns/disk_faults.hpp"

namespace strobe::storage {

struct Trial {
  std::string target;        ///< what is stored: "session", "replaced file", "copied file", "key"
  testing::DiskFault fault;  ///< folder is filled in by run_trial()
};

Trial drawn(campaigns::Draws draws);

/// Counts how it ended: "not reached", the call was not made so often; "harmless", all is stored, nothing had to be told;
/// "refused", told at the start, nothing was begun, nothing touched; "told, stored after all", and the series ended; "told,
/// unstored named", the series ended, and what is missing was named. Its words are the first line told.
campaigns::Verdict run_trial(Trial trial);

/// Of a session: a series of three shots in a folder that holds an earlier one.
campaigns::Verdict run_session(const std::filesystem::path& folder, const testing::DiskFault& fault);

}  // namespace strobe::storage
