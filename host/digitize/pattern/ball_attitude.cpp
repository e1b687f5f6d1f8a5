#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/digitize/digitize.hpp"
#include "host/digitize/pattern/dot_pattern.hpp"

namespace strobe::digitize {

namespace {

// A cut-out's borders, or dots on the limb, hide so much of an outline that its size is not found: it is then
// tried.
constexpr std::array kFills{0.95, 0.75, 0.6};
constexpr double kFillsWithin = 0.15;

}  // namespace

Result<Outline> only_ball(const Photograph& photograph) {
  DigitizeSettings settings;
  settings.ball_diameter_m = 0.04;  // any: nothing is said in metres
  settings.line_drawn = false;
  auto found = digitize(photograph, settings);
  settings.size_tolerance = kFillsWithin;
  for (const double fills : kFills) {
    if (!found || !found->outlines.empty()) break;
    settings.px_per_m = fills * std::min(photograph.width(), photograph.height()) / settings.ball_diameter_m;
    found = digitize(photograph, settings);
  }
  if (!found) return tl::unexpected(found.error());
  if (found->outlines.size() == 1) return found->outlines.front();
  return fail(fmt::format(
      "{}: {} images of a ball were found, not one: give its outline by --circle, or cut the picture",
      photograph.name, found->outlines.size()));
}

Result<BallAttitude> measure_attitude(const Photograph& photograph, const PlaneMap& map,
                                      const Outline& outline, const DotPattern& pattern,
                                      double pattern_sd_rad) {
  // Dots on the limb move outlines by so much more than the sds of balls without; by rendered balls.
  constexpr double kByDots = 1.5;
  DotMatchSettings settings;
  settings.pattern_sd_rad = pattern_sd_rad;
  settings.centre_sd = std::max(1e-4, kByDots * outline.centre_sd() / (0.5 * outline.diameter));
  settings.radius_sd = std::max(1e-4, kByDots * outline.diameter_sd() / outline.diameter);
  auto found = match_dots(find_dots(photograph, map, outline), pattern, settings);
  if (!found) return fail(photograph.name + ": " + found.error().message);
  return found;
}

}  // namespace strobe::digitize
