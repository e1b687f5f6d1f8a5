#include "host/web/json/advice.hpp"

#include <array>
#include <string_view>

namespace strobe::web {
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
    "tells "
    "flashes apart.",
    "Correct equators that were not seen by hand, or use a shorter period.",
    "Look at the photograph: add images that were not found by hand; else aim the camera, or the machine, so "
    "that more "
    "images of each leg are on it.",
    "Look at the photograph: if the image was measured wrongly, move or remove it by hand.",
    "",  // few images: the numbers say how well they are known
    "",
    "Look at the surface line: if it is wrong, give it by hand.",
    "Look at the photograph: the surface line or a leg was not found. Give the line by hand, or remove what "
    "is no image "
    "of the ball.",
    "",
    "The rig says why it was aborted; fire it again.",
    "Look at the camera: its cable, its folder, whether its shutter opened. strobe replay --complete "
    "measures a photograph "
    "that came later.",
    "Look at the flash sensor's place, its cable and threshold.",
    "Look at the flash sensors' wiring; A and B may be swapped.",
    "Messages were lost: look at the network between rig and host. strobed's journal has them.",
    "Look at the shutter's contact (line xsync) and its cable.",
    "",
    "",
    "Look at the surface line: if it is wrong, give it by hand.",
    "Look at the surface line on the photograph: give it by hand, or calibrate it.",
    "Calibrate the camera again, or measure the ball's diameter.",
    "Look for an image that was measured wrongly, for blur, or for a camera that was touched; calibrate "
    "again.",
    "State the scale's sd in the rig file, or calibrate the camera."};

}  // namespace

std::string advice(const host::Shot& result) {
  std::string words;
  for (std::size_t i = 0; i < kAdvice.size(); ++i) {
    if (!result.readout.flags.has(static_cast<Flag>(i)) || kAdvice[i].empty()) continue;
    if (words.find(kAdvice[i]) != std::string::npos) continue;
    words += (words.empty() ? "" : " ") + std::string(kAdvice[i]);
  }
  return words;
}

}  // namespace strobe::web
