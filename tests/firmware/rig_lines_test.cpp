#include <cerrno>

#include "firmware/linux/rig_lines.hpp"
#include "tests/firmware/system_tree.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::firmware;

TEST_GROUP(ChipPath) {
  std::vector<ChipNode> nodes{{"/dev/gpiochip0", "pinctrl-rp1"},
                              {"/dev/gpiochip1", "gpio-brcmstb@107d508500"},
                              {"/dev/gpiochip4", "cp2112_gpio"}};

  std::string path_of(const std::string& which) const {
    const auto found = chip_path(which, nodes);
    return found ? *found : found.error().message;
  }
};

TEST(ChipPath, IsThatOfTheLabelWhateverItsNumber) {
  CHECK_EQUAL("/dev/gpiochip0", path_of("pinctrl-rp1"));
  nodes[0].path = "/dev/gpiochip13";
  CHECK_EQUAL("/dev/gpiochip13", path_of("pinctrl-rp1"));
}

TEST(ChipPath, MayBeGivenAsPathNameOrNumber) {
  CHECK_EQUAL("/dev/by-hand", path_of("/dev/by-hand"));
  CHECK_EQUAL("/dev/gpiochip7", path_of("gpiochip7"));
  CHECK_EQUAL("/dev/gpiochip7", path_of("7"));
}

TEST(ChipPath, OfALabelThatBeginsAsANameIsLookedUp) {
  nodes[2].label = "gpiochip-of-the-bench";
  CHECK_EQUAL("/dev/gpiochip4", path_of("gpiochip-of-the-bench"));
}

TEST(ChipPath, NeedsTheMachinesChipsForALabelOnly) {
  for (const char* name : {"/dev/by-hand", "gpiochip7", "7"}) CHECK_FALSE(is_chip_label(name));
  for (const char* label : {"pinctrl-rp1", "gpiochip-of-the-bench", "gpiochip"})
    CHECK_TRUE(is_chip_label(label));
}

TEST(ChipPath, OfALabelThatTwoHaveIsToldWithBoth) {
  nodes[1].label = "cp2112_gpio";
  CHECK_EQUAL(
      "2 chips are \"cp2112_gpio\": /dev/gpiochip1 (cp2112_gpio), /dev/gpiochip4 (cp2112_gpio); name one by "
      "its path",
      path_of("cp2112_gpio"));
}

TEST(ChipPath, OfALabelThatNoneHasIsToldWithThoseThatThereAre) {
  nodes.resize(2);
  CHECK_EQUAL(
      "there is no chip \"pinctrl-bcm2711\"; there are /dev/gpiochip0 (pinctrl-rp1), /dev/gpiochip1 "
      "(gpio-brcmstb@107d508500)",
      path_of("pinctrl-bcm2711"));
  nodes.clear();
  CHECK_EQUAL("there is no chip \"pinctrl-bcm2711\", nor any other", path_of("pinctrl-bcm2711"));
}

TEST(ChipPath, OfAChipThatThisUserMayNotOpenIsToldWithWhatToDo) {
  nodes = {{"/dev/gpiochip0", "", EACCES}};
  CHECK_EQUAL(
      "there is no chip \"pinctrl-rp1\"; there are /dev/gpiochip0 (Permission denied); the user must be "
      "allowed to "
      "open it, e.g. by the group gpio",
      path_of("pinctrl-rp1"));
}

TEST_GROUP(UsbPort) {
  strobe::testing::SystemTree tree;
  void chip(const std::string& device) {
    tree.link("sys/bus/gpio/devices/gpiochip0", "../../../devices/" + device);
  }
  std::string port() const { return usb_port_of("gpiochip0", tree.files()); }
};

TEST(UsbPort, IsTheDevicesUnderAllItsHubs) {
  chip("pci0000:00/0000:00:14.0/usb1/1-2/1-2.4/1-2.4:1.0/0003:10C4:EA90.0001/gpiochip0");
  CHECK_EQUAL("1-2.4", port());
}

TEST(UsbPort, IsNoneForAChipOfTheBoard) {
  chip("platform/axi/1000120000.pcie/1f000d0000.gpio/gpiochip0");
  CHECK_EQUAL("", port());
}

TEST(UsbPort, IsNoneForAChipThatIsNotThere) { CHECK_EQUAL("", port()); }
