// The rig files that are shipped for boards.
#include <map>

#include "firmware/core/rig.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

std::map<std::string, Rig> boards() {
  std::map<std::string, Rig> found;
  for (const auto& entry : std::filesystem::directory_iterator(STROBE_BUILD_DIR "/share/strobe/boards")) {
    const auto rig = read_rig(testing::read_text(entry.path()), entry.path().filename());
    CHECK_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
    found[entry.path().stem()] = *rig;
  }
  return found;
}

}  // namespace

TEST_GROUP(Boards){};

TEST(Boards, AreFoundByTheirLabels) {
  const auto found = boards();
  CHECK_EQUAL(4U, found.size());
  CHECK_EQUAL("pinctrl-bcm2835", found.at("raspberry-pi-3").chip);
  CHECK_EQUAL("pinctrl-bcm2711", found.at("raspberry-pi-4").chip);
  CHECK_EQUAL("pinctrl-rp1", found.at("raspberry-pi-5").chip);
  CHECK_EQUAL("cp2112_gpio", found.at("usb-cp2112").chip);
}

TEST(Boards, StopOnABrokenWireWithoutAWordAboutIt) {
  for (const auto& [name, rig] : boards()) {
    CHECK_TEXT(rig.line(Line::key).bias == Bias::pull_down, name.c_str());
    CHECK_TEXT(rig.line(Line::estop).bias == Bias::pull_down, name.c_str());
  }
}

TEST(Boards, HaveOutputsOnLinesThatARaspberryPiPullsDownAfterAReset) {
  for (const auto& [name, rig] : boards()) {
    if (!name.starts_with("raspberry-pi")) continue;
    for (const Line output : {Line::strobe_a, Line::strobe_b, Line::shutter, Line::trigger})
      CHECK_TEXT(rig.line(output).offset > 8 && rig.line(output).offset < 28, name.c_str());
  }
}
