// All that is told of one stored shot. Reads the files of corrections; thread-safe; allocates;
// some milliseconds, since it makes the budget.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "host/archive/read_session.hpp"
#include "host/digitize/core/plane_map.hpp"

namespace strobe::web {

struct PhotographPlace {
  std::string url;
  int width_px = 0, height_px = 0;
};

/// shot_json() and more, see host/web/README.md. photograph: absent: none can be shown. What was not measured
/// is null here: the measurement that the log holds does not tell, unless it lies in digitizations/.
nlohmann::ordered_json detail_json(const host::Shot& shot, const std::string& session_id,
                                   const std::optional<PhotographPlace>& photograph);

/// From the frame that counts to the photograph. Without a photograph, whose height nobody knows, one just as
/// high as the images need.
digitize::PlaneMap photograph_map(const host::Shot& shot, const std::optional<PhotographPlace>& photograph);

}  // namespace strobe::web
