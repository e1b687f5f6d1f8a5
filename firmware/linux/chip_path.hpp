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

/// What a user does to whom a chip is forbidden.
inline constexpr const char* kAllowUser = "the user must be allowed to open it, e.g. by the group gpio";

/// Whether it is a label: no path, name ("gpiochip0") or number ("0").
bool is_chip_label(const std::string& which);

/// The path; for a label among these nodes, that are needed for nothing else. Fails with a line of words if no chip
/// has the label, or several have.
Result<std::string> chip_path(const std::string& which, const std::vector<ChipNode>& nodes);

/// The USB port of a chip such as "gpiochip0", e.g. "1-2"; empty if it is on none.
std::string usb_port_of(const std::string& chip, const SystemFiles& files);

}  // namespace strobe::firmware
