#include "sim/ptp/ptp_camera.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <ctime>

#include "sim/photograph/render.hpp"
#include "sim/ptp/jpeg_file.hpp"

namespace strobe::sim::ptp {

namespace {

namespace fs = std::filesystem;

constexpr Duration kRenderTick = milliseconds(20);
constexpr Duration kServeTick = milliseconds(10);
constexpr int kLowestPriority = 19;
constexpr double kExposureUnit_s = 1e-4;  // of the property
constexpr std::uint64_t kBulbTime = 0xFFFFFFFF;
constexpr double kBulbForPicture_s = 0.1;  // nobody holds the shutter
constexpr std::uint64_t kBatteryLow = 8;

ObjectFormat object_format(PhotographFormat format) {
  if (format == PhotographFormat::png) return ObjectFormat::png;
  return format == PhotographFormat::dng ? ObjectFormat::dng : ObjectFormat::tiff;
}

std::string upper_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string time_text(WallTime wall) {
  const std::time_t seconds = static_cast<std::time_t>(to_ns(wall) / 1'000'000'000);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%dT%H%M%S", &parts);
  return text;
}

}  // namespace

std::string serial_of(const std::string& address) { return "PTP-" + address; }

PtpCamera::PtpCamera(const std::string& serial, const fs::path& folder, const Scene& scene,
                     std::uint64_t seed, const ExposureStore& exposure_store, RigClock clock)
    : folder_(folder),
      scene_(scene),
      seed_(seed),
      exposure_store_(exposure_store),
      clock_(clock),
      card_(folder),
      responder_(serial, properties_, card_) {}

PtpCamera::~PtpCamera() {
  static_cast<void>(stop());
  std::error_code error;
  fs::remove_all(folder_, error);
}

Result<std::unique_ptr<PtpCamera>> PtpCamera::create(const std::string& address, const Scene& scene,
                                                     std::uint64_t seed, const ExposureStore& exposure_store,
                                                     RigClock clock) {
  std::error_code error;
  std::string folder = (fs::temp_directory_path(error) / "strobe-sim-card-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr)
    return fail(folder + ": no folder for the camera's card can be made");
  std::unique_ptr<PtpCamera> camera(
      new PtpCamera(serial_of(address), folder, scene, seed, exposure_store, clock));
  PtpCamera* self = camera.get();
  auto server =
      Server::open(address, {[self](const OperationRequest& request) { return self->answer(request); },
                             [self] {
                               const std::lock_guard lock(self->mutex_);
                               self->responder_.end_session();
                             }});
  if (!server) return tl::unexpected(server.error());
  camera->server_ = std::move(*server);
  return camera;
}

void PtpCamera::start(bool gives_way) {
  renders_ = std::thread([this, gives_way] { render_exposures(gives_way); });
  serves_ = std::thread([this] { serve(); });
}

Result<void> PtpCamera::stop() {
  stopping_ = true;
  if (renders_.joinable()) renders_.join();
  if (serves_.joinable()) serves_.join();
  server_.reset();
  return outcome_;
}

void PtpCamera::render_exposures(bool gives_way) {
  if (gives_way) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLowestPriority);
  while (!stopping_) {
    take_exposures();
    take_picture();
    clock_.sleep_for(kRenderTick);
  }
}

MonoTime PtpCamera::due(const Exposure& exposure) {
  const std::lock_guard lock(mutex_);
  MonoTime due = exposure.closed + from_seconds(scene_.camera_link.readout_s);
  if (const Fault* late = shot_fault(scene_.faults, FaultKind::frame_late, exposure.shot); late != nullptr)
    due = due + late->delay;
  // A second exposure, as long and dark, is taken off the first.
  if (properties_.get(PropertyCode::nikon_long_exposure_noise_reduction) != 0)
    due = due + (exposure.closed - exposure.opened);
  return due;
}

void PtpCamera::take_exposures() {
  const auto exposures = exposure_store_.all();
  for (; seen_ < exposures.size(); ++seen_) {
    if (known(exposures[seen_]->opened)) waiting_.push_back(exposures[seen_]);
  }
  std::erase_if(waiting_, [this](const std::shared_ptr<const Exposure>& exposure) {
    if (clock_.now() < due(*exposure)) return false;
    meet_faults(*exposure);
    photograph(*exposure);
    return true;
  });
}

void PtpCamera::take_picture() {
  Duration length{};
  {
    const std::lock_guard lock(mutex_);
    if (!responder_.take_capture()) return;
    const std::uint64_t time = properties_.get(PropertyCode::exposure_time);
    length =
        from_seconds(time == kBulbTime ? kBulbForPicture_s : static_cast<double>(time) * kExposureUnit_s);
  }
  Exposure exposure;
  exposure.opened = clock_.now();
  clock_.sleep_for(length);
  exposure.closed = clock_.now();
  photograph(exposure);
}

void PtpCamera::meet_faults(const Exposure& exposure) {
  const std::lock_guard lock(mutex_);
  if (has(FaultKind::card_full, exposure)) card_.set_full(true);
  if (has(FaultKind::battery_low, exposure)) {
    properties_.put(PropertyCode::battery_level, kBatteryLow);
    events_.push_back({EventCode::property_changed, number(PropertyCode::battery_level)});
  }
  if (const Fault* away = shot_fault(scene_.faults, FaultKind::camera_vanishes, exposure.shot);
      away != nullptr)
    away_until_ = clock_.now() + away->delay;
}

Result<void> PtpCamera::write_files(const Exposure& exposure, FilesWritten wanted, const fs::path& stem) {
  const auto rendered = render(scene_, seed_, exposure);
  if (!rendered) return tl::unexpected(rendered.error());
  const std::string taken = time_text(clock_.wall());
  const auto store = [&](const fs::path& file, ObjectFormat format, const Result<void>& written) {
    if (!written) return written;
    const std::lock_guard lock(mutex_);
    events_.push_back({EventCode::object_added, card_.add(file, format, taken)});
    return written;
  };
  const PhotographFormat format = scene_.photograph.format;
  if (wanted.raw) {
    const fs::path file = stem.string() + upper_case(extension(format));
    const auto stored =
        store(file, object_format(format),
              write_photograph(file, rendered->pixels, format, clock_.wall(), rendered->mosaic));
    if (!stored) return stored;
  }
  if (wanted.jpeg) {
    const fs::path file = stem.string() + ".JPG";
    const int white = (1 << scene_.photograph.bits) - 1;
    return store(file, ObjectFormat::exif_jpeg, write_jpeg(file, rendered->pixels, white));
  }
  return {};
}

void PtpCamera::photograph(const Exposure& exposure) {
  FilesWritten wanted;
  fs::path stem;
  {
    const std::lock_guard lock(mutex_);
    if (card_.full()) {
      events_.push_back({EventCode::store_full, Card::kStorage});
      return;
    }
    wanted = has(FaultKind::frame_twice, exposure) ? FilesWritten{true, true} : properties_.files_written();
    stem = card_.next_stem();
  }
  const bool lost = has(FaultKind::no_photograph, exposure) || has(FaultKind::frame_dropped, exposure);
  const auto written = lost ? Result<void>{} : write_files(exposure, wanted, stem);
  const std::lock_guard lock(mutex_);
  events_.push_back({EventCode::capture_complete, 0});
  if (!written && outcome_) outcome_ = written;
}

Answer PtpCamera::answer(const OperationRequest& request) {
  const std::lock_guard lock(mutex_);
  properties_.set_clock(time_text(clock_.wall() + from_seconds(scene_.camera_link.clock_offset_s)));
  return responder_.answer(request);
}

void PtpCamera::send_events() {
  std::vector<Event> events;
  {
    const std::lock_guard lock(mutex_);
    events.swap(events_);
  }
  for (const Event& event : events) server_->send(event);
}

Result<void> PtpCamera::go_or_come_back() {
  MonoTime away_until;
  {
    const std::lock_guard lock(mutex_);
    away_until = away_until_;
  }
  return server_->set_reachable(!known(away_until) || clock_.now() >= away_until);
}

void PtpCamera::serve() {
  while (!stopping_) {
    if (const auto reachable = go_or_come_back(); !reachable) {
      const std::lock_guard lock(mutex_);
      if (outcome_) outcome_ = reachable;
    }
    send_events();
    server_->wait(clock_, kServeTick);
  }
}

}  // namespace strobe::sim::ptp
