// Any pixels at all, under settings of any kind: the digitizer ends, and what it measured are numbers with
// standard deviations, in order of time. Six bytes of settings, then a small photograph's rows.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

#include "host/digitize/digitize.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

using namespace strobe;
using namespace strobe::digitize;

constexpr std::size_t kSettings = 6;
constexpr double kBall_m = 0.065;

bool has(std::uint8_t byte, int bit) { return ((byte >> bit) & 1) != 0; }

Photograph photograph_of(const std::uint8_t* bytes, std::size_t size) {
  const int width = 24 + bytes[1] % 136;
  const int height = static_cast<int>((size - kSettings) / static_cast<std::size_t>(width));
  Photograph photograph;
  photograph.name = "fuzz.tif";
  if (height < 16 || height > 160) return photograph;
  cv::Mat numbers(height, width, CV_8UC1);
  std::copy_n(bytes + kSettings, numbers.total(), numbers.ptr<std::uint8_t>());
  numbers.convertTo(photograph.intensity, CV_32F, 1.0 / 255.0);
  photograph.saturation = static_cast<float>(0.2 + 0.8 * bytes[3] / 255.0);
  return photograph;
}

DigitizeSettings settings_of(const std::uint8_t* bytes, const Photograph& photograph) {
  DigitizeSettings settings;
  settings.ball_diameter_m = kBall_m;
  settings.px_per_m = (12.0 + bytes[2] % 32) / kBall_m;
  settings.effort = has(bytes[0], 0) ? Effort::standard : Effort::fast;
  if (has(bytes[0], 1)) settings.leftwards = has(bytes[0], 2);
  if (has(bytes[0], 3)) settings.px_per_m_sd = 0.001 * *settings.px_per_m;
  settings.size_tolerance = 0.01 + 0.2 * bytes[5] / 255.0;
  settings.map = PlaneMap::uncalibrated(photograph.height());
  if (has(bytes[0], 4)) {
    settings.flash_times_s.emplace();
    for (int i = 0; i < bytes[4]; ++i)
      settings.flash_times_s->push_back(0.003 * i + (i % 7 == 3 ? 0.001 : 0.0));
  }
  if (has(bytes[0], 5)) settings.surface = SurfaceLine{{{{0.0, 8.0}, {20.0, 8.5}}}, 0.5};
  if (has(bytes[0], 6)) {
    const double middle = 0.5 * photograph.width();
    settings.map =
        PlaneMap::calibrated({{middle, middle}, 200.0, -0.05, 0.0, 0.001, 0.0},
                             cv::Matx33d(1.0, 0.0, 0.0, 0.0, -1.0, photograph.height() - 1.0, 0.0, 1e-5, 1.0),
                             Viewpoint{{middle, middle}, 20.0 * *settings.px_per_m * kBall_m});
  }
  if (has(bytes[0], 7)) settings.px_per_m.reset();
  return settings;
}

void check(const reduction::BallImage& image, bool timed) {
  require(std::isfinite(image.centre_px.x) && std::isfinite(image.centre_px.y));
  require(std::isfinite(image.diameter_px) && image.diameter_px >= 0.0);
  require(std::isfinite(image.time_s) == timed);
  if (image.diameter_sd_px) require(*image.diameter_sd_px > 0.0 && std::isfinite(*image.diameter_sd_px));
  if (image.equator_rad) {
    require(std::isfinite(*image.equator_rad));
    require(image.equator_sd_rad && *image.equator_sd_rad > 0.0 && std::isfinite(*image.equator_sd_rad));
  }
  if (image.centre_cov_px2) {
    const auto& c = *image.centre_cov_px2;
    require(c[0] > 0.0 && c[3] > 0.0 && std::isfinite(c[0] + c[1] + c[3]));
    require(c[0] * c[3] >= c[1] * c[1]);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kSettings) return 0;
  const Photograph photograph = photograph_of(data, size);
  if (photograph.intensity.empty()) return 0;
  const DigitizeSettings settings = settings_of(data, photograph);
  const auto found = digitize::digitize(photograph, settings);
  if (!found) {
    require(found.error().message.find('\n') == std::string::npos);
    return 0;
  }
  require(found->outlines.size() == found->frame.images.size());
  // Where no steady flight passes through the images none has a time, and a remark says so.
  const auto& images = found->frame.images;
  const bool given = settings.flash_times_s && !settings.flash_times_s->empty();
  // Nor has an image of another leg than the bounce's.
  const auto told = std::ranges::find_if(images, [](const auto& image) { return !image.other_leg; });
  const bool timed = given && told != images.end() && std::isfinite(told->time_s);
  if (given && !timed && !images.empty()) require(!found->remarks.empty());
  double before_s = -1.0;
  for (const auto& image : images) {
    check(image, timed && !image.other_leg);
    if (!timed || image.other_leg) continue;
    require(image.time_s > before_s);
    before_s = image.time_s;
  }
  for (const auto& point : found->frame.surface_px) require(std::isfinite(point.x) && std::isfinite(point.y));
  for (const auto& each : found->unmeasured) require(std::isfinite(each.centre.x) && !each.what.empty());
  return 0;
}
