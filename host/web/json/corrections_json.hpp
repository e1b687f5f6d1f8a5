// A person's corrections of a photograph as the page's editor takes them up again: in the photograph's coordinates (column,
// row from the top [px]; angles counter-clockwise as seen), whichever the file has. Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/corrections.hpp"

namespace strobe::web {

/// [{"kind":"move","at_px":[column, row],"centre_px":[…],"centre_sd_px","diameter_px","diameter_sd_px","equator_deg",
/// "equator_sd_deg","no_equator","leg","top_px","contact_width_px","time_s"}, {"kind":"surface","left_px","right_px","sd_px"}].
/// Only what a correction says is there. Standard deviations and the contact's width are the frame's, as in the file.
nlohmann::ordered_json corrections_json(std::span<const digitize::Correction> corrections,
                                        const digitize::PlaneMap& map);

}  // namespace strobe::web
