#include "host/session/live_boots.hpp"

#include <fmt/format.h>
#include <algorithm>

namespace strobe::host {
namespace {

constexpr std::size_t kMaxLiveBoots = 8;
// One that has ended is no reason to wait for longer than it takes to miss three heartbeats.
constexpr Duration kUnprovenHeard = milliseconds{1600};
constexpr Duration kAskEvery = milliseconds{700};
constexpr Duration kAskAgainEvery = std::chrono::seconds{5};
constexpr std::size_t kQuestions = 4;
// One could be an event that somebody else had asked for.
constexpr int kAnswers = 2;

/// splitmix64: numbers that no log has foreseen.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
  x = (x ^ x >> 27) * 0x94d049bb133111ebU;
  return x ^ x >> 31;
}

}  // namespace

LiveBoots::Verdict LiveBoots::Boot::verdict() const {
  if (proven) return Verdict::rig;
  return answers.size() < kQuestions ? Verdict::open : Verdict::silent;
}

/// Of too many the one heard longest ago is forgotten.
LiveBoots::Boot& LiveBoots::boot_of(std::int64_t boot_id) {
  if (!boots_.contains(boot_id) && boots_.size() == kMaxLiveBoots)
    boots_.erase(std::ranges::min_element(boots_, {}, [](const auto& boot) { return boot.second.heard; }));
  return boots_[boot_id];
}

void LiveBoots::on_status(const strobe_msgs::status_t& status, std::string sender, HostTime now) {
  if (!began_) began_ = now;
  const bool known = boots_.contains(status.boot_id);
  Boot& boot = boot_of(status.boot_id);
  if (known && status.mono_ns <= boot.status.mono_ns) return;  // its clock has to go on
  boot.status = status;
  boot.sender = std::move(sender);
  boot.heard = now;
}

/// Whether a boot that is heard, and answers or may yet, came after it.
bool LiveBoots::earlier(std::int64_t boot_id, HostTime now) const {
  return std::ranges::any_of(boots_, [&](const auto& other) {
    return now - other.second.heard <= kHeard && other.second.verdict() != Verdict::silent &&
           std::ranges::any_of(other.second.status.earlier,
                               [&](const auto& listed) { return listed.boot_id == boot_id; });
  });
}

bool LiveBoots::counts(const Boots::value_type& boot, HostTime now) const {
  const Verdict verdict = boot.second.verdict();
  const Duration longest = verdict == Verdict::rig ? kHeard : kUnprovenHeard;
  return verdict != Verdict::silent && now - boot.second.heard <= longest && !earlier(boot.first, now);
}

std::vector<std::int64_t> LiveBoots::heard(HostTime now) const {
  std::vector<std::int64_t> found;
  for (const auto& [boot_id, boot] : boots_)
    if (now - boot.heard <= kHeard && !earlier(boot_id, now)) found.push_back(boot_id);
  return found;
}

/// One of all events that it has, and none that another is asked for: a log that is recorded and played back
/// at once would have that one.
std::int64_t LiveBoots::draw(const Boots::value_type& boot, HostTime now) {
  const auto known = std::max<std::int64_t>(1, boot.second.status.last_sequence);
  const auto seed = static_cast<std::uint64_t>(boot.first ^ now.time_since_epoch().count());
  auto drawn = 1 + static_cast<std::int64_t>(mixed(seed + ++drawn_) % static_cast<std::uint64_t>(known));
  const auto taken = [&drawn](const auto& other) { return other.second.asked == drawn; };
  for (std::size_t i = 0; i < kMaxLiveBoots && std::ranges::any_of(boots_, taken); ++i)
    drawn = drawn % known + 1;
  return drawn;
}

std::vector<EventRange> LiveBoots::due(HostTime now) {
  tell_of_rigs(now);
  std::vector<EventRange> questions;
  const std::vector<std::int64_t> present = heard(now);
  if (present.size() < 2) return questions;
  for (const std::int64_t boot_id : present) {
    Boot& boot = boots_.at(boot_id);
    const Duration every = boot.verdict() == Verdict::open ? kAskEvery : kAskAgainEvery;
    if (boot.asked_at && now - *boot.asked_at < every) continue;
    if (boot.asked != 0) note(boot_id, boot, false);
    boot.asked = draw({boot_id, boot}, now);
    boot.asked_at = now;
    questions.push_back({boot_id, {boot.asked, boot.asked}});
  }
  return questions;
}

void LiveBoots::on_event(std::int64_t boot_id, std::int64_t sequence, HostTime now) {
  const auto found = boots_.find(boot_id);
  if (found == boots_.end() || found->second.asked != sequence || sequence == 0) return;
  if (now - *found->second.asked_at <= kAskEvery) note(boot_id, found->second, true);
}

void LiveBoots::note(std::int64_t boot_id, Boot& boot, bool answered) {
  boot.asked = 0;
  boot.answers.push_back(answered);
  if (boot.answers.size() > kQuestions) boot.answers.erase(boot.answers.begin());
  const auto answers = std::ranges::count(boot.answers, true);
  boot.proven = answers >= kAnswers || (boot.proven && answers > 0);
  if (boot.verdict() != Verdict::silent || boot.told) return;
  boot.told = true;
  notifications_.push_back("heartbeats of " + words(boot_id, boot) +
                           " are heard beside others, and it does not answer this host: a log that is played "
                           "back, or a rig that does not hear; shots are not held up for it");
}

