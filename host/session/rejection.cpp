#include "host/session/rejection.hpp"

#include <array>

namespace strobe::host {

using reduction::Flag;

std::string_view words(Flag flag) {
  switch (flag) {
    case Flag::late_flash:
      return "a flash that shows the ball came late; its measured time was used";
    case Flag::missing_flash:
      return "a flash among those that show the ball was missing";
    case Flag::double_flash:
      return "a lamp flashed twice among the flashes that show the ball";
    case Flag::flash_match_ambiguous:
      return "which flash made which image is not certain, and the numbers depend on it";
    case Flag::spin_aliased:
      return "the ball may have turned more than a quarter turn between images";
    case Flag::too_few_images:
      return "too few images of the ball";
    case Flag::outlier_image:
      return "an image did not fit and was left out";
    case Flag::no_redundancy:
      return "a leg has fewer than four images: a bad one could not be told";
    case Flag::no_contact_image:
      return "no image in contact";
    case Flag::overlaps_surface:
      return "an image given as airborne overlaps the surface and was left out";
    case Flag::degenerate_geometry:
      return "the points do not make a surface and a path that meets it";
    case Flag::sd_from_residuals:
      return "uncertainties are estimated from this shot's own residuals";
    case Flag::shot_aborted:
      return "the shot was aborted";
    case Flag::no_photograph:
      return "the photograph did not come in time";
    case Flag::sensor_missing:
      return "a flash sensor missed flashes that show the ball";
    case Flag::clock_suspect:
      return "flash times are not plausible";
    case Flag::events_missing:
      return "events of the shot were lost";
    case Flag::shutter_suspect:
      return "the shutter's contact did not tell that it opened and closed as it should";
    case Flag::flash_index_ambiguous:
      return "the train's code leaves open which of its flashes made the images";
  }
  return "";
}

std::optional<std::string> rejection_reason(const reduction::Readout& readout) {
  constexpr std::array kRejecting{
      Flag::shot_aborted,       Flag::no_photograph, Flag::too_few_images,        Flag::late_flash,
      Flag::missing_flash,      Flag::double_flash,  Flag::flash_match_ambiguous, Flag::clock_suspect,
      Flag::degenerate_geometry};
  for (const Flag flag : kRejecting) {
    if (readout.flags.has(flag)) return std::string(words(flag));
  }
  return std::nullopt;
}

}  // namespace strobe::host
