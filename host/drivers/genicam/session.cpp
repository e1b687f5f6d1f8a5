#include "host/drivers/genicam/session.hpp"

#include <arv.h>
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <utility>

#include "host/clock/machine_clock.hpp"

namespace strobe::genicam {
namespace {

constexpr Duration kLatchEvery = std::chrono::seconds{1};
// The first relation needs a few, as some take long.
constexpr int kFirstLatches = 8, kFirstLatchesApart_ms = 5;
constexpr int kMaxUnlatched = 2;
// All settings are read again within two seconds, some at a time.
constexpr std::size_t kHousesPerRound = 8;
constexpr Duration kSnapPatience = std::chrono::seconds{3};

Result<void> done_or_why(const char* what, GError* error) {
  if (error == nullptr) return {};
  auto failed = fail(fmt::format("{}: {}", what, error->message));
  g_error_free(error);
  return failed;
}

}  // namespace

Result<std::unique_ptr<Session>> Session::open(const tether::OpenRequest& request,
                                               const std::string& address) {
  auto camera = Camera::open(address);
  if (!camera) return tl::unexpected(camera.error());
  std::unique_ptr<Session> session(new Session);
  session->request_ = request;
  session->camera_ = std::move(*camera);
  session->count_ = FrameCount(session->camera_->is_gige() ? 1 : 0);
  if (auto armed = session->arm(); !armed) return tl::unexpected(armed.error());
  return session;
}

Result<void> Session::arm() {
  if (camera_->kind("Width") == Kind::absent || camera_->kind("PixelFormat") == Kind::absent)
    return fail(identity().address + ": the camera's description of itself cannot be understood");
  stop();  // what another program may have left going
  settings_.emplace(*camera_, request_);
  GError* error = nullptr;
  const std::int64_t payload_bytes = arv_camera_get_payload(camera_->aravis(), &error);
  if (auto good = done_or_why("the size of a frame", error); !good) return good;
  auto stream = Stream::create(*camera_, payload_bytes, request_.set.contains("GevSCPSPacketSize"));
  if (!stream) return tl::unexpected(stream.error());
  stream_ = std::move(*stream);
  latch_ = StampLatch::find(*camera_);
  if (latch_) clock_ = host::CameraClock(latch_->resolution());
  for (int i = 0; latch_ && i < kFirstLatches; ++i) {
    relate_clock();
    poll(nullptr, 0, kFirstLatchesApart_ms);
  }
  if (auto started = start(); !started) return started;
  if (camera_->is_gige()) presence_ = std::make_unique<PresenceWatch>(identity().address);
  next_latch_ = next_house_ = host::steady_now() + kLatchEvery;
  return {};
}

Session::~Session() {
  if (gone_.empty() && camera_) stop();
}

Result<void> Session::start() {
  GError* error = nullptr;
  arv_camera_start_acquisition(camera_->aravis(), &error);
  count_.on_start();
  return done_or_why("it cannot be armed", error);
}

void Session::stop() { arv_camera_stop_acquisition(camera_->aravis(), nullptr); }

tether::OpenedEvent Session::opened() const {
  return {identity(), settings_->exposure(), latch_.has_value(), settings_->all(), settings_->problems()};
}

std::vector<int> Session::descriptors() const {
  std::vector<int> all{stream_->descriptor(), camera_->lost_descriptor()};
  if (presence_ && presence_->descriptor() >= 0) all.push_back(presence_->descriptor());
  return all;
}

HostTime Session::next_due() const { return presence_ ? presence_->next_due() : next_house_; }

void Session::work(HostTime now, const Tell& tell) {
  while (const auto received = stream_->next()) take_frame(*received, tell);
  if (snap_until_ && now > *snap_until_) {
    tell(tether::FailedEvent{"no photograph has come of the snapshot"});
    end_snap(tell);
  }
  bool quiet = now >= next_house_;
  if (presence_) {
    const bool answered = presence_->look(now);
    // Only right after an answer, as a question to a camera that is gone blocks for seconds.
    quiet = quiet && answered;
    if (answered && presence_->presence() == Presence::here && std::exchange(checking_, false))
      tell(tether::ReadyEvent{});
    if (presence_->presence() == Presence::silent) gone_ = "the camera does not answer";
    if (presence_->presence() == Presence::uncontrolled)
      gone_ = "the camera was started anew, or another program has taken it";
  }
  if (camera_->lost() && gone_.empty()) gone_ = "the camera is no longer controlled from here";
  if (gone_.empty() && quiet) keep_house(now, tell);
}

void Session::relate_clock() {
  const auto exchange = latch_->exchange(*camera_);
  unlatched_ = exchange ? 0 : unlatched_ + 1;
  if (exchange) clock_.on_exchange(*exchange);
}

void Session::keep_house(HostTime now, const Tell& tell) {
  next_house_ = now + PresenceWatch::kAskEvery / 2;
  if (latch_ && now >= next_latch_) {
    next_latch_ = now + kLatchEvery;
    relate_clock();
    if (unlatched_ >= kMaxUnlatched) gone_ = "the camera does not do what it is told";
    if (clock_.restarts() != clock_restarts_)
      tell(tether::NoteEvent{"the camera's clock was set, or began anew; the two are compared anew"});
    clock_restarts_ = clock_.restarts();
    return;
  }
  if (snap_until_) return;
  // A frame goes before.
  for (std::size_t i = 0; i <= settings_->count() / kHousesPerRound && !stream_->waits(); ++i) {
    changed_ = settings_->look_again(*camera_) || changed_;
    if (++looked_at_ % std::max<std::size_t>(settings_->count(), 1) != 0 || !changed_) continue;
    changed_ = false;
    tell(opened());
  }
}

std::optional<tether::ExposureStart> Session::exposed(const Received& received) const {
  if (!received.stamp_ns || !latch_) return std::nullopt;
  const auto local = clock_.local(*received.stamp_ns);
  if (!local) return std::nullopt;
  return tether::ExposureStart{local->instant, local->sd};
}

void Session::tell_missing(const Counted& counted, const Tell& tell) {
  constexpr std::int64_t kMaxByOne = 100;
  if (counted.began_anew) tell(tether::NoteEvent{"the camera has begun to count its frames anew"});
  if (counted.missing_before > kMaxByOne) {
    tell(tether::LostEvent{-1, std::nullopt, fmt::format("{} frames have not come", counted.missing_before)});
    return;
  }
  for (std::int64_t number = counted.number - counted.missing_before; number < counted.number; ++number)
    tell(tether::LostEvent{number, std::nullopt, "nothing of the frame has come"});
}

void Session::take_frame(const Received& received, const Tell& tell) {
  const Counted counted = count_.count(received.block_id);
  tell_missing(counted, tell);
  const auto began = exposed(received);
  const auto lost = [&](const std::string& why) {
    tell(tether::LostEvent{counted.number, began, why});
    if (!snap_until_) return;
    tell(tether::FailedEvent{"the snapshot: " + why});
    end_snap(tell);
  };
  if (!received.why_lost.empty()) return lost(received.why_lost);
  const auto tiff = tiff_of(received.frame);
  if (!tiff) return lost(tiff.error().message);
  const std::int64_t stamp_ns = received.stamp_ns.value_or(received.begun.time_since_epoch().count());
  const auto name = put_file(request_.folder, fmt::format("frame-{:06}-{}", counted.number, stamp_ns), *tiff,
                             received.begun);
  if (!name) return lost(name.error().message);
  tell(tether::PhotographEvent{*name, counted.number, began, received.packets_resent});
  if (snap_until_) end_snap(tell);
}

/// Until the snapshot is taken.
void Session::change(const std::string& name, const std::string& value) {
  const auto before = camera_->get(name);
  if (before && *before != value && camera_->set(name, value)) before_snap_.emplace_back(name, *before);
}

void Session::check(HostTime now, const Tell& tell) {
  checking_ = presence_ != nullptr;
  if (presence_) return presence_->ask_now(now);
  if (camera_->lost()) {
    gone_ = "the camera is no longer there";
  } else {
    tell(tether::ReadyEvent{});
  }
}

void Session::snap(double exposure_s, HostTime now, const Tell& tell) {
  if (snap_until_) return tell(tether::FailedEvent{"a snapshot is being taken already"});
  stop();
  change("ExposureMode", "Timed");
  for (const char* time : {"ExposureTime", "ExposureTimeAbs"}) {
    if (camera_->kind(time) == Kind::absent) continue;
    change(time, fmt::to_string(exposure_s * 1e6));
    break;
  }
  const auto sources = camera_->entries("TriggerSource");
  const bool by_command = std::ranges::find(sources, "Software") != sources.end() &&
                          camera_->kind("TriggerSoftware") == Kind::command;
  if (by_command) {
    change("TriggerSource", "Software");
  } else {
    change("TriggerMode", "Off");
    change("AcquisitionMode", "SingleFrame");
  }
  snap_until_ = now + from_seconds(exposure_s) + kSnapPatience;
  auto taken = start();
  if (taken && by_command) taken = camera_->execute("TriggerSoftware");
  if (taken) return;
  tell(tether::FailedEvent{taken.error().message});
  end_snap(tell);
}

/// Frames that came since are of the snapshot, too.
void Session::end_snap(const Tell& tell) {
  snap_until_.reset();
  stop();
  while (stream_->next()) {
  }
  for (auto changed = before_snap_.rbegin(); changed != before_snap_.rend(); ++changed) {
    if (const auto back = camera_->set(changed->first, changed->second); !back)
      tell(tether::NoteEvent{"after the snapshot: " + back.error().message});
  }
  before_snap_.clear();
  if (const auto armed = start(); !armed) gone_ = armed.error().message;
}

}  // namespace strobe::genicam
