// Whether a GigE Vision camera is there and still this program's: asks for its register of control from a
// socket of its own, without waiting. Aravis would take seconds to notice, and block meanwhile. One thread's.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/units/time.hpp"

namespace strobe::genicam {

enum class Presence {
  unknown,       ///< no answer yet
  here,          ///< it has answered, and is controlled
  uncontrolled,  ///< it has answered, but has forgotten who controls it: it was started anew
  silent,        ///< it has answered nothing for three quarters of a second
};

class PresenceWatch {
 public:
  static constexpr Duration kAskEvery = milliseconds{250};

  /// address: IPv4, dotted.
  explicit PresenceWatch(const std::string& address);
  ~PresenceWatch();
  PresenceWatch(const PresenceWatch&) = delete;
  PresenceWatch& operator=(const PresenceWatch&) = delete;

  /// -1: the address is none.
  int descriptor() const { return socket_; }
  /// Asks when it is time to, takes in answers. Returns true if one has come by this very call.
  bool look(HostTime now);
  /// Asks at once; answers to earlier questions count no more.
  void ask_now(HostTime now);
  Presence presence() const { return presence_; }
  HostTime next_due() const { return asked_ + kAskEvery; }

 private:
  void ask();
  bool take_answers();

  int socket_ = -1;
  std::uint16_t question_ = 0;
  int unanswered_ = 0;
  HostTime unanswered_since_;
  HostTime asked_{Duration::min() / 2};
  Presence presence_ = Presence::unknown;
};

}  // namespace strobe::genicam
