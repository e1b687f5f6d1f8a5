#include "host/loop/disarm_request.hpp"

#include <charconv>
#include <string_view>

namespace strobe::host {
namespace {

using strobe_msgs::event_t;

/// Takes `words` off the text's beginning.
bool take(std::string_view& text, std::string_view words) {
  const bool there = text.starts_with(words);
  if (there) text.remove_prefix(words.size());
  return there;
}

std::optional<std::int64_t> take_number(std::string_view& text, int base) {
  std::int64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (read.ec != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return number;
}

struct Disarmed {
  std::int64_t command_id = 0, host_id = 0;
};

/// Of the event's detail, as event_t.lcm gives it.
std::optional<Disarmed> disarmed_in(std::string_view detail) {
  if (!take(detail, "disarmed by command ")) return std::nullopt;
  const auto command_id = take_number(detail, 10);
  if (!command_id || !take(detail, " of ")) return std::nullopt;
  const auto host_id = take_number(detail, 16);
  if (!host_id) return std::nullopt;
  return Disarmed{*command_id, *host_id};
}

}  // namespace

void DisarmRequest::begin(HostTime now) {
  if (!asked_) asked_ = now;
  sent_ = now - kRepeat;
  first_command_ = 0;
}

bool DisarmRequest::due(HostTime now) {
  if (!asked_ || now - sent_ < kRepeat) return false;
  sent_ = now;
  return true;
}

void DisarmRequest::on_sent(std::int64_t command_id) {
  if (first_command_ == 0) first_command_ = command_id;
}

bool DisarmRequest::on_event(const event_t& event, std::int64_t boot_id) {
  if (!asked_ || first_command_ == 0 || event.kind != event_t::DISARMED || event.boot_id != boot_id)
    return false;
  const auto disarmed = disarmed_in(event.detail);
  if (!disarmed || disarmed->host_id != host_id_ || disarmed->command_id < first_command_) return false;
  asked_.reset();
  return true;
}

std::string DisarmRequest::not_confirmed(HostTime now) const {
  if (!asked_ || now - *asked_ < kConfirmWithin) return "";
  return "DISARM NOT CONFIRMED: the rig does not answer and may still be armed or fire; press the e-stop";
}

}  // namespace strobe::host
