// The one loop of a host, whatever runs it (fire, live, replay, the soak test): messages in, the session
// kept, photographs matched and measured, lost events requested again, shot results handed to the listeners.
// With the lab's key, nothing is acted on that is not sealed with it (PacketCheck); without one, what is
// seen is marked as unverified, and nothing can be sent.
//
// Transport and clock are ports, so that it runs on virtual time as well. Single-threaded; run_once() blocks
// in the transport, for 20 ms at most, nothing else does.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <strobe_msgs/event_t.hpp>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/messages/channels.hpp"
#include "common/units/time.hpp"
#include "host/clock/machine_clock.hpp"
#include "host/messages/command_factory.hpp"
#include "host/messages/message_decoder.hpp"
#include "host/messages/transport.hpp"
#include "host/photographs/photograph_pipeline.hpp"
#include "host/session/live_boots.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

/// A DISARM that somebody has asked for: sent again and again until the firmware says that it has obeyed one
/// of them. Only that event tells: a rig that is stopped may have been so before, by a stop that somebody is
/// about to reset. Decides only; the host loop sends. No I/O.
class DisarmRequest {
 public:
  static constexpr Duration kRepeat = milliseconds{100};
  /// Not confirmed for so long it is told as a danger.
  static constexpr Duration kConfirmWithin = milliseconds{500};

  /// host_id: this host's.
  explicit DisarmRequest(std::int64_t host_id) : host_id_(host_id) {}

  /// What was sent before it confirms nothing any more.
  void begin(HostTime now);
  /// Whether a DISARM is to be sent now; counts as sent.
  bool due(HostTime now);
  void on_sent(std::int64_t command_id);
  /// Returns true if this is the confirmation: of a firmware of boot_id, the one that is addressed.
  bool on_event(const strobe_msgs::event_t& event, std::int64_t boot_id);

  /// Asked for, and not confirmed.
  bool open() const { return asked_.has_value(); }
  /// For a person: empty as long as a confirmation is not overdue.
  std::string not_confirmed(HostTime now) const;

 private:
  std::int64_t host_id_;
  std::optional<HostTime> asked_;
  HostTime sent_;
  std::int64_t first_command_ = 0;  ///< 0: none was sent
};

struct HostLoopSettings {
  std::string rig;
  AssemblySettings assembly;
  std::int64_t host_id = 0;  ///< random, of this process; not 0
  bool fires = false;        ///< this host's own shots each get a readout, which is published
  std::optional<authentication::Key> key = {};  ///< absent: nothing is verified, requested or fired
  bool replays = false;                         ///< a log: verified, but nobody is there to be asked
  std::string host_name = {};                   ///< who fires, told to other hosts; empty: nothing is said
  std::string until_known = {};                 ///< Shot::until_known of this host's shots
};

/// Hears what happens in a session. The default is to ignore it.
class HostListener {
 public:
  virtual ~HostListener() = default;
  virtual void on_shot_result(const Shot&) {}
  /// Each new event, after the session has it.
  virtual void on_event(const strobe_msgs::event_t&) {}
  /// Each shot's summary, as often as it comes.
  virtual void on_shot(const strobe_msgs::shot_t&) {}
  /// A shot's photograph has been read, also a dry one's; where the session keeps it.
  virtual void on_photograph(const KeptPhotograph&) {}
  /// The camera, its settings and what is wrong with them, whenever they are otherwise than before.
  virtual void on_camera(const tether::OpenedEvent&) {}
  /// A photograph that the session should have kept has not been, or a message has not been taken in; told as
  /// a notification, too.
  virtual void on_not_kept(const std::string&) {}
  /// A line that a person should read.
  virtual void on_notification(const std::string&) {}
};

class HostLoop final : private MessageHandler {
 public:
  /// The ports must outlive the loop.
  HostLoop(HostLoopSettings settings, Transport& transport, Clock& clock);

  /// Listeners are called in the order of their adding and must outlive the loop.
  void add_listener(HostListener& listener) { listeners_.push_back(&listener); }
  /// Photographs are taken from this pipeline. Null: none are.
  void set_photographs(std::unique_ptr<PhotographPipeline> pipeline) { photographs_ = std::move(pipeline); }
  /// run_once() returns when it is readable, too. -1: none.
  void set_wake_descriptor(int descriptor) { wake_descriptor_ = descriptor; }
  PhotographPipeline* photographs() { return photographs_.get(); }
  /// A summary, or a frame, from an earlier run's log.
  void process(const strobe_msgs::shot_t& shot);
  void process(const strobe_msgs::frame_t& frame);
  /// The readouts of these shots have been published before, and are not again.
  void mark_read_out(const std::set<ShotKey>& shots) { read_out_ = shots; }

