// The kinds of trouble that a shot can have: in what is measured, in what is told with it, in what is assumed. Their
// numbers determine what a seed draws: append.
// Constants only.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace strobe::contradictions {

enum class Kind {
  none,
  unread_equators,
  long_period,
  surface_point,
  surface_pair,
  scale,
  ball_size,
  ball_size_uncalibrated,
  noise_understated,
  noise_overstated,
  heavy_tails,
  correlated,
  outlier_centre,
  outlier_first_image,
  outlier_diameter,
  outlier_equator,
  two_equators,
  two_centres,
  image_time,
  time_noise,
  alpha,
  drag,
  spin_decay,
  surface_angle,
  wrong_leg,
  gap,
  air,
  fast_spin,
  fast_spin_coded,
  tilted_axis,
  tilted_axis_unmeasured,
  off_plane,
};

struct KindInWords {
  std::string_view name;
  std::string_view what;
};

/// In the order of Kind.
inline constexpr std::array<KindInWords, 32> kKinds{{
    {"none", "undisturbed"},
    {"unread_equators", "5-90 % of the equators unread, at random or every second or third"},
    {"long_period", "5-15 ms between flashes, spins up to 600 rad/s"},
    {"surface_point", "one of 3-6 surface points 1-100 sd off the line"},
    {"surface_pair", "one of two surface points 1-100 sd off the line"},
    {"scale", "calibrated scale 0.5-10 % off, stated to 0.2 %"},
    {"ball_size", "ball 1-8 % larger or smaller than told, scale calibrated to 0.2 %"},
    {"ball_size_uncalibrated", "likewise, scale from the ball"},
    {"noise_understated", "noise 1-3.3 times what is stated, of all measurements or of one kind"},
    {"noise_overstated", "noise 0.3-1 times what is stated, of all measurements or of one kind"},
    {"heavy_tails", "noise of Student's t with 3 degrees of freedom"},
    {"correlated", "two to four neighbouring centres share a shift of 0.5-5 sd"},
    {"outlier_centre", "one airborne centre 1-100 sd off"},
    {"outlier_first_image", "the first image's centre 1-100 sd off"},
    {"outlier_diameter", "one airborne diameter 1-100 sd off"},
    {"outlier_equator", "one airborne equator 1-100 sd off, or anyhow"},
    {"two_equators", "two equators of one leg 1-100 sd off, or anyhow"},
    {"two_centres", "two centres of one leg 1-100 sd off"},
    {"image_time", "one airborne image's time off by up to a period"},
    {"time_noise", "times with noise of 0.3-10 centre sd along the path, not stated"},
    {"alpha", "the ball's alpha 0.51-0.60, 0.55 is told"},
    {"drag", "drag coefficient up to 20 % off"},
    {"spin_decay", "spin's decay in flight 0.5-2 % a metre, 1 % is assumed"},
    {"surface_angle", "told inclination of the plate 0.5-15 degrees off"},
    {"wrong_leg", "one image labelled with a wrong leg"},
    {"gap", "5-70 % of the images missing, at random or in a row"},
    {"air", "drag, lift, the spin's decay and alpha drawn from their tolerances"},
    {"fast_spin", "spins up to 1,500 rad/s, of which nobody told, an even train of 1-6 ms"},
    {"fast_spin_coded", "likewise, a coded train"},
    {"tilted_axis", "spins about axes up to 60 degrees off the camera's, other ones after the bounce, tilts of the line measured"},
    {"tilted_axis_unmeasured", "likewise, tilts not measured"},
    {"off_plane", "the ball comes nearer or goes away by up to 5 degrees, the lens 1-3 m away"},
}};
inline constexpr std::size_t kKindCount = kKinds.size();

constexpr std::string_view name(Kind kind) { return kKinds[static_cast<std::size_t>(kind)].name; }
constexpr std::string_view words(Kind kind) { return kKinds[static_cast<std::size_t>(kind)].what; }

constexpr std::optional<Kind> kind_from_name(std::string_view text) {
  for (std::size_t i = 0; i < kKindCount; ++i)
    if (kKinds[i].name == text) return static_cast<Kind>(i);
  return std::nullopt;
}

}  // namespace strobe::contradictions
