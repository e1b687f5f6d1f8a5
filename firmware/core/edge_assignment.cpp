#include "firmware/core/edge_assignment.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace strobe::firmware {

namespace {

MonoTime begin_of(const FlashRecord& flash) {
  return (known(flash.issue_start) ? flash.issue_start : flash.commanded) - EdgeAssignment::kEarly;
}

}  // namespace

void EdgeAssignment::open(ShotRecord& record, Duration shortest) noexcept {
  assert(shortest > Duration{});
  record_ = &record;
  record_->flashes.clear();
  shortest_ = shortest;
}

void EdgeAssignment::plan(MonoTime commanded, Lamps lamps) noexcept {
  if (record_->flashes.size() == record_->flashes.capacity()) return;
  assert(record_->flashes.empty() || record_->flashes.back().commanded < commanded);
  FlashRecord flash;
  flash.lamps = lamps;
  flash.commanded = commanded;
  record_->flashes.push_back(flash);
}

void EdgeAssignment::issued(std::int32_t flash_index, MonoTime start, MonoTime end) noexcept {
  assert(flash_index >= 0 && static_cast<std::size_t>(flash_index) < record_->flashes.size());
  FlashRecord& flash = record_->flashes[static_cast<std::size_t>(flash_index)];
  flash.issue_start = start;
  flash.issue_end = end;
}

FlashRecord* EdgeAssignment::latest_begun_by(MonoTime seen) noexcept {
  auto& flashes = record_->flashes;
  const auto after =
      std::upper_bound(flashes.begin(), flashes.end(), seen,
                       [](MonoTime t, const FlashRecord& flash) { return t < begin_of(flash); });
  return after == flashes.begin() ? nullptr : &*std::prev(after);
}

Duration EdgeAssignment::until_next(const FlashRecord& flash) const noexcept {
  return &flash == &record_->flashes.back() ? shortest_ : (&flash + 1)->commanded - flash.commanded;
}

void EdgeAssignment::edge(Input sensor, MonoTime seen) noexcept {
  if (record_ == nullptr) return;
  FlashRecord* flash = latest_begun_by(seen);
  if (flash == nullptr) return;
  assert(begin_of(*flash) <= seen);
  const Duration since_begin = seen - (begin_of(*flash) + kEarly);
  if (since_begin >= until_next(*flash)) return;
  MonoTime& observed = sensor == Input::sensor_a ? flash->observed_a : flash->observed_b;
  if (known(observed) || since_begin >= shortest_ / 2) {
    ++flash->extra_edges;
  } else {
    observed = seen;
  }
}

}  // namespace strobe::firmware
