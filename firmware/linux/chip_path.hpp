// Which /dev/gpiochipN a rig file means: numbers move between kernels, labels do not. Set-up only, not real-time.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

struct ChipNode {
  std::string path;
  std::string label;
  int error = 0;  ///< an errno, if its label cannot be read
};
/// Every GPIO chip of this machine, by number; links to one (Raspberry Pi OS has some) are left out.
std::vector<ChipNode> chip_nodes();

/// The path for a path, name ("gpiochip0"), number ("0") or label. Fails with a line of words if no chip has the label,
/// or several have.
Result<std::string> chip_path(const std::string& which, const std::vector<ChipNode>& nodes);

/// The USB port of a chip such as "gpiochip0", e.g. "1-2"; empty if it is on none.
std::string usb_port_of(const std::string& chip, const SystemFiles& files);

}  // namespace strobe::firmware
