#include "firmware/publisher/resend_queue.hpp"

#include <algorithm>
#include <utility>

namespace strobe::firmware {

namespace {

bool within(const EventRange& inner, const EventRange& outer) {
  return inner.boot_id == outer.boot_id && inner.sequences.first >= outer.sequences.first &&
         inner.sequences.last <= outer.sequences.last;
}

}  // namespace

bool ResendQueue::asked_for(const EventRange& range) const {
  const auto holds = [&range](const EventRange& other) { return within(range, other); };
  return holds(being_answered_) || std::ranges::any_of(hosts_, [&](const Host& host) {
           return std::ranges::any_of(host.this_boot, holds) || std::ranges::any_of(host.earlier, holds);
         });
}

ResendQueue::Host* ResendQueue::host(std::int64_t id) {
  const auto known = std::ranges::find(hosts_, id, &Host::id);
  if (known != hosts_.end()) return &*known;
  if (hosts_.size() == kMaxHosts) return nullptr;
  return &hosts_.emplace_back(Host{id, {}, {}});
}

bool ResendQueue::add(const ResendRequest& request) {
  EventRange range = request.range;
  range.sequences.first = std::max<std::int64_t>(range.sequences.first, 1);
  if (range.sequences.last < range.sequences.first) return false;
  range.sequences.last -=
      std::max<std::int64_t>(range.sequences.last - range.sequences.first + 1 - kMaxEvents, 0);
  if (asked_for(range)) return true;
  Host* const asking = host(request.host_id);
  if (asking == nullptr) return false;
  std::deque<EventRange>& waiting = request.this_boot ? asking->this_boot : asking->earlier;
  if (waiting.size() == kMaxOfHost) return false;
  waiting.push_back(range);
  return true;
}

std::optional<EventRange> ResendQueue::next() {
  being_answered_ = {};
  if (hosts_.empty()) return std::nullopt;
  Host served = std::move(hosts_.front());
  hosts_.pop_front();
  std::deque<EventRange>& waiting = served.this_boot.empty() ? served.earlier : served.this_boot;
  being_answered_ = waiting.front();
  waiting.pop_front();
  if (!served.this_boot.empty() || !served.earlier.empty()) hosts_.push_back(std::move(served));
  return being_answered_;
}

}  // namespace strobe::firmware
