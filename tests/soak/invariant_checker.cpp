#include "tests/soak/invariant_checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <strobe_msgs/command_t.hpp>

namespace strobe::soak {

using firmware::Output;
using strobe_msgs::command_t;

namespace {

constexpr Duration kMakesSafe = milliseconds(1);
constexpr Duration kGuardianMakesSafe = milliseconds(6);
constexpr Duration kRace = microseconds(2);  // from the last look at the key to the line's edge
constexpr Duration kTokenLife = milliseconds(30'100);
constexpr Duration kFireToTrigger = milliseconds(5'000);

constexpr Duration kRestartDelay = milliseconds(1000);
constexpr Duration kBeginWithin = milliseconds(10'000);
constexpr Duration kShownWithin = milliseconds(1000);

constexpr std::array kOutputNames{"trigger", "lamps", "shutter"};

// An encoded event begins with its fingerprint and its version; boot and sequence follow.
constexpr std::size_t kBoot = 12, kSequence = 20;

template <typename Byte>
std::int64_t big_endian(const Byte* bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < 8; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  return static_cast<std::int64_t>(value);
}

}  // namespace

Duration InvariantChecker::excused(MonoTime from, MonoTime to) const {
  Duration sum{};
  for (const Still& still : still_) {
    const MonoTime begin = std::max(from, still.from), end = std::min(to, still.until);
    if (end > begin) sum = sum + (end - begin);
  }
  if (known(died_) && died_ <= to && died_ + kGuardianMakesSafe >= from) sum = sum + kGuardianMakesSafe;
  return sum;
}

Duration InvariantChecker::longest(Output output) const {
  switch (output) {
    case Output::trigger:
      return limits_.machine.max_on;
    case Output::strobes:
      return limits_.lamps.max_on;
    case Output::shutter:
      return limits_.shutter.max_open;
  }
  return {};
}

bool InvariantChecker::unsafe_before(MonoTime at) const {
  return known(unsafe_since_) && at - unsafe_since_ > kMakesSafe + excused(unsafe_since_, at);
}

void InvariantChecker::output(Output output, bool active, MonoTime at, strobe::Lamps lamps) {
  Watched& watched = outputs_[index_of(output)];
  if (watched.active == active) return;
  if (!active) {
    check_end(output, watched, at);
    watched = {};
    return;
  }
  const bool too_late = unsafe_before(at);
  watched = {true, at, too_late ? kNoTime : unsafe_since_};
  if (too_late) {
    violate(fmt::format("{} made active at {} with the key off or the e-stop pressed since {}",
                        kOutputNames[index_of(output)], to_ns(at), to_ns(unsafe_since_)));
  }
  if (output == Output::trigger) check_trigger(at);
  if (output == Output::shutter) flashes_of_shot_ = 0;  // each shot opens it once
  if (output == Output::strobes) check_lamps(lamps, at);
}

void InvariantChecker::check_end(Output output, const Watched& watched, MonoTime at) {
  const Duration on = at - watched.since;
  if (on > longest(output) + limits_.tolerance.late + excused(watched.since, at)) {
    violate(fmt::format("{} active for {} us until {}", kOutputNames[index_of(output)], on / microseconds(1),
                        to_ns(at)));
  }
  if (known(watched.must_end) && at - watched.must_end > kMakesSafe + excused(watched.must_end, at)) {
    violate(fmt::format("{} inactive only {} us after the key or the e-stop demanded it, at {}",
                        kOutputNames[index_of(output)], (at - watched.must_end) / microseconds(1),
                        to_ns(at)));
  }
}

void InvariantChecker::check_trigger(MonoTime at) {
  ++triggers_;
  if (known(unsafe_since_) && at - unsafe_since_ > kRace + excused(unsafe_since_, at)) {
    violate(fmt::format("trigger at {} with the key off or the e-stop pressed since {}", to_ns(at),
                        to_ns(unsafe_since_)));
  }
  // Of several that were fired it is the one that may: the firmware has refused the others.
  Token* fired = nullptr;
  std::string objection;
  for (auto& [id, token] : tokens_) {
    if (token.boot_id != boot_id_ || !known(token.fired) || token.dry || token.spent) continue;
    if (at < token.fired || at - token.fired > kFireToTrigger + excused(token.fired, at)) continue;
    if (fired != nullptr && objection.empty()) break;
    fired = &token;
    objection = objection_to(token, at);
  }
  if (fired == nullptr) return violate(fmt::format("trigger at {} without a fresh token", to_ns(at)));
  fired->spent = true;
  if (objection.empty()) return;
  ++stops_.triggers;
  violate(fmt::format("trigger at {} by host {:x} {}", to_ns(at), fired->host_id, objection));
}

/// Why no person wanted it after the last stop; empty: one did.
std::string InvariantChecker::objection_to(const Token& token, MonoTime at) const {
  const auto act = acted_.find(token.host_id);
  const MonoTime acted = act == acted_.end() ? kNoTime : act->second;
  const auto acted_since = [acted](MonoTime stop) { return known(acted) && acted > stop; };
  const auto slept = host_slept_.find(token.host_id);
  if (slept != host_slept_.end() && token.fired >= slept->second && !acted_since(slept->second))
    return "after its sleep, without a person's act";
  if (!known(last_stop_) || at - last_stop_ <= kMakesSafe + excused(last_stop_, at)) return "";
  // A firmware that starts anew has forgotten its stops: a series that it has not yet armed may begin, soon after its
  // command.
  const bool begins = known(acted) && last_stop_ < booted_at_ && booted_at_ - acted <= kBeginWithin &&
                      !armed_in_another_boot(token.host_id);
  if (!acted_since(last_stop_) && !begins)
    return fmt::format("without a person's act since the stop at {}", to_ns(last_stop_));
  if (stopped_in_boot_ && (!known(reset_) || at - reset_ < kRestartDelay))
    return "sooner than the restart delay after a reset";
  return "";
}

bool InvariantChecker::armed_in_another_boot(std::int64_t host_id) const {
  return std::ranges::any_of(tokens_, [&](const auto& entry) {
    return entry.second.host_id == host_id && entry.second.boot_id != boot_id_;
  });
}

/// Has reached the rig.
void InvariantChecker::stop(MonoTime at) {
  last_stop_ = at;
  reset_ = kNoTime;
  stopped_in_boot_ = true;
}

void InvariantChecker::booted(std::int64_t boot_id, MonoTime at) {
  boot_id_ = boot_id;
  booted_at_ = at;
  alive_ = true;
  stopped_in_boot_ = false;
  newest_command_.clear();
}

void InvariantChecker::note_command(std::int64_t host_id, std::int8_t kind, MonoTime at) {
  if (kind == command_t::DISARM) {
    stop(at);
    const auto asked = asked_.find(host_id);
    if (asked != asked_.end() && !std::exchange(asked->second.reached, true)) ++stops_.reached;
  }
  const auto act = acted_.find(host_id);
  if (kind == command_t::RESET && !known(reset_) && act != acted_.end() && act->second > last_stop_)
    reset_ = at;
}

void InvariantChecker::stop_asked(std::int64_t host_id, HostTime then, MonoTime at) {
  ++stops_.asked;
  asked_.insert({host_id, {then, at, false, false}});
}

void InvariantChecker::confirmation_shown(std::int64_t host_id) {
  const auto asked = asked_.find(host_id);
  if (asked == asked_.end()) return;
  ++stops_.confirmed;
  // Whatever it was that stopped the rig: who was told so relies on it.
  if (!known(last_stop_) || asked->second.at > last_stop_) last_stop_ = asked->second.at;
  asked_.erase(asked);
}

void InvariantChecker::shows(std::int64_t host_id, bool danger, HostTime now) {
  const auto found = asked_.find(host_id);
  if (found == asked_.end()) return;
  Asked& asked = found->second;
  if (asked.danger) return;
  if (danger) {
    asked.danger = true;
    ++stops_.danger_shown;
  } else if (now - asked.then > kShownWithin) {
    asked.danger = true;
    violate(fmt::format("a stop asked for at host {:x} at {} is neither confirmed nor shown as a danger",
                        host_id, to_ns(asked.at)));
  }
}

void InvariantChecker::check_lamps(strobe::Lamps lamps, MonoTime at) {
  std::optional<Duration> shortest;
  for (std::size_t lamp = 0; lamp < last_flash_.size(); ++lamp) {
    if (lamp == 0 ? !has_a(lamps) : !has_b(lamps)) continue;
    const MonoTime before = std::exchange(last_flash_[lamp], at);
    if (known(before)) shortest = std::min(shortest.value_or(at - before), at - before);
  }
  // A daemon that is started anew does not know when the last one flashed; it takes much longer than that.
  if (shortest && *shortest + limits_.tolerance.late + microseconds(1) < limits_.lamps.min_period) {
    violate(fmt::format("a lamp flashed {} us after its flash before, at {}", *shortest / microseconds(1),
                        to_ns(at)));
  }
  if (++flashes_of_shot_ > limits_.lamps.max_flashes)
    violate(fmt::format("{} flashes in one shot, at {}", flashes_of_shot_, to_ns(at)));
}

void InvariantChecker::became_unsafe(MonoTime at) {
  if (!known(unsafe_since_)) unsafe_since_ = at;
  for (Watched& watched : outputs_)
    if (watched.active && !known(watched.must_end)) watched.must_end = at;
}

void InvariantChecker::key(bool on, MonoTime at) {
  if (alive_) stop(at);
  if (alive_ && !on) ++stops_.reached;
  key_ = on;
  if (!on) became_unsafe(at);
  if (key_ && !estop_) unsafe_since_ = kNoTime;
}

void InvariantChecker::estop(bool pressed, MonoTime at) {
  if (alive_) stop(at);
  if (alive_ && pressed) ++stops_.reached;
  estop_ = pressed;
  if (pressed) became_unsafe(at);
  if (key_ && !estop_) unsafe_since_ = kNoTime;
}

void InvariantChecker::token_drawn(std::int64_t token, MonoTime at) {
  tokens_[token] = {arming_host_, boot_id_, at, kNoTime, false, false};
}

void InvariantChecker::at_firmware(const std::vector<std::uint8_t>& bytes, MonoTime at) {
  command_t command{};
  if (command.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return;
  if (command.boot_id != boot_id_) return;
  // One whose number is not above the last one's is ignored.
  std::int64_t& newest = newest_command_[command.host_id];
  if (command.command_id > newest) note_command(command.host_id, command.kind, at);
  newest = std::max(newest, command.command_id);
  if (command.kind == command_t::ARM) arming_host_ = command.host_id;
  if (command.kind != command_t::FIRE) return;
  const auto token = tokens_.find(command.arm_token);
  if (token == tokens_.end() || token->second.boot_id != boot_id_) return;
  Token& t = token->second;
  if (t.host_id != command.host_id || known(t.fired) || at - t.armed > kTokenLife + excused(t.armed, at))
    return;
  t.fired = at;
  t.dry = command.plan.dry != 0;
}

void InvariantChecker::at_host(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  if (!channel.ends_with("/EVENT")) return;
  if (bytes.size() < kSequence + 8) return;
  const std::int64_t sequence = big_endian(&bytes[kSequence]);
  if (sequence < 1 || sequence > 10'000'000) return violate("an event's sequence is absurd");
  std::vector<bool>& have = on_host_[big_endian(&bytes[kBoot])];
  if (have.size() <= static_cast<std::size_t>(sequence))
    have.resize(std::max(2 * have.size(), static_cast<std::size_t>(sequence) + 1));
  have[static_cast<std::size_t>(sequence)] = true;
}

void InvariantChecker::readout(std::int64_t host_id, ShotKey shot, const reduction::Readout& readout,
                               const Truth& truth, bool dry) {
  comparison_.reset();
  if (!read_out_.insert({host_id, shot}).second) {
    violate(fmt::format("shot {} of boot {:x} was read out twice on host {:x}", shot.shot_id, shot.boot_id,
                        host_id));
  }
  if (dry) return;
  comparison_ = compare_with_truth(readout, truth, soak_sigma_limit());
  if (!comparison_->wrong.empty()) {
    violate(fmt::format("shot {} of boot {:x}: wrong without a flag:{}", shot.shot_id, shot.boot_id,
                        comparison_->wrong));
  }
}

void InvariantChecker::read_journal(const std::filesystem::path& path) {
  // An LCM log's record: sync word, number, time, the lengths of channel and data, big-endian; then both.
  constexpr std::size_t kHeader = 28;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream whole;
  whole << file.rdbuf();
  const std::string text = std::move(whole).str();
  const auto number = [&text](std::size_t from) {
    std::uint32_t value = 0;
    for (std::size_t i = from; i < from + 4; ++i) value = value << 8 | static_cast<std::uint8_t>(text[i]);
    return std::size_t{value};
  };
  std::int64_t expected = 1;
  for (std::size_t at = 0; at + kHeader <= text.size();) {
    if (number(at) != 0xEDA1DA01) return violate(path.filename().string() + " is damaged");
    const std::size_t channel = number(at + 20), data = number(at + 24), begin = at + kHeader + channel;
    if (begin + data > text.size()) return violate(path.filename().string() + " ends in a torn record");
    at = begin + data;
    if (!std::string_view(text).substr(begin - channel, channel).ends_with("/EVENT")) continue;
    if (data < kSequence + 8) {
      violate(path.filename().string() + " holds what is no event");
      continue;
    }
    ++journalled_;
    const std::int64_t boot_id = big_endian(&text[begin + kBoot]);
    const std::int64_t sequence = big_endian(&text[begin + kSequence]);
    if (sequence != expected)
      violate(fmt::format("{}: event {} follows {}", path.filename().string(), sequence, expected - 1));
    expected = sequence + 1;
    const auto have = on_host_.find(boot_id);
    const auto index = static_cast<std::size_t>(sequence);
    if (have != on_host_.end() && index < have->second.size() && have->second[index]) continue;
    if (have == on_host_.end()) {
      ++never_received_;  // no host ever heard of this boot: none can know that there is something to ask for
      continue;
    }
    ++missing_;
    violate(fmt::format("event {} of boot {:x} is in the journal and on no host", sequence, boot_id));
  }
}

void InvariantChecker::end(const std::filesystem::path& session) {
  for (std::size_t i = 0; i < outputs_.size(); ++i)
    if (outputs_[i].active) violate(fmt::format("{} still active in the end", kOutputNames[i]));
  std::error_code error;
  std::vector<std::filesystem::path> journals;
  for (const auto& entry : std::filesystem::directory_iterator(session, error))
    if (entry.path().extension() == ".lcmlog") journals.push_back(entry.path());
  std::sort(journals.begin(), journals.end());
  for (const auto& journal : journals) read_journal(journal);
}

}  // namespace strobe::soak
