#include "host/photographs/open_pipeline.hpp"

#include "host/photographs/digitize_settings.hpp"
#include "host/digitize/digitize.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::host {
namespace {

tl::expected<PhotographReading, UnreadPhotograph> measure(const RigFile& rig, digitize::Effort effort,
                                                          const std::filesystem::path& file,
                                                          const std::vector<double>& flash_times_s) {
  const auto photograph = digitize::load_photograph(file);
  if (!photograph) return tl::unexpected(UnreadPhotograph{photograph.error().message, true});
  auto settings = digitize_settings(rig, photograph->width(), photograph->height());
  if (!settings) {
    return tl::unexpected(
        UnreadPhotograph{file.filename().string() + ": " + settings.error().message, false});
  }
  settings->effort = effort;
  if (!flash_times_s.empty()) settings->flash_times_s = flash_times_s;
  auto result = digitize::digitize(*photograph, *settings);
  if (!result) {
    return tl::unexpected(UnreadPhotograph{file.filename().string() + ": " + result.error().message, false});
  }
  PhotographReading reading;
  reading.frame = std::move(result->frame);
  reading.remarks = std::move(result->remarks);
  if (result->no_surface) reading.remarks.push_back("no surface line: " + result->no_surface->detail);
  return reading;
}

}  // namespace

Result<std::unique_ptr<PhotographPipeline>> open_pipeline(const RigFile& rig,
                                                          const PhotographOptions& options,
                                                          const std::filesystem::path& keep_folder,
                                                          std::int64_t host_id, const DeviceClock& clock,
                                                          const HostReading& now) {
  const std::string name = options.folder.empty() ? rig.camera.folder.value_or("") : options.folder;
  if (name.empty()) return nullptr;
  if (!rig.camera.px_per_m && !rig.analysis.px_per_m) {
    return fail(
        "photographs need a scale: camera.px_per_m (strobe calibrate) or analysis.px_per_m in the rig file");
  }
  auto folder = CameraFolder::open(name, now.mono);
  if (!folder) return tl::unexpected(folder.error());
  const digitize::Effort effort = digitize::effort_from_name(options.effort).value();
  auto pipeline = std::make_unique<PhotographPipeline>(
      clock, std::move(*folder),
      [rig, effort](const std::filesystem::path& file, const std::vector<double>& flash_times_s) {
        return measure(rig, effort, file, flash_times_s);
      },
      PhotographSettings{rig.analysis.photograph_timeout_s, host_id, keep_folder});
  pipeline->notify("photographs from " + name);
  if (auto warning = calibration_warning(rig.camera, now.wall)) pipeline->notify(*warning);
  return pipeline;
}

}  // namespace strobe::host
