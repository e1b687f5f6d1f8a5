#include "host/session/heard_time.hpp"

namespace strobe::host {

void HeardTime::on_heartbeat(std::int64_t boot_id, MonoTime sent) {
  const Boot* before = boots_.find(boot_id);
  const Duration passed = before ? sent - before->newest : Duration{};
  if (passed < Duration{}) return;
  if (passed <= kSilent) now_ += passed;
  boots_.put(boot_id, {sent, now_});
}

std::optional<Duration> HeardTime::at(std::int64_t boot_id, MonoTime instant) const {
  const Boot* boot = boots_.find(boot_id);
  return boot ? std::optional(boot->at + (instant - boot->newest)) : std::nullopt;
}

}  // namespace strobe::host
