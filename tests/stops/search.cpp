#include "tests/stops/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <deque>
#include <string_view>
#include <unordered_set>

namespace strobe::stops {

namespace {

constexpr std::uint32_t kMaxStates = 4'000'000;

struct KeyHash {
  std::size_t operator()(const Key& key) const {
    return std::hash<std::string_view>{}({reinterpret_cast<const char*>(key.data()), key.size()});
  }
};

/// How a state was first reached.
struct Trace {
  std::uint32_t from = 0;
  Step by = Step::count;
};

class Search {
 public:
  Search(const Limits& limits, const Fault& fault) : ways_back_(limits.ways_back) {
    add(Model(limits, fault), {});
  }

  Found run() {
    const auto begin = std::chrono::steady_clock::now();
    for (std::uint32_t place = 0; !open_.empty() && found_.wrong.empty(); ++place) {
      if (place > kMaxStates) found_.wrong = "MORE STATES THAN EXPECTED";
      expand(open_.front(), place);
      open_.pop_front();
    }
    found_.states = traces_.size();
    found_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return found_;
  }

 private:
  void add(Model&& model, Trace trace) {
    if (!known_.insert(model.key()).second) return;
    traces_.push_back(trace);
    open_.push_back(std::move(model));
  }

  void expand(const Model& model, std::uint32_t place) {
    int turns = 0;
    const std::string stuck = ways_back_ ? model.revive(turns) : "";
    if (!stuck.empty()) return report(stuck, place, Step::count);
    found_.turns = std::max(found_.turns, turns);
    for (int i = 0; i < static_cast<int>(Step::count); ++i) {
      const Step step = static_cast<Step>(i);
      if (!model.possible(step)) continue;
      Model next = model;
      ++found_.transitions;
      if (const std::string wrong = next.take(step); !wrong.empty()) return report(wrong, place, step);
      if (next.triggered()) ++found_.triggers;
      add(std::move(next), {place, step});
    }
    if (open_.size() == 1) found_.depth = path_to(place).size();
  }

  std::vector<Step> path_to(std::uint32_t place) const {
    std::vector<Step> path;
    for (; place != 0; place = traces_[place].from) path.push_back(traces_[place].by);
    std::reverse(path.begin(), path.end());
    return path;
  }

  void report(const std::string& wrong, std::uint32_t place, Step last) {
    found_.wrong = wrong;
    found_.path = path_to(place);
    if (last != Step::count) found_.path.push_back(last);
  }

  bool ways_back_;
  std::deque<Model> open_;
  std::vector<Trace> traces_;
  std::unordered_set<Key, KeyHash> known_;
  Found found_;
};

}  // namespace

Found search(const Limits& limits, const Fault& fault) { return Search(limits, fault).run(); }

std::string in_words(const Found& found) {
  std::string text = fmt::format(
      "{} states, {} transitions, {} triggers, depth {}, at most {} turns from act to trigger, {:.1f} s",
      found.states, found.transitions, found.triggers, found.depth, found.turns, found.seconds);
  if (found.wrong.empty()) return text;
  text += "\n  " + found.wrong + ":";
  for (const Step step : found.path) text += fmt::format("\n    {}", words(step));
  return text;
}

}  // namespace strobe::stops
