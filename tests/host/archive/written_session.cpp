#include "tests/host/archive/written_session.hpp"

#include <fmt/format.h>

#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>

#include "common/shot/shot_plan.hpp"

namespace strobe::host_test {
namespace {

using messages::Channel;
using strobe_msgs::event_t;

// 2026-01-31 09:30:00 UTC (date -u -d @1769851800).
constexpr WallTime kDay{milliseconds{1'769'851'800'000}};
std::int64_t next_sender = 500;  // each logged packet has a number that none had before it

}  // namespace

WrittenRun::WrittenRun(const std::filesystem::path& folder, const authentication::Key& key,
                       std::int64_t host_id, int second, const std::string& rig_text)
    : key_(key), host_id_(host_id), sender_(key, ++next_sender), wall_(kDay + std::chrono::seconds{second}) {
  folder_ = host::SessionFolder::open(folder, host::utc_for_file(wall_), rig_text, "").value();
}

void WrittenRun::wait_s(double seconds) {
  const auto beats = static_cast<int>(seconds / 0.5);
  for (int i = 0; i < beats; ++i) {
    mono_ns += 499'000'000;
    wall_ += milliseconds{499};
    heartbeat();
  }
}

void WrittenRun::log_bytes(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
  mono_ns += 1'000'000;
  wall_ += milliseconds{1};
  folder_->log(channel, bytes, wall_);
}

void WrittenRun::heartbeat(std::int64_t boot_id) {
  strobe_msgs::status_t status{};
  status.schema_version = strobe_msgs::status_t::SCHEMA_VERSION;
  status.boot_id = boot_id;
  status.last_sequence = sequence;
  status.mono_ns = status.boot_time_ns = mono_ns;
  status.wall_ns = to_ns(wall_);
  log(Channel::status, status);
}

void WrittenRun::event(std::int8_t kind, int shot_id, std::int64_t boot_id, const std::string& detail) {
  event_t event{};
  event.schema_version = event_t::SCHEMA_VERSION;
  event.boot_id = boot_id;
  event.sequence = ++sequence;
  event.kind = kind;
  event.shot_id = shot_id;
  event.device_time_ns = mono_ns;
  event.commanded_ns = event.issue_start_ns = event.issue_end_ns = event_t::NO_TIME;
  event.flash_index = -1;
  event.detail = detail;
  log(Channel::event, event);
}

void WrittenRun::arm_and_fire(std::int64_t boot_id) {
  host::CommandFactory commands(host_id_);
  const host::CommandSealer sealer(key_, "bench");
  const std::string channel = messages::channel_name("bench", Channel::command);
  log_bytes(channel, sealer.seal(commands.arm(boot_id)).value());
  event(event_t::ARMED, 0, boot_id, fmt::format("{:x}", host_id_));
  log_bytes(channel, sealer.seal(commands.fire(boot_id, 1, ShotPlan{}, {})).value());
}

void WrittenRun::started(int shot_id, std::int64_t boot_id, std::int64_t by_host, bool dry) {
  if (by_host != 0) event(event_t::ARMED, 0, boot_id, fmt::format("{:x}", by_host));
  event(event_t::SHOT_STARTED, shot_id, boot_id, dry ? "dry" : "");
  first_sequence_ = sequence;
}

void WrittenRun::flash(int shot_id, std::int64_t boot_id) { event(event_t::FLASH, shot_id, boot_id); }
void WrittenRun::ended(int shot_id, std::int64_t boot_id) { event(event_t::SHOT_ENDED, shot_id, boot_id); }

void WrittenRun::summary(int shot_id, std::int64_t boot_id, std::int64_t by_host, std::uint32_t seed,
                         const std::string& abort_reason) {
  Scenario scenario;
  scenario.seed = seed;
  auto shot = make_shot(scenario).shot;
  shot.boot_id = boot_id;
  shot.shot_id = shot_id;
  shot.host_id = by_host == 0 ? host_id_ : by_host;
  shot.first_sequence = first_sequence_;
  shot.last_sequence = sequence;
  shot.aborted = !abort_reason.empty();
  shot.abort_reason = abort_reason;
  for (const auto& [key, value] : notes) {
    strobe_msgs::note_t note;
    note.key = key;
    note.value = value;
    shot.notes.push_back(note);
  }
  shot.note_count = static_cast<std::int32_t>(shot.notes.size());
  log(Channel::shot, shot);
}

void WrittenRun::frame(int shot_id, std::int64_t boot_id, const std::string& photograph, std::uint32_t seed) {
  Scenario scenario;
  scenario.seed = seed;
  auto frame = make_shot(scenario).frame;
  frame.boot_id = boot_id;
  frame.shot_id = shot_id;
  frame.host_id = host_id_;
  frame.source = "auto";
  frame.photograph = photograph;
  log(Channel::frame, frame);
}

void WrittenRun::shot(int shot_id, const std::string& photograph) {
  heartbeat();
  arm_and_fire();
  started(shot_id);
  flash(shot_id);
  ended(shot_id);
  summary(shot_id);
  frame(shot_id, kBoot, photograph);
}

void WrittenRun::result(int shot_id, const std::string& utc, std::int64_t boot_id) {
  host::Shot result;
  result.boot_id = boot_id;
  result.shot_id = shot_id;
  folder_->add(result, utc);
}

}  // namespace strobe::host_test
