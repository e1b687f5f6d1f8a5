#include "host/commands/fire_run.hpp"

#include <fmt/format.h>

#include "common/messages/channels.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/well_formed.hpp"
#include "host/commands/command.hpp"
#include "host/commands/watched_photographs.hpp"
#include "host/loop/session_monitor.hpp"
#include "host/messages/lcm_link.hpp"
#include "host/messages/message_decoder.hpp"
#include "host/session/gap_recovery.hpp"

namespace strobe::host {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kDisarm_ns = 1 * kSecond_ns;
constexpr int kTurn_ms = 20;

template <typename Message>
std::string encoded(const Message& message) {
  std::string bytes(static_cast<std::size_t>(message.getEncodedSize()), '\0');
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

class FireRun {
 public:
  explicit FireRun(const FireOrder& order)
      : order_(order),
        factory_(random_host_id()),
        sealer_(order.key, order.rig.rig),
        series_(order.series, factory_),
        monitor_(assembly_settings(order.rig), factory_.host_id(),
                 fmt::format("strobe fire   rig {}   session {}", order.rig.rig, order.session)),
        photographs_(order.rig, order.photographs, order.session, factory_.host_id(), monitor_),
        decoder_(order.rig.rig, photographs_.sink()) {}

  int run() {
    auto folder =
        SessionFolder::open(order_.session, utc_for_file(wall_now_us()), order_.rig.text, order_.plan_text);
    if (!folder) return bad_input(folder.error().message);
    folder_ = std::move(*folder);
    folder_->recall(monitor_.session().ledger(), order_.rig.rig);
    if (auto watched = photographs_.open(); !watched) return bad_input(watched.error().message);
    auto link =
        LcmLink::open(order_.url, order_.rig.rig,
                      [this](const std::string& c, const void* d, std::size_t n) { receive(c, d, n); });
    if (!link) return failed(link.error().message);
    link_ = std::move(*link);
    catch_signals();
    Terminal terminal(order_.style);
    terminal_ = &terminal;
    monitor_.model().thesis = order_.condition;
    monitor_.on_shot_result = [this](const ShotResult& shot_result) { done(shot_result); };
    monitor_.on_event = [this](const strobe_msgs::event_t& event) { series_.on_event(event); };
    monitor_.on_shot = [this](const strobe_msgs::shot_t& shot) { keep_flashes(shot); };
    monitor_.on_notification = [this](const std::string& text) { terminal_->notify(text); };
    terminal.notify(fmt::format("session {}, rig {} on {}", order_.session, order_.rig.rig, order_.url));
    for (const std::string& text : photographs_.opening_words()) monitor_.notify(text);
    fire();
    if (interrupted()) disarm();
    collect_missing();
    take_photographs(true);
    terminal.close();
    return conclude();
  }

 private:
  void receive(const std::string& channel, const void* data, std::size_t size) {
    // Own readouts and frames are logged as they are published.
    if (channel == messages::channel_name(order_.rig.rig, messages::Channel::readout) &&
        own_readout(data, size))
      return;
    if (photographs_.own_frame(channel, data, size)) return;
    folder_->log(channel, data, size,
                 wall_now_us());  // first, so that the record holds what a result came from
    decoder_.receive(channel, data, size, steady_now_ns());
  }

  bool own_readout(const void* data, std::size_t size) const {
    return messages::readout_host(data, size) == factory_.host_id();
  }

  void done(const ShotResult& shot_result) {
    const std::int64_t wall_us = wall_now_us();
    if (shot_result.host_id == factory_.host_id() && !shot_result.dry) {
      const auto message =
          messages::readout_to_lcm(shot_result.readout, factory_.host_id(), shot_result.boot_id);
      link_->publish(message);
      log_readout(message, wall_us);
      if (auto added = folder_->add(shot_result, utc_for_table(wall_us)); !added)
        monitor_.notify(added.error().message);
    }
    series_.on_shot_result(shot_result);
    terminal_->shot_result(shot_result);
  }

  void keep_flashes(const strobe_msgs::shot_t& shot) {
    if (auto added = folder_->add(shot); !added) monitor_.notify(added.error().message);
  }

  void log_readout(const strobe_msgs::readout_t& message, std::int64_t wall_us) {
    const std::string bytes = encoded(message);
    folder_->log(messages::channel_name(order_.rig.rig, messages::Channel::readout), bytes.data(),
                 bytes.size(), wall_us);
  }

  /// A frame is logged and taken in here as if it had come from elsewhere, and sent to everybody else.
  void take_photographs(bool last) {
    for (const auto& frame : last ? photographs_.end(steady_now_ns()) : photographs_.turn(steady_now_ns())) {
      const std::string bytes = encoded(frame);
      receive_frame(bytes);
      link_->publish(frame);
    }
    for (const std::string& text : photographs_.take_notifications()) monitor_.notify(text);
  }

  void receive_frame(const std::string& bytes) {
    const std::string channel = messages::channel_name(order_.rig.rig, messages::Channel::frame);
    folder_->log(channel, bytes.data(), bytes.size(), wall_now_us());
    decoder_.receive(channel, bytes.data(), bytes.size(), steady_now_ns());
  }

  /// One turn: what has come, what is due, the screen.
  bool turn() {
    if (!link_->wait(kTurn_ms, photographs_.descriptors()) || !link_->drain()) {
      monitor_.notify("LCM cannot receive any more");
      return false;
    }
    take_photographs(false);
    now_ns_ = steady_now_ns();
    monitor_.time(now_ns_);
    monitor_.local_clocks(read_clocks());
    ask_for_missing();
    return true;
  }

  void ask_for_missing() {
    const auto& status = monitor_.session().status();
    if (!status) return;  // nobody to ask yet
    for (const EventRange& range : monitor_.session().ledger().due(now_ns_))
      send(factory_.resend(status->boot_id, range));
  }

  /// Said once: what the firmware takes for forged just after this host has sent something is this host's.
  void say_if_key_differs() {
    const auto& status = monitor_.session().status();
    if (status && status->arm_host_id == factory_.host_id()) key_known_ = true;
    if (!status || key_known_ || key_differs_said_) return;
    if (!forged_before_) forged_before_ = status->rejected_forged;
    if (status->rejected_forged <= *forged_before_) return;
    key_differs_said_ = true;
    key_differs_since_ns_ = now_ns_;
    terminal_->notify(
        fmt::format("strobed ignores commands that are sealed with another key than its own: it tells its "
                    "key's fingerprint at "
                    "its start, this host's is {} (see strobe key, --key-file)",
                    order_.key.fingerprint()));
  }

  /// A stranger's forgeries alone do not end a series: it waits for a token as long as for anything else.
  bool shut_out() const {
    return key_differs_said_ && !key_known_ &&
           static_cast<double>(now_ns_ - key_differs_since_ns_) > order_.series.blocked_timeout_s * 1e9;
  }

  void send(const strobe_msgs::command_t& command) {
    if (const auto sealed = sealer_.seal(command)) {
      link_->publish_command(*sealed);
      folder_->log(messages::channel_name(order_.rig.rig, messages::Channel::command), sealed->data(),
                   sealed->size(), wall_now_us());
    } else {
      monitor_.notify(sealed.error().message);
    }
  }

  void send_commands() {
    for (const auto& command : series_.take_commands()) send(command);
    for (const std::string& text : series_.take_notifications()) monitor_.notify(text);
  }

  /// What a person who sees no screen should know: what has been lasting for two seconds.
  void say_what_lasts() {
    const std::string now =
        series_.blocking_reason().empty() ? series_.activity() : "waiting: " + series_.blocking_reason();
    if (now != lasting_) {
      lasting_ = now;
      lasting_since_ns_ = now_ns_;
      said_ = false;
    }
    if (said_ || series_.finished() || now_ns_ - lasting_since_ns_ < 2 * kSecond_ns) return;
    said_ = true;
    terminal_->notify(lasting_);
  }

  void show() {
    monitor_.model().activity = series_.activity();
    monitor_.model().blocking_reason = series_.blocking_reason();
    say_what_lasts();
    say_if_key_differs();
    terminal_->show(monitor_.shown(now_ns_), now_ns_);
  }

  void fire() {
    // The first status may take half a second: nothing is missing before it had time to come.
    const std::int64_t started_ns = steady_now_ns();
    while (!series_.finished() && !interrupted() && !shut_out() && turn()) {
      const auto heard = monitor_.heard(now_ns_);
      if (heard || now_ns_ - started_ns > kSecond_ns) series_.step(heard, now_ns_);
      send_commands();
      show();
    }
  }

  void disarm() {
    series_.stop(monitor_.heard(now_ns_));
    send_commands();
    monitor_.notify("interrupted: disarming");
    const std::int64_t until_ns = steady_now_ns() + kDisarm_ns;
    while (turn() && now_ns_ < until_ns) {
      const auto& status = monitor_.session().status();
      if (!status || (status->arm_token == 0 && status->state != strobe_msgs::status_t::FIRING)) break;
    }
  }

  /// Events that were lost on the way are fetched from the journal before the log is closed.
  void collect_missing() {
    if (shut_out()) return;  // nothing that is asked for would come
    const EventLedger& ledger = monitor_.session().ledger();
    GapRecovery collection(steady_now_ns());
    bool said = false;
    while (turn() && !collection.over(monitor_.session(), monitor_.heard(now_ns_).has_value(), now_ns_)) {
      if (!said && now_ns_ - collection.started_ns() > 2 * kSecond_ns) {
        said = true;
        terminal_->notify(fmt::format("fetching {} events that were lost on the way", ledger.missing()));
      }
      show();
    }
    if (ledger.missing() > 0)
      terminal_->notify(fmt::format("{} events are still missing here", ledger.missing()));
  }

  int conclude() {
    if (order_.style != Terminal::Style::json && !order_.series.dry) {
      print(render_series(monitor_.model().series, order_.condition, kPlainWidth));
    }
    const std::string summary =
        fmt::format("{} of {} shots came, {} fired again; session in {}", series_.good(), order_.series.shots,
                    series_.refired(), order_.session);
    if (!series_.succeeded())
      return failed(summary + (series_.blocking_reason().empty() ? "" : ": " + series_.blocking_reason()));
    std::fprintf(stderr, "strobe: %s\n", summary.c_str());
    return kDone;
  }

  const FireOrder& order_;
  CommandFactory factory_;
  CommandSealer sealer_;
  ShotSeries series_;
  SessionMonitor monitor_;
  WatchedPhotographs photographs_;
  MessageDecoder decoder_;
  std::unique_ptr<SessionFolder> folder_;
  std::unique_ptr<LcmLink> link_;
  Terminal* terminal_ = nullptr;
  std::int64_t now_ns_ = 0;
  std::optional<std::int64_t> forged_before_;
  bool key_differs_said_ = false;
  bool key_known_ = false;
  std::int64_t key_differs_since_ns_ = 0;
  std::string lasting_;
  std::int64_t lasting_since_ns_ = 0;
  bool said_ = false;
};

}  // namespace

int run_fire(const FireOrder& order) { return FireRun(order).run(); }

}  // namespace strobe::host
