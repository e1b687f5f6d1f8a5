// The chip and lines that a rig file names, found or told in words that name the file's line and key. Set-up
// only, not real-time.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/gpio/gpio_chip.hpp"
#include "firmware/linux/system_files.hpp"

namespace strobe::firmware {

/// "FILE:LINE: KEY: ", with which an error begins.
std::string place(const Rig& rig, std::uint32_t line, const std::string& key);
/// `what` after the file's name, the line's place there, and its key.
std::string line_message(const Rig& rig, Line which, const std::string& what);
/// The same as an error.
tl::unexpected<Error> line_failure(const Rig& rig, Line which, const std::string& what);
Result<GpioChip> open_chip(const Rig& rig);
/// Its offset on the chip.
Result<unsigned> find_line(const GpioChip& chip, const Rig& rig, Line which);
/// Why a line could not be taken, an errno, and by whom it is used.
std::string request_error(const GpioChip& chip, unsigned offset, int error);

/// One of this machine's chips. Which of them a rig file means: numbers move between kernels, labels do not.
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

/// The path; for a label among these nodes, that are needed for nothing else. Fails with a line of words if
/// no chip has the label, or several have.
Result<std::string> chip_path(const std::string& which, const std::vector<ChipNode>& nodes);

/// The USB port of a chip such as "gpiochip0", e.g. "1-2"; empty if it is on none.
std::string usb_port_of(const std::string& chip, const SystemFiles& files);

}  // namespace strobe::firmware
