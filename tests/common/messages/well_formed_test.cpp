#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <strobe_msgs/ball_image_2_t.hpp>
#include <strobe_msgs/ball_image_3_t.hpp>
#include <strobe_msgs/ball_image_t.hpp>
#include <strobe_msgs/coded_flash_t.hpp>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/earlier_boot_t.hpp>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/flash_t.hpp>
#include <strobe_msgs/frame_2_t.hpp>
#include <strobe_msgs/frame_3_t.hpp>
#include <strobe_msgs/frame_4_t.hpp>
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
#include <vector>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::messages;
using namespace strobe_msgs;

namespace {

constexpr std::int64_t kLargest = std::int64_t{1} << 60;

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

template <typename Message>
bool decodes(const Message& message) {
  const auto bytes = encoded(message);
  Message decoded;
  return decode_checked(decoded, bytes.data(), bytes.size()) && encoded(decoded) == bytes;
}

/// Neither any beginning of the message nor the message with a byte more.
template <typename Message>
void check_no_other_length(const Message& message) {
  auto bytes = encoded(message);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    CHECK_FALSE(well_formed<Message>(bytes.data(), size));
  CHECK_TRUE(well_formed<Message>(bytes.data(), bytes.size()));
  bytes.push_back(0);
  CHECK_FALSE(well_formed<Message>(bytes.data(), bytes.size()));
}

status_t full_status() {
  status_t status{};
  status.earlier.resize(2), status.earlier_count = 2;
  status.histograms.resize(2), status.histogram_count = 2;
  for (auto& histogram : status.histograms) histogram.quantity = 1, histogram.bin_width_us = 1.0;
  status.histograms[1].bins = {1, 2, 3}, status.histograms[1].bin_count = 3;
  status.message = "the key is off";
  return status;
}

shot_t full_shot() {
  shot_t shot{};
  shot.plan.code.resize(2), shot.plan.code_count = 2;
  for (auto& flash : shot.plan.code) flash.lamps = 3;
  shot.flashes.resize(3), shot.flash_count = 3;
  for (auto& flash : shot.flashes) flash.lamps = 3;
  shot.notes.resize(1), shot.note_count = 1;
  shot.notes[0].key = "operator", shot.notes[0].value = "somebody";
  shot.abort_reason = "late";
  return shot;
}

}  // namespace

TEST_GROUP(ChecksOfMessages){};

TEST(ChecksOfMessages, WholeMessagesPassAndNoOtherLengthDoes) {
  readout_t readout{};
  readout.flags = {"late_flash", "spin_aliased"}, readout.flag_count = 2;
  sealed_command_t sealed{};
  sealed.body = {1, 2, 3}, sealed.body_size = 3;
  frame_t frame{};
  frame.surface.resize(2), frame.surface_count = 2;
  frame.images.resize(1), frame.image_count = 1;
  CHECK_TRUE(decodes(full_status()) && decodes(full_shot()) && decodes(frame) && decodes(event_t{}));
  CHECK_TRUE(decodes(readout) && decodes(sealed) && decodes(command_t{}));
  check_no_other_length(full_status());
  check_no_other_length(full_shot());
  check_no_other_length(frame);
  check_no_other_length(readout);
  check_no_other_length(sealed);
}

TEST(ChecksOfMessages, ACountBeyondItsRangeIsRefusedAlthoughTheBytesAreThere) {
  command_t command{};
  command.notes.resize(64), command.note_count = 64;
  CHECK_TRUE(decodes(command));
  command.notes.resize(65), command.note_count = 65;
  CHECK_FALSE(decodes(command));
  status_t status = full_status();
  status.earlier.resize(17), status.earlier_count = 17;
  CHECK_FALSE(decodes(status));
  shot_t shot = full_shot();
  shot.plan.code.resize(1025), shot.plan.code_count = 1025;
  CHECK_FALSE(decodes(shot));
}

TEST(ChecksOfMessages, AnotherTypesFingerprintIsRefused) {
  auto bytes = encoded(full_shot());
  bytes[0] ^= 1;
  shot_t shot;
  CHECK_TRUE(well_formed<shot_t>(bytes.data(), bytes.size()));
  CHECK_FALSE(decode_checked(shot, bytes.data(), bytes.size()));
}

// Every number another one, so that no two can be taken for each other.
template <typename Former>
Former former_frame() {
  Former former{};
  former.schema_version = Former::SCHEMA_VERSION;
  former.boot_id = 1, former.shot_id = 2, former.host_id = 3;
  former.source = "hand", former.photograph = "a.tif";
  former.centre_sd_px = 4, former.diameter_sd_px = 5, former.surface_sd_px = 6, former.equator_sd_rad = 7;
  former.px_per_m = 8, former.px_per_m_sd = 9;
  former.surface.resize(2), former.surface_count = 2;
  former.surface[1].y_px = 10;
  former.images.resize(2), former.image_count = 2;
  auto& image = former.images[1];
  image.leg = 1, image.source = 2, image.centre_x_px = 11, image.centre_y_px = 12;
  image.centre_xx_px2 = 13, image.centre_xy_px2 = 14, image.centre_yy_px2 = 15, image.diameter_px = 16;
  image.diameter_sd_px = 17, image.equator_rad = 18, image.equator_sd_rad = 19;
  image.top_x_px = 20, image.top_y_px = 21, image.contact_width_px = 22;
  return former;
}

