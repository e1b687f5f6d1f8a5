#include "firmware/linux/core_timeline.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace strobe::firmware {

namespace {

using Kind = Culprit::Kind;
using Occupant = std::pair<Kind, int>;

/// The kernel records a page fault that slept once the thread is back and has the page.
constexpr Duration kWakeToFault = microseconds(100);
constexpr pid_t kIdle = 0;

struct Core {
  pid_t running = kIdle;
  std::vector<int> interrupts;  ///< nested, the innermost last
  std::vector<int> softirqs;
};

/// Goes through a timeline and tells who has the thread's CPU.
class Replay {
 public:
  Replay(const CoreTimeline& timeline, pid_t thread) : timeline_(timeline), thread_(thread) {
    std::set<int> unswitched = timeline.cpus;
    bool placed = false;
    for (const CoreRecord& record : timeline.records) {
      if (record.kind != CoreRecord::Kind::switched) continue;
      if (unswitched.erase(record.cpu) > 0) cores_[record.cpu].running = record.from;
      if (placed || (record.from != thread && record.to != thread)) continue;
      placed = true;
      cpu_ = record.cpu;
      runs_ = record.from == thread;
    }
    // It has kept its CPU all the time: one on which nothing was switched.
    if (!placed && !unswitched.empty()) cpu_ = *unswitched.begin();
  }

  void apply(std::size_t index) {
    const CoreRecord& record = timeline_.records[index];
    Core& core = cores_[record.cpu];
    switch (record.kind) {
      case CoreRecord::Kind::switched:
        return switch_threads(core, index);
      case CoreRecord::Kind::woken:
        if (!runs_) cpu_ = next_cpu(index);
        asleep_ = waits_for_page_ = false;
        return;
      case CoreRecord::Kind::page_fault:
        return;
      case CoreRecord::Kind::interrupt_begin:
        return core.interrupts.push_back(record.number);
      case CoreRecord::Kind::interrupt_end:
        return end(core.interrupts);
      case CoreRecord::Kind::softirq_begin:
        return core.softirqs.push_back(record.number);
      case CoreRecord::Kind::softirq_end:
        return end(core.softirqs);
    }
  }

  Occupant occupant() {
    if (!runs_ && asleep_ && timeline_.tells_wakings)
      return {waits_for_page_ ? Kind::page_fault : Kind::waited, 0};
    const Core& core = cores_[cpu_];
    if (!core.interrupts.empty()) return {Kind::interrupt, core.interrupts.back()};
    if (!core.softirqs.empty()) return {Kind::softirq, core.softirqs.back()};
    if (runs_) return {Kind::core_stopped, 0};
    if (waits_for_page_) return {Kind::page_fault, 0};
    if (core.running == kIdle) return {Kind::waited, 0};
    return {Kind::thread, core.running};
  }

 private:
  static void end(std::vector<int>& open) {
    if (!open.empty()) open.pop_back();
  }

  void switch_threads(Core& core, std::size_t index) {
    const CoreRecord& record = timeline_.records[index];
    core.running = record.to;
    core.softirqs.clear();  // with PREEMPT_RT they are a thread's work, and preempted with it
    if (record.from == thread_) {
      runs_ = false;
      cpu_ = record.cpu;
      asleep_ = !record.preempted;
      waits_for_page_ = asleep_ && is_back_with_page(index);
    } else if (record.to == thread_) {
      runs_ = true;
      cpu_ = record.cpu;
      asleep_ = waits_for_page_ = false;
    }
  }

  bool is_back_with_page(std::size_t index) const {
    MonoTime back = kNoTime;
    for (std::size_t i = index + 1; i < timeline_.records.size(); ++i) {
      const CoreRecord& record = timeline_.records[i];
      if (known(back) && record.at - back > kWakeToFault) return false;
      if (known(back) && record.kind == CoreRecord::Kind::page_fault) return true;
      if (record.kind == CoreRecord::Kind::switched && record.to == thread_) back = record.at;
    }
    return false;
  }

  /// Where the thread runs next: there it has been waiting since it was woken.
  int next_cpu(std::size_t index) const {
    for (std::size_t i = index; i < timeline_.records.size(); ++i) {
      const CoreRecord& record = timeline_.records[i];
      if (record.kind == CoreRecord::Kind::switched && record.to == thread_) return record.cpu;
    }
    return cpu_;
  }

  const CoreTimeline& timeline_;
  pid_t thread_;
  std::map<int, Core> cores_;
  int cpu_ = 0;
  bool runs_ = true;
  bool asleep_ = false;
  bool waits_for_page_ = false;
};

}  // namespace

NumberedCulprit find_culprit(CoreTimeline timeline, pid_t thread, MonoTime from, MonoTime to) {
  if (timeline.since > from || from >= to) return {};
  std::vector<CoreRecord>& records = timeline.records;
  std::stable_sort(records.begin(), records.end(),
                   [](const CoreRecord& a, const CoreRecord& b) { return a.at < b.at; });
  Replay replay(timeline, thread);
  std::map<Occupant, Duration> took;
  MonoTime since = from;
  for (std::size_t i = 0; i < records.size() && records[i].at < to; ++i) {
    if (records[i].at > since) {
      took[replay.occupant()] += records[i].at - since;
      since = records[i].at;
    }
    replay.apply(i);
  }
  took[replay.occupant()] += to - since;
  const auto most = std::max_element(took.begin(), took.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return {most->first.first, most->first.second, most->second};
}

}  // namespace strobe::firmware
