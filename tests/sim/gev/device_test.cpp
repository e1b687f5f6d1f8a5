// The simulated camera's control channel, asked in the standard's own bytes.
#include "sim/gev/device.hpp"

#include <bit>
#include <string>

#include "tests/sim/gev/commands.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim::gev;
using strobe::testing::Datagram;
using strobe::testing::gvcp;
using strobe::testing::read_register;
using strobe::testing::word_of;
using strobe::testing::write_register;
using std::chrono::seconds;

constexpr Endpoint kApplication{0x7f000001, 40000};
constexpr Endpoint kStranger{0x7f000001, 40001};
constexpr MonoTime kStart = MonoTime{} + seconds(500);
constexpr std::uint32_t kControl = 0x0a00, kPacketSize = 0x0d04;

DeviceSettings settings_of_test() {
  DeviceSettings settings;
  settings.address = 0x7f000107;
  settings.serial = "SIM-7F000107";
  settings.width = 640;
  settings.height = 480;
  settings.pixel_format = PixelFormat::mono12;
  settings.clock_offset_s = 1000.0;
  settings.clock_drift_ppm = 50.0;
  settings.description = description();
  return settings;
}

std::uint32_t float_bits(float value) { return std::bit_cast<std::uint32_t>(value); }

}  // namespace

TEST_GROUP(GevDevice) {
  Device device{settings_of_test(), kStart};
  MonoTime now = kStart;

  Datagram ask(const Datagram& datagram, const Endpoint& sender = kApplication) {
    const auto answer = device.answer(datagram, sender, now);
    CHECK_TRUE(answer.has_value());
    return *answer;
  }
  /// The status code of the answer.
  std::uint32_t status(const Datagram& datagram, const Endpoint& sender = kApplication) {
    return word_of(ask(datagram, sender), 0) >> 16;
  }
  std::uint32_t value(std::uint32_t address) {
    const Datagram answer = ask(read_register(address));
    LONGS_EQUAL(12, answer.size());
    return word_of(answer, 8);
  }
  void take_control() { LONGS_EQUAL(0, status(write_register(kControl, 2))); }
};

TEST(GevDevice, TellsWhoItIsWhenItIsLookedFor) {
  const Datagram answer = ask(gvcp(0x0002, {}));
  LONGS_EQUAL(0x00000003, word_of(answer, 0));  // success, DISCOVERY_ACK
  LONGS_EQUAL(0x00f80007, word_of(answer, 4));  // 248 bytes, the command's id
  LONGS_EQUAL(8 + 248, answer.size());
  LONGS_EQUAL(0x7f000107, word_of(answer, 8 + 0x24));
  STRCMP_EQUAL("SIM-7F000107", reinterpret_cast<const char*>(&answer[8 + 0xd8]));
}

TEST(GevDevice, AnswersWithTheStandardsStatusCodes) {
  LONGS_EQUAL(0x8003, status(read_register(0x00090000)));                 // no such address
  LONGS_EQUAL(0x8005, status(read_register(0x0002)));                     // not at a register's beginning
  LONGS_EQUAL(0x8006, status(write_register(kPacketSize, 1500)));         // before control was taken
  take_control();
  LONGS_EQUAL(0x8004, status(write_register(0x0000, 1)));                 // the version
  LONGS_EQUAL(0x8002, status(write_register(camera::kPixelFormat, 99)));  // no such choice
  LONGS_EQUAL(0x8002, status(write_register(camera::kExposureTime, float_bits(-5.0F))));
  LONGS_EQUAL(0x8002, status(write_register(camera::kExposureTime, 0x7fc00000)));  // not a number
  LONGS_EQUAL(0x8001, status(gvcp(0x0100, {1, 2, 3})));                            // ACTION
  LONGS_EQUAL(0x8002, status(gvcp(0x0080, {})));
  Datagram short_of_what_it_says = read_register(kControl);
  short_of_what_it_says.pop_back();
  LONGS_EQUAL(0x800e, status(short_of_what_it_says));
}

