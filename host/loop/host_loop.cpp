#include "host/loop/host_loop.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <string_view>
#include <strobe_msgs/readout_t.hpp>

#include "common/messages/lcm_conversions.hpp"
#include "common/messages/well_formed.hpp"
#include "common/reduction/mixture.hpp"
#include "host/text/text.hpp"

namespace strobe::host {
namespace {

constexpr std::chrono::milliseconds kMaxWait{20};
// Two clocks are not read quite together.
constexpr Duration kAsleep = std::chrono::seconds{1};

Duration slept(const HostReading& reading) { return reading.since_boot - reading.mono.time_since_epoch(); }

}  // namespace

HostLoop::HostLoop(HostLoopSettings settings, Transport& transport, Clock& clock)
    : settings_(std::move(settings)),
      transport_(transport),
      clock_(clock),
      commands_(settings_.host_id, settings_.host_name),
      rig_channels_("STROBE/" + settings_.rig + "/"),
      command_channel_(messages::channel_name(settings_.rig, messages::Channel::command)),
      check_(settings_.key, settings_.host_id),
      session_(settings_.assembly, settings_.fires ? settings_.host_id : 0,
               settings_.key.has_value() && !settings_.replays),
      decoder_(settings_.rig, *this),
      disarm_(settings_.host_id),
      now_(clock.read().mono),
      last_message_(now_) {
  const HostReading begin = clock.read();
  acted_ = begin.since_boot;
  slept_before_ = slept(begin);
  session_.boots().set_rig(settings_.rig);
  if (!settings_.key || settings_.replays) return;
  sealer_.emplace(*settings_.key, settings_.rig);
  seal_.emplace(*settings_.key);
}

bool HostLoop::run_once() {
  std::vector<int> descriptors = photographs_ ? photographs_->descriptors() : std::vector<int>();
  if (wake_descriptor_ >= 0) descriptors.push_back(wake_descriptor_);
  const bool receiving = transport_.receive(
      kMaxWait, descriptors,
      [this](const std::string& channel, Transport::Bytes bytes) { receive(channel, bytes); });
  if (receiving) step();
  return receiving;
}

void HostLoop::receive(const std::string& channel, Transport::Bytes bytes) {
  if (channel == command_channel_ || !channel.starts_with(rig_channels_)) return;
  now_ = clock_.read().mono;
  const auto message = check_.open(channel, bytes);
  if (!message) return;
  last_message_ = now_;
  transport_.keep(channel, bytes);  // first, so that a log holds what a result came from
  decoder_.receive(channel, *message);
}

void HostLoop::step() {
  const HostReading reading = clock_.read();
  now_ = reading.mono;
  suspended_ = suspended_ || slept(reading) - slept_before_ > kAsleep;
  if (photographs_) {
    photographs_->step(now_);
    publish_photographs();
  }
  session_.on_time(now_);
  session_.on_local_clocks(reading);
  if (const auto line = check_.due_line(now_)) notify(*line);
  report();
  report_fault();
  request_lost_events();
  repeat_disarm();
  ask_who_hears();
}

/// Of the handling of a message, such as memory that was not to be had.
void HostLoop::report_fault() {
  if (decoder_.fault() == told_fault_) return;
  told_fault_ = decoder_.fault();
  tell_not_kept("a message could not be taken in: " + told_fault_);
}

void HostLoop::tell_not_kept(const std::string& text) {
  notify(text);
  for (HostListener* listener : listeners_) listener->on_not_kept(text);
}

void HostLoop::on_status(const strobe_msgs::status_t& message) {
  session_.on_status(message, now_, transport_.sender());
  answers_.on_status(message);
  if (session_.status() && session_.status()->boot_time_ns == message.boot_time_ns)
    last_status_ = clock_.read();
  report();
}

void HostLoop::on_event(const strobe_msgs::event_t& message) {
  const auto& status = session_.status();
  if (status && disarm_.on_event(message, status->boot_id)) {
    session_.set_unconfirmed("");
    notify(
        "disarmed: the firmware confirms it; nothing is armed until a person gives the command to fire anew");
  }
  session_.on_event(message, now_);
  answers_.on_event(message);
  for (HostListener* listener : listeners_) listener->on_event(message);
  report();
}

void HostLoop::on_shot(const strobe_msgs::shot_t& message) {
  if (photographs_) photographs_->on_shot(message);
  session_.on_shot(message, now_);
  for (HostListener* listener : listeners_) listener->on_shot(message);
  report();
}

void HostLoop::on_frame(const strobe_msgs::frame_t& message) {
  // Its own are taken in as they are published.
  if (photographs_ && message.host_id == settings_.host_id) return;
  // Of which session? It could be any day's, played back.
  if (verifies() && message.boot_id == 0)
    return notify(fmt::format(
        "a frame of shot {} is not used: it does not say of which start of the firmware", message.shot_id));
  process(message);
}

void HostLoop::process(const strobe_msgs::shot_t& shot) {
  if (photographs_) photographs_->on_shot(shot);
  session_.on_shot(shot, now_);
}

void HostLoop::process(const strobe_msgs::frame_t& frame) {
  if (photographs_) photographs_->on_frame(frame);
  session_.on_frame(frame, now_);
  report();
}

void HostLoop::publish_photographs() {
  for (const KeptPhotograph& kept : photographs_->take_kept())
    for (HostListener* listener : listeners_) listener->on_photograph(kept);
  for (const tether::OpenedEvent& camera : photographs_->take_camera_states())
    for (HostListener* listener : listeners_) listener->on_camera(camera);
  for (const auto& frame : photographs_->take_frames()) {
    publish(messages::Channel::frame, frame);  // first, so that a log holds what a result came from
    process(frame);
  }
  for (const std::string& text : photographs_->take_notifications()) notify(text);
  for (const std::string& text : photographs_->take_not_kept()) tell_not_kept(text);
}

void HostLoop::end_photographs() {
  if (!photographs_) return;
  photographs_->end(now_);
  publish_photographs();
}

void HostLoop::end_session() {
  session_.on_end();
  report();
}

void HostLoop::request_lost_events() {
  const auto& status = session_.status();
  if (!sealer_ || !status) return;
  for (const EventRange& range : session_.ledger().due(now_)) send(commands_.resend(status->boot_id, range));
}

void HostLoop::ask_who_hears() {
  if (!sealer_) return;
  for (const EventRange& range : session_.boots().due(now_)) send(commands_.resend(range.boot_id, range));
  const std::string problem = unanswered();
  if (problem.empty() == told_unanswered_.empty()) return;
  notify(problem.empty() ? "no longer so: the rig answers again, or is not heard any more" : problem);
  told_unanswered_ = problem;
}

/// The firmware's CLOCK_BOOTTIME now, or earlier by what its status was on its way. 0: it is not heard.
std::int64_t HostLoop::firmware_boot_time_ns(std::int64_t boot_id) {
  const auto& status = session_.status();
  if (!status || status->boot_id != boot_id) return 0;
  return status->boot_time_ns + (clock_.read().mono - last_status_.mono).count();
}

/// When the person acted, by the firmware's CLOCK_BOOTTIME, or earlier likewise. 0: it is not heard.
std::int64_t HostLoop::acted_boot_time_ns(std::int64_t boot_id) const {
  const auto& status = session_.status();
  if (!status || status->boot_id != boot_id) return 0;
  return status->boot_time_ns + (acted_ - last_status_.since_boot).count();
}

void HostLoop::disarm(const std::string& by) {
  if (!sealer_)
    return notify("cannot DISARM (asked for by " + by + "): this host does not have the lab's key");
  notify("DISARM asked for by " + by);
  disarm_.begin(now_);
  repeat_disarm();
}

void HostLoop::repeat_disarm() {
  const auto& status = session_.status();
  if (disarm_.due(now_)) {
    std::vector<std::int64_t> boots = session_.boots().heard(now_);  // two rigs of one name, if there are
    if (status && !std::ranges::count(boots, status->boot_id)) boots.push_back(status->boot_id);
    for (const std::int64_t boot_id : boots) {
      const strobe_msgs::command_t command = commands_.disarm(boot_id);
      disarm_.on_sent(command.command_id);
      send(command);
    }
  }
  if (!disarm_.open()) return;
  const std::string words = disarm_.not_confirmed(now_);
  if (session_.set_unconfirmed(words)) notify(words);
}

void HostLoop::send(strobe_msgs::command_t command) {
  if (!sealer_) return;
  answers_.on_sent(command, live_status(), now_);
  const bool is_reset = command.kind == strobe_msgs::command_t::RESET;
  command.sent_boot_time_ns =
      is_reset ? acted_boot_time_ns(command.boot_id) : firmware_boot_time_ns(command.boot_id);
  if (const auto sealed = sealer_->seal(command)) {
    transport_.publish(command_channel_, *sealed);
  } else {
    notify(sealed.error().message);
  }
}

template <typename Message>
void HostLoop::publish(messages::Channel channel, const Message& message) {
  assert(channel != messages::Channel::command);  // which have a sealer and a path of their own
  const std::string name = messages::channel_name(settings_.rig, channel);
  const std::vector<std::uint8_t> bytes = messages::encode(message);
  transport_.publish(name, seal_ ? seal_->seal(name, bytes, {settings_.host_id, ++packets_sealed_}) : bytes);
}

/// Some milliseconds, which nobody who waits for the readout's message waits for.
void HostLoop::make_budget(Shot& result) {
  if (!result.matched) return;
  result.budget = reduction::mixture_budget(*result.matched, result.readout);
  if (auto told = reduction::photograph_witnesses(*result.matched)) result.witnesses = std::move(*told);
  result.matched.reset();
}

void HostLoop::report() {
  for (const std::string& text : session_.take_notifications()) notify(text);
  for (Shot& result : session_.take_shot_results()) {
    result.verified = verifies();
    const bool own = result.host_id == settings_.host_id || session_.adopted(result.host_id);
    if (settings_.fires && own && !result.dry && !read_out_.contains(result.key())) {
      publish(messages::Channel::readout,
              messages::readout_to_lcm(result.readout, settings_.host_id, result.boot_id));
    }
    make_budget(result);
    if (own) result.until_known = settings_.until_known;
    for (HostListener* listener : listeners_) listener->on_shot_result(result);
  }
}

void HostLoop::notify(const std::string& text) {
  for (HostListener* listener : listeners_) listener->on_notification(text);
}

namespace {

using strobe_msgs::event_t;

struct Disarmed {
  std::int64_t command_id = 0, host_id = 0;
};

/// Of the event's detail, as event_t.lcm gives it.
std::optional<Disarmed> disarmed_in(std::string_view detail) {
  Disarmed found;
  if (!take(detail, "disarmed by command ") || !take(detail, found.command_id, 10) || !take(detail, " of ") ||
      !take(detail, found.host_id, 16))
    return std::nullopt;
  return found;
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
