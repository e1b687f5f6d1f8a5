#include "host/tether/tethered_camera.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace strobe::tether {
namespace {

constexpr Duration kAskEvery = milliseconds{500};
/// An answer that is older says nothing of the camera as it is now.
constexpr Duration kAnswerHolds = milliseconds{2000};
/// A driver that takes over a large file from a slow camera answers that much later.
constexpr Duration kHangsAfter = std::chrono::seconds{30};
constexpr Duration kStartAgain = std::chrono::seconds{1};
constexpr Duration kOpenAgain = std::chrono::seconds{2};

std::string words(const Setting& setting) {
  const std::string remark = setting.remark.empty() ? "" : " (" + setting.remark + ")";
  switch (setting.state) {
    case SettingState::rounded:
      return fmt::format("{}: {} was asked for, the camera took {}{}", setting.name, setting.asked,
                         setting.is, remark);
    case SettingState::refused:
      return fmt::format("{}: {} was asked for, the camera keeps {}{}", setting.name, setting.asked,
                         setting.is, remark);
    case SettingState::absent:
      return fmt::format("{}: the camera has no such setting{}", setting.name, remark);
    case SettingState::as_asked:
    case SettingState::read:
      break;
  }
  return "";
}

/// As it was before; null if it was not read then.
const Setting* find_setting(const std::optional<OpenedEvent>& before, const std::string& name) {
  if (!before) return nullptr;
  const auto found = std::ranges::find(before->settings, name, &Setting::name);
  return found == before->settings.end() ? nullptr : &*found;
}

}  // namespace

Result<std::unique_ptr<TetheredCamera>> TetheredCamera::start(const std::filesystem::path& program,
                                                              OpenRequest open, HostTime now) {
  auto driver = CameraDriver::start(program);
  if (!driver) return tl::unexpected(driver.error());
  std::unique_ptr<TetheredCamera> camera(
      new TetheredCamera(program, std::move(open), std::move(*driver), now));
  camera->open(now);
  return camera;
}

TetheredCamera::TetheredCamera(std::filesystem::path program, OpenRequest open,
                               std::unique_ptr<CameraDriver> driver, HostTime now)
    : program_(std::move(program)), request_(std::move(open)), driver_(std::move(driver)), answered_(now) {}

void TetheredCamera::open(HostTime now) {
  started_ = now;
  open_failed_ = false;
  driver_->send(request_);
  ask(now);
}

void TetheredCamera::ask(HostTime now) {
  asked_ = now;
  open_question_ = true;
  driver_->send(CheckRequest{});
}

void TetheredCamera::step(HostTime now) {
  for (const Event& event : driver_->take_events())
    std::visit([&](const auto& what) { on(what, now); }, event);
  if (!driver_->ended().empty()) return restart(now);
  if (open_question_ && now - asked_ > kHangsAfter) return restart(now);
  if (open_failed_ && now - started_ >= kOpenAgain) return open(now);
  if (!open_question_ && now - asked_ >= kAskEvery) ask(now);
}

void TetheredCamera::restart(HostTime now) {
  on_gone(driver_->ended().empty() ? "its driver hangs" : driver_->ended());
  if (now - started_ < kStartAgain) return;
  auto driver = CameraDriver::start(program_);
  started_ = now;
  if (!driver) return notifications_.push_back(driver.error().message);
  driver_ = std::move(*driver);
  open(now);
}

void TetheredCamera::on_gone(const std::string& why) {
  const std::string words = "the camera is gone: " + why;
  open_question_ = false;
  if (away_ != words) notifications_.push_back(words);
  away_ = words;
}

void TetheredCamera::tell_settings(const OpenedEvent& event) {
  for (const Setting& setting : event.settings) {
    const Setting* before = find_setting(opened_, setting.name);
    const bool news = before == nullptr || before->is != setting.is || before->state != setting.state;
    const std::string said = words(setting);
    if (news && !said.empty()) notifications_.push_back("camera: " + said);
    if (before != nullptr && before->is != setting.is && said.empty())
      notifications_.push_back(
          fmt::format("camera: {} was {} and is {}", setting.name, before->is, setting.is));
  }
  for (const Problem& problem : event.problems) {
    const bool known = opened_ && std::ranges::find(opened_->problems, problem.text, &Problem::text) !=
                                      opened_->problems.end();
    if (!known) notifications_.push_back("camera: " + problem.text);
  }
}

void TetheredCamera::on(const OpenedEvent& event, HostTime now) {
  tell_settings(event);
  if (!away_.empty())
    notifications_.push_back(fmt::format("camera: {} {} {} is {}, exposes {}", event.camera.vendor,
                                         event.camera.model, event.camera.serial, opened_ ? "back" : "ready",
                                         event.exposure));
  away_.clear();
  if (!opened_ || to_line(*opened_) != to_line(event)) news_.push_back(event);
  opened_ = event;
  answered_ = now;
}

void TetheredCamera::on(const ReadyEvent&, HostTime) {
  open_question_ = false;
  answered_ = asked_;
}

void TetheredCamera::on(const PhotographEvent& event, HostTime) {
  // A name alone: whatever a driver says, nothing but what lies in its folder is taken.
  const std::filesystem::path name = std::filesystem::path(event.file).filename();
  photographs_.push_back({std::filesystem::path(request_.folder) / name, event.exposed});
  // Told as it grows: a poor link loses some of every photograph.
  if (event.packets_resent > 2 * most_resent_)
    notifications_.push_back(fmt::format("camera: {} packets of {} were lost and sent again",
                                         event.packets_resent, name.string()));
  most_resent_ = std::max(most_resent_, event.packets_resent);
}

void TetheredCamera::on(const FailedEvent& event, HostTime) {
  open_question_ = false;
  if (away_.empty()) return notifications_.push_back("camera: " + event.why);
  if (away_ != event.why) notifications_.push_back("camera: " + event.why);
  away_ = event.why;
  open_failed_ = true;
}

std::string TetheredCamera::problem(HostTime now) const {
  if (!away_.empty()) return away_;
  if (now - answered_ > kAnswerHolds)
    return fmt::format("the camera has not answered for {:.0f} s", to_seconds(now - answered_));
  for (const Problem& problem : opened_->problems) {
    if (problem.prevents) return problem.text;
  }
  return "";
}

}  // namespace strobe::tether
