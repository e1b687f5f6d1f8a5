#include "host/drivers/genicam/presence.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

namespace strobe::genicam {
namespace {

// GigE Vision's control protocol (GVCP), all numbers big-endian: READREG of the control channel privilege.
constexpr std::uint16_t kPort = 3956;
constexpr std::uint8_t kKey = 0x42, kAcknowledge = 0x01;
constexpr std::uint8_t kReadRegister = 0x80, kReadRegisterAnswer = 0x81;
constexpr std::uint8_t kControlled = 0x03;
constexpr Duration kMaxSilence = 3 * PresenceWatch::kAskEvery;

}  // namespace

PresenceWatch::PresenceWatch(const std::string& address) {
  sockaddr_in camera{};
  camera.sin_family = AF_INET;
  camera.sin_port = htons(kPort);
  if (inet_pton(AF_INET, address.c_str(), &camera.sin_addr) != 1) return;
  socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) return;
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&camera), sizeof camera) != 0) {
    close(socket_);
    socket_ = -1;
  }
}

PresenceWatch::~PresenceWatch() {
  if (socket_ >= 0) close(socket_);
}

void PresenceWatch::ask() {
  question_ = static_cast<std::uint16_t>(question_ % 0xFFFF + 1);  // never 0
  const std::array<std::uint8_t, 12> packet{kKey,
                                            kAcknowledge,
                                            0,
                                            kReadRegister,
                                            0,
                                            4,
                                            static_cast<std::uint8_t>(question_ >> 8),
                                            static_cast<std::uint8_t>(question_ & 0xFF),
                                            0,
                                            0,
                                            0x0A,
                                            0};
  static_cast<void>(!send(socket_, packet.data(), packet.size(), MSG_NOSIGNAL));
}

bool PresenceWatch::take_answers() {
  bool answered = false;
  std::array<std::uint8_t, 64> packet{};
  // An error that the network reports is no answer either.
  for (int i = 0; i < 64; ++i) {
    const ssize_t size = recv(socket_, packet.data(), packet.size(), 0);
    if (size < 0) break;
    if (size < 8 || packet[3] != kReadRegisterAnswer) continue;
    const int id = packet[6] << 8 | packet[7];
    if (id != question_) continue;
    // Refused, as while another program has it alone.
    const bool good = size >= 12 && packet[0] == 0 && packet[1] == 0;
    presence_ = good && (packet[11] & kControlled) != 0 ? Presence::here : Presence::uncontrolled;
    unanswered_ = 0;
    answered = true;
  }
  return answered;
}

bool PresenceWatch::look(HostTime now) {
  if (socket_ < 0) return false;
  const bool answered = take_answers();
  if (now < next_due()) return answered;
  ask_now(now);
  return answered;
}

void PresenceWatch::ask_now(HostTime now) {
  if (unanswered_ == 0) unanswered_since_ = now;
  if (now - unanswered_since_ >= kMaxSilence) presence_ = Presence::silent;
  ++unanswered_;
  asked_ = now;
  ask();
}

}  // namespace strobe::genicam
