// `strobed --check` on a flash sequencer.
#pragma once

#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/flash_sequencer/link.hpp"
#include "firmware/linux/check_item.hpp"
#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

/// How long answers take, of a connected link: adapters from USB may hold them back for milliseconds.
CheckItem answer_times(FlashSequencerLink& link, Clock& clock);

/// The kernel hands over what comes by a serial line, replies too, with an ordinary worker: whether that may
/// run on the loop's CPU, where whatever stops the loop stops it as well.
CheckItem replies_item(const Rig& rig, const SystemFiles& files);

/// sequencer.port, how fast it answers, its clock, what hands its replies over, and what its inputs read.
/// Makes the sequencer cut its outputs. Takes a second at most if it answers.
std::vector<CheckItem> inspect_flash_sequencer(const Rig& rig);

}  // namespace strobe::firmware
