// Queue of what is scheduled on the virtual clock, in order of time; items of one instant keep their order.
// One thread's; allocates.
#pragma once

#include <cstdint>
#include <queue>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::soak {

inline constexpr MonoTime kFarFuture = MonoTime::max();

template <typename Item>
class Timeline {
 public:
  struct Entry {
    MonoTime at;
    std::uint64_t order = 0;
    Item item{};
  };

  void schedule(MonoTime at, Item item) { heap_.push({at, ++order_, std::move(item)}); }
  MonoTime next() const { return heap_.empty() ? kFarFuture : heap_.top().at; }
  bool empty() const { return heap_.empty(); }
  Entry take() {
    Entry first = heap_.top();
    heap_.pop();
    return first;
  }

 private:
  struct Later {
    bool operator()(const Entry& a, const Entry& b) const {
      return a.at != b.at ? a.at > b.at : a.order > b.order;
    }
  };
  std::priority_queue<Entry, std::vector<Entry>, Later> heap_;
  std::uint64_t order_ = 0;
};

}  // namespace strobe::soak
