#include "host/photographs/measure_photograph.hpp"

#include <utility>

#include "host/assembly/camera_map.hpp"
#include "host/assembly/flash_times.hpp"
#include "host/photographs/digitize_settings.hpp"

namespace strobe::host {

Result<digitize::Digitization> measure(const digitize::Photograph& photograph,
                                       const digitize::DigitizeSettings& settings,
                                       const std::vector<digitize::Correction>& corrections,
                                       const CameraTable& camera) {
  auto found = digitize::digitize(photograph, settings);
  if (!found) return fail(photograph.name + ": " + found.error().message);
  if (!corrections.empty()) {
    if (auto applied = digitize::apply_corrections(*found, corrections, settings); !applied)
      return tl::unexpected(applied.error());
  }
  found->frame.map_errors = map_errors(camera, found->frame);
  return found;
}

std::vector<double> flash_times_s(const strobe_msgs::shot_t& shot) {
  const FlashTimes times = flash_times(shot);
  std::vector<double> seconds;
  if (!times.in_order) return seconds;
  for (const ObservedFlash& flash : times.seen)
    seconds.push_back(to_seconds(flash.time - times.seen.front().time));
  return seconds;
}

tl::expected<MeasuredPhotograph, UnreadPhotograph> measure_photograph(const std::filesystem::path& file,
                                                                      const RigFile& rig,
                                                                      const MeasureSettings& wanted) {
  auto photograph = digitize::load_photograph(file);
  if (!photograph) return tl::unexpected(UnreadPhotograph{photograph.error().message, true});
  auto settings = digitize_settings(rig, photograph->width(), photograph->height());
  if (!settings)
    return tl::unexpected(
        UnreadPhotograph{file.filename().string() + ": " + settings.error().message, false});
  photograph->name = file.filename().string();
  settings->effort = wanted.effort;
  if (!wanted.flash_times_s.empty()) settings->flash_times_s = wanted.flash_times_s;
  auto found = measure(*photograph, *settings, wanted.corrections, rig.camera);
  if (!found) return tl::unexpected(UnreadPhotograph{found.error().message, false});
  return MeasuredPhotograph{std::move(*photograph), std::move(*settings), std::move(*found)};
}

}  // namespace strobe::host
