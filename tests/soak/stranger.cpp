#include "tests/soak/stranger.hpp"

#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/messages/channels.hpp"

namespace strobe::soak {

namespace {

constexpr std::size_t kRemembered = 256;

using strobe_msgs::event_t;
using strobe_msgs::frame_t;
using strobe_msgs::shot_t;
using strobe_msgs::status_t;

template <typename Message, typename Change>
std::vector<std::uint8_t> changed(std::span<const std::uint8_t> bytes, const Change& change) {
  Message message;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return {};
  change(message);
  return messages::encode(message);
}

/// Each shot aborted, each other event a refusal; of the boot and host given, if they are not 0.
std::vector<std::uint8_t> lie(const std::string& channel, std::span<const std::uint8_t> bytes,
                              std::int64_t boot, std::int64_t host) {
  if (channel.ends_with("/SHOT")) {
    return changed<shot_t>(bytes, [&](shot_t& shot) {
      shot.aborted = true;
      shot.abort_reason = "a stranger says so";
      if (boot != 0) shot.boot_id = boot;
      if (host != 0) shot.host_id = host;
    });
  }
  if (channel.ends_with("/EVENT")) {
    return changed<event_t>(bytes, [&](event_t& event) {
      event.kind = event.sequence % 2 == 0 ? event_t::REFUSED : event_t::SHOT_ABORTED;
      if (boot != 0) event.boot_id = boot;
    });
  }
  if (channel.ends_with("/FRAME")) {
    return changed<frame_t>(bytes, [&](frame_t& frame) {
      for (auto& image : frame.images) image.centre_x_px += 100.0 * image.centre_y_px;
      if (boot != 0) frame.boot_id = boot;
    });
  }
  return changed<status_t>(bytes, [&](status_t& status) {
    status.state = status_t::FAULT;
    status.last_shot_id += 1;
    if (boot != 0) status.boot_id = boot;
    if (host != 0 && status.arm_host_id != 0) status.arm_host_id = host;  // today's was not drawn yet
  });
}

}  // namespace

Stranger::Stranger(std::uint64_t seed, std::string rig, const authentication::Key& lab_key)
    : random_(seed),
      rig_(std::move(rig)),
      old_boot_(random_.id()),
      old_host_(random_.id()),
      other_lab_(authentication::Key::random(), 600),
      yesterday_(lab_key, old_boot_) {}

Stranger::Packet Stranger::forge(const std::string& channel, std::span<const std::uint8_t> packet) {
  heard_.push_back({channel, {packet.begin(), packet.end()}});
  if (heard_.size() > kRemembered) heard_.pop_front();
  const int way = random_.integer(0, 5);
  if (way == 0) return {channel, lie(channel, packet, 0, 0)};
  if (way == 1)
    return {channel, other_lab_.packet(channel, authentication::Bytes(lie(channel, packet, 0, 0)))};
  Packet sent = heard_.back();
  if (way == 2)
    sent.bytes[random_.bits() % sent.bytes.size()] ^= static_cast<std::uint8_t>(1 << random_.integer(0, 7));
  if (way == 3) sent.bytes.resize(random_.bits() % sent.bytes.size());
  if (way == 4)
    sent.channel = messages::channel_name(
        rig_, channel.ends_with("/SHOT") ? messages::Channel::frame : messages::Channel::shot);
  // One that has arrived long ago: a newer one could be the first of its number, as a doubled one is.
  if (way == 5) sent = heard_.size() < kRemembered ? Packet{channel, {1, 2, 3}} : heard_.front();
  return sent;
}

Stranger::Packet Stranger::of_yesterday(const std::string& channel, std::span<const std::uint8_t> packet) {
  const std::vector<std::uint8_t> message = lie(channel, packet, old_boot_, old_host_);
  return {channel, yesterday_.packet(channel, authentication::Bytes(message))};
}

}  // namespace strobe::soak
