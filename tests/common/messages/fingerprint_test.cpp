// Pins the wire format: a change of any message type must be a decision, not an accident.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <strobe_msgs/ball_image_t.hpp>
#include <strobe_msgs/coded_flash_t.hpp>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/earlier_boot_t.hpp>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/flash_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/histogram_t.hpp>
#include <strobe_msgs/note_t.hpp>
#include <strobe_msgs/plan_t.hpp>
#include <strobe_msgs/point_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/readout_values_t.hpp>
#include <strobe_msgs/sealed_command_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include <CppUTest/TestHarness.h>

namespace {

struct Pin {
  std::int64_t is;
  std::uint64_t pinned;
};

const std::map<std::string, Pin>& pins() {
  static const std::map<std::string, Pin> table{
      {"ball_image_t", {strobe_msgs::ball_image_t::getHash(), 0xc4e7715c496d5f93}},
      {"coded_flash_t", {strobe_msgs::coded_flash_t::getHash(), 0xca8d3fdb380ff32a}},
      {"command_t", {strobe_msgs::command_t::getHash(), 0x93f0d571328d2e0d}},
      {"earlier_boot_t", {strobe_msgs::earlier_boot_t::getHash(), 0x27c50a9305638140}},
      {"event_t", {strobe_msgs::event_t::getHash(), 0x5d73a8136a3a7405}},
      {"flash_t", {strobe_msgs::flash_t::getHash(), 0x6bcbfe82d3bd0204}},
      {"frame_t", {strobe_msgs::frame_t::getHash(), 0xa3be7c3c948983f8}},
      {"histogram_t", {strobe_msgs::histogram_t::getHash(), 0x2ce6f085294c452f}},
      {"note_t", {strobe_msgs::note_t::getHash(), 0x2eae802baa5ddbbd}},
      {"plan_t", {strobe_msgs::plan_t::getHash(), 0x0b742a0ba6b4a4e8}},
      {"point_t", {strobe_msgs::point_t::getHash(), 0xb9e20652cc607e78}},
      {"readout_t", {strobe_msgs::readout_t::getHash(), 0x784800cf5a41192a}},
      {"readout_values_t", {strobe_msgs::readout_values_t::getHash(), 0xb7fa907edaf1173a}},
      {"sealed_command_t", {strobe_msgs::sealed_command_t::getHash(), 0x86509c45717d16ca}},
      {"shot_t", {strobe_msgs::shot_t::getHash(), 0xb7f5b496dce12d29}},
      {"status_t", {strobe_msgs::status_t::getHash(), 0x0dfd0c24e1915cf1}},
  };
  return table;
}

}  // namespace

TEST_GROUP(MessageFingerprints){};

TEST(MessageFingerprints, AreThePinnedOnes) {
  for (const auto& [type, pin] : pins()) {
    char text[400];
    std::snprintf(
        text, sizeof text,
        "%s has changed: its fingerprint is now 0x%016llx. Logs and messages of other versions cannot be "
        "read any more. If that is meant: describe the change in common/messages/CHANGELOG.md, raise "
        "SCHEMA_VERSION if a field's meaning changed, and pin the new fingerprint here.",
        type.c_str(), static_cast<unsigned long long>(pin.is));
    CHECK_TRUE_TEXT(static_cast<std::uint64_t>(pin.is) == pin.pinned, text);
  }
}

TEST(MessageFingerprints, ArePinnedForEveryType) {
  for (const auto& entry : std::filesystem::directory_iterator(STROBE_SOURCE_DIR "/common/messages")) {
    if (entry.path().extension() != ".lcm") continue;
    const std::string type = entry.path().stem().string();
    CHECK_TRUE_TEXT(pins().contains(type), (type + " is not pinned in this test").c_str());
  }
}
