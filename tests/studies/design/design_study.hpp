// What `strobe design` foretells against what simulated shots of drawn designs then have: the rms error against the
// truth of the scene, which has flight, contact and measurement of its own. Deterministic from the seed, whatever the
// number of threads. Thread-safe; allocates.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "host/design/improvements.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::studies {

/// A set-up with its balls, as the simulator and as the host have it.
struct DrawnDesign {
  sim::Scene scene;
  host::Design design;
  host::RigFile rig;
  bool calibrated = false;
  double scale_sd = 0.0;  ///< relative
};

/// 3 to 45 m/s, 10 to 90 degrees, spin within 600 rad/s, 800 to 6,000 px/m, centres to 0.03 to 2 px; three to twelve
/// images of the incoming leg; coded or even trains; with and without a calibrated scale.
DrawnDesign drawn_design(const sim::Scene& base, std::uint64_t seed, int number);

/// Of one quantity of one design.
struct Foretold {
  double predicted = 0.0;  ///< total standard uncertainty of one shot
  double error = 0.0;      ///< rms over the shots that count
  double stated = 0.0;     ///< rms of what the same shots' readouts state
  int shots = 0;           ///< of these
  int gross = 0;           ///< others, more than ten of what is foretold off: read with another spin
  double ratio() const { return predicted / error; }
};

struct DesignOutcome {
  std::string name;
  double predicted_readable = 0.0, readable = 0.0;  ///< share of shots
  std::array<Foretold, reduction::kQuantityCount> quantities{};  ///< without shots: neither has the number
};

/// Each shot with errors of its own of scale, ball, drag, lift and the spin's decay, by what is stated of them.
DesignOutcome foretold_and_found(const DrawnDesign& drawn, int shots, std::uint64_t seed);

}  // namespace strobe::studies
