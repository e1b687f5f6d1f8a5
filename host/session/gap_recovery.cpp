#include "host/session/gap_recovery.hpp"

namespace strobe::host {
namespace {

constexpr Duration kTimeout = std::chrono::minutes{1};
constexpr Duration kNoProgressTimeout = std::chrono::seconds{15};
// A status that arrives within this time may have been sent before the start.
constexpr Duration kTransit = milliseconds{100};

}  // namespace

bool GapRecovery::finished(const Session& session, HostTime now) {
  const EventLedger& ledger = session.ledger();
  if (ledger.received() != received_ || progress_ == HostTime{}) progress_ = now;
  received_ = ledger.received();
  if (now - started_ > kTimeout || now - progress_ > kNoProgressTimeout) return true;
  if (!session.status()) return true;  // nobody can be asked
  if (!ledger.complete()) return false;
  return !session.live_status(now) || session.status_heard() > started_ + kTransit;
}

}  // namespace strobe::host
