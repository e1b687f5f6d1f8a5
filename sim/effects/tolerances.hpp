// The quantities of a readout and their tolerances, by which models of a scene are compared. Pure;
// thread-safe.
#pragma once

#include <array>
#include <string_view>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// One number >= 0 for each quantity of a readout, in its unit; infinite: no bound, or any value is
/// acceptable.
class PerQuantity {
 public:
  double& operator[](reduction::Quantity q) { return values_[static_cast<std::size_t>(q)]; }
  double operator[](reduction::Quantity q) const { return values_[static_cast<std::size_t>(q)]; }
  double& operator[](std::size_t i) { return values_[i]; }
  double operator[](std::size_t i) const { return values_[i]; }

  /// Each quantity's larger one.
  void max_with(const PerQuantity& other);
  bool all_zero() const;
  bool operator==(const PerQuantity&) const = default;

 private:
  std::array<double, reduction::kQuantityCount> values_{};
};

/// Whether no number changes by more than is allowed.
bool within(const PerQuantity& change, const PerQuantity& allowed);

/// |a - b|; infinite if only one is absent.
PerQuantity difference(const reduction::Quantities& a, const reduction::Quantities& b);

/// The readout of a shot's frame: the best estimator with gravity, drag (the spin's decay with it) and Magnus
/// and every image kept, so that it is a smooth function of the frame. A noise that the frame does not state
/// (a scene with a perfect hand) is taken as a tenth of a millimetre and a tenth of a degree: it only weighs
/// the measurements. All absent for a frame that cannot be reduced.
reduction::Quantities readout_of(reduction::Frame frame);

/// What a relative tolerance of 1 means for each quantity: the mean speed at touchdown v for velocities and
/// the slip, v/R for spins, 1 radian (in degrees) for angles, 1 for e and mu, the mean dwell time for the
/// dwell time, v times that for the dwell distance, 100 for the court pace.
PerQuantity readout_scales(const Scene& scene);

/// relative · scale, but for the quantities for which the scene's [readout] has a tolerance of its own.
PerQuantity tolerances(const Scene& scene, double relative);

/// The quantity whose change takes most of its tolerance; the first of all if no change is above 0.
reduction::Quantity worst(const PerQuantity& change, const PerQuantity& tolerance);

/// Unit as text: "m/s", "rad/s", "deg", "ms", "cm" or "".
std::string_view unit(reduction::Quantity quantity);

}  // namespace strobe::sim
