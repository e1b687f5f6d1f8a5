// The rig files of boards, each checked on a simulated chip with that board's label and lines.
#include <map>
#include <string>

#include "firmware/core/rig_file.hpp"
#include "sim/gpiochip/chip.hpp"
#include "tests/hil/rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::hil;
using namespace std::chrono_literals;

namespace {

/// Of the kernel's drivers, by label.
const std::map<std::string, std::size_t> kLinesOfChip{
    {"pinctrl-bcm2835", 54}, {"pinctrl-bcm2711", 58}, {"pinctrl-rp1", 54}, {"cp2112_gpio", 8}};

strobe::sim::Chip chip_of(const std::filesystem::path& folder, const std::string& label) {
  strobe::sim::ChipSpec spec;
  spec.name = "gpiochip11";
  spec.label = label;
  spec.lines.resize(kLinesOfChip.at(label));
  auto chip = strobe::sim::Chip::create(folder, spec);
  CHECK_TEXT(chip.has_value(), chip ? "" : chip.error().message.c_str());
  return std::move(*chip);
}

std::string checked(const std::filesystem::path& rig, const std::filesystem::path& chip) {
  strobe::testing::Command command;
  command.arguments = {program("strobed"), "--check", "--allow-no-rt", "--config", rig};
  command.environment = strobe::hil::environment_of_chip(chip);
  return strobe::testing::run_process(command, 20s).out;
}

}  // namespace

TEST_GROUP(Boards) { strobe::testing::TemporaryFolder folder; };

TEST(Boards, FindTheirChipAndEveryLineOfTheirRigFile) {
  for (const auto& entry : std::filesystem::directory_iterator(share("boards"))) {
    const auto rig = strobe::firmware::read_rig(strobe::testing::read_text(entry.path()), entry.path());
    CHECK_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
    const strobe::sim::Chip chip = chip_of(folder / "chip", rig->chip);
    const std::string out = checked(entry.path(), chip.dir());
    CHECK_TEXT(out.find("chip.name        ok: /dev/gpiochip11") != std::string::npos, out.c_str());
    for (std::size_t i = 1; i < strobe::firmware::kLineCount; ++i) {
      const auto which = static_cast<strobe::firmware::Line>(i);
      if (!rig->line(which).fitted) continue;
      std::string item = std::string("lines.") + strobe::firmware::line_key(which);
      item.resize(17, ' ');
      CHECK_TEXT(out.find(item + "ok") != std::string::npos, out.c_str());
    }
    CHECK_TEXT(out.find("lines.estop.bias ok: pull_down") != std::string::npos ||
                   out.find("lines.estop.bias advice: pull_down") != std::string::npos,
               out.c_str());
  }
}

TEST(Boards, AreToldApart) {
  const strobe::sim::Chip chip = chip_of(folder / "chip", "pinctrl-bcm2711");
  const std::string out = checked(share("boards") / "raspberry-pi-5.toml", chip.dir());
  CHECK_TEXT(out.find("there is no chip \"pinctrl-rp1\"; there are ") != std::string::npos, out.c_str());
  CHECK_TEXT(out.find("/dev/gpiochip11 (pinctrl-bcm2711)") != std::string::npos, out.c_str());
}
