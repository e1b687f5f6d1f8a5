#include "sim/gpiochip/chip.hpp"

#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "sim/gpiochip/folder.hpp"
#include "sim/gpiochip/levels.hpp"
#include "sim/gpiochip/ownership.hpp"
#include "sim/gpiochip/rig_time.hpp"
#include "sim/gpiochip/system.hpp"

namespace strobe::sim::gpio {
namespace {

constexpr int kDepthV1 = 16;

bool is_active(std::uint32_t config, unsigned level) {
  return (level != 0) != ((config & ConfigWord::kActiveLow) != 0);
}

bool is_wanted(std::uint32_t config, unsigned level) {
  const std::uint32_t edge = is_active(config, level) ? ConfigWord::kRising : ConfigWord::kFalling;
  return (config & ConfigWord::kRequested) != 0 && (config & edge) != 0;
}

void emit_v1(int fifo, std::uint32_t config, unsigned level, std::int64_t stamp_ns) {
  int queued = 0;
  if (fifo < 0 || sys::ioctl(fifo, FIONREAD, &queued) != 0) return;
  gpioevent_data event{};
  if (queued >= kDepthV1 * static_cast<int>(sizeof(event))) return;
  event.timestamp = static_cast<std::uint64_t>(stamp_ns);
  event.id = is_active(config, level) ? GPIOEVENT_EVENT_RISING_EDGE : GPIOEVENT_EVENT_FALLING_EDGE;
  sys::write(fifo, &event, sizeof(event));
}

/// As the kernel's linereq_put_event(). A read takes whole events, also this one of the oldest: nobody reads
/// between its bytes.
void put_dropping_oldest(int fifo, std::uint32_t depth, const gpio_v2_line_event& event) {
  int queued = 0;
  gpio_v2_line_event oldest;
  if (sys::ioctl(fifo, FIONREAD, &queued) != 0) return;
  if (queued >= static_cast<int>(depth * sizeof(event))) sys::read(fifo, &oldest, sizeof(oldest));
  // A FIFO for which the system grants few pages may be full before its depth.
  while (sys::write(fifo, &event, sizeof(event)) < 0 && sys::read(fifo, &oldest, sizeof(oldest)) > 0) {
  }
}

gpio_v2_line_event event_of(State& state, std::uint32_t line, unsigned level, std::int64_t stamp_ns) {
  gpio_v2_line_event event{};
  const std::uint32_t config = state.lines[line].config.load();
  const bool realtime = (config & ConfigWord::kRealtime) != 0;
  event.timestamp_ns =
      static_cast<std::uint64_t>(realtime ? stamp_ns + realtime_ns(state) - now_ns(state) : stamp_ns);
  event.id = is_active(config, level) ? GPIO_V2_LINE_EVENT_RISING_EDGE : GPIO_V2_LINE_EVENT_FALLING_EDGE;
  event.offset = line;
  return event;
}

void emit_v2(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t stamp_ns) {
  State& state = *folder.state;
  const std::uint32_t slot = ConfigWord::slot(state.lines[line].config.load());
  const EmitLock lock(folder.lock_fd, slot);
  // Looked at again: meanwhile the request may have ended and another one have its slot.
  const std::uint32_t config = state.lines[line].config.load();
  const bool same = (config & ConfigWord::kVersion2) != 0 && ConfigWord::slot(config) == slot;
  if (!lock.held() || !same || !is_wanted(config, level) || folder.requests[slot] < 0) return;
  Handle& request = state.handles[slot];
  gpio_v2_line_event event = event_of(state, line, level, stamp_ns);
  // Numbered first: an edge whose process is killed here is missing, and told so by its number.
  event.line_seqno = state.lines[line].seqno.fetch_add(1) + 1;
  event.seqno = request.count.load() == 1 ? event.line_seqno : request.seqno.fetch_add(1) + 1;
  put_dropping_oldest(folder.requests[slot], request.event_depth.load(), event);
}

/// Emits the event of a debounced line that has settled at `now_ns` at `level`. Nobody else emits an edge of
/// this line meanwhile.
void emit_settled(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t now_ns) {
  Settled settled;
  if (!take_settled(*folder.state, line, level, now_ns, settled) || !settled.changed) return;
  if (is_wanted(folder.state->lines[line].config.load(), level))
    emit_v2(folder, line, level, settled.stamp_ns);
}

/// The line has just become `level` at `stamp_ns`, and whoever requested it for that edge gets its event.
/// Nobody else emits an edge of this line meanwhile. A v1 request's queue holds 16 events, and a newer one is
/// dropped. A v2 request's drops the oldest, and numbers all its edges, dropped ones too. A debounced line
/// only notes the edge.
void emit_edge(const ChipFolder& folder, std::uint32_t line, unsigned level, std::int64_t stamp_ns) {
  const std::uint32_t config = folder.state->lines[line].config.load();
  if (is_debounced(*folder.state, line)) {
    emit_settled(folder, line, 1 - level, stamp_ns);  // before this edge
    return note_bounce(*folder.state, line, stamp_ns);
  }
  if (!is_wanted(config, level)) return;
  if ((config & ConfigWord::kVersion2) != 0) {
    emit_v2(folder, line, level, stamp_ns);
  } else {
    emit_v1(folder.events[line], config, level, stamp_ns);
  }
}

}  // namespace
}  // namespace strobe::sim::gpio

