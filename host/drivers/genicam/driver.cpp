#include "host/drivers/genicam/driver.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "host/clock/machine_clock.hpp"

namespace strobe::genicam {
namespace {

using tether::CameraIdentity;

constexpr Duration kTryEvery = std::chrono::seconds{1};
constexpr Duration kListEvery = std::chrono::seconds{5};
// A camera believes for three seconds that a program controls it which has died.
constexpr int kOpenings = 5, kOpeningsApart_ms = 1000;

std::string described(const std::vector<CameraIdentity>& cameras) {
  std::string text;
  for (const CameraIdentity& camera : cameras)
    text += fmt::format("{}{} {} {} at {}", text.empty() ? "" : ", ", camera.vendor, camera.model,
                        camera.serial, camera.address);
  return text;
}

/// Its address.
Result<std::string> find(const tether::OpenRequest& request) {
  if (!request.address.empty()) return request.address;
  std::vector<CameraIdentity> cameras = list_cameras();
  if (!request.serial.empty())
    std::erase_if(cameras, [&](const CameraIdentity& camera) { return camera.serial != request.serial; });
  if (cameras.empty())
    return fail(request.serial.empty()
                    ? "no camera is found"
                    : fmt::format("no camera with the serial number {} is found", request.serial));
  if (cameras.size() > 1)
    return fail(fmt::format("there are {} cameras, say which by its serial number: {}", cameras.size(),
                            described(cameras)));
  return cameras.front().address;
}

Result<std::unique_ptr<Session>> open_checked(const tether::OpenRequest& request,
                                              const std::string& address) {
  auto session = Session::open(request, address);
  if (session && !request.serial.empty() && (*session)->identity().serial != request.serial)
    return fail(fmt::format("{}: the camera there has the serial number {} instead of {}", address,
                            (*session)->identity().serial, request.serial));
  return session;
}

}  // namespace

void Driver::run() {
  while (!channel_.closed()) {
    while (const auto request = channel_.next())
      std::visit([this](const auto& known) { handle(known); }, *request);
    if (channel_.closed()) break;
    work();
    wait();
  }
  session_.reset();
}

void Driver::handle(const tether::ListRequest&) { send(tether::CamerasEvent{list_cameras()}); }

void Driver::handle(const tether::OpenRequest& request) {
  session_.reset();
  away_.reset();
  request_ = request;
  const auto address = find(request);
  if (!address) return send(tether::FailedEvent{address.error().message});
  auto session = open_checked(request, *address);
  for (int i = 1; !session && i < kOpenings; ++i) {
    if (session.error().message.find("another program") == std::string::npos) break;
    poll(nullptr, 0, kOpeningsApart_ms);
    session = open_checked(request, *address);
  }
  if (!session) return send(tether::FailedEvent{session.error().message});
  session_ = std::move(*session);
  send(session_->opened());
}

void Driver::handle(const tether::SnapRequest& request) {
  if (!session_) return send(tether::FailedEvent{"no camera is open"});
  session_->snap(request.exposure_s, host::steady_now(), [this](const tether::Event& event) { send(event); });
}

void Driver::handle(const tether::CheckRequest&) {
  if (!session_) return send(tether::GoneEvent{away_ ? "the camera does not answer" : "no camera is open"});
  session_->check(host::steady_now(), [this](const tether::Event& event) { send(event); });
}

void Driver::work() {
  const HostTime now = host::steady_now();
  if (session_) session_->work(now, [this](const tether::Event& event) { send(event); });
  if (session_ && !session_->gone().empty()) lose();
  if (away_) look_for_it(now);
}

/// The farewell is said by a thread of its own: it asks a camera that is gone, which takes seconds.
void Driver::lose() {
  send(tether::GoneEvent{session_->gone()});
  const HostTime now = host::steady_now();
  away_.emplace(Away{session_->identity(), now, now, now, nullptr, ""});
  away_->presence = std::make_unique<PresenceWatch>(away_->camera.address);
  away_->next_list += list_every();
  std::thread([session = std::move(session_)]() mutable { session.reset(); }).detach();
}

/// What has an address can be asked there.
Duration Driver::list_every() const { return away_->presence->descriptor() >= 0 ? kListEvery : kTryEvery; }

/// Its address now. Where it was an answer says so at once; that it may be elsewhere is asked less often, as
/// that takes a second.
std::optional<std::string> Driver::found_again(HostTime now) {
  away_->presence->look(now);
  const Presence presence = away_->presence->presence();
  const bool answers = presence == Presence::here || presence == Presence::uncontrolled;
  if (answers && now >= away_->next_try) return away_->camera.address;
  if (answers || now < away_->next_list) return std::nullopt;
  const std::vector<CameraIdentity> cameras = list_cameras();
  away_->next_list = host::steady_now() + list_every();
  const auto found = std::ranges::find(cameras, away_->camera.serial, &CameraIdentity::serial);
  return found == cameras.end() ? std::nullopt : std::optional(found->address);
}

void Driver::look_for_it(HostTime now) {
  const auto address = found_again(now);
  if (!address) return;
  tether::OpenRequest request = request_;
  request.serial = away_->camera.serial;
  auto session = open_checked(request, *address);
  away_->next_try = host::steady_now() + kTryEvery;
  if (!session) {
    if (std::exchange(away_->told, session.error().message) != session.error().message)
      send(tether::NoteEvent{"the camera is there, but cannot be opened: " + session.error().message});
    return;
  }
  session_ = std::move(*session);
  const double away_s = to_seconds(host::steady_now() - away_->since);
  away_.reset();
  send(session_->opened());
  send(tether::NoteEvent{
      fmt::format("the camera was away for {:.1f} s; what it exposed then is lost", away_s)});
}

void Driver::wait() const {
  const HostTime now = host::steady_now();
  if (session_) {
    const auto descriptors = session_->descriptors();
    return channel_.wait(descriptors, std::clamp(session_->next_due() - now, Duration{}, kTryEvery));
  }
  if (away_) return channel_.wait({}, std::min(PresenceWatch::kAskEvery, kTryEvery));
  channel_.wait({}, std::chrono::minutes{1});
}

}  // namespace strobe::genicam
