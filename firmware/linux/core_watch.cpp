#include "firmware/linux/core_watch.hpp"

#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/linux/core_timeline.hpp"
#include "firmware/linux/interrupts.hpp"
#include "firmware/linux/perf_event.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kRing = 256 * kPage;  // some 20,000 records

/// In the kernel's order, include/linux/interrupt.h.
constexpr std::array kSoftirqs{"HI",       "TIMER",   "NET_TX", "NET_RX",  "BLOCK",
                               "IRQ_POLL", "TASKLET", "SCHED",  "HRTIMER", "RCU"};

/// Where the kernel puts the numbers, Documentation/trace/events.rst and each event's `format`.
constexpr std::size_t kFirstField = 8;
constexpr std::size_t kWokenThread = 24;

struct Tracepoint {
  const char* name;
  CoreRecord::Kind kind;
};
constexpr std::array kTracepoints{Tracepoint{"irq/irq_handler_entry", CoreRecord::Kind::interrupt_begin},
                                  Tracepoint{"irq/irq_handler_exit", CoreRecord::Kind::interrupt_end},
                                  Tracepoint{"irq/softirq_entry", CoreRecord::Kind::softirq_begin},
                                  Tracepoint{"irq/softirq_exit", CoreRecord::Kind::softirq_end},
                                  Tracepoint{"sched/sched_wakeup", CoreRecord::Kind::woken}};

std::optional<int> tracepoint_id(const SystemFiles& files, const char* name) {
  for (const char* folder : {"sys/kernel/tracing/events/", "sys/kernel/debug/tracing/events/"}) {
    const auto id = files.read(std::string(folder) + name + "/id");
    if (id && is_number(*id)) return std::atoi(id->c_str());
  }
  return std::nullopt;
}

perf_event_attr watched_event(std::uint32_t type, std::uint64_t config) {
  perf_event_attr event{};
  event.size = sizeof event;
  event.type = type;
  event.config = config;
  event.sample_period = 1;
  event.sample_type = PERF_SAMPLE_TID | PERF_SAMPLE_TIME | PERF_SAMPLE_CPU | PERF_SAMPLE_RAW;
  event.sample_id_all = 1;
  event.use_clockid = 1;
  event.clockid = CLOCK_MONOTONIC;
  event.write_backward = 1;
  event.watermark = 1;
  event.wakeup_watermark = kRing;  // nobody waits
  return event;
}

std::string refusal(const char* what) {
  return std::string(what) + ": " + std::strerror(errno) +
         "; be root, have CAP_PERFMON (the unit's AmbientCapabilities and CapabilityBoundingSet), or set "
         "kernel.perf_event_paranoid to 0";
}