namespace strobe::sim {
namespace {

// How often a waiting rig looks for owners that died; a release is stamped when it is found.
constexpr std::int64_t kSweep_ns = 1'000'000;
// In rig time each look stops the program under test; an edge that must settle is reported then.
constexpr std::int64_t kKeptSweep_ns = 100'000'000;
constexpr std::int64_t kDebounceSweep_ns = 20'000'000;

Change unpack(const gpio::State& state, std::uint64_t word) {
  using gpio::RingWord;
  Change change;
  change.time = from_ns(state.epoch_ns + static_cast<std::int64_t>(word >> RingWord::kTimeShift));
  change.line = static_cast<std::uint32_t>(word >> RingWord::kLineShift) & (gpio::kMaxLines - 1);
  change.level = static_cast<std::uint8_t>(word & RingWord::kLevel);
  change.cause = static_cast<Cause>((word >> RingWord::kCauseShift) & 3);
  assert(change.line < state.line_count);
  return change;
}

}  // namespace

struct Chip::Impl {
  gpio::ChipFolder folder;
  std::int64_t swept_ns = 0;
  std::unique_ptr<gpio::TimeKeeper> keeper{};

  gpio::State& state() const { return *folder.state; }
  const char* path() const { return folder.path.c_str(); }

  void sweep() {
    const std::int64_t now = gpio::now_ns(state());
    if (now - swept_ns < sweep_ns()) return;
    swept_ns = now;
    gpio::finish_pending(state());
    if (state().input_on_release != 0) gpio::reap_outputs(state(), path(), folder.lock_fd);
    gpio::reap_watched(state(), path(), folder.lock_fd);
    for (std::uint32_t line = 0; line < state().line_count; ++line) settle(line, now);
    if (state().unplugged.load() != 0) folder.close_events();
  }

  std::int64_t sweep_ns() const {
    if (!keeper) return kSweep_ns;
    return gpio::any_debounced(state()) ? kDebounceSweep_ns : kKeptSweep_ns;
  }

