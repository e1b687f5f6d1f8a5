// The closed list of what a readout can be flagged with. Names are stable: scripts rely on them.
// common/reduction/README.md describes them. Values only; thread-safe, real-time safe.
#pragma once

#include <array>
#include <bitset>
#include <string_view>

namespace strobe::reduction {

enum class Flag {
  late_flash,  // a flash that shows the ball came later than the rig's tolerance; its measured time was used
  missing_flash,  // a planned flash among those that show the ball was seen by no sensor
  double_flash,   // a lamp flashed twice for one pulse, or between two, among those that (may) show the ball
  flash_match_ambiguous,  // several assignments of images to flashes are plausible and differ by more than
                          // the rest of a number's uncertainty, or no steady flight fits the flashes
  spin_aliased,    // another spin that friction allows explains the equators as well; the regime is unclear
  too_few_images,  // a leg has too few airborne images for some number, which is null
  outlier_image,   // an image did not fit its leg, or the times of the flashes, and was left out
  no_redundancy,   // a leg has two or three images or equators, the photograph two or three diameters, or the
                   // surface fewer than four points: a bad one could not be found
  no_contact_image,     // no image between touchdown and lift-off
  overlaps_surface,     // an image given as airborne overlaps the surface line and was left out
  degenerate_geometry,  // no line through the surface, a leg that does not meet it or may not, or no scale:
                        // numbers are null
  sd_from_residuals,    // noise was estimated from this shot's residuals; the sd is scaled by Student's t
  shot_aborted,         // outputs went safe before the plan's end
  no_photograph,        // the photograph or its digitized frame did not come in time
  sensor_missing,       // a fitted flash sensor saw none, or not all, of the flashes that show the ball
  clock_suspect,        // flash times are not plausible: out of order, or not of this shot
  events_missing,       // events of this shot were lost before the journal, or never came to this host
  shutter_suspect,  // the shutter's contact (X-sync) did not tell of opening or closing, or well off its lag
  flash_index_ambiguous,  // the code of a coded train leaves open which flashes made the images; the numbers
                          // do not depend on it
  air_not_fitted,  // drag or lift matters, but a leg is too long for their series: it was fitted without them
  outlier_surface_point,  // a surface point did not lie on the line through the others and was left out
  surface_suspect,  // the surface points disagree and none could be singled out (their sd was scaled to their
                    // scatter), or an image in contact contradicts the line
  scale_contradicts_ball,  // the images' diameters together contradict the calibrated scale, which was
                           // believed as far as its sd says
  residuals_exceed_noise,  // the residuals are larger than the stated noise explains: the sds are too small
  scale_sd_unknown,    // the calibrated scale came without an sd: it was taken as exact, and the sds lack its
                       // share
  spin_limit_assumed,  // a spin faster than any in play explains all as well; nobody said how fast the ball
                       // can spin
  air_extrapolated,    // the ball flew slower or faster than its kind's drag and lift were measured at
  axis_tilted,   // the ball does not spin about the camera's axis: the spin was found in three dimensions
  out_of_plane,  // the ball came nearer or went away from the camera, by more than its diameters' noise
};

inline constexpr std::array<std::string_view, 29> kFlagNames{"late_flash",
                                                             "missing_flash",
                                                             "double_flash",
                                                             "flash_match_ambiguous",
                                                             "spin_aliased",
                                                             "too_few_images",
                                                             "outlier_image",
                                                             "no_redundancy",
                                                             "no_contact_image",
                                                             "overlaps_surface",
                                                             "degenerate_geometry",
                                                             "sd_from_residuals",
                                                             "shot_aborted",
                                                             "no_photograph",
                                                             "sensor_missing",
                                                             "clock_suspect",
                                                             "events_missing",
                                                             "shutter_suspect",
                                                             "flash_index_ambiguous",
                                                             "air_not_fitted",
                                                             "outlier_surface_point",
                                                             "surface_suspect",
                                                             "scale_contradicts_ball",
                                                             "residuals_exceed_noise",
                                                             "scale_sd_unknown",
                                                             "spin_limit_assumed",
                                                             "air_extrapolated",
                                                             "axis_tilted",
                                                             "out_of_plane"};
inline constexpr std::size_t kFlagCount = kFlagNames.size();

constexpr std::string_view name(Flag flag) { return kFlagNames[static_cast<std::size_t>(flag)]; }

/// A set of an enumeration's values, which count from 0.
template <typename Enum, std::size_t kCount>
class EnumSet {
 public:
  void set(Enum value) { bits_.set(static_cast<std::size_t>(value)); }
  bool has(Enum value) const { return bits_.test(static_cast<std::size_t>(value)); }
  bool empty() const { return bits_.none(); }
  const std::bitset<kCount>& bits() const { return bits_; }
  void merge(const EnumSet& other) { bits_ |= other.bits_; }
  bool operator==(const EnumSet&) const = default;

 private:
  std::bitset<kCount> bits_;
};
using FlagSet = EnumSet<Flag, kFlagCount>;

}  // namespace strobe::reduction
