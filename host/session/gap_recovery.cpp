#include "host/session/gap_recovery.hpp"

namespace strobe::host {
namespace {

constexpr std::int64_t kTimeout_ns = 60'000'000'000;
constexpr std::int64_t kNoProgressTimeout_ns = 15'000'000'000;
// A status that arrives within this time may have been sent before the start.
constexpr std::int64_t kTransit_ns = 100'000'000;

}  // namespace

bool GapRecovery::finished(const Session& session, std::int64_t now_ns) {
  const EventLedger& ledger = session.ledger();
  if (ledger.received() != received_ || progress_ns_ == 0) progress_ns_ = now_ns;
  received_ = ledger.received();
  if (now_ns - started_ns_ > kTimeout_ns || now_ns - progress_ns_ > kNoProgressTimeout_ns) return true;
  if (!session.status()) return true;  // nobody can be asked
  if (!ledger.complete()) return false;
  return !session.live_status(now_ns) || session.status_heard_ns() > started_ns_ + kTransit_ns;
}

}  // namespace strobe::host
