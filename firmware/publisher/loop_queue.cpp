#include "firmware/publisher/loop_queue.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::firmware {

LoopQueue::LoopQueue(const Rig& rig, Wake& publisher) : queue_(kCapacity), publisher_(publisher) {
  for (Slot& slot : slots_) slot.record.flashes.reserve(static_cast<std::size_t>(rig.lamps.max_flashes));
}

void LoopQueue::event(const Event& event) noexcept {
  const Item item(event);
  if (!queue_.try_enqueue(item)) overflows_.fetch_add(1, std::memory_order_relaxed);
  news_ = true;
}

void LoopQueue::status(const LoopStatus& status) noexcept {
  unsent_status_.reset();
  const Item item(status);
  if (!queue_.try_enqueue(item)) unsent_status_ = status;
  news_ = true;
}

ShotRecord* LoopQueue::free_record() noexcept {
  for (Slot& slot : slots_) {
    if (slot.free.load(std::memory_order_acquire)) return &slot.record;
  }
  return nullptr;
}

LoopQueue::Slot& LoopQueue::slot_of(const ShotRecord* record) noexcept {
  const auto slot = std::find_if(slots_.begin(), slots_.end(),
                                 [record](const Slot& each) { return &each.record == record; });
  assert(slot != slots_.end());
  return *slot;
}

bool LoopQueue::shot_done(ShotRecord* record) noexcept {
  slot_of(record).free.store(false, std::memory_order_relaxed);
  const Item item(record);
  const bool taken = queue_.try_enqueue(item);
  news_ = news_ || taken;
  return taken;
}

void LoopQueue::give_back(ShotRecord* record) {
  Slot& slot = slot_of(record);
  assert(!slot.free.load(std::memory_order_relaxed));
  slot.free.store(true, std::memory_order_release);
}

void LoopQueue::flush() noexcept {
  if (unsent_status_) status(LoopStatus(*unsent_status_));
  if (!news_) return;
  news_ = !publisher_.wake();
}

}  // namespace strobe::firmware
