#include "host/photographs/measure_photograph.hpp"

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

MeasurePhotograph photograph_measurer(const RigFile& rig, digitize::Effort effort) {
  return [rig, effort](const std::filesystem::path& file, const std::vector<double>& flash_times_s) {
    return measure(rig, effort, file, flash_times_s);
  };
}

}  // namespace strobe::host
