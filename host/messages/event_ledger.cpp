#include "host/messages/event_ledger.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::host {
namespace {

constexpr Duration kGrace = milliseconds{100};  // datagrams of two senders may overtake each other
constexpr Duration kAskAgain = milliseconds{250};
constexpr std::int64_t kMaxEventsPerAsk = 512;  // so that an answer fits the socket's buffer
constexpr std::size_t kMaxAsks = 8;
// Losses this close to each other are asked for as one range; what comes twice is cheaper than more
// questions.
constexpr std::int64_t kMergeWithin = 64;
constexpr std::int64_t kTail = 1'000'000;
// A lab's are few; a log of years that is played back, or strangers where nothing is verified, have any
// number.
constexpr std::size_t kMaxBoots = 256;
// An ask and its answer each pass a lossy link: at 20 % loss eight in vain have a chance of 0.36^8 = 0.03 %.
constexpr int kTailRequests = 8;
// At 50 % loss 24 in vain have a chance of 0.1 %.
constexpr int kRepeatRequests = 24;

}  // namespace

/// start: first sequence that counts where not everything is wanted.
EventLedger::Boot& EventLedger::boot_of(std::int64_t boot_id, std::int64_t start) {
  const auto [found, is_new] = boots_.try_emplace(boot_id);
  Boot& boot = found->second;
  if (is_new) {
    if (boots_.size() > kMaxBoots) forget_one_but(boot_id);
    boot.start = from_start_ ? 1 : start;
    boot.tail_requests_left = from_start_ ? kTailRequests : 0;
  }
  return boot;
}

/// The one heard longest ago.
void EventLedger::forget_one_but(std::int64_t newest) {
  auto oldest = boots_.end();
  for (auto it = boots_.begin(); it != boots_.end(); ++it) {
    if (it->first == newest || it->first == current_boot_) continue;
    if (oldest == boots_.end() || it->second.heard < oldest->second.heard) oldest = it;
  }
  boots_.erase(oldest);
}

bool EventLedger::add(std::int64_t boot_id, std::int64_t sequence, HostTime now) {
  if (sequence < 1) return false;
  Boot& boot = boot_of(boot_id, sequence);
  boot.heard = now;
  boot.again.erase(sequence);
  auto next = boot.runs.upper_bound(sequence);
  if (next != boot.runs.begin() && std::prev(next)->second >= sequence) return false;
  std::int64_t first = sequence, last = sequence;
  if (next != boot.runs.begin() && std::prev(next)->second == sequence - 1) {
    first = std::prev(next)->first;
    boot.runs.erase(std::prev(next));
  }
  if (next != boot.runs.end() && next->first == sequence + 1) {
    last = next->second;
    boot.runs.erase(next);
  }
  boot.runs[first] = last;
  if (sequence > boot.newest + 1 || boot.gap_since == HostTime{}) boot.gap_since = now;
  boot.newest = std::max(boot.newest, sequence);
  if (boot_id != current_boot_ && from_start_ && !boot.end_known) boot.tail_requests_left = kTailRequests;
  assert(consistent(boot));
  return true;
}

/// Runs are in order, with a gap between two, and none goes beyond the newest event.
bool EventLedger::consistent(const Boot& boot) {
  std::int64_t before = -1;
  for (const auto& [first, last] : boot.runs) {
    if (first <= before + 1 || last < first || last > boot.newest) return false;
    before = last;
  }
  return true;
}

void EventLedger::status(std::int64_t boot_id, std::int64_t last_sequence, HostTime now) {
  current_boot_ = boot_id;
  if (last_sequence < 1) return;
  Boot& boot = boot_of(boot_id, last_sequence + 1);
  if (last_sequence > boot.newest) {
    boot.gap_since = now;
    boot.newest = last_sequence;
  }
}

void EventLedger::earlier(std::span<const EndedBoot> boots, HostTime now) {
  const auto heard = [this](const EndedBoot& ended) { return boots_.contains(ended.boot_id); };
  const auto oldest = std::find_if(boots.rbegin(), boots.rend(), heard);
  for (auto ended = boots.begin(); ended != oldest.base(); ++ended) {
    Boot& boot = boot_of(ended->boot_id, ended->last_sequence + 1);
    if (ended->last_sequence > boot.newest) {
      boot.gap_since = now;
      boot.newest = ended->last_sequence;
    }
    boot.end_known = true;
    boot.tail_requests_left = 0;
  }
}

