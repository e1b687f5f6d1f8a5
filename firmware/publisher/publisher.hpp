// Writes the loop's records to the journal, then publishes them; publishes the status; resends from the
// journal. Runs on a thread of its own, without real-time rights. An exception here ends the process, and
// the guardian makes the outputs safe.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <optional>
#include <stop_token>

#include "firmware/core/shot_timing.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/ports/message_bus.hpp"
#include "firmware/publisher/journal.hpp"
#include "firmware/publisher/journal_folder.hpp"
#include "firmware/publisher/loop_queue.hpp"
#include "firmware/publisher/mailbox.hpp"
#include "firmware/publisher/status_message.hpp"

namespace strobe::firmware {

/// A line on standard error, after the program's name.
void log_to_stderr(const std::string& line);

struct PublisherSettings {
  std::int64_t boot_id = 0;
  std::filesystem::path session;
  bool real_time = false;
  bool verbose = false;
  std::function<void()> on_first_status;  ///< called once, on the publisher's thread
  std::function<std::int64_t()> wall_ns = system_wall_ns;
  std::function<std::int64_t()> boot_time_ns = system_boot_time_ns;
  std::function<RejectedCommands()> rejected = [] { return RejectedCommands{}; };  ///< so far
  std::function<void(const std::string&)> say = log_to_stderr;
  std::atomic<std::int64_t>* heartbeat_ns = nullptr;  ///< set at each turn, for the watchdog
  int drill_at_shot = 0;  ///< `drill` is called at flashes from the n-th shot of this boot on; 0: never
  std::function<void()> drill;
  FolderFindings found;  ///< reported by events after STARTED, and in the status
};

class Publisher {
 public:
  Publisher(const Rig& rig, PublisherSettings settings, LoopQueue& queue, Mailbox& mailbox, Journal& journal,
            MessageBus& bus, Clock& clock);

  /// Calls turn() when wake_fd (an eventfd) is written or a turn is due, until stop is requested; then
  /// finish().
  void run(const std::stop_token& stop, int wake_fd);
  /// Writes and publishes the queue, continues resends, publishes the status when due. Does not wait.
  void turn();
  /// When a turn is due even if the queue is empty; may be in the past.
  MonoTime next_turn() const;
  /// Writes and syncs what is left in the queue.
  void finish();

 private:
  void empty_queue();
  bool collect();
  void take(const Event& event);
  void report_earlier_boots(MonoTime now);
  void take(const LoopStatus& status);
  void take(ShotRecord* record);
  void write_and_publish();
  void publish_outbox();
  void publish_status();
  void start_resend(const EventRange& request);
  const std::vector<JournalEntry>& entries_of(std::int64_t boot_id);
  void resend_some();
  void wait_for_work(int wake_fd) const;

  struct Resend {
    LogReader reader;
    std::vector<JournalEntry> entries;
    std::size_t next = 0;
  };

  const Rig& rig_;
  PublisherSettings settings_;
  LoopQueue& queue_;
  Mailbox& mailbox_;
  Journal& journal_;
  MessageBus& bus_;
  Clock& clock_;
  std::string event_channel_, shot_channel_, status_channel_;
  std::vector<Message> outbox_;
  std::deque<Resend> resends_;
  std::int64_t scanned_boot_ = 0;  ///< earlier boot whose journal was last read
  std::vector<JournalEntry> scanned_;
  std::int64_t sequence_ = 0;  ///< of the newest event made
  std::int64_t journalled_sequence_ = 0;
  std::int64_t shot_first_sequence_ = 0;
  int shots_started_ = 0;
  bool sync_due_ = false;
  ShotTiming timing_;
  LoopStatus status_;
  std::string journal_fault_;
  MonoTime next_status_{};
};

}  // namespace strobe::firmware
