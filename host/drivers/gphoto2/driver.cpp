#include "host/drivers/gphoto2/driver.hpp"

#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <utility>

#include "host/drivers/gphoto2/settings.hpp"

namespace strobe::gphoto2 {

namespace {

constexpr Duration kTick = milliseconds{20};
constexpr Duration kIdle = milliseconds{200};
constexpr milliseconds kEventWait{5};
constexpr int kMaxEvents = 50;  // between two looks at the requests
constexpr Duration kLookAgain = std::chrono::seconds{1};
/// A file, after the exposure is told to be complete, or before: cameras differ.
constexpr Duration kFileFollows = std::chrono::seconds{5};
constexpr Duration kListEvery = milliseconds{500};
constexpr Duration kReadEvery = std::chrono::seconds{30};
constexpr Duration kReadAfterChange = std::chrono::seconds{1};
constexpr std::size_t kManyFiles = 500;

HostTime now() { return HostTime(std::chrono::steady_clock::now().time_since_epoch()); }

}  // namespace

void Driver::run() {
  while (!channel_.closed()) {
    while (const auto request = channel_.next())
      std::visit([this](const auto& wanted) { handle(wanted); }, *request);
    if (channel_.closed()) return;
    if (camera_) {
      step(now());
    } else if (was_away_) {
      look_again(now());
    }
    channel_.wait({}, camera_ ? kTick : kIdle);
  }
}

void Driver::handle(const tether::ListRequest&) {
  const auto cameras = GphotoCamera::list();
  if (!cameras) return channel_.send(tether::FailedEvent{cameras.error().message});
  channel_.send(tether::CamerasEvent{*cameras});
}

void Driver::handle(const tether::OpenRequest& request) {
  camera_.reset();
  photographs_.reset();
  serial_.clear();
  was_away_ = false;
  why_gone_ = "it is not open";
  wanted_ = request;
  if (const auto opened = open(); !opened) channel_.send(tether::FailedEvent{opened.error().message});
}

void Driver::handle(const tether::CheckRequest&) {
  if (!camera_) return channel_.send(tether::GoneEvent{why_gone_});
  if (!camera_->answers()) return on_gone("it does not answer");
  channel_.send(tether::ReadyEvent{});
}

void Driver::handle(const tether::SnapRequest& request) {
  if (!camera_) return channel_.send(tether::FailedEvent{"no camera is open"});
  const Config config = camera_->config().value_or(Config{});
  const TimeChoice time = nearest_time(config, request.exposure_s);
  if (!time.name.empty()) static_cast<void>(camera_->set(time.name, time.value));
  const auto file = camera_->capture();
  if (!time.name.empty()) static_cast<void>(camera_->set(time.name, config.at(time.name).value));
  if (!file) return channel_.send(tether::FailedEvent{"no picture can be taken: " + file.error().message});
  photographs_->on_added(*file, now());
  // Of several files libgphoto2 names the last.
  static_cast<void>(photographs_->look(*camera_, now(), false));
}

Result<void> Driver::open() {
  const std::string& serial = wanted_->serial.empty() ? serial_ : wanted_->serial;
  auto camera = GphotoCamera::open(wanted_->address, wanted_->address.empty() ? serial : wanted_->serial);
  // On USB it has another address each time.
  if (!camera && !wanted_->address.empty() && !serial.empty()) {
    auto elsewhere = GphotoCamera::open("", serial);
    if (elsewhere) camera = std::move(elsewhere);
  }
  if (!camera) return tl::unexpected(camera.error());
  const auto before = (*camera)->config();
  if (!before) return tl::unexpected(before.error());
  asked_ = wanted_settings(wanted_->set, *before);
  refused_ = apply(**camera, *before, asked_);
  if (!photographs_) {
    photographs_.emplace(wanted_->folder, wanted_->delete_from_camera);
    const auto files = photographs_->begin(**camera);
    if (!files) {
      photographs_.reset();
      return tl::unexpected(files.error());
    }
    if (*files > kManyFiles)
      channel_.send(tether::NoteEvent{
          fmt::format("{} files are on the camera's card: an empty one is faster to look through", *files)});
  } else if (const auto looked = photographs_->look(**camera, now(), false); !looked) {
    return looked;
  }
  camera_ = std::move(*camera);
  serial_ = camera_->identity().serial;
  was_away_ = false;
  tells_events_ = true;
  tell_state(now(), true);
  return {};
}

void Driver::look_again(HostTime now) {
  if (now - tried_ < kLookAgain) return;
  tried_ = now;
  static_cast<void>(open());  // on failure it is still away
}

void Driver::on_gone(const std::string& why) {
  camera_.reset();
  was_away_ = true;
  why_gone_ = why;
  exposed_.reset();
  tried_ = now();
  channel_.send(tether::GoneEvent{why});
}

void Driver::step(HostTime now) {
  take_events(now);
  if (camera_ && !tells_events_ && now - looked_ >= kListEvery) {
    looked_ = now;
    if (const auto looked = photographs_->look(*camera_, now, true); !looked) on_gone(looked.error().message);
  }
  if (exposed_ && now - *exposed_ > kFileFollows) {
    channel_.send(tether::NoteEvent{"the camera tells of an exposure, but of no file: look at its card"});
    exposed_.reset();
  }
  if (camera_ && photographs_->waits()) take_photographs(now);
  if (camera_ && now - read_ >= (changed_ ? kReadAfterChange : kReadEvery)) tell_state(now, false);
}

void Driver::take_events(HostTime now) {
  for (int i = 0; i < kMaxEvents && tells_events_; ++i) {
    const auto event = camera_->wait_for_event(kEventWait);
    if (!event) {
      if (!camera_->answers()) on_gone("its connection has ended: " + event.error().message);
      return;
    }
    switch (event->kind) {
      case CameraEvent::Kind::none:
        return;
      case CameraEvent::Kind::file_added:
        photographs_->on_added(event->file, now);
        newest_file_ = now;
        exposed_.reset();
        break;
      case CameraEvent::Kind::setting_changed:
        changed_ = true;
        break;
      case CameraEvent::Kind::card_full:
        channel_.send(tether::LostEvent{-1, std::nullopt, "the camera's card is full"});
        changed_ = true;
        break;
      case CameraEvent::Kind::unsupported:
        tells_events_ = false;
        break;
      case CameraEvent::Kind::capture_complete:
        if (now - newest_file_ > kFileFollows) exposed_ = now;
        break;
      case CameraEvent::Kind::other:
        break;
    }
  }
}

void Driver::take_photographs(HostTime now) {
  const auto events = photographs_->take(*camera_, now);
  if (!events) return on_gone(events.error().message);
  for (const tether::Event& event : *events) channel_.send(event);
}

void Driver::tell_state(HostTime now, bool in_any_case) {
  read_ = now;
  changed_ = false;
  const auto config = camera_->config();
  if (!config) {
    if (!camera_->answers()) on_gone(config.error().message);
    return;
  }
  photographs_->set_written(written_files(*config));
  tether::OpenedEvent event;
  event.camera = camera_->identity();
  event.exposure = wanted_->exposure_by_line ? "while its remote release is held by the rig's line"
                                             : "for the time that is set on it";
  event.settings = settings_of(*config, asked_, refused_);
  event.problems =
      find_problems({*config, camera_->free_bytes(), wanted_->exposure_by_line, std::time(nullptr)});
  const std::string line = to_line(tether::Event(event));
  if (in_any_case || line != told_) channel_.send(event);
  told_ = line;
}

}  // namespace strobe::gphoto2
