#include "firmware/publisher/publisher.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <stdexcept>
#include <utility>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"

namespace strobe::firmware {

namespace {

constexpr Duration kHeartbeat = milliseconds(500);
constexpr std::size_t kBatch = 512;        // so that a burst is published while it goes on
constexpr std::size_t kResendBatch = 128;  // so that new events do not wait for a long resend
constexpr std::size_t kMaxUnwritten = 100'000;
constexpr Duration kPause = milliseconds(2);  // leaves the receiver's socket time to empty

/// What a person did for safety, or the rig for a person: the journal must tell it even if the power fails
/// next.
bool is_of_safety(EventKind kind) {
  switch (kind) {
    case EventKind::key:
    case EventKind::estop:
    case EventKind::disarmed:
    case EventKind::fault:
    case EventKind::cleared:
    case EventKind::reset:
      return true;
    default:
      return false;
  }
}

std::string in_words(const Event& event, std::int64_t sequence) {
  std::string words = "event " + std::to_string(sequence);
  words += " kind " + std::to_string(static_cast<int>(event.kind)) + " shot " + std::to_string(event.shot_id);
  words += " flash " + std::to_string(event.flash_index) + " level " + std::to_string(event.level) + " ";
  return words.append(event.detail.view());
}

}  // namespace

Publisher::Publisher(const Rig& rig, PublisherSettings settings, LoopQueue& queue, Mailbox& mailbox,
                     Journal& journal, MessageBus& bus, Clock& clock)
    : rig_(rig),
      settings_(std::move(settings)),
      queue_(queue),
      mailbox_(mailbox),
      journal_(journal),
      bus_(bus),
      clock_(clock),
      event_channel_(messages::channel_name(rig.name, messages::Channel::event)),
      shot_channel_(messages::channel_name(rig.name, messages::Channel::shot)),
      status_channel_(messages::channel_name(rig.name, messages::Channel::status)) {}

void Publisher::run(const std::stop_token& stop, int wake_fd) {
  while (!stop.stop_requested()) {
    wait_for_work(wake_fd);
    turn();
  }
  finish();
}

void Publisher::finish() {
  empty_queue();
  publish_status();
  auto done = journal_.sync();
  if (done) done = give_numbers_back();
  if (!done) settings_.say(done.error().message);
}

bool Publisher::at_work() const { return resend_ || check_ || mailbox_.resends_wait(); }

MonoTime Publisher::next_turn() const {
  return at_work() ? std::min(next_status_, clock_.now() + kPause) : next_status_;
}

void Publisher::wait_for_work(int wake_fd) const {
  const std::int64_t left_ms = std::chrono::ceil<milliseconds>(next_turn() - clock_.now()).count();
  pollfd wake{wake_fd, POLLIN, 0};
  poll(&wake, 1, static_cast<int>(std::clamp<std::int64_t>(left_ms, at_work() ? 2 : 0, 500)));
  std::uint64_t count = 0;
  if ((wake.revents & POLLIN) != 0 && read(wake_fd, &count, sizeof count) < 0) count = 0;
}

void Publisher::turn() {
  empty_queue();
  if (clock_.now() >= next_status_) publish_status();
  resend_some();
  if (!resend_) check_some();
}

void Publisher::empty_queue() {
  for (bool more = true; more;) {
    more = collect();
    write_and_publish(!more);
  }
}

/// Takes at most a batch from the queue; false: the queue is empty.
bool Publisher::collect() {
  LoopQueue::Item item;
  for (std::size_t n = 0; n < kBatch; ++n) {
    if (!queue_.pop(item)) return false;
    if (auto* event = std::get_if<Event>(&item)) name_culprit(*event);
    std::visit([this](const auto& content) { take(content); }, item);
  }
  return true;
}

/// What is late enough to be told is rare, or the machine unfit: this may take a millisecond.
void Publisher::name_culprit(Event& event) {
  const bool aborted = event.kind == EventKind::shot_aborted && known(event.commanded);
  const bool late =
      event.kind == EventKind::flash && event.issue_start - event.commanded > rig_.tolerance.late;
  if (!aborted && !late) return;
  const std::string culprit =
      settings_.culprit(event.commanded, aborted ? event.device_time : event.issue_start);
  if (culprit.empty()) return;
  if (late) {
    const Duration lateness = event.issue_start - event.commanded;
    event.detail.append(lateness / microseconds(1)).append(" us late");
  }
  event.detail.append(": ").append(culprit);
  if (aborted) late_abort_ = event;
}

void Publisher::take(const Event& event) {
  if (event.kind == EventKind::shot_started) {
    ++shots_started_;
    shot_first_sequence_ = sequence_ + 1;
  }
  if (is_of_safety(event.kind)) sync_due_ = true;
  if (event.kind == EventKind::flash) {
    timing_.issued(event.commanded, event.issue_start, event.issue_end);
    if (settings_.drill_at_shot > 0 && shots_started_ >= settings_.drill_at_shot) settings_.drill();
  }
  ++sequence_;
  if (settings_.verbose) settings_.say(in_words(event, sequence_));
  outbox_.push_back({Message::Kind::event,
                     {sequence_, sequence_},
                     event_channel_,
                     messages::encode(to_message(event, settings_.boot_id, sequence_))});
  if (event.kind == EventKind::started) report_earlier_boots(event.device_time);
}

void Publisher::report_earlier_boots(MonoTime now) {
  for (const std::string& line : std::exchange(settings_.found.repaired, {})) report_repaired(line, now);
  const auto unchecked = std::exchange(settings_.found.unchecked_boot, std::nullopt);
  if (unchecked) check_.emplace(journal_path(settings_.session, *unchecked), *unchecked);
}

void Publisher::report_repaired(const std::string& line, MonoTime now) {
  Event event;
  event.kind = EventKind::repaired;
  event.device_time = now;
  event.detail = ShortText(std::string_view(line));
  take(event);
}

void Publisher::take(const LoopStatus& status) {
  status_ = status;
  next_status_ = MonoTime{};
}

void Publisher::take(ShotRecord* record) {
  assert(shot_first_sequence_ > 0 && shot_first_sequence_ <= sequence_);
  const SequenceRange sequences{shot_first_sequence_, sequence_};
  if (const auto abort = std::exchange(late_abort_, std::nullopt); abort && abort->shot_id == record->shot_id)
    record->abort_reason = abort->detail;
  const auto notes = merged(rig_.record, mailbox_.take(record->host_id, record->command_id));
  outbox_.push_back({Message::Kind::shot, sequences, shot_channel_,
                     messages::encode(to_message(*record, rig_, settings_.boot_id, sequences, notes))});
  timing_.seen(*record);
  queue_.give_back(record);
  sync_due_ = true;
}

/// last: of a turn, which syncs once, however many batches it wrote.
void Publisher::write_and_publish(bool last) {
  if (settings_.heartbeat_ns != nullptr) *settings_.heartbeat_ns = to_ns(clock_.now());
  auto done = journal_.check();
  if (done) done = journal_.append(outbox_, settings_.wall_ns() / 1000);
  if (done) publish_outbox();
  if (done && last && std::exchange(sync_due_, false)) done = journal_.sync();
  // A shot that runs may use up its room; the next one must have it before it is armed for.
  if (done) done = journal_.make_room();
  if (done) done = set_numbers_aside();
  const std::string fault = done ? "" : done.error().message;
  if (fault != journal_fault_) {
    settings_.say(fault.empty() ? "the journal can be written again" : fault);
    next_status_ = MonoTime{};
  }
  journal_fault_ = fault;
  queue_.set_journal_ok(fault.empty());
  // What is left is tried again with the next batch or heartbeat.
  if (outbox_.size() > kMaxUnwritten) throw std::runtime_error("too many events wait for the journal");
}

/// As long as it fails, shots may use up what there is.
Result<void> Publisher::set_numbers_aside() {
  if (settings_.numbers == nullptr) return {};
  const auto done =
      settings_.numbers->set_aside(std::max(status_.last_shot_id, settings_.numbers->last_before()));
  queue_.set_shot_id_limit(settings_.numbers->limit());
  return done;
}

/// What could not be journalled has used numbers that nobody will find there.
Result<void> Publisher::give_numbers_back() {
  if (settings_.numbers == nullptr || !outbox_.empty() || queue_.overflows() > 0) return {};
  return settings_.numbers->give_back(std::max(status_.last_shot_id, settings_.numbers->last_before()));
}

void Publisher::publish_outbox() {
  for (const Message& message : outbox_) {
    assert(message.kind != Message::Kind::event || message.sequences.first == journalled_sequence_ + 1);
    bus_.publish(message.channel, message.bytes);
    if (message.kind == Message::Kind::event) journalled_sequence_ = message.sequences.last;
  }
  outbox_.clear();
  assert(journalled_sequence_ == sequence_);
}

void Publisher::publish_status() {
  StatusParts parts;
  parts.boot_id = settings_.boot_id;
  parts.last_sequence = journalled_sequence_;
  parts.clocks = read_clocks(clock_, settings_.wall_ns, settings_.boot_time_ns);
  parts.loop = status_;
  parts.real_time = settings_.real_time;
  parts.journal_fault = journal_fault_;
  parts.queue_overflows = queue_.overflows();
  parts.earlier = settings_.found.earlier;
  parts.rejected = settings_.rejected();
  bus_.publish(status_channel_, messages::encode(to_message(parts, timing_, histograms_)));
  next_status_ = clock_.now() + kHeartbeat;
  settings_.on_status(status_.state);
  if (settings_.on_first_status && sequence_ > 0) std::exchange(settings_.on_first_status, nullptr)();
}

void Publisher::resend_some() {
  if (!resend_) {
    const auto wanted = mailbox_.next_resend();
    if (!wanted) return;
    resend_.emplace(journal_path(settings_.session, wanted->boot_id), wanted->sequences);
  }
  const std::int64_t until = resend_->bytes_read() + kTurn_bytes;
  wire::LogRecord record;
  for (std::size_t sent = 0; sent < kResendBatch && resend_->bytes_read() < until;) {
    const RangeReader::Step step = resend_->step(record);
    if (step == RangeReader::Step::done) return resend_.reset();
    if (step == RangeReader::Step::searching) continue;
    bus_.publish(record.channel, record.bytes);
    ++sent;
  }
}

void Publisher::check_some() {
  if (!check_) return;
  const std::int64_t until = check_->bytes_read() + kTurn_bytes;
  while (check_->bytes_read() < until) {
    if (check_->step()) continue;
    if (const std::string damage = check_->finding(); !damage.empty()) {
      settings_.say(damage);
      report_repaired(damage, clock_.now());
    }
    return check_.reset();
  }
}

}  // namespace strobe::firmware