  /// An edge and its event belong together: held while one process drives the line.
  void lock_drive(std::uint32_t line) const {
    const std::int64_t byte = gpio::kDriveByte + line;
    while (gpio::sys::try_lock(folder.lock_fd, byte, true) == -EAGAIN) gpio::sys::sleep_ns(1'000);
  }
  void unlock_drive(std::uint32_t line) const { gpio::sys::unlock(folder.lock_fd, gpio::kDriveByte + line); }

  void change_outside(std::uint32_t line, gpio::PinEdit edit, MonoTime stamp,
                      Cause cause = Cause::drive) const {
    if (line >= state().line_count || state().unplugged.load() != 0) return;
    const std::int64_t stamp_ns = std::min(to_ns(stamp), gpio::now_ns(state()));
    lock_drive(line);
    if (gpio::change_line(state(), line, edit, cause, stamp_ns))
      gpio::emit_edge(folder, line, gpio::level_of(state(), line), stamp_ns);
    unlock_drive(line);
    gpio::notify(state());
  }

  void settle(std::uint32_t line, std::int64_t now_ns) const {
    if (!gpio::is_debounced(state(), line)) return;
    lock_drive(line);
    gpio::emit_settled(folder, line, gpio::level_of(state(), line), now_ns);
    unlock_drive(line);
  }

  bool read_ring(ChangeCursor& cursor, std::vector<Change>& changes) {
    std::uint64_t word = 0;
    for (;;) {
      switch (gpio::read_slot(state(), cursor.next, word)) {
        case gpio::Slot::ready:
          changes.push_back(unpack(state(), word));
          ++cursor.next;
          break;
        case gpio::Slot::not_yet:
          return true;
        case gpio::Slot::lapped:
          cursor.next = std::max(cursor.next + 1, gpio::newest(state()) - gpio::kRingSize);
          return false;
      }
    }
  }

  /// Sleeps until something may have happened, the deadline, or the next sweep.
  void sleep(const ChangeCursor& cursor, MonoTime deadline) {
    const std::uint32_t seen = state().wake.load();
    state().waiting.store(1);
    if (gpio::newest(state()) != cursor.next) return;
    std::int64_t until = to_ns(deadline);
    if (gpio::any_requested(state())) until = std::min(until, swept_ns + sweep_ns());
    if (keeper) return gpio::sleep_as_rig(state(), cursor.next, seen, until);
    std::int64_t left = until - gpio::now_ns(state());
    if (gpio::is_kept(state()))
      left = std::min(left, kSweep_ns);  // rig time may go faster than the machine's
    if (left > 0) gpio::sys::futex_wait(&state().wake, seen, gpio::sys::now_ns() + left);
  }
};

Chip::Chip(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Chip::Chip(Chip&&) noexcept = default;
Chip& Chip::operator=(Chip&&) noexcept = default;
Chip::~Chip() = default;

Result<Chip> Chip::create(const std::filesystem::path& dir, const ChipSpec& spec) {
  auto folder = gpio::ChipFolder::create(dir, spec);
  if (!folder) return tl::unexpected(folder.error());
  return Chip(std::make_unique<Impl>(Impl{std::move(*folder)}));
}

Result<Chip> Chip::attach(const std::filesystem::path& dir) {
  auto folder = gpio::ChipFolder::attach(dir);
  if (!folder) return tl::unexpected(folder.error());
  return Chip(std::make_unique<Impl>(Impl{std::move(*folder)}));
}

std::size_t Chip::line_count() const { return impl_->state().line_count; }

Result<std::uint32_t> Chip::line_named(const std::string& name) const {
  for (std::uint32_t line = 0; line < impl_->state().line_count; ++line) {
    if (name == impl_->state().lines[line].name) return line;
  }
  return fail("the simulated chip has no line named " + name);
}

std::string Chip::line_name(std::uint32_t line) const {
  return line < impl_->state().line_count ? impl_->state().lines[line].name : "";
}

LineState Chip::state(std::uint32_t line) const {
  LineState found;
  if (line >= impl_->state().line_count) return found;
  gpio::reap_line(impl_->state(), impl_->path(), impl_->folder.lock_fd, line);
  const gpio::Line& entry = impl_->state().lines[line];
  const std::uint32_t config = entry.config.load();
  found.level = static_cast<int>(gpio::level_of(impl_->state(), line));
  found.is_output = (config & gpio::ConfigWord::kIsOut) != 0;
  found.requested = (config & gpio::ConfigWord::kRequested) != 0;
  char consumer[gpio::kNameSize];
  gpio::get_consumer(entry, consumer);
  found.consumer = consumer;
  return found;
}

void Chip::drive(std::uint32_t line, int level, MonoTime stamp, Cause cause) {
  impl_->change_outside(line, gpio::outside_edit(level != 0 ? 1 : 0), stamp, cause);
}

void Chip::open_wire(std::uint32_t line, MonoTime stamp) {
  impl_->change_outside(line, gpio::open_edit(), stamp);
}

bool Chip::wait_changes(ChangeCursor& cursor, MonoTime deadline, std::vector<Change>& changes) {
  const std::size_t before = changes.size();
  for (;;) {
    // Looked at first: a caller that was held up past its deadline still gets what a sweep finds.
    const bool expired = gpio::now_ns(impl_->state()) >= to_ns(deadline);
    impl_->sweep();
    if (!impl_->read_ring(cursor, changes)) return false;
    if (changes.size() != before || expired) return true;
    impl_->sleep(cursor, deadline);
  }
}

RigClock Chip::clock() const { return RigClock(impl_->state()); }

void Chip::keep_time(gpio::Pace pace, const std::optional<gpio::TimeKeeper::Repeatable>& repeatable) {
  if (pace != gpio::Pace::machine)
    impl_->keeper = std::make_unique<gpio::TimeKeeper>(impl_->state(), pace, repeatable);
}

void Chip::join_time() const { gpio::join_time(impl_->state(), ::getpid()); }

bool Chip::set_clocks(Duration suspended, Duration wall_step) const {
  gpio::State& state = impl_->state();
  if (!gpio::is_kept(state)) return false;
  state.time.boottime_less_ns.fetch_add(suspended.count());
  state.time.realtime_less_ns.fetch_add((suspended + wall_step).count());
  return true;
}

void Chip::begin_time() const { impl_->state().time.begun.store(1); }
void Chip::hold_time() const { impl_->state().time.begun.store(0); }

void Chip::await_writes_to(int terminal) const {
  gpio::sys::FileId id;
  if (gpio::sys::identify(terminal, id) != 0) return;
  impl_->state().time.terminal_device.store(id.device);
  impl_->state().time.terminal_inode.store(id.inode);
}

void Chip::took_written(std::size_t bytes) const { impl_->state().time.terminal_taken.fetch_add(bytes); }

bool Chip::keeps_time() const { return gpio::is_kept(impl_->state()); }

ChangeCursor Chip::cursor_now() const { return {gpio::newest(impl_->state())}; }

void Chip::unplug() {
  gpio::State& state = impl_->state();
  state.unplugged.store(1);
  impl_->folder.close_events();
  for (std::uint32_t line = 0; state.input_on_release != 0 && line < state.line_count; ++line) {
    gpio::change_line(state, line, gpio::float_edit(), gpio::Cause::release, gpio::now_ns(state));
  }
  gpio::notify(state);
}

bool Chip::unplugged() const { return impl_->state().unplugged.load() != 0; }

const std::filesystem::path& Chip::dir() const { return impl_->folder.path; }

Result<std::filesystem::path> preload_path() {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return fail("cannot read /proc/self/exe: " + error.message());
  const std::filesystem::path prefix = self.parent_path().parent_path();
  for (const char* folder : {"lib", STROBE_LIBRARY_FOLDER}) {
    const std::filesystem::path candidate = prefix / folder / "libstrobe-gpiochip.so";
    if (std::filesystem::exists(candidate, error)) return candidate;
  }
  return fail("libstrobe-gpiochip.so is not beside " + self.string() + " (expected in " +
              (prefix / "lib").string() + ")");
}

MonoTime RigClock::now() const {
  return from_ns(state_ != nullptr ? gpio::now_ns(*state_) : gpio::sys::now_ns());
}

Duration RigClock::since_boot() const {
  return Duration{state_ != nullptr ? gpio::boottime_ns(*state_) : gpio::sys::clock_ns(CLOCK_BOOTTIME)};
}

WallTime RigClock::wall() const {
  return WallTime{
      Duration{state_ != nullptr ? gpio::realtime_ns(*state_) : gpio::sys::clock_ns(CLOCK_REALTIME)}};
}

void RigClock::sleep_for(Duration duration) const { static_cast<void>(poll(nullptr, 0, duration)); }

int RigClock::poll(struct pollfd* polled, nfds_t count, Duration timeout) const {
  const std::int64_t timeout_ns = to_ns(MonoTime{} + timeout);
  if (state_ != nullptr && gpio::is_kept(*state_)) return gpio::wait_for(*state_, polled, count, timeout_ns);
  const timespec limit = gpio::sys::to_timespec(std::max<std::int64_t>(timeout_ns, 0));
  return ::ppoll(polled, count, &limit, nullptr);
}

std::uint64_t RigClock::seed() const { return state_ != nullptr ? state_->time.seed : 0; }

}  // namespace strobe::sim
