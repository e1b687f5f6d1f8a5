// A few values that are dear to make, those used last. Not thread-safe.
#pragma once

#include <cassert>
#include <cstddef>
#include <list>
#include <utility>

namespace strobe::web {

template <typename Key, typename Value>
class BoundedCache {
 public:
  /// All that is kept costs at most so much, but for the newest value, which is always kept.
  explicit BoundedCache(std::size_t max_cost) : max_cost_(max_cost) {}

  /// Null: it is not kept. Until the next call.
  Value* find(const Key& key) {
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      if (!(entry->key == key)) continue;
      entries_.splice(entries_.begin(), entries_, entry);
      return &entries_.front().value;
    }
    return nullptr;
  }

  Value& put(Key key, Value value, std::size_t cost) {
    erase(key);
    entries_.push_front({std::move(key), std::move(value), cost});
    cost_ += cost;
    while (cost_ > max_cost_ && entries_.size() > 1) {
      cost_ -= entries_.back().cost;
      entries_.pop_back();
    }
    assert(cost_ >= entries_.front().cost);
    return entries_.front().value;
  }

  void erase(const Key& key) {
    entries_.remove_if([&](const Entry& entry) {
      if (!(entry.key == key)) return false;
      cost_ -= entry.cost;
      return true;
    });
  }

  std::size_t size() const { return entries_.size(); }
  std::size_t cost() const { return cost_; }

 private:
  struct Entry {
    Key key;
    Value value;
    std::size_t cost;
  };
  std::size_t max_cost_, cost_ = 0;
  std::list<Entry> entries_;  ///< the one used last first
};

}  // namespace strobe::web