// `without`: numbers that a present image has at its end, and a former one does not.
template <typename Former>
void check_is_read(Former former, std::size_t without) {
  auto bytes = encoded(former);
  frame_t frame;
  CHECK_TRUE(decode_checked(frame, bytes.data(), bytes.size()));
  LONGS_EQUAL(frame_t::SCHEMA_VERSION, frame.schema_version);
  // The former bytes again.
  const auto now = encoded(frame);
  constexpr std::size_t kPresent = 130, kHead = 12;  // an image; fingerprint and version
  const std::size_t former_image = kPresent - 8 * without;
  const auto end = now.end() - 8;  // of the images: what diameters are off alike follows
  CHECK_TRUE(std::isnan(frame.shared_diameter_sd_px));
  std::vector<std::uint8_t> old(now.begin(), end - 2 * kPresent);
  for (auto at = end - 2 * kPresent; at != end; at += kPresent)
    old.insert(old.end(), at, at + former_image);
  CHECK_TRUE(std::equal(old.begin() + kHead, old.end(), bytes.begin() + kHead, bytes.end()));
  // Of another version it is nobody's.
  former.schema_version = 1;
  bytes = encoded(former);
  CHECK_FALSE(decode_checked(frame, bytes.data(), bytes.size()));
}

TEST(ChecksOfMessages, AFrameOfBeforeItsImagesHadATiltIsRead) {
  const auto former = former_frame<frame_2_t>();
  check_is_read(former, 4);
  const auto bytes = encoded(former);
  frame_t frame;
  CHECK_TRUE(decode_checked(frame, bytes.data(), bytes.size()));
  for (const auto& image : frame.images)
    CHECK_TRUE(std::isnan(image.equator_tilt_rad) && std::isnan(image.equator_tilt_sd_rad) &&
               std::isnan(image.equator_tilt_correlation) && std::isnan(image.probability));
}

TEST(ChecksOfMessages, AFrameOfBeforeItsImagesHadAProbabilityIsRead) {
  auto former = former_frame<frame_3_t>();
  auto& image = former.images[1];
  image.equator_tilt_rad = 23, image.equator_tilt_sd_rad = 24, image.equator_tilt_correlation = 25;
  check_is_read(former, 1);
  const auto bytes = encoded(former);
  frame_t frame;
  CHECK_TRUE(decode_checked(frame, bytes.data(), bytes.size()));
  for (const auto& one : frame.images) CHECK_TRUE(std::isnan(one.probability));
}

TEST(ChecksOfMessages, AFrameOfBeforeItHadASharedSdIsRead) {
  auto former = former_frame<strobe_msgs::frame_4_t>();
  former.images[1].probability = 0.5;
  check_is_read(former, 0);
}

TEST(ChecksOfMessages, AnImagesProbabilityIsAboveZeroToOneOrNaN) {
  ball_image_t image{};
  image.centre_xx_px2 = image.centre_yy_px2 = image.diameter_px = image.diameter_sd_px = 1.0;
  image.equator_sd_rad = image.contact_width_px = image.equator_tilt_sd_rad = 1.0;
  for (const double p : {1e-9, 0.5, 1.0, std::nan("")}) {
    image.probability = p;
    CHECK_TRUE(in_range(image));
  }
  for (const double p : {0.0, -0.1, 1.0 + 1e-9, HUGE_VAL, -HUGE_VAL}) {
    image.probability = p;
    CHECK_FALSE(in_range(image));
  }
}

TEST(ChecksOfMessages, NumbersAtTheirLimitsAreInRangeAndBeyondThemNot) {
  const auto with_time = [](std::int64_t ns) {
    event_t event{};
    event.commanded_ns = ns;
    return in_range(event);
  };
  CHECK_TRUE(with_time(kLargest) && with_time(-kLargest) && with_time(event_t::NO_TIME));
  CHECK_FALSE(with_time(kLargest + 1) || with_time(-kLargest - 1));
  event_t event{};
  event.sequence = -1;
  CHECK_FALSE(in_range(event));
  status_t status = full_status();
  CHECK_TRUE(in_range(status));
  status.wall_ns = 4'000'000'000'000'000'001;
  CHECK_FALSE(in_range(status));
}

