#include "firmware/linux/inspect_lines.hpp"

#include <cerrno>

#include "firmware/linux/input_bias.hpp"
#include "firmware/linux/rig_lines.hpp"

namespace strobe::firmware {

namespace {

using Verdict = CheckItem::Verdict;

void inspect_line(GpioChip& chip, const Rig& rig, Line which, std::vector<CheckItem>& items) {
  CheckItem item{std::string("lines.") + line_key(which), Verdict::ok, ""};
  const auto offset = find_line(chip, rig, which);
  if (!offset) {
    item = {item.name, Verdict::fault, offset.error().message};
  } else if (chip.user_of(*offset)) {
    item = {item.name, Verdict::fault, line_message(rig, which, request_error(chip, *offset, EBUSY))};
  }
  items.push_back(item);
  if (item.verdict != Verdict::ok) return;
  for (CheckItem& bias : try_bias(chip, rig, which, *offset)) items.push_back(std::move(bias));
}

CheckItem bus_of(const GpioChip& chip, const SystemFiles& files) {
  const std::string port = usb_port_of(chip.name(), files);
  if (port.empty()) return {"chip.bus", Verdict::ok, "not USB"};
  return {
      "chip.bus", Verdict::advice,
      "USB (port " + port +
          "): every call takes a frame of 0.125 or 1 ms, edges are stamped when they were fetched, and a "
          "pulled cable "
          "leaves the outputs as they are: good to try the wiring, not for flashes that are to be measured"};
}

}  // namespace

std::vector<CheckItem> inspect_lines(const Rig& rig, const SystemFiles& files) {
  auto chip = open_chip(rig);
  if (!chip) return {{"chip.name", Verdict::fault, chip.error().message}};
  std::vector<CheckItem> items{{"chip.name", Verdict::ok, "/dev/" + chip->name()}, bus_of(*chip, files)};
  for (std::size_t i = 1; i < kLineCount; ++i) {
    const auto which = static_cast<Line>(i);
    if (rig.line(which).fitted) inspect_line(*chip, rig, which, items);
  }
  return items;
}

}  // namespace strobe::firmware
