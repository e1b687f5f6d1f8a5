// The digitizer as the photographs' reader wants it. Reads files; allocates.
#pragma once

#include "host/config/rig_file.hpp"
#include "host/digitize/core/types.hpp"
#include "host/photographs/photograph_reader.hpp"

namespace strobe::host {

/// Loads a photograph and digitizes it with what the rig file says of camera and ball. A photograph that
/// cannot be decoded may be unfinished; one of another size than the camera's, or without a scale, is
/// refused.
MeasurePhotograph photograph_measurer(const RigFile& rig, digitize::Effort effort);

}  // namespace strobe::host
