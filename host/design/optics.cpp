#include "host/design/optics.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace strobe::host {
namespace {

/// C-mount's and photographers'.
constexpr double kUsualFocalLengths_mm[] = {300, 200, 135, 105, 100, 85,   75, 60, 50, 40, 35,
                                            28,  25,  24,  20,  16,  12.5, 12, 8,  6,  5,  4};

double focal_length_m(const LensSetUp& set_up) { return 1e-3 * set_up.focal_length_mm; }
double pitch_m(const LensSetUp& set_up) { return 1e-6 * set_up.pixel_pitch_um; }
double aperture_m(const LensSetUp& set_up) { return focal_length_m(set_up) / set_up.f_number; }

struct LensFieldRange {
  const char* field;
  double value, least, most;
};

}  // namespace

Result<void> check(const LensSetUp& s) {
  for (const LensFieldRange& range :
       {LensFieldRange{"width_px", static_cast<double>(s.width_px), 16, 100'000},
        {"height_px", static_cast<double>(s.height_px), 16, 100'000},
        {"pixel_pitch_um", s.pixel_pitch_um, 0.1, 100},
        {"focal_length_mm", s.focal_length_mm, 0.1, 10'000},
        {"f_number", s.f_number, 0.5, 128}}) {
    if (!(range.value >= range.least && range.value <= range.most))
      return fail(fmt::format("{}: must be {} to {}", range.field, range.least, range.most));
  }
  if (!(s.distance_m > focal_length_m(s))) return fail("distance_m: must be above the focal length");
  return {};
}

double magnification(const LensSetUp& set_up) {
  return focal_length_m(set_up) / (set_up.distance_m - focal_length_m(set_up));
}

double px_per_m(const LensSetUp& set_up) { return magnification(set_up) / pitch_m(set_up); }

ViewSize view_size(const LensSetUp& set_up) {
  const double scale = px_per_m(set_up);
  return {set_up.width_px / scale, set_up.height_px / scale};
}

DepthOfField depth_of_field(const LensSetUp& set_up, double circle_px) {
  // By reciprocals, in which an infinite distance is no special case.
  const double f = focal_length_m(set_up), focused = 1.0 / set_up.distance_m;
  const double spread = circle_px * pitch_m(set_up) / (aperture_m(set_up) * f) * (1.0 - f * focused);
  const double far = focused - spread;
  return {1.0 / (focused + spread), far > 0.0 ? 1.0 / far : std::numeric_limits<double>::infinity()};
}

double defocus_sd_px(const LensSetUp& set_up, double off_plane_m) {
  const double share = std::abs(off_plane_m) / (set_up.distance_m + off_plane_m);
  return 0.25 * aperture_m(set_up) * px_per_m(set_up) * share;
}

double diffraction_sd_px(const LensSetUp& set_up, double wavelength_nm) {
  const double working_f_number = set_up.f_number * (1.0 + magnification(set_up));
  return std::numbers::sqrt2 / std::numbers::pi * 1e-9 * wavelength_nm * working_f_number / pitch_m(set_up);
}

double perspective_per_mm(const LensSetUp& set_up) { return 1e-3 / set_up.distance_m; }

double motion_px(const LensSetUp& set_up, double speed_mps, double flash_s) {
  return speed_mps * flash_s * px_per_m(set_up);
}

double distance_for_scale_m(const LensSetUp& set_up, double wanted_px_per_m) {
  return focal_length_m(set_up) * (1.0 + 1.0 / (wanted_px_per_m * pitch_m(set_up)));
}

std::optional<double> focal_length_for_view_mm(LensSetUp set_up, const ViewSize& wanted) {
  for (const double focal_length_mm : kUsualFocalLengths_mm) {
    set_up.focal_length_mm = focal_length_mm;
    if (focal_length_m(set_up) >= set_up.distance_m) continue;
    const ViewSize view = view_size(set_up);
    if (view.width_m >= wanted.width_m && view.height_m >= wanted.height_m) return focal_length_mm;
  }
  return std::nullopt;
}

}  // namespace strobe::host
