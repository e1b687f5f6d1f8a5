#include "host/session/advice.hpp"

#include <array>

namespace strobe::host {
namespace {

using reduction::Flag;

/// In the order of Flag; empty: nothing need be done.
constexpr std::array<std::string_view, reduction::kFlagCount> kAdvice{
    "If flashes come late in many shots, look at the timing page: another program may take the rig's "
    "processor.",
    "Look at the lamp's supply and trigger cable, and at the flash sensor's place before it.",
    "Let the lamp recharge for longer (a longer period), or look for reflections and crosstalk in its "
    "trigger cable.",
    "Correct images that are missing or wrong by hand, or fire it again; a coded train (spacing = \"coded\") "
    "tells flashes apart.",
    "Correct equators that were not seen by hand, or use a shorter period.",
    "Look at the photograph: add images that were not found by hand; else aim the camera, or the machine, so "
    "that more images of each leg are on it.",
    "Look at the photograph: if the image was measured wrongly, move or remove it by hand.",
    "",  // no_redundancy: the numbers' sds say how well they are known
    "",  // no_contact_image: legs alone give every number
    "Look at the surface line: if it is wrong, give it by hand.",
    "Look at the photograph: the surface line or a leg was not found. Give the line by hand, or remove what "
    "is no image of the ball.",
    "",  // sd_from_residuals: the sds are right so
    "Look at strobed's log for why it was aborted; mend that, and fire it again.",
    "Look at the camera: its cable, its folder, whether its shutter opened. strobe replay --complete "
    "measures a photograph that came later.",
    "Look at the flash sensor's place, its cable and threshold.",
    "Look at the flash sensors' wiring; A and B may be swapped.",
    "Messages were lost: look at the network between rig and host. strobed's journal has them.",
    "Look at the shutter's contact (line xsync) and its cable.",
    "",  // flash_index_ambiguous: no number depends on it
    "Remove the images farthest from the surface by hand, or open the shutter for less time.",
    "Look at the surface line: if it is wrong, give it by hand.",
    "Look at the surface line on the photograph: give it by hand, or calibrate it.",
    "Calibrate the camera again, or measure the ball's diameter.",
    "Look for an image that was measured wrongly, for blur, or for a camera that was touched; calibrate "
    "again.",
    "State the scale's sd in the rig file, or calibrate the camera.",
    "State the fastest spin that the machine can throw ([ball] fastest_spin_radps), or use a coded train.",
    "Look at the kind's range of speeds (strobe ball KIND); a file of one's own can state another drag.",
    "If the axis is tilted in many shots, square up the machine's wheels, or the camera, to the lane; a ball "
    "thrown with sidespin shows so, and its numbers are right.",
    "If balls leave the plane in many shots, turn the machine along the photograph's plane; calibrate the "
    "camera with the board in that plane."};

constexpr std::string_view kNoBall =
    "Look at the photograph. If the ball is on it, add its images by hand; if not, look whether the machine "
    "threw it, whether it came while the shutter was open ([machine] lag_ms), and whether the lamps lit it.";

struct AbortAdvice {
  std::string_view part;  ///< of the reason
  std::string_view advice;
};

constexpr std::string_view kBusy =
    "The rig's computer was busy: strobed --check names what its real-time set-up lacks; end what else runs "
    "there.";
constexpr std::string_view kChip =
    "Press the e-stop. Look at the GPIO chip, its cable and its lines (strobed --check); then go on with "
    "strobe fire --resume --clear-fault.";
constexpr std::string_view kEarlyOrLate =
    "Measure the machine's lag again ([machine] lag_ms); look for stray light, or a hand, in the gate.";

/// The first whose part stands in a reason is its own.
constexpr std::array kAbortAdvice = std::to_array<AbortAdvice>({
    {"key or e-stop c", kChip},
    {"edges cannot be read", kChip},
    {"could not be s", kChip},  // set, switched off
    {"e-stop",
     "Find out why the e-stop was used. When nobody is in danger, release it and go on with strobe fire "
     "--resume."},
    {"the key",
     "Turn the key on when nobody stands before the machine, and go on with strobe fire --resume. If nobody "
     "turned it, look for a loose contact."},
    {"disarmed by command",
     "The rig was disarmed: by Ctrl-C here, by another host or on a page. If it was not you, ask who did; "
     "then "
     "go on with strobe fire --resume."},
    {"suspended", "Keep the rig's computer from sleeping, then go on with strobe fire --resume."},
    {"would have been", kBusy},
    {"beats did not come", kBusy},
    {"not loaded in time", kBusy},
    {"would have come",
     "Give the plan a longer period: the lamps had no time to recharge after a flash that came late."},
    {" on for ", kBusy},
    {"interlock", "Look at key, e-stop and faults in strobed's log at that time, and fire it again."},
    {"before the shutter was open", kEarlyOrLate},
    {"too late for the burst", kEarlyOrLate},
    {"gate never seen",
     "Look whether the machine threw the ball and whether it crosses the light gate; look at the gate's lamp "
     "and cable."},
    {"stopped by a signal", "strobed was ended: start it again, and go on with strobe fire --resume."},
    {"flash sequencer",
     "Look at the flash sequencer's line, cable and supply (strobed --check asks it), and fire it again."},
    {"guardian",
     "Look at strobed's log for why its guardian failed, start it again, and go on with strobe fire "
     "--resume."},
    {"ended during the shot",
     "strobed, the host or their computer ended within the shot: look at power and logs, start them again, "
     "and go on with strobe fire --resume."},
});

void add(std::string& words, std::string_view sentence) {
  if (sentence.empty() || words.find(sentence) != std::string::npos) return;
  words += (words.empty() ? "" : " ") + std::string(sentence);
}

bool shows_no_ball(const Shot& shot) { return shot.frame() != nullptr && shot.frame()->images.empty(); }

/// A shot may be rejected by its match though the flag, which compares it with the rest of the uncertainty,
/// is not set.
reduction::FlagSet flags_of(const Shot& shot) {
  reduction::FlagSet flags = shot.readout.flags;
  if (shot.rejected && shot.rejected->starts_with(words(Flag::flash_match_ambiguous)))
    flags.set(Flag::flash_match_ambiguous);
  return flags;
}

}  // namespace

std::string_view advice(Flag flag) { return kAdvice[static_cast<std::size_t>(flag)]; }

std::string_view advice_on_abort(std::string_view reason) {
  for (const AbortAdvice& each : kAbortAdvice)
    if (reason.find(each.part) != std::string_view::npos) return each.advice;
  return {};
}

std::string advice(const Shot& shot) {
  const reduction::FlagSet flags = flags_of(shot);
  if (flags.has(Flag::shot_aborted)) {
    const auto its_own = advice_on_abort(shot.summary ? shot.summary->abort_reason : shot.problem);
    return std::string(its_own.empty() ? advice(Flag::shot_aborted) : its_own);
  }
  std::string words;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<Flag>(i);
    if (!flags.has(flag)) continue;
    add(words, flag == Flag::too_few_images && shows_no_ball(shot) ? kNoBall : advice(flag));
  }
  return words;
}

}  // namespace strobe::host
