// Writes the loop's records to the journal, then publishes them, and syncs it in the turns in which a shot
// has ended or somebody has stopped or freed the rig; publishes the status; resends from the journal. Runs on
// a thread of its own, without real-time rights. An exception here ends the process, and the guardian makes
// the outputs safe.
#pragma once

#include <atomic>
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
#include "firmware/publisher/messages.hpp"
#include "firmware/publisher/resend.hpp"
#include "firmware/publisher/shot_numbers.hpp"

namespace strobe::firmware {

struct PublisherSettings {
  std::int64_t boot_id = 0;
  std::filesystem::path session;
  bool real_time = false;
  bool verbose = false;
  std::function<void()> on_first_status;                ///< called once, on the publisher's thread
  std::function<void(State)> on_status = [](State) {};  ///< called with each one, on the publisher's thread
  std::function<std::int64_t()> wall_ns = system_wall_ns;
  std::function<std::int64_t()> boot_time_ns = system_boot_time_ns;
  std::function<RejectedCommands()> rejected = [] { return RejectedCommands{}; };  ///< so far
  std::function<void(const std::string&)> say = [](const std::string&) {
  };                                                  ///< a line for a person; must not wait
  std::atomic<std::int64_t>* heartbeat_ns = nullptr;  ///< set at each turn, for the watchdog
  int drill_at_shot = 0;  ///< `drill` is called at flashes from the n-th shot of this boot on; 0: never
  std::function<void()> drill;
  /// What ran instead of the loop in a span, in words; empty: nothing is known. Asked for what was late.
  std::function<std::string(MonoTime, MonoTime)> culprit = [](MonoTime, MonoTime) { return std::string(); };
  FolderFindings found;  ///< reported by events after STARTED, and in the status
  ShotNumbers* numbers =
      nullptr;  ///< sets numbers for shots aside; null: none need be. Outlives the publisher
};

class Publisher {
 public:
  Publisher(const Rig& rig, PublisherSettings settings, LoopQueue& queue, Mailbox& mailbox, Journal& journal,
            MessageBus& bus, Clock& clock);

  /// Calls turn() when wake_fd (an eventfd) is written or a turn is due, until stop is requested; then
  /// finish().
  void run(const std::stop_token& stop, int wake_fd);
  /// Longest part of journals that a turn reads [bytes], besides one record.
  static constexpr std::int64_t kTurn_bytes = std::int64_t{64} << 10;
  /// Writes and publishes the queue; publishes the status when due; goes on with a resend or, if there is
  /// none, with the check of the last boot's journal. Does not wait.
  void turn();
  /// When a turn is due even if the queue is empty; may be in the past.
  MonoTime next_turn() const;
  /// Writes and syncs what is left in the queue.
  void finish();

 private:
  void empty_queue();
  bool collect();
  void take(const Event& event);
  void name_culprit(Event& event);
  void report_earlier_boots(MonoTime now);
  void report_repaired(const std::string& line, MonoTime now);
  void take(const LoopStatus& status);
  void take(ShotRecord* record);
  void write_and_publish(bool last);
  void publish_outbox();
  Result<void> set_numbers_aside();
  Result<void> give_numbers_back();
  void publish_status();
  bool at_work() const;
  void resend_some();
  void check_some();
  void wait_for_work(int wake_fd) const;

  const Rig& rig_;
  PublisherSettings settings_;
  LoopQueue& queue_;
  Mailbox& mailbox_;
  Journal& journal_;
  MessageBus& bus_;
  Clock& clock_;
  std::string event_channel_, shot_channel_, status_channel_;
  std::vector<Message> outbox_;
  std::optional<RangeReader> resend_;
  std::optional<DamageCheck> check_;
  std::int64_t sequence_ = 0;  ///< of the newest event made
  std::int64_t journalled_sequence_ = 0;
  std::int64_t shot_first_sequence_ = 0;
  int shots_started_ = 0;
  std::optional<Event> late_abort_;  ///< of the shot under way
  bool sync_due_ = false;
  ShotTiming timing_;
  HistogramMessages histograms_;
  LoopStatus status_;
  std::string journal_fault_;
  MonoTime next_status_{};
};

}  // namespace strobe::firmware