std::string LiveBoots::words(std::int64_t boot_id, const Boot& boot) {
  return fmt::format("boot {:x}{}", boot_id, boot.sender.empty() ? "" : " at " + boot.sender);
}

std::vector<LiveBoots::Boots::const_iterator> LiveBoots::counted(HostTime now) const {
  std::vector<Boots::const_iterator> found;
  for (auto boot = boots_.begin(); boot != boots_.end(); ++boot)
    if (counts(*boot, now)) found.push_back(boot);
  return found;
}

bool LiveBoots::proven(const std::vector<Boots::const_iterator>& rigs) {
  return rigs.size() > 1 &&
         std::ranges::all_of(rigs, [](const auto& rig) { return rig->second.verdict() == Verdict::rig; });
}

void LiveBoots::tell_of_rigs(HostTime now) {
  const bool several = proven(counted(now));
  if (several && !told_rigs_) notifications_.push_back(problem(now));
  told_rigs_ = several;
}

std::string LiveBoots::problem(HostTime now) const {
  const std::vector<Boots::const_iterator> rigs = counted(now);
  if (rigs.size() > 1) {
    std::string all;
    for (const auto& rig : rigs) all += (all.empty() ? "" : ", ") + words(rig->first, rig->second);
    return proven(rigs) ? fmt::format("{} rigs have the name {}: {}; stop or rename all but one", rigs.size(),
                                      name_, all)
                        : fmt::format("{} rigs may have the name {}: {}; they are being asked", rigs.size(),
                                      name_, all);
  }
  if (began_ && now - *began_ < kListen) return "listening for another rig with the name " + name_;
  return "";
}

namespace {

using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr int kHeartbeats = 3;  // it goes on while nothing is answered

bool moves_by_itself(std::int8_t kind) {
  switch (kind) {
    case event_t::KEY:
    case event_t::ESTOP:
    case event_t::GATE:
    case event_t::SENSOR:
    case event_t::XSYNC:
    case event_t::FLASH:
    case event_t::SHUTTER:
    case event_t::TRIGGER:
    case event_t::FAULT:
    case event_t::REPAIRED:
    case event_t::STARTED:
    case event_t::STOPPED:
      return true;
    default:
      return false;
  }
}

/// A DISARM of what is disarmed, and events of another boot, which may be lost, have no answer that is
/// certain.
bool must_be_answered(const command_t& command, const status_t& status) {
  if (command.boot_id != status.boot_id) return false;
  if (command.kind == command_t::DISARM) return status.arm_token != 0 || status.state == status_t::FIRING;
  if (command.kind == command_t::RESEND)
    return command.resend_boot_id == command.boot_id && command.resend_last <= status.last_sequence &&
           status.journal_ok != 0;
  return true;
}

}  // namespace

void AnswerWatch::on_sent(const command_t& command, const std::optional<status_t>& status, HostTime now) {
  if (!status || !must_be_answered(command, *status)) return;
  if (boot_id_ != status->boot_id) asked_ = 0;
  if (asked_++ == 0) {
    boot_id_ = status->boot_id;
    since_ = now;
    heartbeats_ = 0;
    forged_ = forged_before_ = status->rejected_forged;
  }
  newest_ = Question{command.kind, command.host_id, status->last_sequence, command.resend_first,
                     command.resend_last};
}

bool AnswerWatch::answered_by(const status_t& status) const {
  if (newest_->kind == command_t::ARM) return status.arm_host_id == newest_->host_id;
  if (newest_->kind == command_t::DISARM) return status.arm_token == 0 && status.state != status_t::FIRING;
  return newest_->kind == command_t::FIRE && status.state == status_t::FIRING;
}

void AnswerWatch::on_status(const status_t& status) {
  if (asked_ == 0 || status.boot_id != boot_id_) return;
  ++heartbeats_;
  forged_ = status.rejected_forged;
  if (answered_by(status)) asked_ = 0;
}

/// What comes of a command, or an event that was asked for.
void AnswerWatch::on_event(const event_t& event) {
  if (asked_ == 0 || event.boot_id != boot_id_) return;
  const bool again = newest_->kind == command_t::RESEND && event.sequence >= newest_->first &&
                     event.sequence <= newest_->last;
  const bool obeyed = event.sequence > newest_->after && !moves_by_itself(event.kind);
  if (again || obeyed) asked_ = 0;
}

std::string AnswerWatch::problem(HostTime now) const {
  if (asked_ < kQuestions || heartbeats_ < kHeartbeats || now - since_ < kLongest) return "";
  std::string words =
      "the rig is heard but does not answer, so no DISARM reaches it either: use the e-stop; look at the "
      "rig's "
      "network interface and at firewalls for multicast to it";
  if (forged_ > forged_before_) words += "; it counts commands sealed with another key (see strobe key)";
  return words;
}

}  // namespace strobe::host