void EventLedger::request_again(std::int64_t boot_id, std::int64_t sequence) {
  if (sequence >= 1) boot_of(boot_id, sequence).again.try_emplace(sequence, 0);
}

void EventLedger::cancel_request(std::int64_t boot_id, std::int64_t sequence) {
  if (const auto boot = boots_.find(boot_id); boot != boots_.end()) boot->second.again.erase(sequence);
}

std::vector<EventRange> EventLedger::gaps(std::int64_t boot_id, const Boot& boot) const {
  std::vector<EventRange> ranges;
  std::int64_t next = boot.start;
  const auto gap = [&](std::int64_t first, std::int64_t last) {
    if (first > last) return;
    const bool merges = !ranges.empty() && first - ranges.back().sequences.last <= kMergeWithin &&
                        last - ranges.back().sequences.first < kMaxEventsPerAsk;
    if (merges) {
      ranges.back().sequences.last = last;
    } else {
      ranges.push_back({boot_id, {first, std::min(last, first + kMaxEventsPerAsk - 1)}});
    }
  };
  for (const auto& [first, last] : boot.runs) {
    gap(next, first - 1);
    next = std::max(next, last + 1);
  }
  gap(next, boot.newest);
  return ranges;
}

std::vector<EventRange> EventLedger::due(HostTime now) {
  std::vector<EventRange> asks;
  for (auto& [boot_id, boot] : boots_) {
    if (now - boot.gap_since < kGrace || now - boot.asked < kAskAgain) continue;
    std::vector<EventRange> ranges = gaps(boot_id, boot);
    // First: with it comes the shot's summary, which somebody waits for.
    std::vector<EventRange> again;
    for (auto& [sequence, asked] : boot.again) {
      ++asked;
      again.push_back({boot_id, {sequence, sequence}});
    }
    if (boot_id != current_boot_)
      std::erase_if(boot.again, [](const auto& wanted) { return wanted.second >= kRepeatRequests; });
    ranges.insert(ranges.begin(), again.begin(), again.end());
    if (ranges.empty() && boot_id != current_boot_ && current_boot_ != 0 && boot.tail_requests_left > 0) {
      --boot.tail_requests_left;
      ranges.push_back({boot_id, {boot.newest + 1, boot.newest + kTail}});
    }
    if (ranges.size() > kMaxAsks) ranges.resize(kMaxAsks);
    if (!ranges.empty()) boot.asked = now;
    asks.insert(asks.end(), ranges.begin(), ranges.end());
  }
  return asks;
}

std::int64_t EventLedger::missing_of(const Boot& boot) {
  if (boot.newest < boot.start) return 0;
  std::int64_t missing = boot.newest - boot.start + 1;
  for (const auto& [first, last] : boot.runs) missing -= last - std::max(first, boot.start) + 1;
  return missing;
}

std::int64_t EventLedger::missing() const {
  std::int64_t sum = 0;
  for (const auto& [boot_id, boot] : boots_) sum += missing_of(boot);
  return sum;
}

bool EventLedger::complete() const {
  return std::all_of(boots_.begin(), boots_.end(), [this](const auto& entry) {
    const auto& [boot_id, boot] = entry;
    return missing_of(boot) == 0 && boot.again.empty() &&
           (boot_id == current_boot_ || boot.tail_requests_left == 0);
  });
}

std::int64_t EventLedger::received() const {
  std::int64_t sum = 0;
  for (const auto& [boot_id, boot] : boots_) {
    for (const auto& [first, last] : boot.runs) sum += last - first + 1;
  }
  return sum;
}

bool EventLedger::holds(std::int64_t boot_id, std::int64_t first, std::int64_t last) const {
  const auto boot = boots_.find(boot_id);
  if (boot == boots_.end()) return false;
  const auto after = boot->second.runs.upper_bound(first);
  return after != boot->second.runs.begin() && std::prev(after)->second >= last;
}

bool EventLedger::ended_and_complete(std::int64_t boot_id) const {
  const auto found = boots_.find(boot_id);
  if (found == boots_.end() || boot_id == current_boot_ || current_boot_ == 0) return false;
  const Boot& boot = found->second;
  return missing_of(boot) == 0 && (boot.end_known || (from_start_ && boot.tail_requests_left == 0));
}

}  // namespace strobe::host
