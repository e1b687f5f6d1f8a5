#include "host/archive/log_player.hpp"

#include <algorithm>
#include <iterator>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/sealed_command_t.hpp>
#include <utility>

#include "common/authentication/packet_seal.hpp"
#include "common/messages/channels.hpp"
#include "common/messages/danger.hpp"
#include "common/messages/well_formed.hpp"
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

namespace {

using strobe_msgs::event_t;

}  // namespace

FiredShots::FiredShots(LogPlayer& player, const std::string& rig)
    : player_(player),
      command_channel_(messages::channel_name(rig, messages::Channel::command)),
      readout_channel_(messages::channel_name(rig, messages::Channel::readout)),
      frame_channel_(messages::channel_name(rig, messages::Channel::frame)) {
  player.loop().add_listener(*this);
}

void FiredShots::watch(const LogMessage& message) {
  if (message.channel == command_channel_) return watch_command(message);
  const auto bytes = authentication::message_of(message.bytes);
  if (message.channel == readout_channel_) return watch_readout(message, bytes);
  if (message.channel != frame_channel_) return;
  strobe_msgs::frame_t frame;
  if (messages::decode_checked(frame, bytes.data(), bytes.size()) &&
      frame.schema_version == strobe_msgs::frame_t::SCHEMA_VERSION)
    frames_[{frame.boot_id, frame.shot_id}] = {message.time, frame};
}

void FiredShots::watch_readout(const LogMessage& message, authentication::Bytes bytes) {
  if (const std::int64_t host = messages::readout_host(bytes.data(), bytes.size()); host != 0)
    reading_.try_emplace(host, HostHeard{message.time, message.log});
  strobe_msgs::readout_t readout;
  if (messages::decode_checked(readout, bytes.data(), bytes.size()))
    read_out_[{readout.boot_id, readout.shot_id}] = message.time;
}

void FiredShots::watch_command(const LogMessage& message) {
  strobe_msgs::sealed_command_t sealed;
  if (!messages::decode_checked(sealed, message.bytes.data(), message.bytes.size())) return;
  strobe_msgs::command_t command;
  if (messages::decode_checked(command, sealed.body.data(), sealed.body.size()))
    commanding_.try_emplace(command.host_id, HostHeard{message.time, message.log});
}

const LoggedFrame* FiredShots::frame(const ShotKey& key) const {
  auto found = frames_.find(key);
  if (found == frames_.end()) found = frames_.find({0, key.shot_id});
  return found == frames_.end() ? nullptr : &found->second;
}

const LoggedFrame* FiredShots::late_frame(const ShotKey& key) const {
  const auto shot = shots_.find(key);
  const auto logged = frames_.find(key);
  const auto told = read_out_.find(key);
  if (shot == shots_.end() || !shot->second.summary || logged == frames_.end() || told == read_out_.end())
    return nullptr;
  const bool measured = shot->second.result && shot->second.result->frame() != nullptr;
  return measured || told->second < logged->second.time ? nullptr : &logged->second;
}

LoggedShot& FiredShots::heard_of(const ShotKey& key) {
  const auto [found, is_new] = shots_.try_emplace(key);
  if (is_new) found->second.heard = player_.logged();
  return found->second;
}

/// Who armed for it: the last one before its start.
std::int64_t FiredShots::host_of(std::int64_t boot_id, std::int64_t started) const {
  const auto after = armed_.lower_bound({boot_id, started});
  if (after == armed_.begin() || std::prev(after)->first.first != boot_id) return 0;
  return std::prev(after)->second;
}

void FiredShots::on_event(const event_t& event) {
  boots_.try_emplace(event.boot_id, player_.logged());
  if (event.kind == event_t::ARMED)
    armed_[{event.boot_id, event.sequence}] = messages::host_id_in(event.detail);
  if (event.shot_id < 1 || event.kind != event_t::SHOT_STARTED) return;
  LoggedShot& shot = heard_of({event.boot_id, event.shot_id});
  shot.dry = event.detail == "dry";
  if (shot.host_id == 0) shot.host_id = host_of(event.boot_id, event.sequence);
}

void FiredShots::on_shot(const strobe_msgs::shot_t& summary) {
  boots_.try_emplace(summary.boot_id, player_.logged());
  LoggedShot& shot = heard_of({summary.boot_id, summary.shot_id});
  if (shot.summary) return;
  shot.summary = summary;
  shot.host_id = summary.host_id;
  shot.dry = summary.plan.dry;
  shot.from_journal = in_journal_;
  shot.heard = player_.logged();
}

void FiredShots::on_shot_result(const Shot& result) {
  boots_.try_emplace(result.boot_id, player_.logged());
  LoggedShot& shot = heard_of(result.key());
  if (shot.host_id == 0) shot.host_id = result.host_id;
  shot.dry = result.dry;
  shot.result = result;
}

}  // namespace strobe::host
