#include "firmware/linux/rig_lines.hpp"

#include <cerrno>
#include <cstring>

#include "firmware/linux/chip_path.hpp"

namespace strobe::firmware {

namespace {

std::string place(const Rig& rig, std::uint32_t line, const std::string& key) {
  return rig.file_name + ":" + std::to_string(line) + ": " + key + ": ";
}

}  // namespace

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

}  // namespace strobe::firmware
