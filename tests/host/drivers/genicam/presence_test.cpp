// A camera that is a socket of the test's, on a clock that the test moves.
#include "host/drivers/genicam/presence.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <stdexcept>

#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::genicam;

namespace {

constexpr std::uint16_t kPort = 3956;

}  // namespace

TEST_GROUP(GenicamPresence) {
  int camera = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  HostTime now = from_ns<HostTime>(1'000'000'000'000);
  std::array<std::uint8_t, 12> question{};

  void setup() override {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(kPort);
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (bind(camera, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0)
      throw std::runtime_error("the camera's port is taken");
  }
  void teardown() override { close(camera); }

  /// The camera hears the question, and answers with its register of control, or not.
  void hear(bool answer, std::uint8_t control, std::uint8_t status = 0) {
    sockaddr_in asker{};
    socklen_t size = sizeof asker;
    LONGS_EQUAL(12, recvfrom(camera, question.data(), question.size(), 0, reinterpret_cast<sockaddr*>(&asker), &size));
    if (!answer) return;
    const std::array<std::uint8_t, 12> packet{status, 0, 0, 0x81, 0, 4, question[6], question[7], 0, 0, 0, control};
    LONGS_EQUAL(12, sendto(camera, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&asker), size));
  }
};

TEST(GenicamPresence, AsksForTheRegisterOfControl) {
  PresenceWatch watch("127.0.0.1");
  CHECK_FALSE(watch.look(now));
  hear(true, 2);
  // READREG of 0x0A00, with an acknowledge wanted (GigE Vision 1.2, section 14).
  const std::array<std::uint8_t, 6> header{0x42, 1, 0, 0x80, 0, 4};
  for (std::size_t i = 0; i < header.size(); ++i) LONGS_EQUAL(header[i], question[i]);
  LONGS_EQUAL(0x0A, question[10]);
  CHECK_TRUE(watch.presence() == Presence::unknown);
  CHECK_TRUE(watch.look(now));
  CHECK_TRUE(watch.presence() == Presence::here);
  CHECK_TRUE(watch.next_due() == now + PresenceWatch::kAskEvery);
}

TEST(GenicamPresence, CameraThatForgotWhoControlsItOrRefusesIsNotOurs) {
  PresenceWatch watch("127.0.0.1");
  watch.look(now);
  hear(true, 0);
  CHECK_TRUE(watch.look(now));
  CHECK_TRUE(watch.presence() == Presence::uncontrolled);
  now += PresenceWatch::kAskEvery;
  watch.look(now);
  hear(true, 2, 0x80);
  CHECK_TRUE(watch.look(now));
  CHECK_TRUE(watch.presence() == Presence::uncontrolled);
}

TEST(GenicamPresence, IsSilentAfterThreeQuartersOfASecondAndHeardAgain) {
  PresenceWatch watch("127.0.0.1");
  watch.look(now);
  hear(true, 2);
  watch.look(now);
  for (int i = 0; i < 3; ++i) {
    now += PresenceWatch::kAskEvery;
    watch.look(now);
    hear(false, 0);
    CHECK_TRUE(watch.presence() == Presence::here);
  }
  now += PresenceWatch::kAskEvery;
  watch.look(now);
  CHECK_TRUE(watch.presence() == Presence::silent);
  hear(true, 2);
  CHECK_TRUE(watch.look(now));
  CHECK_TRUE(watch.presence() == Presence::here);
}

TEST(GenicamPresence, AnswerToAnEarlierQuestionDoesNotCount) {
  PresenceWatch watch("127.0.0.1");
  watch.look(now);
  watch.ask_now(now);
  hear(true, 2);  // the first
  CHECK_FALSE(watch.look(now));
  hear(true, 2);
  CHECK_TRUE(watch.look(now));
}

TEST(GenicamPresence, AddressOfTheUniversalSerialBusIsNotAsked) {
  PresenceWatch watch("usb:1");
  LONGS_EQUAL(-1, watch.descriptor());
  CHECK_FALSE(watch.look(now));
}