template <typename Value>
Value value_at(const std::vector<char>& bytes, std::size_t offset) {
  Value value{};
  if (offset + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// The end of every record: sample_id_all's part of perf_event_open(2).
struct SampleId {
  std::uint32_t pid, tid;
  std::uint64_t time_ns;
  std::uint32_t cpu, reserved;
};

}  // namespace

/// One CPU's records.
class CoreRing {
 public:
  static Result<CoreRing> open(int cpu, pid_t thread,
                               const std::vector<std::pair<int, CoreRecord::Kind>>& tracepoints) {
    perf_event_attr switches = watched_event(PERF_TYPE_SOFTWARE, PERF_COUNT_SW_DUMMY);
    switches.context_switch = 1;
    CoreRing ring(cpu, thread, PerfEvent(switches, -1, cpu));
    if (ring.events_.front().get() < 0) return fail(refusal("perf_event_open"));
    ring.pages_ = mmap(nullptr, kPage + kRing, PROT_READ, MAP_SHARED, ring.events_.front().get(), 0);
    if (ring.pages_ == MAP_FAILED) return fail(refusal("the perf ring of 1 MiB"));
    ring.add(watched_event(PERF_TYPE_SOFTWARE, PERF_COUNT_SW_PAGE_FAULTS_MAJ), thread);
    for (const auto& [id, kind] : tracepoints) {
      if (!ring.add(watched_event(PERF_TYPE_TRACEPOINT, static_cast<std::uint64_t>(id)), -1)) continue;
      ring.kinds_.emplace_back(id, kind);
      if (kind != CoreRecord::Kind::woken) continue;
      const std::string filter = "pid == " + std::to_string(thread);
      ring.tells_wakings_ = ioctl(ring.events_.back().get(), PERF_EVENT_IOC_SET_FILTER, filter.c_str()) == 0;
    }
    ring.opened_ = SystemClock().now();
    return ring;
  }
  CoreRing(CoreRing&& other) noexcept
      : cpu_(other.cpu_),
        thread_(other.thread_),
        events_(std::move(other.events_)),
        pages_(std::exchange(other.pages_, MAP_FAILED)),
        kinds_(std::move(other.kinds_)),
        tells_wakings_(other.tells_wakings_),
        opened_(other.opened_) {}
  CoreRing& operator=(CoreRing&&) = delete;
  ~CoreRing() {
    if (pages_ != MAP_FAILED) munmap(pages_, kPage + kRing);
  }

  void read_into(CoreTimeline& timeline) const {
    ioctl(events_.front().get(), PERF_EVENT_IOC_PAUSE_OUTPUT, 1);
    const std::uint64_t head =
        __atomic_load_n(&static_cast<const perf_event_mmap_page*>(pages_)->data_head, __ATOMIC_ACQUIRE);
    const std::uint64_t written = -head;  // the ring is written downwards from 0
    const bool whole = written <= kRing;
    std::vector<char> record;
    MonoTime oldest = opened_;
    for (std::uint64_t read = 0; read < std::min<std::uint64_t>(written, kRing);) {
      perf_event_header header{};
      copy(head + read, &header, sizeof header);
      if (header.size < sizeof header || read + header.size > kRing) break;
      record.resize(header.size);
      copy(head + read, record.data(), header.size);
      read += header.size;
      if (const MonoTime at = decode(header, record, timeline); !whole && known(at)) oldest = at;
    }
    ioctl(events_.front().get(), PERF_EVENT_IOC_PAUSE_OUTPUT, 0);
    timeline.cpus.insert(cpu_);
    timeline.since = std::max(timeline.since, oldest);
    timeline.tells_wakings = tells_wakings_;
  }

 private:
  CoreRing(int cpu, pid_t thread, PerfEvent switches) : cpu_(cpu), thread_(thread) {
    events_.push_back(std::move(switches));
  }

  bool add(const perf_event_attr& event, pid_t thread) {
    PerfEvent added(event, thread, cpu_);
    if (added.get() < 0 || ioctl(added.get(), PERF_EVENT_IOC_SET_OUTPUT, events_.front().get()) != 0)
      return false;
    events_.push_back(std::move(added));
    return true;
  }

  void copy(std::uint64_t at, void* to, std::size_t bytes) const {
    const char* ring = static_cast<const char*>(pages_) + kPage;
    const std::size_t begin = at % kRing;
    const std::size_t first = std::min(bytes, kRing - begin);
    std::memcpy(to, ring + begin, first);
    std::memcpy(static_cast<char*>(to) + first, ring, bytes - first);
  }

  /// Returns its instant, kNoTime if it is of another kind.
  MonoTime decode(const perf_event_header& header, const std::vector<char>& bytes,
                  CoreTimeline& timeline) const {
    CoreRecord record;
    record.cpu = cpu_;
    if (header.type == PERF_RECORD_SWITCH_CPU_WIDE) {
      const auto id = value_at<SampleId>(bytes, bytes.size() - sizeof(SampleId));
      record.at = from_ns(static_cast<std::int64_t>(id.time_ns));
      const bool out = (header.misc & PERF_RECORD_MISC_SWITCH_OUT) != 0;
      record.from = static_cast<pid_t>(id.tid);
      record.to = value_at<pid_t>(bytes, sizeof header + sizeof(std::uint32_t));
      if (!out) std::swap(record.from, record.to);
      // Each switch is recorded twice, but for one from idle.
      if (!out && record.from != 0) return record.at;
      record.preempted = (header.misc & PERF_RECORD_MISC_SWITCH_OUT_PREEMPT) != 0;
      timeline.records.push_back(record);
      return record.at;
    }
    if (header.type != PERF_RECORD_SAMPLE) return kNoTime;
    const auto id = value_at<SampleId>(bytes, sizeof header);
    record.at = from_ns(static_cast<std::int64_t>(id.time_ns));
    const std::size_t raw = sizeof header + sizeof(SampleId) + sizeof(std::uint32_t);
    record.kind = CoreRecord::Kind::page_fault;
    if (value_at<std::uint32_t>(bytes, raw - sizeof(std::uint32_t)) > kFirstField) {
      const int type = value_at<std::uint16_t>(bytes, raw);
      for (const auto& [known_type, kind] : kinds_)
        if (known_type == type) record.kind = kind;
      record.number = value_at<std::int32_t>(bytes, raw + kFirstField);
      if (record.kind == CoreRecord::Kind::woken && value_at<pid_t>(bytes, raw + kWokenThread) != thread_)
        return record.at;
    }
    timeline.records.push_back(record);
    return record.at;
  }

  int cpu_;
  pid_t thread_;
  std::vector<PerfEvent> events_;  ///< the first owns the ring
  void* pages_ = MAP_FAILED;
  std::vector<std::pair<int, CoreRecord::Kind>> kinds_;  ///< by tracepoint
  bool tells_wakings_ = false;
  MonoTime opened_;
};

namespace {

std::string thread_name(const SystemFiles& files, int number) {
  const std::string pid = std::to_string(number);
  return files.read("proc/" + pid + "/comm").value_or("(gone)") + " (pid " + pid + ")";
}

std::string interrupt_name(const SystemFiles& files, int number) {
  std::string name = "interrupt " + std::to_string(number);
  for (const Interrupt& interrupt : read_interrupts(files))
    if (interrupt.number == number && !interrupt.name.empty()) name += " (" + interrupt.name + ")";
  return name;
}

std::string softirq_name(int number) {
  const auto index = static_cast<std::size_t>(number);
  return index < kSoftirqs.size() ? kSoftirqs[index] : std::to_string(number);
}

}  // namespace

std::string in_words(const Culprit& culprit) {
  const std::string took = " for " + std::to_string(culprit.took / microseconds(1)) + " us";
  switch (culprit.kind) {
    case Culprit::Kind::thread:
    case Culprit::Kind::interrupt:
      return culprit.name + " ran" + took;
    case Culprit::Kind::softirq:
      return "softirq " + culprit.name + " ran" + took;
    case Culprit::Kind::page_fault:
      return "a page fault held it" + took;
    case Culprit::Kind::waited:
      return "it slept" + took + ", and nothing else kept it";
    case Culprit::Kind::core_stopped:
      return "the core stood still" + took;
    case Culprit::Kind::unknown:
      break;
  }
  return "no record tells what ran";
}

namespace {

std::int64_t kernels_monotonic_ns() {
  timespec t{};
  syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

}  // namespace

bool clock_is_the_kernels() {
  const std::int64_t before_ns = kernels_monotonic_ns();
  const std::int64_t here_ns = to_ns(SystemClock().now());
  return before_ns <= here_ns && here_ns <= kernels_monotonic_ns();
}

struct CoreWatch::Rings {
  pid_t thread = 0;
  std::vector<CoreRing> rings;
};

CoreWatch::CoreWatch(std::unique_ptr<Rings> rings) : rings_(std::move(rings)) {}
CoreWatch::CoreWatch(CoreWatch&&) noexcept = default;
CoreWatch& CoreWatch::operator=(CoreWatch&&) noexcept = default;
CoreWatch::~CoreWatch() = default;

Result<CoreWatch> CoreWatch::open(const std::set<int>& cpus, pid_t tid) {
  const SystemFiles files;
  std::vector<std::pair<int, CoreRecord::Kind>> tracepoints;
  for (const Tracepoint& each : kTracepoints)
    if (const auto id = tracepoint_id(files, each.name)) tracepoints.emplace_back(*id, each.kind);
  auto rings = std::make_unique<Rings>();
  rings->thread = tid;
  for (const int cpu : cpus) {
    auto ring = CoreRing::open(cpu, tid, tracepoints);
    if (!ring) return tl::unexpected(ring.error());
    rings->rings.push_back(std::move(*ring));
  }
  return CoreWatch(std::move(rings));
}

Culprit CoreWatch::culprit(MonoTime from, MonoTime to) {
  CoreTimeline timeline;
  timeline.since = MonoTime::min();
  for (const CoreRing& ring : rings_->rings) ring.read_into(timeline);
  const NumberedCulprit found = find_culprit(std::move(timeline), rings_->thread, from, to);
  const SystemFiles files;
  std::string name;
  if (found.kind == Culprit::Kind::thread) name = thread_name(files, found.number);
  if (found.kind == Culprit::Kind::interrupt) name = interrupt_name(files, found.number);
  if (found.kind == Culprit::Kind::softirq) name = softirq_name(found.number);
  return {found.kind, std::move(name), found.took};
}

}  // namespace strobe::firmware
