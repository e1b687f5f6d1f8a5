#include "firmware/publisher/resend.hpp"

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

namespace {

std::int64_t size_of(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<std::int64_t>(size);
}

}  // namespace

RangeReader::RangeReader(const std::filesystem::path& path, const SequenceRange& wanted)
    : log_(path), wanted_(wanted) {
  narrow(0, wanted.first > 1 ? size_of(path) : 0);
}

void RangeReader::narrow(std::int64_t begin, std::int64_t end) {
  begin_ = begin;
  end_ = end;
  middle_ = begin + (end - begin) / 2;
  log_.seek(found() ? begin_ : middle_);
}

RangeReader::Step RangeReader::step(wire::LogRecord& record) {
  if (over_) return Step::done;
  if (found()) return collect(record);
  halve();
  return Step::searching;
}

/// One step of the search for a record behind the middle, and once it is found, of the halving.
void RangeReader::halve() {
  wire::LogRecord record;
  const wire::LogReader::Step step = log_.advance(record);
  if (step == wire::LogReader::Step::end || (step == wire::LogReader::Step::searching && log_.at() >= end_))
    return narrow(begin_, middle_);
  if (step == wire::LogReader::Step::searching) return;
  const auto entry = entry_of(record);
  // The search began anywhere: what looks like a record may be a part of one.
  if (!entry) return log_.seek(record.offset + 1);
  if (record.offset < end_ && entry->sequences.last < wanted_.first) return narrow(log_.at(), end_);
  narrow(begin_, middle_);
}

RangeReader::Step RangeReader::collect(wire::LogRecord& record) {
  const wire::LogReader::Step step = log_.advance(record);
  over_ = step == wire::LogReader::Step::end;
  if (step != wire::LogReader::Step::record) return over_ ? Step::done : Step::searching;
  const auto entry = entry_of(record);
  if (!entry || entry->sequences.last < wanted_.first) return Step::searching;
  if (entry->kind == Message::Kind::shot) {
    over_ = entry->sequences.last >= wanted_.last;
    return entry->sequences.first <= wanted_.last ? Step::message : Step::done;
  }
  if (entry->sequences.last <= wanted_.last) {
    shot_id_ = entry->shot_id;
    return Step::message;
  }
  // The summary of the shot that the last event belongs to comes behind all of that shot's events.
  over_ = shot_id_ == 0 || entry->shot_id != shot_id_;
  return over_ ? Step::done : Step::searching;
}

}  // namespace strobe::firmware