TEST(ChecksOfMessages, TheNumbersOfAMessagesPartsAreCheckedToo) {
  CHECK_TRUE(in_range(full_shot()));
  shot_t shot = full_shot();
  shot.flashes[2].observed_b_ns = kLargest + 1;
  CHECK_FALSE(in_range(shot));
  shot = full_shot();
  shot.plan.code[1].lamps = 4;
  CHECK_FALSE(in_range(shot));
  shot = full_shot();
  shot.plan.impact_at_ns = -1;
  CHECK_FALSE(in_range(shot));
  status_t status = full_status();
  status.histograms[1].quantity = 0;
  CHECK_FALSE(in_range(status));
}

TEST(ChecksOfMessages, ANumberThatMayBeAbsentIsNaNOrInRange) {
  const auto with_sd = [](double sd) {
    frame_t frame{};
    frame.centre_sd_px = frame.diameter_sd_px = frame.surface_sd_px = frame.equator_sd_rad = 1.0;
    frame.px_per_m = 4000.0;
    frame.px_per_m_sd = sd;
    return in_range(frame);
  };
  CHECK_TRUE(with_sd(0.0) && with_sd(5.0) && with_sd(std::nan("")));
  CHECK_FALSE(with_sd(-1e-9) || with_sd(std::numeric_limits<double>::infinity()));
  shot_t shot = full_shot();
  shot.late_tolerance_us = std::nan("");
  CHECK_FALSE(in_range(shot));
}

TEST(ChecksOfMessages, AReadoutTellsItsHostWithoutBeingDecoded) {
  for (const std::int64_t host : {-0x0123456789abcdef, 0x0123456789abcdef}) {
    readout_t readout{};
    readout.host_id = host;
    const auto bytes = encoded(readout);
    LONGLONGS_EQUAL(host, readout_host(bytes.data(), bytes.size()));
    for (std::size_t size = 0; size < 20; ++size) LONGLONGS_EQUAL(0, readout_host(bytes.data(), size));
  }
  const auto other = encoded(full_status());
  LONGLONGS_EQUAL(0, readout_host(other.data(), other.size()));
}

// Pins the wire format: a change of any message type must be a decision, not an accident.
namespace {

struct Pin {
  std::int64_t is;
  std::uint64_t pinned;
};

const std::map<std::string, Pin>& pins() {
  static const std::map<std::string, Pin> table{
      {"ball_image_t", {strobe_msgs::ball_image_t::getHash(), 0xbd700e25627d4dab}},
      {"ball_image_2_t", {strobe_msgs::ball_image_2_t::getHash(), 0xc4e7715c496d5f93}},
      {"ball_image_3_t", {strobe_msgs::ball_image_3_t::getHash(), 0x658f8967f56e96db}},
      {"coded_flash_t", {strobe_msgs::coded_flash_t::getHash(), 0xca8d3fdb380ff32a}},
      {"command_t", {strobe_msgs::command_t::getHash(), 0x93f0d571328d2e0d}},
      {"earlier_boot_t", {strobe_msgs::earlier_boot_t::getHash(), 0x27c50a9305638140}},
      {"event_t", {strobe_msgs::event_t::getHash(), 0x5d73a8136a3a7405}},
      {"flash_t", {strobe_msgs::flash_t::getHash(), 0x6bcbfe82d3bd0204}},
      {"frame_2_t", {strobe_msgs::frame_2_t::getHash(), 0xa3be7c3c948983f8}},
      {"frame_3_t", {strobe_msgs::frame_3_t::getHash(), 0xe50eac53ec8bf289}},
      {"frame_4_t", {strobe_msgs::frame_4_t::getHash(), 0x94cfb5cec6a96028}},
      {"frame_t", {strobe_msgs::frame_t::getHash(), 0x39169a17ceaf32a3}},
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

using namespace strobe::messages;

TEST_GROUP(Channels){};

TEST(Channels, AreNamedAfterRigAndKind) {
  const Channel all[] = {Channel::command, Channel::event, Channel::status,
                         Channel::shot,    Channel::frame, Channel::readout};
  std::string names;
  for (const Channel channel : all) names += channel_name("b", channel) + " ";
  CHECK_EQUAL(
      "STROBE/b/COMMAND STROBE/b/EVENT STROBE/b/STATUS STROBE/b/SHOT STROBE/b/FRAME STROBE/b/READOUT ",
      names);
}

TEST(Channels, ARigsNameHas1To24LettersDigitsAndDashes) {
  for (const std::string& name : {std::string("azAZ09_-"), std::string(24, 'r')})
    CHECK_TRUE_TEXT(valid_rig_name(name), name.c_str());
  CHECK_FALSE(valid_rig_name("") || valid_rig_name(std::string(25, 'r')));
  for (const char c : {'`', '{', '@', '[', '/', ':', ' ', '.'})
    CHECK_FALSE(valid_rig_name(std::string("rig") + c));
}
