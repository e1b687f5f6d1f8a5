// A person's corrections: read or refused with one line, and applied to a small digitization so that it stays
// whole or is left as it was.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host/digitize/corrections.hpp"
#include "tests/fuzz/require.hpp"

using namespace strobe::fuzz;

namespace {

using namespace strobe;
using namespace strobe::digitize;

Digitization three_images() {
  Digitization found;
  for (int i = 0; i < 3; ++i) {
    reduction::BallImage image;
    image.centre_px = {100.0 + 60.0 * i, 200.0 - 40.0 * i};
    image.diameter_px = 50.0;
    image.time_s = 0.003 * i;
    image.flash_index = i;
    image.source = "auto";
    found.frame.images.push_back(image);
    Outline outline;
    outline.centre = {image.centre_px.x, image.centre_px.y};
    outline.diameter = 50.0;
    outline.covariance = cv::Matx33d::eye();
    found.outlines.push_back(outline);
  }
  return found;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = text_of(data, size);
  const auto corrections = parse_corrections(text, "edit.toml");
  if (!corrections) return require_one_line(corrections.error().message, "edit.toml:"), 0;
  require(!corrections->empty());
  DigitizeSettings settings;
  settings.px_per_m = 800.0;
  settings.map = PlaneMap::uncalibrated(400);
  settings.flash_times_s = {{0.0, 0.003, 0.006, 0.009}};
  Digitization found = three_images();
  if (const auto applied = apply_corrections(found, *corrections, settings); !applied) {
    require(applied.error().message.starts_with("edit.toml:"));
    require(found.frame.images.size() == 3);
    return 0;
  }
  require(found.surface_by_hand == (found.frame.surface_px.size() == 2));
  for (const auto& p : found.frame.surface_px) require(std::isfinite(p.x) && std::isfinite(p.y));
  require(found.outlines.size() == found.frame.images.size());
  for (const auto& image : found.frame.images) {
    require(std::isfinite(image.centre_px.x) && std::isfinite(image.centre_px.y));
    require(image.diameter_px >= 0.0 && (image.source == "auto" || image.source == "hand"));
  }
  return 0;
}
