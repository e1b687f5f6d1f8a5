// A shot's photograph with what was measured on it: drawn from the stored photograph and the stored measurement, without
// measuring again. Reads the photograph; thread-safe; allocates.
#pragma once

#include "host/archive/read_session.hpp"
#include "host/report/model/model.hpp"

namespace strobe::lab_report {

/// A JPEG of at most `longest_side_px`. Fails with why there is none, for a person: no photograph is kept, it cannot be read,
/// nothing was measured on it.
Result<Picture> overlay_picture(const host::StoredSession& session, const host::Shot& shot,
                                int longest_side_px);

}  // namespace strobe::lab_report
