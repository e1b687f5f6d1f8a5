#include "host/archive/log_player.hpp"

#include <algorithm>

#include "common/authentication/packet_seal.hpp"
#include "common/messages/channels.hpp"
#include "host/messages/message_decoder.hpp"

namespace strobe::host {
namespace {

HostLoopSettings loop_settings(const RigFile& rig, const std::optional<authentication::Key>& key,
                               bool budgets) {
  HostLoopSettings settings{rig.rig, assembly_settings(rig)};
  settings.assembly.budgets = budgets;
  settings.replays = true;
  settings.key = key;
  return settings;
}

/// Hands a journal's messages to the session past the check of seals, and to one more.
class PastTheCheck final : public MessageHandler {
 public:
  PastTheCheck(HostLoop& loop, MessageHandler& also) : loop_(loop), also_(also) {}
  void on_status(const strobe_msgs::status_t&) override {}
  void on_event(const strobe_msgs::event_t& message) override {
    also_.on_event(message);
    loop_.session().on_event(message, loop_.now());
  }
  void on_shot(const strobe_msgs::shot_t& message) override {
    also_.on_shot(message);
    loop_.session().on_shot(message, loop_.now());
  }
  void on_frame(const strobe_msgs::frame_t&) override {}

 private:
  HostLoop& loop_;
  MessageHandler& also_;
};

}  // namespace

std::optional<bool> is_sealed(const std::filesystem::path& path, const std::string& rig,
                              const authentication::Key& key) {
  const std::string channels = "STROBE/" + rig + "/";
  const std::string commands = messages::channel_name(rig, messages::Channel::command);
  const authentication::PacketSeal seal(key);
  wire::LogReader log(path);
  wire::LogRecord record;
  std::optional<bool> sealed;
  while (log.next(record)) {
    if (!record.channel.starts_with(channels) || record.channel == commands) continue;
    if (seal.open(record.channel, record.bytes)) return true;
    sealed = false;
  }
  return sealed;
}

LogPlayer::LogPlayer(const RigFile& rig, const std::optional<authentication::Key>& key, bool budgets)
    : rig_(rig.rig), loop_(loop_settings(rig, key, budgets), transport_, clock_) {}

void LogPlayer::play(StoredLogs& logs, const Watcher& watcher) {
  while (const auto message = logs.next()) {
    clock_.now = std::max(clock_.now, message->time.time_since_epoch());
    logged_ = WallTime{clock_.now};
    if (watcher) watcher(*message);
    loop_.step();
    loop_.receive(message->channel, message->bytes);
  }
}

void LogPlayer::complete_from(StoredLogs& journal, MessageHandler& handler) {
  PastTheCheck past(loop_, handler);
  MessageDecoder decoder(rig_, past);
  while (const auto message = journal.next()) {
    logged_ = message->time;
    decoder.receive(message->channel, authentication::message_of(message->bytes));
  }
}

}  // namespace strobe::host
