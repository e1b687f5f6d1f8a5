#include "sim/flash_sequencer/flash_sequencer.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace strobe::sim::sequencer {
namespace {

using flash_sequencer::Frame;
using flash_sequencer::Phase;

constexpr Duration kByteTime = microseconds(10);  // 8N1 at 1,000,000 baud
constexpr Duration kReplyAfter{flash_sequencer::kReplyAfter * flash_sequencer::kTick_ns};
constexpr Duration kTurn = milliseconds(1);  // it looks after its train
constexpr Duration kIdle = milliseconds(100);
constexpr int kPriority = 90;  // above strobed's loop
constexpr std::size_t kMaxBacklog_bytes = 1 << 16;
constexpr auto kOutputs = static_cast<std::uint32_t>(RigLine::sensor_a);  // lines before it
constexpr double kDamagedShare = 0.0005;

}  // namespace

FlashSequencer::FlashSequencer(Chip chip, std::uint64_t seed, RigClock clock)
    : chip_(std::move(chip)),
      clock_(clock),
      event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      draws_(seed, Purpose::flash_sequencer, 1),
      board_(seed) {}

FlashSequencer::~FlashSequencer() {
  stop();
  close(event_);
}

Result<std::unique_ptr<FlashSequencer>> FlashSequencer::create(const std::filesystem::path& port,
                                                               const std::filesystem::path& chip_folder,
                                                               std::uint64_t seed, RigClock clock) {
  auto chip = Chip::attach(chip_folder);
  if (!chip) return tl::unexpected(chip.error());
  std::unique_ptr<FlashSequencer> made(new FlashSequencer(std::move(*chip), seed, clock));
  auto terminal = Terminal::open(port, made->chip_);
  if (!terminal) return tl::unexpected(terminal.error());
  made->terminal_.emplace(std::move(*terminal));
  made->power_up(clock.now());
  return made;
}

void FlashSequencer::start() {
  thread_ = std::thread([this] { run(); });
}

void FlashSequencer::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  eventfd_write(event_, 1);
  thread_.join();
}

void FlashSequencer::power_up(MonoTime now) {
  board_.power_up(now);
  for (std::uint32_t line = 0; line < kWiredLines; ++line)
    board_.line_changed(static_cast<RigLine>(line), chip_.state(line).level, now);
  flash_sequencer::InputEdge edge;
  while (board_.pop_input(edge)) continue;  // no edges, but what it finds
  const auto high = std::uint64_t{board_.random()};
  controller_.emplace(board_, high << 32 | board_.random(), false);
}

void FlashSequencer::run() {
  // As prompt in the machine's time as a microcontroller would be, where that is permitted.
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters));
  while (!stopping_) {
    Duration wait;
    {
      const std::scoped_lock lock(mutex_);
      turn();
      wait = until_due();
    }
    pollfd awaited[] = {{terminal_->descriptor(), POLLIN, 0}, {event_, POLLIN, 0}};
    clock_.poll(awaited, std::size(awaited), wait);
    eventfd_t ignored = 0;
    if ((awaited[1].revents & POLLIN) != 0) eventfd_read(event_, &ignored);
  }
}

void FlashSequencer::turn() {
  const MonoTime now = clock_.now();
  board_.advance(now);
  take_bytes(now);
  if (controller_) {
    answer_requests(now);
    controller_->turn();
    Frame report;
    while (controller_->next_input(report)) send(report, now);
  }
  move_pins();
  deliver(now);
}

Duration FlashSequencer::until_due() const {
  const MonoTime now = clock_.now();
  MonoTime due = std::min(now + kIdle, board_.next_edge());
  const auto end = std::ranges::find(bytes_, std::uint8_t{0}, &Byte::value);
  if (end != bytes_.end()) due = std::min(due, end->arrived);
  if (!replies_.empty()) due = std::min(due, replies_.front().sent);
  const bool busy =
      controller_ && (controller_->phase() == Phase::armed || controller_->phase() == Phase::playing);
  if (busy) due = std::min(due, now + kTurn);
  return std::max(Duration{1}, due - now);
}

void FlashSequencer::lines_changed(const std::vector<Change>& changes) {
  const auto is_output = [](const Change& change) { return change.line < kOutputs; };
  if (std::ranges::all_of(changes, is_output)) return;
  {
    const std::scoped_lock lock(mutex_);
    for (const Change& change : changes) line_changed(change);
    move_pins();
  }
  eventfd_write(event_, 1);
}

void FlashSequencer::line_changed(const Change& change) {
  if (const auto line = rig_line(change.line)) return board_.line_changed(*line, change.level, change.time);
  if (change.line == kNoise.line) noisy_ = change.level != 0;
  if (change.line == kCable.line) plugged_in_ = change.level != 0;
  if (change.line != kRun.line) return;
  board_.advance(change.time);
  bytes_.clear();
  replies_.clear();
  decoder_ = {};
  if (change.level != 0) return power_up(change.time);
  board_.cut();  // its pins float, and the outputs' pull-downs hold them
  controller_.reset();
}

void FlashSequencer::take_bytes(MonoTime now) {
  while (const auto written = terminal_->read()) {
    incoming_free_ = std::max(incoming_free_, std::min(now, written->at));
    for (const std::uint8_t byte : written->bytes) {
      incoming_free_ += kByteTime;
      if (controller_ && plugged_in_ && bytes_.size() < kMaxBacklog_bytes)
        bytes_.push_back({incoming_free_, on_the_way(byte)});
    }
  }
}

void FlashSequencer::answer_requests(MonoTime now) {
  while (!bytes_.empty() && bytes_.front().arrived <= now) {
    const Byte byte = bytes_.front();
    bytes_.pop_front();
    const Frame* const request = decoder_.take(byte.value);
    Frame reply;
    if (request != nullptr && controller_->answer(*request, board_.ticks(byte.arrived), reply))
      send(reply, byte.arrived + kReplyAfter);
  }
}

void FlashSequencer::send(const Frame& frame, MonoTime begin) {
  std::array<std::uint8_t, flash_sequencer::kMaxFrame> wire;
  const std::size_t size = flash_sequencer::encode(frame, wire);
  outgoing_free_ = std::max(outgoing_free_, begin) + static_cast<Duration::rep>(size) * kByteTime;
  replies_.push_back({outgoing_free_, {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(size)}});
}

void FlashSequencer::deliver(MonoTime now) {
  for (; !replies_.empty() && replies_.front().sent <= now; replies_.pop_front()) {
    if (!plugged_in_) continue;
    for (std::uint8_t& byte : replies_.front().wire) byte = on_the_way(byte);
    terminal_->write(replies_.front().wire);
  }
}

std::uint8_t FlashSequencer::on_the_way(std::uint8_t byte) {
  if (!noisy_ || draws_.uniform() >= kDamagedShare) return byte;
  return static_cast<std::uint8_t>(byte ^ (1U << static_cast<unsigned>(8.0 * draws_.uniform())));
}

void FlashSequencer::move_pins() {
  for (const PinChange& pin : board_.take_pin_changes())
    chip_.drive(static_cast<std::uint32_t>(pin.line), pin.level, pin.at, Cause::set);
}

}  // namespace strobe::sim::sequencer
