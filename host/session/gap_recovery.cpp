#include "host/session/gap_recovery.hpp"

namespace strobe::host {
namespace {

constexpr std::int64_t kLongest_ns = 60'000'000'000;
constexpr std::int64_t kNothingNew_ns = 15'000'000'000;
// Until then a status that is heard may have been sent before the start.
constexpr std::int64_t kOnTheWay_ns = 100'000'000;

}  // namespace

bool GapRecovery::over(const Session& session, bool firmware_heard, std::int64_t now_ns) {
  const EventLedger& ledger = session.ledger();
  if (ledger.received() != received_ || progress_ns_ == 0) progress_ns_ = now_ns;
  received_ = ledger.received();
  if (now_ns - started_ns_ > kLongest_ns || now_ns - progress_ns_ > kNothingNew_ns) return true;
  if (!session.status()) return true;  // there is nobody to ask
  if (!ledger.complete()) return false;
  return !firmware_heard || session.status_heard_ns() > started_ns_ + kOnTheWay_ns;
}

}  // namespace strobe::host
