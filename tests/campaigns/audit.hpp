// Holds what a host has in its session folder against what the firmware has journalled in its own: read by
// bytes, without the product's own bookkeeping. Pure but for reading files.
//
// The newest boot may outlive the host. Of it a host must have what was journalled when the firmware sent the
// newest status that the host has heard: it could not know of more, which counts as "later". Of earlier boots it must
// have everything. Shots that the firmware died in are "cut off": the next boot's firmware must have reported them.
// Of readouts none may come twice, and none without a flag while events of its shot were not yet here.
#pragma once

#include <filesystem>

#include "tests/campaigns/campaign.hpp"

namespace strobe::loss {

/// firmware: the folder of the journals. host: that of the host's logs, in the order of their names.
campaigns::Verdict audit(const std::filesystem::path& firmware, const std::filesystem::path& host);

}  // namespace strobe::loss
