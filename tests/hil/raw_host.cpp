#include "tests/hil/raw_host.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <random>
#include <stdexcept>

#include "common/authentication/key_file.hpp"
#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "common/wire/lcm_datagram.hpp"
#include "common/wire/lcm_url.hpp"
#include "tests/support/process.hpp"

namespace strobe::hil {

using messages::Channel;
using messages::channel_name;
using namespace std::chrono_literals;

namespace {

std::int64_t random_id() {
  std::random_device random;
  return std::uniform_int_distribution<std::int64_t>(1)(random);
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

RawHost::RawHost(const RigFixture& bench)
    : bench_(bench),
      lcm_(bench.lcm_url()),
      rig_("bench"),
      key_(authentication::find_key({}).value().key),
      host_id_(random_id()) {
  if (!lcm_.good()) throw std::runtime_error("no LCM at " + bench.lcm_url());
  const std::string& rig = rig_;
  const auto all = [](lcm::Subscription* subscription) {
    subscription->setQueueCapacity(messages::kSubscriptionQueueCapacity);
  };
  all(lcm_.subscribe(channel_name(rig, Channel::status), &RawHost::take_status, this));
  all(lcm_.subscribe(channel_name(rig, Channel::event), &RawHost::take_event, this));
  all(lcm_.subscribe(channel_name(rig, Channel::shot), &RawHost::take_shot, this));
}

void RawHost::take_status(const lcm::ReceiveBuffer*, const std::string&,
                          const strobe_msgs::status_t* status) {
  status_ = *status;
  status_seen_ = true;
}

void RawHost::take_event(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::event_t* event) {
  events_.push_back(*event);
}

void RawHost::take_shot(const lcm::ReceiveBuffer*, const std::string&, const strobe_msgs::shot_t* shot) {
  shots_.push_back(*shot);
}

bool RawHost::wait(const std::function<bool()>& condition, std::chrono::milliseconds limit) {
  const std::int64_t end = testing::monotonic_now_ns() + std::chrono::nanoseconds(limit).count();
  while (!condition()) {
    if (testing::monotonic_now_ns() >= end) return false;
    lcm_.handleTimeout(10);
  }
  return true;
}

void RawHost::listen(std::chrono::milliseconds time) {
  wait([] { return false; }, time);
}

bool RawHost::wait_status() {
  return wait([this] { return status_seen_; }, kLongestWait);
}

std::int64_t RawHost::boot_time_ns() {
  if (!chip_)
    if (auto chip = sim::Chip::attach(bench_.chip_dir())) chip_.emplace(std::move(*chip));
  return (chip_ ? chip_->clock() : sim::RigClock()).since_boot().count();
}

strobe_msgs::command_t RawHost::command(std::int8_t kind) {
  strobe_msgs::command_t command{};
  command.schema_version = strobe_msgs::command_t::SCHEMA_VERSION;
  command.host_id = host_id_;
  command.command_id = next_command_++;
  command.boot_id = status_.boot_id;
  command.sent_boot_time_ns = boot_time_ns();
  command.kind = kind;
  command.note_count = 0;
  return command;
}

void RawHost::send(const strobe_msgs::command_t& command) { send_bytes(sealed(command, key_)); }

std::vector<std::uint8_t> RawHost::sealed(const strobe_msgs::command_t& command,
                                          const authentication::Key& key) const {
  return authentication::seal(key, rig_, body(command)).value();
}

std::vector<std::uint8_t> RawHost::body(const strobe_msgs::command_t& command) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(command.getEncodedSize()));
  command.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

void RawHost::send_bytes(std::span<const std::uint8_t> bytes) {
  lcm_.publish(channel_name(rig_, Channel::command), bytes.data(), static_cast<unsigned>(bytes.size()));
}

bool RawHost::reset() {
  const auto ready = [this] {
    return status_.state != strobe_msgs::status_t::STOPPED && status_.message.empty();
  };
  // Asked anew where the stop, or a switch's return, had not been seen yet.
  const auto asked_until_ready = [&] {
    send(command(strobe_msgs::command_t::RESET));
    return wait(ready, 500ms);
  };
  return wait(asked_until_ready, kLongestWait);
}

std::int64_t RawHost::arm(std::chrono::milliseconds limit) {
  // What was heard meanwhile may name the token of an earlier arming, which is no longer good.
  while (lcm_.handleTimeout(0) > 0) continue;
  if (status_.state == strobe_msgs::status_t::STOPPED && !reset()) return 0;
  const std::int64_t earlier = status_.arm_token;
  send(command(strobe_msgs::command_t::ARM));
  const auto given = [&] {
    return status_.arm_host_id == host_id_ && status_.arm_token != 0 && status_.arm_token != earlier;
  };
  const auto stopped = [&] { return status_.state == strobe_msgs::status_t::STOPPED; };
  if (!wait([&] { return given() || stopped(); }, limit)) return 0;
  if (given()) return status_.arm_token;
  // Word of the stop came after the command.
  if (!reset()) return 0;
  send(command(strobe_msgs::command_t::ARM));
  return wait(given, limit) ? status_.arm_token : 0;
}

std::int64_t RawHost::fire_until_flash(LineWatcher& watch, const ShotOfToken& shot, int shots) {
  for (int fired = 0; fired < shots; ++fired) {
    const std::int64_t token = arm();
    if (token == 0)
      throw std::runtime_error("no token: " + (events_.empty() ? status_.message : events_.back().detail));
    send(shot(token));
    // A shot that comes late ends without a flash; one that is refused never begins.
    std::int64_t flash_ns = 0;
    const auto flashed_or_over = [&] {
      flash_ns = watch.wait_for("STROBE_A", 1, 10ms);
      return flash_ns != 0 || status_.state == strobe_msgs::status_t::SPENT;
    };
    if (!wait(flashed_or_over, kLongestWait))
      throw std::runtime_error("no shot: " + (events_.empty() ? "" : events_.back().detail));
    if (flash_ns != 0) return flash_ns;
  }
  return 0;
}

strobe_msgs::command_t RawHost::fire_command(std::int64_t token, bool dry) {
  strobe_msgs::command_t fire = command(strobe_msgs::command_t::FIRE);
  fire.arm_token = token;
  fire.plan.train = strobe_msgs::plan_t::TRAIN_FREE;
  fire.plan.period_ns = 3'000'000;
  fire.plan.shutter_open_ns = 200'000'000;
  fire.plan.impact_at_ns = 100'000'000;
  fire.plan.dry = dry ? 1 : 0;
  return fire;
}

bool RawHost::saw(std::int8_t event_kind) const {
  for (const auto& event : events_) {
    if (event.kind == event_kind) return true;
  }
  return false;
}

LogContents read_log(const std::string& path) {
  lcm::LogFile log(path, "r");
  if (!log.good()) throw std::runtime_error("no log " + path);
  LogContents contents;
  while (const lcm::LogEvent* entry = log.readNextEvent()) {
    strobe_msgs::event_t event;
    strobe_msgs::shot_t shot;
    strobe_msgs::frame_t frame;
    if (ends_with(entry->channel, "/EVENT") && event.decode(entry->data, 0, entry->datalen) > 0) {
      contents.events.push_back(event);
    } else if (ends_with(entry->channel, "/SHOT") && shot.decode(entry->data, 0, entry->datalen) > 0) {
      contents.shots.push_back(shot);
    } else if (ends_with(entry->channel, "/FRAME") && frame.decode(entry->data, 0, entry->datalen) > 0) {
      contents.frames.push_back(frame);
    } else if (ends_with(entry->channel, "/COMMAND")) {
      ++contents.commands;
    } else {
      ++contents.other;
    }
  }
  return contents;
}


RawSender::RawSender(const std::string& lcm_url) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const auto url = wire::read_lcm_url(lcm_url);
  if (!url || fd_ < 0) throw std::runtime_error("no multicast group in " + lcm_url);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url->group.port);
  inet_pton(AF_INET, url->group.address.c_str(), &address.sin_addr);
  const int ttl = 0;
  setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  if (connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("no route to " + lcm_url);
}

RawSender::~RawSender() { close(fd_); }

bool RawSender::send(const Bytes& datagram) const {
  return ::send(fd_, datagram.data(), datagram.size(), 0) == static_cast<ssize_t>(datagram.size());
}

Bytes RawSender::whole(std::string_view channel, const Bytes& message) {
  constexpr std::array<std::uint8_t, 8> kHeader{'L', 'C', '0', '2', 0, 0, 0, 1};
  Bytes datagram(kHeader.size() + channel.size() + 1 + message.size());
  auto end = std::copy(kHeader.begin(), kHeader.end(), datagram.begin());
  end = std::copy(channel.begin(), channel.end(), end) + 1;  // a zero ends the channel
  std::copy(message.begin(), message.end(), end);
  return datagram;
}

Flooder::Flooder(const std::string& lcm_url, const std::string& rig, const Bytes& true_command)
    : sender_(lcm_url) {
  const std::string channel = messages::channel_name(rig, messages::Channel::command);
  const Bytes body(true_command.size() - authentication::kSealed_bytes, 1);
  const auto strangers_key = authentication::Key::random();
  datagrams_[forged] = RawSender::whole(channel, authentication::seal(strangers_key, rig, body).value());
  datagrams_[replayed] = RawSender::whole(channel, true_command);
  datagrams_[garbage] = RawSender::whole(channel, Bytes(true_command.size(), 0x5a));
  datagrams_[oversized] = RawSender::whole(channel, Bytes(65'000, 0x5a));
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

std::int64_t Flooder::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return sent_;
}

void Flooder::run(const std::stop_token& stop) {
  constexpr std::int64_t kSmallOnes = 64;  // for each of the largest, which would else be all that fits
  for (std::int64_t i = 0; !stop.stop_requested(); ++i) {
    const std::size_t kind =
        i % kSmallOnes == 0 ? static_cast<std::size_t>(oversized) : static_cast<std::size_t>(i % 3);
    if (sender_.send(datagrams_[kind])) sent_.fetch_add(1, std::memory_order_relaxed);
  }
}

}  // namespace strobe::hil