TEST(GevDevice, SaysNothingToWhatIsNoCommand) {
  Datagram other_key = read_register(kControl);
  other_key[0] = 0x41;
  CHECK_FALSE(device.answer(other_key, kApplication, now).has_value());
  CHECK_FALSE(device.answer(Datagram(7, 0x42), kApplication, now).has_value());
  CHECK_FALSE(device.answer({}, kApplication, now).has_value());
  Datagram no_answer_wanted = read_register(kControl);
  no_answer_wanted[1] = 0;
  CHECK_FALSE(device.answer(no_answer_wanted, kApplication, now).has_value());
}

TEST(GevDevice, IsControlledByOneApplication) {
  take_control();
  LONGS_EQUAL(0x8006, status(write_register(kControl, 2), kStranger));
  LONGS_EQUAL(0x8006, status(write_register(camera::kAcquisitionStart, 1), kStranger));
  LONGS_EQUAL(0, status(read_register(kControl), kStranger));
  LONGS_EQUAL(0, status(write_register(kControl, 1)));  // exclusively
  LONGS_EQUAL(0x8006, status(read_register(kControl), kStranger));
}

TEST(GevDevice, LetsGoOfAnApplicationThatFellSilent) {
  take_control();
  LONGS_EQUAL(0, status(write_register(camera::kAcquisitionStart, 1)));
  now += milliseconds(2900);
  LONGS_EQUAL(2, value(kControl));  // a heartbeat
  now += milliseconds(2900);
  device.check_heartbeat(now);
  CHECK_TRUE(device.acquires());
  now += milliseconds(101);  // 3.001 s after it, of 3
  device.check_heartbeat(now);
  CHECK_FALSE(device.acquires());
  LONGS_EQUAL(0, value(kControl));
}

TEST(GevDevice, RoundsExposureTimes) {
  take_control();
  LONGS_EQUAL(0, status(write_register(camera::kExposureTime, float_bits(1236.0F))));
  LONGS_EQUAL(float_bits(1240.0F), value(camera::kExposureTime));
  LONGS_EQUAL(0, status(write_register(camera::kExposureTime, float_bits(2.0F))));
  LONGS_EQUAL(float_bits(10.0F), value(camera::kExposureTime));
}

TEST(GevDevice, TellsHowLargeAFrameIs) {
  LONGS_EQUAL(2 * 640 * 480, value(camera::kPayloadSize));
  take_control();
  LONGS_EQUAL(0, status(write_register(camera::kPixelFormat, 0x01080001)));  // Mono8
  LONGS_EQUAL(640 * 480, value(camera::kPayloadSize));
}

