#include "host/session/collection.hpp"

namespace strobe::host {
namespace {

constexpr std::int64_t kLongest_ns = 10'000'000'000;
// Until then a status that is heard may have been sent before the start.
constexpr std::int64_t kOnTheWay_ns = 100'000'000;

}  // namespace

bool Collection::over(const Session& session, bool firmware_heard, std::int64_t now_ns) const {
  if (!firmware_heard || now_ns - started_ns_ > kLongest_ns) return true;
  return session.status_heard_ns() > started_ns_ + kOnTheWay_ns && session.ledger().complete();
}

}  // namespace strobe::host
