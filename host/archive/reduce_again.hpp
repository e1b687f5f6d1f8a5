// A stored shot's numbers by another estimator. Pure; thread-safe; allocates.
#pragma once

#include "common/reduction/reduce.hpp"
#include "host/archive/stored_session.hpp"

namespace strobe::host {

/// The result with a readout by this estimator, from the digitization that counts and the flashes' most probable times;
/// whether the shot counts stays as it was. Fails with one line if there is no digitization, or no flashes match it.
Result<ShotResult> reduced_by(const StoredShot& shot, reduction::Estimator estimator,
                              const reduction::ReduceOptions& options);

}  // namespace strobe::host
