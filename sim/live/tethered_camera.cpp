#include "sim/live/tethered_camera.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include "sim/photograph/render.hpp"

namespace strobe::sim {

namespace {

namespace fs = std::filesystem;

constexpr Duration kLook = milliseconds(20);
constexpr int kLowest = 19;

/// When the file appears at the earliest.
MonoTime due(const Scene& scene, const Exposure& exposure) {
  const Fault* late = shot_fault(scene.faults, FaultKind::frame_late, exposure.shot);
  return exposure.closed + (late != nullptr ? late->delay : Duration{});
}

bool makes_photograph(const Scene& scene, const Exposure& exposure) {
  return known(exposure.opened) &&
         shot_fault(scene.faults, FaultKind::no_photograph, exposure.shot) == nullptr;
}

}  // namespace

TetheredCamera::TetheredCamera(const fs::path& folder, const Scene& scene, std::uint64_t seed,
                               const ExposureStore& exposure_store, RigClock clock)
    : folder_(folder), scene_(scene), seed_(seed), exposure_store_(exposure_store), clock_(clock) {}

TetheredCamera::~TetheredCamera() { static_cast<void>(stop()); }

Result<std::unique_ptr<TetheredCamera>> TetheredCamera::create(const fs::path& folder, const Scene& scene,
                                                               std::uint64_t seed,
                                                               const ExposureStore& exposure_store,
                                                               RigClock clock) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error) || access(folder.c_str(), W_OK) != 0)
    return fail(folder.string() + ": no folder that photographs can be written to");
  const SensorSize size = sensor_size(scene);
  if (static_cast<double>(size.width) * size.height > kMaxPixels)
    return fail(fmt::format("scene {}: photographs of {} x {} px are too large", scene.name, size.width,
                            size.height));
  return std::unique_ptr<TetheredCamera>(new TetheredCamera(folder, scene, seed, exposure_store, clock));
}

void TetheredCamera::start(bool gives_way) {
  thread_ = std::thread([this, gives_way] { run(gives_way); });
}

Result<void> TetheredCamera::stop() {
  if (thread_.joinable()) {
    stopping_ = true;
    thread_.join();
  }
  return outcome_;
}

void TetheredCamera::run(bool gives_way) {
  if (gives_way) setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLowest);
  while (!stopping_) {
    take(false);
    clock_.sleep_for(kLook);
  }
  take(true);
}

void TetheredCamera::take(bool at_once) {
  const auto exposures = exposure_store_.all();
  for (; seen_ < exposures.size(); ++seen_) {
    if (makes_photograph(scene_, *exposures[seen_])) waiting_.push_back(exposures[seen_]);
  }
  std::erase_if(waiting_, [&](const std::shared_ptr<const Exposure>& exposure) {
    if (!at_once && clock_.now() < due(scene_, *exposure)) return false;
    photograph(*exposure);
    return true;
  });
}

fs::path TetheredCamera::next_path() {
  fs::path path;
  std::error_code error;
  do {
    path = folder_ / fmt::format("exposure-{:04}{}", ++last_number_, extension(scene_.photograph.format));
  } while (fs::exists(path, error));
  return path;
}

void TetheredCamera::photograph(const Exposure& exposure) {
  const auto photograph = render(scene_, seed_, exposure);
  const Result<void> written =
      photograph ? write_photograph(next_path(), photograph->pixels, scene_.photograph.format, clock_.wall(),
                                    photograph->mosaic)
                 : Result<void>(tl::unexpected(photograph.error()));
  if (!written && outcome_) outcome_ = written;
}

}  // namespace strobe::sim
