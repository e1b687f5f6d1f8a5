// A map of bounded size that forgets what was entered first. Shots and events are keyed by boot, and boots
// are random numbers: the smallest key is not the oldest. Not thread-safe; allocates.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <utility>

namespace strobe {

template <typename Key, typename Value>
class RecentMap {
 public:
  /// capacity: at least 1.
  explicit RecentMap(std::size_t capacity) : capacity_(capacity) { assert(capacity > 0); }

  /// Enters or replaces; a key that is replaced keeps its age.
  Value& put(const Key& key, Value value) {
    if (!map_.contains(key)) {
      if (order_.size() == capacity_) {
        map_.erase(order_.front());
        order_.pop_front();
      }
      order_.push_back(key);
    }
    assert(order_.size() <= capacity_);
    return map_.insert_or_assign(key, std::move(value)).first->second;
  }
  const Value* find(const Key& key) const {
    const auto found = map_.find(key);
    return found == map_.end() ? nullptr : &found->second;
  }
  Value* find(const Key& key) {
    const auto found = map_.find(key);
    return found == map_.end() ? nullptr : &found->second;
  }
  std::optional<Value> take(const Key& key) {
    auto node = map_.extract(key);
    if (node.empty()) return std::nullopt;
    order_.erase(std::ranges::find(order_, key));
    return std::move(node.mapped());
  }
  /// In the order of the keys.
  const std::map<Key, Value>& all() const { return map_; }

 private:
  std::size_t capacity_;
  std::map<Key, Value> map_;
  std::deque<Key> order_;  ///< oldest first
};

}  // namespace strobe
