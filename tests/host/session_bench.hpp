// A session that is handed messages in virtual time.
#pragma once

#include <string>
#include <vector>

#include "host/session/session.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"

namespace strobe::host_test {

using host::Session;
using host::Shot;
using reduction::Flag;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

inline constexpr Duration kSecond = std::chrono::seconds{1};

inline host::AssemblySettings settings() {
  host::AssemblySettings s;
  s.machine_lag_s = host_test::kMachineLag_s;
  s.analysis.photograph_timeout_s = 5.0;
  s.ball.fastest_spin_radps = 600.0;
  return s;
}

/// Host and firmware clocks differ by an arbitrary offset.
struct Bench {
  Session session;
  SyntheticShot made = make_shot({});
  HostTime local{40 * kSecond};
  MonoTime end = from_ns(made.shot.shutter_close_ns);
  std::int64_t last_written = 5;  ///< of boot 77, as later ones say

  explicit Bench(std::int64_t host_id = 0) : session(settings(), host_id) { status(end - kSecond / 2); }

  MonoTime newest() const { return from_ns(session.status()->mono_ns); }
  void status(MonoTime mono, std::int64_t boot_id = 77) {
    status_t status{};
    status.boot_id = boot_id;
    status.mono_ns = status.boot_time_ns = status.wall_ns = to_ns(mono);
    if (boot_id != 77) status.earlier.push_back({77, last_written});
    status.earlier_count = static_cast<std::int32_t>(status.earlier.size());
    if (session.status()) local += mono - newest();
    session.on_status(status, local);
  }
  /// A heartbeat every half second.
  void beat_until(MonoTime mono) {
    for (MonoTime beat = newest() + kSecond / 2; beat < mono; beat += kSecond / 2) status(beat);
    status(mono);
  }
  void shot() { session.on_shot(made.shot, local); }
  void frame() { session.on_frame(made.frame, local); }
  std::vector<Shot> shot_results() { return session.take_shot_results(); }
  Shot only_result() {
    const auto results = shot_results();
    LONGS_EQUAL(1, results.size());
    return results.at(0);
  }
};

inline event_t ended(std::int32_t shot_id, std::int64_t sequence) {
  event_t event{};
  event.boot_id = 77;
  event.shot_id = shot_id;
  event.sequence = sequence;
  event.kind = event_t::SHOT_ENDED;
  return event;
}

/// Events 1 to 4 of boot 77: armed by host 5, shot 6 started, two flashes; then the firmware dies.
struct CutOff : Bench {
  explicit CutOff(std::int64_t host_id, const std::string& kind_of_shot = "") : Bench(host_id) {
    session.on_event(of_kind(event_t::ARMED, 0, 1, "5"), local);
    session.on_event(of_kind(event_t::SHOT_STARTED, 6, 2, kind_of_shot), local);
    session.on_event(of_kind(event_t::FLASH, 6, 3, ""), local);
    session.on_event(of_kind(event_t::FLASH, 6, 4, ""), local);
  }
  /// The next boot tells of the last number that boot 77 has written.
  void tell_of_death(std::int64_t last_sequence) {
    status(end, 78);
    const host::EndedBoot dead{77, last_sequence};
    session.ledger().earlier({&dead, 1}, local);
  }
  static event_t of_kind(std::int8_t kind, std::int32_t shot_id, std::int64_t sequence,
                         const std::string& detail) {
    event_t event = ended(shot_id, sequence);
    event.kind = kind;
    event.detail = detail;
    return event;
  }
};

inline std::string first_notice(Session& session) {
  const auto notifications = session.take_notifications();
  return notifications.empty() ? "" : notifications.front();
}

}  // namespace strobe::host_test
