#include "host/design/exposure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace strobe::host {
namespace {

constexpr int kMaxOverlapping = 1000;

bool is_in_range(const PhotographedLight& light, int overlapping) {
  return light.brightness > 0.0 && light.brightness <= 1.0 && light.dark >= 0.0 &&
         light.dark < light.brightness && light.transfer_exponent.value_or(1.0) > 0.0 && overlapping >= 1 &&
         overlapping <= kMaxOverlapping;
}

/// How many images' light a place holds.
int images_before(double level, double dark_light, double image_light) {
  return static_cast<int>(std::min<double>(kMaxOverlapping, std::floor((level - dark_light) / image_light)));
}

std::string what_to_do(double stops) {
  const double size = std::abs(stops);
  const char* unit = size == 1.0 ? "stop" : "stops";
  if (stops == 0.0) return "leave the aperture as it is";
  return fmt::format("{} by {:g} {}", stops > 0.0 ? "open" : "close", size, unit);
}

}  // namespace

std::optional<ExposureAdvice> exposure_advice(const std::optional<PhotographedLight>& measured,
                                              int overlapping) {
  if (!measured || !is_in_range(*measured, overlapping)) return std::nullopt;
  const double to_light = 1.0 / measured->transfer_exponent.value_or(1.0);
  ExposureAdvice advice;
  advice.dark_light = std::pow(measured->dark, to_light);
  advice.image_light = std::pow(measured->brightness, to_light) - advice.dark_light;
  advice.is_clipped = measured->brightness >= 1.0;
  advice.images_before_clip =
      advice.is_clipped ? 0 : images_before(1.0, advice.dark_light, advice.image_light);
  // The dark is taken to stay: room light does with the aperture, a black level does not.
  const double wanted = (kBrightestPlace - advice.dark_light) / overlapping;
  const double target = std::max(wanted, kMinImageLight);
  advice.stops = 0.5 * std::floor(2.0 * std::log2(target / advice.image_light) + 1e-9);
  if (advice.is_clipped) {
    advice.stops = std::min(advice.stops, -1.0);
    advice.words =
        fmt::format("{} at least, and photograph again: one image saturates", what_to_do(advice.stops));
    return advice;
  }
  const double then = advice.image_light * std::exp2(advice.stops);
  const int before_clip = images_before(1.0, advice.dark_light, then);
  advice.words =
      fmt::format("{}: one image is then at {:.0f} % of white", what_to_do(advice.stops), 100.0 * then);
  advice.words += before_clip < overlapping
                      ? fmt::format(", and clips where more than {} of {} overlap: use a longer period",
                                    before_clip, overlapping)
                      : fmt::format(", and {} may overlap", before_clip);
  return advice;
}

}  // namespace strobe::host
