#include "firmware/linux/rig_lines.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace strobe::firmware {

std::string place(const Rig& rig, std::uint32_t line, const std::string& key) {
  return rig.file_name + ":" + std::to_string(line) + ": " + key + ": ";
}

std::string line_message(const Rig& rig, Line which, const std::string& what) {
  return place(rig, rig.line(which).file_line, std::string("lines.") + line_key(which)) + what;
}

tl::unexpected<Error> line_failure(const Rig& rig, Line which, const std::string& what) {
  return fail(line_message(rig, which, what));
}

Result<GpioChip> open_chip(const Rig& rig) {
  const auto path = chip_path(rig.chip, is_chip_label(rig.chip) ? chip_nodes() : std::vector<ChipNode>{});
  if (!path) return fail(place(rig, rig.chip_file_line, "chip.name") + path.error().message);
  auto chip = GpioChip::open(*path);
  if (chip) return std::move(*chip);
  const int error = chip.error();
  // Either libgpiod has its own number for a device of another kind.
  if (error == ENOTTY || error == ENODEV)
    return fail(place(rig, rig.chip_file_line, "chip.name") + "\"" + rig.chip + "\" is no GPIO chip");
  const std::string hint = error == EACCES ? std::string(" (") + kAllowUser + ")" : "";
  return fail(place(rig, rig.chip_file_line, "chip.name") + "cannot open \"" + rig.chip +
              "\": " + std::strerror(error) + hint);
}

Result<unsigned> find_line(const GpioChip& chip, const Rig& rig, Line which) {
  const LineConfig& config = rig.line(which);
  if (config.offset >= 0) {
    const unsigned count = chip.line_count();
    if (config.offset < count) return static_cast<unsigned>(config.offset);
    return line_failure(rig, which,
                        "no offset " + std::to_string(config.offset) + " on " + chip.name() + ", which has " +
                            std::to_string(count) + " lines");
  }
  const auto offset = chip.find_line(config.name);
  if (!offset) return line_failure(rig, which, "no line named \"" + config.name + "\" on " + chip.name());
  return *offset;
}

std::string request_error(const GpioChip& chip, unsigned offset, int error) {
  std::string what = "cannot take line " + std::to_string(offset) + ": " + std::strerror(error);
  if (error != EBUSY) return what;
  const auto user = chip.user_of(offset);
  return user && !user->empty() ? what + " (used by " + *user + ")" : what;
}

namespace {

const std::string kDevices = "/dev/";
const std::string kChip = "gpiochip";

int is_chip(const dirent* entry) { return std::string(entry->d_name).starts_with(kChip) ? 1 : 0; }

ChipNode look_at(const std::string& path) {
  const int chip = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (chip < 0) return {path, "", errno};
  gpiochip_info info{};
  const int error = ioctl(chip, GPIO_GET_CHIPINFO_IOCTL, &info) == 0 ? 0 : errno;
  close(chip);
  info.label[sizeof info.label - 1] = '\0';
  return {path, info.label, error};
}

std::string listed(const std::vector<ChipNode>& nodes) {
  std::string text;
  bool forbidden = false;
  for (const ChipNode& node : nodes) {
    const std::string known = node.error != 0 ? std::strerror(node.error) : node.label;
    text += (text.empty() ? "" : ", ") + node.path + " (" + known + ")";
    forbidden = forbidden || node.error == EACCES;
  }
  return forbidden ? text + "; " + kAllowUser : text;
}

/// "1-2.3", as against "usb1" and an interface's "1-2.3:1.0".
bool is_port(const std::string& part) {
  return part.find('-') != std::string::npos && part.find_first_not_of("0123456789-.") == std::string::npos;
}

}  // namespace

std::vector<ChipNode> chip_nodes() {
  dirent** entries = nullptr;
  const int count = scandir(kDevices.c_str(), &entries, is_chip, versionsort);
  std::vector<ChipNode> nodes;
  for (int i = 0; i < count; ++i) {
    const std::string path = kDevices + entries[i]->d_name;
    struct stat status {};
    if (lstat(path.c_str(), &status) == 0 && S_ISCHR(status.st_mode)) nodes.push_back(look_at(path));
    std::free(entries[i]);
  }
  std::free(entries);
  return nodes;
}

bool is_chip_label(const std::string& which) {
  const bool is_name = which.starts_with(kChip) && is_number(which.substr(kChip.size()));
  return !which.starts_with("/") && !is_number(which) && !is_name;
}

Result<std::string> chip_path(const std::string& which, const std::vector<ChipNode>& nodes) {
  if (!is_chip_label(which)) {
    if (which.starts_with("/")) return which;
    return kDevices + (is_number(which) ? kChip : "") + which;
  }
  std::vector<ChipNode> labelled;
  std::copy_if(nodes.begin(), nodes.end(), std::back_inserter(labelled),
               [&](const ChipNode& node) { return node.path == kDevices + which || node.label == which; });
  if (labelled.size() == 1) return labelled.front().path;
  if (labelled.empty())
    return fail("there is no chip \"" + which + "\"" +
                (nodes.empty() ? ", nor any other" : "; there are " + listed(nodes)));
  return fail(std::to_string(labelled.size()) + " chips are \"" + which + "\": " + listed(labelled) +
              "; name one by its path");
}

std::string usb_port_of(const std::string& chip, const SystemFiles& files) {
  std::istringstream parts(files.resolved("sys/bus/gpio/devices/" + chip).value_or(""));
  bool usb = false;
  std::string port;
  for (std::string part; std::getline(parts, part, '/');) {
    usb = usb || (part.starts_with("usb") && is_number(part.substr(3)));
    if (usb && is_port(part)) port = part;
  }
  return port;
}

}  // namespace strobe::firmware