TEST(GevDevice, LatchesItsOwnClock) {
  take_control();
  now = kStart + seconds(100);
  LONGS_EQUAL(0, status(write_register(0x0944, 2)));
  const std::uint64_t latched = std::uint64_t{value(0x0948)} << 32 | value(0x094c);
  // 1000 s when switched on, 100 s since, 50 parts in a million of which are 5 ms.
  UNSIGNED_LONGS_EQUAL(UINT64_C(1'100'005'000'000), latched);
  LONGS_EQUAL(0, status(write_register(0x0944, 3)));  // reset, then latched
  LONGS_EQUAL(0, value(0x0948));
  LONGS_EQUAL(0, value(0x094c));
  LONGS_EQUAL(1'000'000'000, value(0x0940));  // ticks in a second
}

TEST(GevDevice, FiresATestPacketOfTheSizeThatIsWritten) {
  take_control();
  LONGS_EQUAL(0, status(write_register(kPacketSize, 0xc0000000 | 8000)));
  LONGS_EQUAL(8000, value(kPacketSize));
  CHECK_TRUE(device.take_test_packet());
  CHECK_FALSE(device.take_test_packet());
}

TEST(GevDevice, SendsFramesOverTheLoopbackOnly) {
  take_control();
  LONGS_EQUAL(0, status(write_register(0x0d00, 5000)));
  LONGS_EQUAL(0, status(write_register(0x0d18, 0x0a000001)));  // 10.0.0.1
  CHECK_FALSE(device.stream_destination().has_value());
  LONGS_EQUAL(0, status(write_register(0x0d18, 0x7f000001)));
  CHECK_TRUE(device.stream_destination() == Endpoint({0x7f000001, 5000}));
}

TEST(GevDevice, CountsBlocksAnewWhenTheStreamsChannelIsOpened) {
  constexpr std::uint32_t kStreamPort = 0x0d00;
  ask(write_register(kControl, 2));
  CHECK_FALSE(device.take_stream_opened());
  ask(write_register(kStreamPort, 50000));
  CHECK_TRUE(device.take_stream_opened());
  ask(write_register(kStreamPort, 0));
  CHECK_FALSE(device.take_stream_opened());
}

TEST(GevDevice, TakesRequestsForPacketsFromItsReceiver) {
  take_control();
  LONGS_EQUAL(0, status(write_register(0x0d00, 5000)));
  LONGS_EQUAL(0, status(write_register(0x0d18, 0x7f000001)));
  const Datagram request = gvcp(0x0040, {9, 3, 5});  // channel 0, block 9
  CHECK_FALSE(device.answer(request, kStranger, now).has_value());
  LONGS_EQUAL(0, device.take_resend_requests().size());
  CHECK_FALSE(device.answer(request, {0x7f000001, 5000}, now).has_value());
  const auto requests = device.take_resend_requests();
  LONGS_EQUAL(1, requests.size());
  LONGS_EQUAL(9, requests[0].block);
  LONGS_EQUAL(3, requests[0].first);
  LONGS_EQUAL(5, requests[0].last);
}

TEST(GevDevice, IsAsCamerasComeAfterItWasSwitchedOn) {
  take_control();
  LONGS_EQUAL(0, status(write_register(camera::kGainAuto, 0)));
  LONGS_EQUAL(0, status(write_register(camera::kTriggerMode, 1)));
  device.power_up(now);
  LONGS_EQUAL(0, value(kControl));
  LONGS_EQUAL(1, value(camera::kGainAuto));
  LONGS_EQUAL(0, value(camera::kTriggerMode));
}

TEST(GevDevice, KeepsTheNameThatItIsGiven) {
  take_control();
  LONGS_EQUAL(0, status(gvcp(0x0086, {0x00e8, 0x73696465, 0})));  // WRITEMEM "side"
  const Datagram answer = ask(gvcp(0x0084, {0x00e8, 8}));
  LONGS_EQUAL(0x000000e8, word_of(answer, 8));
  STRCMP_EQUAL("side", reinterpret_cast<const char*>(&answer[12]));
}

TEST(GevDevice, GivesItsWholeDescriptionFromMemory) {
  const Datagram url = ask(gvcp(0x0084, {0x0200, 64}));
  const std::string text(reinterpret_cast<const char*>(&url[12]));
  const std::string told = "local:simulated_camera.xml;100000;";
  STRCMP_CONTAINS(told.c_str(), text.c_str());
  const std::uint32_t size = static_cast<std::uint32_t>(std::stoul(text.substr(told.size()), nullptr, 16));
  std::string xml;
  for (std::uint32_t at = 0; at < size; at += 512) {
    const std::uint32_t count = std::min<std::uint32_t>(512, size - at);
    const Datagram part = ask(gvcp(0x0084, {0x100000 + at, count}));
    xml.append(reinterpret_cast<const char*>(&part[12]), count);
  }
  STRCMP_CONTAINS("</RegisterDescription>", xml.c_str());
  LONGS_EQUAL(0x8003, status(gvcp(0x0084, {0x100000 + size, 4})));
}
