// What is going to happen on the virtual clock, in order of time; at one instant in the order in which it was
// scheduled. One thread's; allocates.
#pragma once

#include <cstdint>
#include <limits>
#include <queue>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::soak {

inline constexpr MonoTime kFarFuture = MonoTime::max();

template <typename What>
class Timeline {
 public:
  struct Happening {
    MonoTime at;
    std::uint64_t order = 0;
    What what{};
  };

  void schedule(MonoTime at, What what) { heap_.push({at, ++order_, std::move(what)}); }
  MonoTime next() const { return heap_.empty() ? kFarFuture : heap_.top().at; }
  bool empty() const { return heap_.empty(); }
  Happening take() {
    Happening first = heap_.top();
    heap_.pop();
    return first;
  }

 private:
  struct Later {
    bool operator()(const Happening& a, const Happening& b) const {
      return a.at != b.at ? a.at > b.at : a.order > b.order;
    }
  };
  std::priority_queue<Happening, std::vector<Happening>, Later> heap_;
  std::uint64_t order_ = 0;
};

}  // namespace strobe::soak
