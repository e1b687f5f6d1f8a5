#include "firmware/publisher/receiver.hpp"

#include <sodium.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "common/authentication/seal.hpp"
#include "common/messages/danger.hpp"
#include "common/messages/plan_lcm.hpp"
#include "common/messages/well_formed.hpp"
#include "common/wire/log_reader.hpp"
#include "firmware/core/pulse_schedule.hpp"

namespace strobe::firmware {

using authentication::Rejection;

std::int64_t random_id() {
  std::int64_t id = 0;
  while (id == 0) {
    randombytes_buf(&id, sizeof id);
    id &= 0x7fffffffffffffff;
  }
  return id;
}

bool CommandQueue::push(const Command& command) {
  if (!queue_.try_enqueue(command)) return false;
  loop_.wake();
  return true;
}

bool RepetitionFilter::is_new(std::int64_t host_id, std::int64_t command_id) {
  const auto known = newest_.find(host_id);
  if (known == newest_.end()) {
    if (newest_.size() == kMaxHosts) return false;
    newest_[host_id] = command_id;
    return true;
  }
  if (command_id <= known->second) return false;
  known->second = command_id;
  return true;
}

namespace {

/// No value may look like a journal's record, which the journal's readers search for.
bool good_note(const strobe_msgs::note_t& note) {
  return note.value.find(wire::kLogSync_bytes) == std::string::npos && !note.key.empty() &&
         note.key.size() <= 64 && note.value.size() <= 1024 &&
         note.key.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == std::string::npos;
}

/// Who asks, as the command tells for a person: one word.
ShortText host_name_in(const strobe_msgs::command_t& command) {
  constexpr std::size_t kLongestName = 64;
  for (const auto& note : command.notes) {
    if (note.key != messages::kHostNameNote || !good_note(note)) continue;
    std::string name = note.value.substr(0, kLongestName);
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return c <= ' ' || c == 0x7f; }, '_');
    return ShortText(std::string_view(name));
  }
  return {};
}

}  // namespace

std::string find_defect(const strobe_msgs::command_t& command, const Rig& rig) {
  using Type = strobe_msgs::command_t;
  if (command.schema_version != Type::SCHEMA_VERSION) {
    return "schema version " + std::to_string(command.schema_version) + " instead of " +
           std::to_string(static_cast<int>(Type::SCHEMA_VERSION));
  }
  if (command.host_id == 0) return "the command names no host";
  if (command.kind != Type::FIRE) return "";
  if (!std::all_of(command.notes.begin(), command.notes.end(), good_note))
    return "a note's key, length or text is not allowed";
  const auto checked = check_plan(messages::plan_from_lcm(command.plan), rig);
  return checked ? "" : checked.error().message;
}

std::string find_age(const strobe_msgs::command_t& command, std::int64_t boot_time_ns) {
  using Type = strobe_msgs::command_t;
  if (command.kind == Type::DISARM || command.kind == Type::RESEND) return "";
  constexpr std::int64_t kMillisecond_ns = 1'000'000;
  constexpr std::int64_t kNoClock_ns = std::int64_t{1}
                                       << 60;  // 36 years: no instant, and no difference overflows
  const std::int64_t sent_ns = command.sent_boot_time_ns;
  if (sent_ns == 0 || sent_ns < -kNoClock_ns || sent_ns > kNoClock_ns)
    return "it does not say when it was sent";
  const std::int64_t age_ns = boot_time_ns - sent_ns;
  // However long ago a person acted: what counts is that no stop came since, which the interlock knows.
  if (age_ns > Type::LONGEST_LIFE_NS && command.kind != Type::RESET) {
    return "it came " + std::to_string(age_ns / kMillisecond_ns) + " ms after it was sent, and is good for " +
           std::to_string(Type::LONGEST_LIFE_NS / kMillisecond_ns) + " ms";
  }
  if (age_ns <= -Type::EARLIEST_NS) return "it was sent in the future: does its host hear this rig's status?";
  return "";
}

Receiver::Receiver(const Rig& rig, std::int64_t boot_id, const authentication::Key& key,
                   CommandQueue& commands, Mailbox& mailbox, Rejections& rejections,
                   std::function<std::int64_t()> boot_time_ns, std::function<std::int64_t()> draw_token,
                   std::atomic<std::int64_t>* heard_ns)
    : rig_(rig),
      boot_id_(boot_id),
      key_(key),
      commands_(commands),
      mailbox_(mailbox),
      rejections_(rejections),
      boot_time_ns_(std::move(boot_time_ns)),
      draw_token_(std::move(draw_token)),
      heard_ns_(heard_ns) {}

void Receiver::receive(std::span<const std::uint8_t> sealed) noexcept {
  try {
    open(sealed);
  } catch (const std::exception& error) {
    // Out of a message handler an exception would cross C code.
    rejections_.tell(std::string("a command was dropped: ") + error.what());
  }
}

void Receiver::open(std::span<const std::uint8_t> sealed) {
  const auto body = authentication::unseal(key_, rig_.name, sealed);
  if (!body) return rejections_.note(body.error());
  strobe_msgs::command_t command{};
  if (!messages::decode_checked(command, body->data(), body->size()))
    return rejections_.note(Rejection::malformed);
  dispatch(command);
}

void Receiver::dispatch(const strobe_msgs::command_t& message) {
  if (message.boot_id != boot_id_) return rejections_.note(Rejection::stale);
  if (message.kind < strobe_msgs::command_t::ARM || message.kind > strobe_msgs::command_t::RESET)
    return rejections_.note(Rejection::malformed);
  if (!filter_.is_new(message.host_id, message.command_id)) return rejections_.note(Rejection::replayed);
  if (heard_ns_ != nullptr) *heard_ns_ = boot_time_ns_();
  std::string defect = find_defect(message, rig_);
  if (defect.empty()) defect = find_age(message, boot_time_ns_());
  if (message.kind == strobe_msgs::command_t::RESEND) {
    const EventRange range{message.resend_boot_id, {message.resend_first, message.resend_last}};
    if (defect.empty()) mailbox_.ask({message.host_id, range, range.boot_id == boot_id_});
    return;
  }
  Command command;
  command.kind = static_cast<CommandKind>(message.kind);
  command.host_id = message.host_id;
  command.command_id = message.command_id;
  command.token = message.arm_token;
  command.plan = messages::plan_from_lcm(message.plan);
  command.defect = ShortText(defect);
  command.host_name = host_name_in(message);
  if (command.kind == CommandKind::arm) command.new_token = draw_token_();
  if (command.kind == CommandKind::reset) command.acted_boot_time = Duration{message.sent_boot_time_ns};
  if (command.kind == CommandKind::fire && defect.empty()) {
    ShotNotes notes{message.host_id, message.command_id, {}};
    for (const auto& note : message.notes) notes.notes.push_back({note.key, note.value});
    mailbox_.keep(std::move(notes));
  }
  if (!commands_.push(command)) rejections_.tell("a command was dropped: too many at once");
}

}  // namespace strobe::firmware
