#include "host/photographs/open_pipeline.hpp"

#include "host/photographs/measure_photograph.hpp"

namespace strobe::host {
namespace {

tl::expected<PhotographReading, UnreadPhotograph> reading_of(const RigFile& rig, digitize::Effort effort,
                                                             const std::filesystem::path& file,
                                                             const std::vector<double>& flash_times_s) {
  auto measured = measure_photograph(file, rig, {effort, flash_times_s, {}});
  if (!measured) return tl::unexpected(measured.error());
  PhotographReading reading;
  reading.frame = std::move(measured->found.frame);
  reading.remarks = std::move(measured->found.remarks);
  if (const auto& missing = measured->found.no_surface)
    reading.remarks.push_back("no surface line: " + missing->detail);
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
        return reading_of(rig, effort, file, flash_times_s);
      },
      PhotographSettings{rig.analysis.photograph_timeout_s, host_id, keep_folder});
  pipeline->notify("photographs from " + name);
  if (auto warning = calibration_warning(rig.camera, now.wall)) pipeline->notify(*warning);
  return pipeline;
}

}  // namespace strobe::host
