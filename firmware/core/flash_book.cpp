#include "firmware/core/flash_book.hpp"

#include <algorithm>
#include <iterator>

namespace strobe::firmware {

namespace {

MonoTime begin_of(const FlashRecord& flash) {
  return (flash.issue_start.known() ? flash.issue_start : flash.commanded) - FlashBook::kEarly;
}

}  // namespace

void FlashBook::open(ShotRecord& record, Duration shortest) noexcept {
  record_ = &record;
  record_->flashes.clear();
  shortest_ = shortest;
}

void FlashBook::plan(MonoTime commanded, Lamps lamps) noexcept {
  if (record_->flashes.size() == record_->flashes.capacity()) return;
  FlashRecord flash;
  flash.lamps = lamps;
  flash.commanded = commanded;
  record_->flashes.push_back(flash);
}

void FlashBook::issued(std::int32_t flash_index, MonoTime start, MonoTime end) noexcept {
  FlashRecord& flash = record_->flashes[static_cast<std::size_t>(flash_index)];
  flash.issue_start = start;
  flash.issue_end = end;
}

FlashRecord* FlashBook::last_begun(MonoTime seen) noexcept {
  auto& flashes = record_->flashes;
  const auto after =
      std::upper_bound(flashes.begin(), flashes.end(), seen,
                       [](MonoTime t, const FlashRecord& flash) { return t < begin_of(flash); });
  return after == flashes.begin() ? nullptr : &*std::prev(after);
}

Duration FlashBook::until_next(const FlashRecord& flash) const noexcept {
  return &flash == &record_->flashes.back() ? shortest_ : (&flash + 1)->commanded - flash.commanded;
}

void FlashBook::edge(Input sensor, MonoTime seen) noexcept {
  if (record_ == nullptr) return;
  FlashRecord* flash = last_begun(seen);
  if (flash == nullptr) return;
  const Duration since_begin = seen - (begin_of(*flash) + kEarly);
  if (since_begin >= until_next(*flash)) return;
  MonoTime& observed = sensor == Input::sensor_a ? flash->observed_a : flash->observed_b;
  if (observed.known() || since_begin.ns >= shortest_.ns / 2) {
    ++flash->extra_edges;
  } else {
    observed = seen;
  }
}

}  // namespace strobe::firmware