  /// Waits for messages, takes them in, does what is due. Returns false if the transport has failed.
  bool run_once();
  /// The parts of run_once() but for the wait, for callers that have messages and time from elsewhere.
  void receive(const std::string& channel, Transport::Bytes bytes);
  void step();
  /// No photograph will come any more: what was measured is published, what is left over is told.
  void end_photographs();
  /// No message will come any more: shots that wait for a photograph end without.
  void end_session();

  /// Seals and publishes a command, with the instant on the firmware's clock; without a key it is dropped.
  void send(strobe_msgs::command_t command);
  /// A person asks now for something that may fire: typed the command, answered yes. Only stops from before
  /// are reset by it. The loop's construction counts as one.
  void person_acted() { acted_ = clock_.read().since_boot; }
  void person_acted(const HostReading& then) { acted_ = then.since_boot; }
  /// Disarms the rig, whoever armed it, also a firmware that is silent: the DISARM is repeated until it is
  /// confirmed, and a danger (Session::danger()) as long as its confirmation is overdue. by: who asks, for a
  /// person.
  void disarm(const std::string& by);
  /// A DISARM has been asked for and is not confirmed.
  bool disarming() const { return disarm_.open(); }
  /// This machine has been suspended since the loop began: what it was about to do belongs to another day.
  bool was_suspended() const { return suspended_; }
  void notify(const std::string& text);

  const HostLoopSettings& settings() const { return settings_; }
  CommandFactory& commands() { return commands_; }
  Session& session() { return session_; }
  const Session& session() const { return session_; }
  /// The newest status if the firmware is not silent.
  std::optional<strobe_msgs::status_t> live_status() const { return session_.live_status(now_); }
  /// Why nothing may be armed although the status does not say so: another rig has the name. Empty: it may.
  std::string second_rig() const { return session_.boots().problem(now_); }
  /// The rig is heard and does not answer (AnswerWatch), for a person; empty: it does, as far as is known.
  std::string unanswered() const { return live_status() ? answers_.problem(now_) : ""; }
  HostTime now() const { return now_; }
  /// When the last message came.
  HostTime last_message() const { return last_message_; }
  /// Whether all that this loop acts on is sealed with the lab's key.
  bool verifies() const { return settings_.key.has_value(); }
  /// Packets that were not acted on.
  const authentication::UnverifiedCounts& unverified() const { return check_.unverified(); }
  /// What the last exception on a message said; empty: there was none.
  const std::string& fault() const { return decoder_.fault(); }

 private:
  void on_status(const strobe_msgs::status_t& message) override;
  void on_event(const strobe_msgs::event_t& message) override;
  void on_shot(const strobe_msgs::shot_t& message) override;
  void on_frame(const strobe_msgs::frame_t& message) override;
  std::int64_t firmware_boot_time_ns(std::int64_t boot_id);
  std::int64_t acted_boot_time_ns(std::int64_t boot_id) const;
  void repeat_disarm();
  void publish_photographs();
  void request_lost_events();
  void ask_who_hears();
  static void make_budget(Shot& result);
  void report();
  void report_fault();
  void tell_not_kept(const std::string& text);
  template <typename Message>
  void publish(messages::Channel channel, const Message& message);

  HostLoopSettings settings_;
  Transport& transport_;
  Clock& clock_;
  CommandFactory commands_;
  std::optional<CommandSealer> sealer_;
  std::optional<authentication::PacketSeal> seal_;
  std::int64_t packets_sealed_ = 0;
  std::string rig_channels_, command_channel_;
  PacketCheck check_;
  Session session_;
  AnswerWatch answers_;
  std::string told_unanswered_;
  std::unique_ptr<PhotographPipeline> photographs_;
  MessageDecoder decoder_;
  DisarmRequest disarm_;
  int wake_descriptor_ = -1;
  std::vector<HostListener*> listeners_;
  std::set<ShotKey> read_out_;
  std::string told_fault_;
  HostTime now_;
  HostTime last_message_;
  HostReading last_status_;  ///< when the session's status came
  Duration acted_{};         ///< HostReading::since_boot
  Duration slept_before_{};
  bool suspended_ = false;
};

}  // namespace strobe::host
