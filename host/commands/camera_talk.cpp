#include "host/commands/camera_talk.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "host/clock/machine_clock.hpp"
#include "host/commands/terminal.hpp"
#include "host/photographs/photograph_pipeline.hpp"

namespace strobe::host {
namespace {

namespace fs = std::filesystem;
using tether::CameraDriver;
using tether::Event;

constexpr Duration kAnswersWithin = std::chrono::seconds{30};
constexpr const char* kInterrupted = "interrupted";

/// For a person who waits.
class Waiting {
 public:
  explicit Waiting(std::string what) : what_(std::move(what)) {}
  void tell() {
    constexpr Duration kEvery = std::chrono::seconds{2};
    const HostTime now = steady_now();
    if (now - told_ < kEvery) return;
    told_ = now;
    fmt::print(stderr, "strobe: camera: {} ({:.0f} s)\n", what_, to_seconds(now - since_));
  }
  Duration lasted() const { return steady_now() - since_; }

 private:
  std::string what_;
  HostTime since_ = steady_now(), told_ = since_;
};

void wait_for(int descriptor) {
  constexpr int kLook_ms = 100;
  pollfd ready{descriptor, POLLIN, 0};
  ::poll(&ready, 1, kLook_ms);
}

/// The first event of that kind; fails with what a failure or the driver's end says.
template <typename Wanted>
Result<Wanted> wait_for_event(CameraDriver& driver, const char* what, Duration within) {
  Waiting waiting(what);
  while (waiting.lasted() < within) {
    for (Event& event : driver.take_events()) {
      if (auto* wanted = std::get_if<Wanted>(&event)) return std::move(*wanted);
      if (const auto* note = std::get_if<tether::NoteEvent>(&event))
        fmt::print(stderr, "strobe: camera: {}\n", note->text);
      if (const auto* failed = std::get_if<tether::FailedEvent>(&event)) return fail(failed->why);
      if (const auto* lost = std::get_if<tether::LostEvent>(&event))
        fmt::print(stderr, "strobe: camera: a photograph is lost: {}\n", lost->why);
      if (const auto* gone = std::get_if<tether::GoneEvent>(&event))
        return fail("the camera is gone: " + gone->why);
    }
    if (!driver.ended().empty()) return fail(driver.ended());
    if (interrupted()) return fail(kInterrupted);
    waiting.tell();
    wait_for(driver.descriptor());
  }
  return fail(fmt::format("no answer within {:.0f} s: {}", to_seconds(within), what));
}

Result<std::unique_ptr<CameraDriver>> start_driver(const std::string& kind) {
  const auto program = CameraDriver::find(kind);
  if (!program) return tl::unexpected(program.error());
  return CameraDriver::start(*program);
}

}  // namespace

FoundCameras find_cameras() {
  FoundCameras found;
  for (const CameraKind kind : {CameraKind::genicam, CameraKind::gphoto2}) {
    const std::string word(host::name(kind));
    auto driver = start_driver(word);
    if (!driver) {
      found.problems.push_back(driver.error().message);
      continue;
    }
    (*driver)->send(tether::ListRequest{});
    auto listed = wait_for_event<tether::CamerasEvent>(**driver, "looking for cameras", kAnswersWithin);
    if (!listed) {
      found.problems.push_back(word + ": " + listed.error().message);
      continue;
    }
    for (tether::CameraIdentity& camera : listed->cameras) found.cameras.push_back({word, std::move(camera)});
  }
  return found;
}

Result<PictureSource> PictureSource::open(const RigFile& rig) {
  PictureSource source;
  const CameraKind kind = rig.camera.connection.kind;
  if (kind == CameraKind::folder) {
    if (!rig.camera.folder) return fail("camera.folder: the rig file names neither a folder nor a camera");
    auto folder = CameraFolder::open(*rig.camera.folder, steady_now());
    if (!folder) return fail("camera.folder of the rig file: " + folder.error().message);
    source.folder_ = std::move(*folder);
    return source;
  }
  auto work = external::WorkFolder::make(fs::temp_directory_path());
  if (!work) return tl::unexpected(work.error());
  source.work_ = std::make_unique<external::WorkFolder>(std::move(*work));
  auto driver = start_driver(std::string(host::name(kind)));
  if (!driver) return fail("camera.kind of the rig file: " + driver.error().message);
  source.driver_ = std::move(*driver);
  source.driver_->send(
      open_request(rig.camera.connection, source.work_->path(), to_seconds(rig.plan.even.exposure)));
  auto opened = wait_for_event<tether::OpenedEvent>(*source.driver_, "opening the camera", kAnswersWithin);
  if (!opened) return tl::unexpected(opened.error());
  source.opened_ = std::move(*opened);
  return source;
}

std::string PictureSource::name() const {
  if (!opened_) return folder_->path().string();
  return fmt::format("{} {} {}", opened_->camera.vendor, opened_->camera.model, opened_->camera.serial);
}

Result<fs::path> PictureSource::next(double exposure_s) { return driver_ ? snapped(exposure_s) : arrived(); }

Result<fs::path> PictureSource::snapped(double exposure_s) {
  driver_->send(tether::SnapRequest{exposure_s});
  const auto picture = wait_for_event<tether::PhotographEvent>(
      *driver_, "waiting for the picture",
      kAnswersWithin + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(exposure_s)));
  if (!picture) return tl::unexpected(picture.error());
  // A name alone: whatever a driver says, nothing but what lies in its folder is taken.
  return work_->path() / fs::path(picture->file).filename();
}

Result<fs::path> PictureSource::arrived() {
  Waiting waiting("waiting for a photograph in " + folder_->path().string());
  for (;;) {
    auto arrivals = folder_->look(steady_now());
    for (const std::string& note : folder_->take_notifications()) fmt::print(stderr, "strobe: {}\n", note);
    if (!arrivals.empty()) return arrivals.back().path;
    if (interrupted()) return fail(kInterrupted);
    waiting.tell();
    wait_for(folder_->descriptor());
  }
}

}  // namespace strobe::host
