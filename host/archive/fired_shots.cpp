#include "host/archive/fired_shots.hpp"

#include <charconv>
#include <iterator>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/sealed_command_t.hpp>

#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::event_t;

std::int64_t host_id_in(const std::string& hex) {
  std::uint64_t host = 0;
  std::from_chars(hex.data(), hex.data() + hex.size(), host, 16);
  return static_cast<std::int64_t>(host);
}

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
    told_[{readout.boot_id, readout.shot_id}] = message.time;
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
  const auto told = told_.find(key);
  if (shot == shots_.end() || !shot->second.summary || logged == frames_.end() || told == told_.end())
    return nullptr;
  const bool measured = shot->second.result && shot->second.result->frame;
  return measured || told->second < logged->second.time ? nullptr : &logged->second;
}

FiredShot& FiredShots::heard_of(const ShotKey& key) {
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
  if (event.kind == event_t::ARMED) armed_[{event.boot_id, event.sequence}] = host_id_in(event.detail);
  if (event.shot_id < 1 || event.kind != event_t::SHOT_STARTED) return;
  FiredShot& shot = heard_of({event.boot_id, event.shot_id});
  shot.dry = event.detail == "dry";
  if (shot.host_id == 0) shot.host_id = host_of(event.boot_id, event.sequence);
}

void FiredShots::on_shot(const strobe_msgs::shot_t& summary) {
  boots_.try_emplace(summary.boot_id, player_.logged());
  FiredShot& shot = heard_of({summary.boot_id, summary.shot_id});
  if (shot.summary) return;
  shot.summary = summary;
  shot.host_id = summary.host_id;
  shot.dry = summary.plan.dry;
  shot.from_journal = in_journal_;
  shot.heard = player_.logged();
}

void FiredShots::on_shot_result(const ShotResult& result) {
  boots_.try_emplace(result.boot_id, player_.logged());
  FiredShot& shot = heard_of({result.boot_id, result.shot_id});
  if (shot.host_id == 0) shot.host_id = result.host_id;
  shot.dry = result.dry;
  shot.result = result;
}

}  // namespace strobe::host
