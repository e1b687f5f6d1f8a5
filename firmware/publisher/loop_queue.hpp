// From the loop to the publisher: a lock-free queue of one producer and one consumer, allocated at the start.
#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "firmware/core/rig.hpp"
#include "firmware/ports/event_sink.hpp"
#include "firmware/ports/wake.hpp"

// moodycamel's queue is annotated for the thread sanitizer, which does not see its fences under g++ and would
// report every hand-over as a race.
#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
namespace strobe::firmware {
inline int tsan_fence;
}
#define AE_TSAN_ANNOTATE_RELEASE() __tsan_release(&strobe::firmware::tsan_fence)
#define AE_TSAN_ANNOTATE_ACQUIRE() __tsan_acquire(&strobe::firmware::tsan_fence)
#endif

#include <readerwriterqueue/readerwriterqueue.h>

namespace strobe::firmware {

/// Allocates at construction only, as long as try_enqueue() is used.
template <typename T>
using SpscQueue = moodycamel::ReaderWriterQueue<T>;

/// The loop calls the EventSink (real-time safe), the publisher pop() and what follows it.
class LoopQueue final : public EventSink {
 public:
  /// More than a shot's events: for each flash an issue and two sensor edges, and a sensor that chatters.
  static constexpr std::size_t kCapacity = 16384;
  static constexpr std::size_t kRecords = 4;
  using Item = std::variant<Event, LoopStatus, ShotRecord*>;

  /// publisher: woken when there is something to do.
  LoopQueue(const Rig& rig, Wake& publisher);

  void event(const Event& event) noexcept override;
  void status(const LoopStatus& status) noexcept override;
  ShotRecord* free_record() noexcept override;
  bool shot_done(ShotRecord* record) noexcept override;
  void flush() noexcept override;
  std::int64_t overflows() const noexcept override { return overflows_.load(std::memory_order_relaxed); }
  bool journal_ok() const noexcept override { return journal_ok_.load(std::memory_order_relaxed); }

  std::int32_t shot_id_limit() const noexcept override {
    return shot_id_limit_.load(std::memory_order_relaxed);
  }

  bool pop(Item& item) { return queue_.try_dequeue(item); }
  void give_back(ShotRecord* record);
  void set_journal_ok(bool ok) { journal_ok_.store(ok, std::memory_order_relaxed); }
  /// Until it is set there is none.
  void set_shot_id_limit(std::int32_t limit) { shot_id_limit_.store(limit, std::memory_order_relaxed); }

 private:
  struct Slot {
    ShotRecord record;
    std::atomic<bool> free{true};
  };
  Slot& slot_of(const ShotRecord* record) noexcept;

  SpscQueue<Item> queue_;
  std::array<Slot, kRecords> slots_;
  std::optional<LoopStatus> unsent_status_;
  std::atomic<std::int64_t> overflows_{0};
  std::atomic<bool> journal_ok_{true};
  std::atomic<std::int32_t> shot_id_limit_{std::numeric_limits<std::int32_t>::max()};
  Wake& publisher_;
  bool news_ = false;
};

}  // namespace strobe::firmware
