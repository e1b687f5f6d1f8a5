// What was measured on a photograph, and a person's corrections of it, in its own coordinates: column, row
// from the top [px]; angles counter-clockwise as seen. Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>

#include "host/assembly/assemble.hpp"
#include "host/config/rig_file.hpp"
#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/corrections.hpp"

namespace strobe::web {

/// Each of the frame's images in its order: where it is, how well that is known, whether the readout uses it
/// or why not, and how far from the fitted path it lies. summary: null: no flash is known, and none is used.
nlohmann::ordered_json images_json(const strobe_msgs::shot_t* summary, const strobe_msgs::frame_t& frame,
                                   const host::AssemblySettings& settings, const digitize::PlaneMap& map);

/// [{"what","centre_px","diameter_px","why"}]
nlohmann::ordered_json unmeasured_json(std::span<const digitize::Unmeasured> unmeasured,
                                       const digitize::PlaneMap& map);

/// [[column, row], …]; null without a line.
nlohmann::ordered_json surface_json(const strobe_msgs::frame_t& frame, const digitize::PlaneMap& map);

/// Corrections as the page's editor takes them up again, in the photograph's coordinates whichever the file
/// has:
/// [{"kind":"move","at_px":[column,
/// row],"centre_px":[…],"centre_sd_px","diameter_px","diameter_sd_px","equator_deg",
/// "equator_sd_deg","no_equator","leg","top_px","contact_width_px","time_s"},
/// {"kind":"surface","left_px","right_px","sd_px"}]. Only what a correction says is there. Standard
/// deviations and the contact's width are the frame's, as in the file.
nlohmann::ordered_json corrections_json(std::span<const digitize::Correction> corrections,
                                        const digitize::PlaneMap& map);

}  // namespace strobe::web
