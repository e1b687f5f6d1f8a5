// Equators of one leg that fit no spin of the others: several bad readings mask each other where they are
// looked for one by one. Part of the reduction, not of its interface. Thread-safe; allocates.
#pragma once

#include <cstddef>
#include <vector>

#include "common/reduction/spin_fit.hpp"

namespace strobe::reduction {

/// Whether one spin explains the readings of a leg: chi squared of their fit is not beyond 4 of its sd, or
/// where their noise was estimated it is no more than `usual_sd_rad`, half as much again.
bool equators_agree(const std::vector<EquatorReading>& readings, const SpinFit& fit, double usual_sd_rad);

/// Which readings, by their place, do not belong to the consensus: the spin within the window that most
/// readings share, of all that two readings propose (random sample consensus with every sample: Fischler,
/// Bolles, CACM 24, 1981). Each of those left out is further from it than chance explains for any subset of
/// their number: either by the consensus's own scatter (Student's t), or by three times the noise. Their
/// false alarms on clean readings are below `false_alarms`, even where the stated noise is a third of the
/// true one. Empty where the consensus is no majority, has fewer than three readings, or where another spin
/// has as good a one. Readings are in order of time, which runs as the spin decays; noise that was estimated
/// is taken as `usual_sd_rad`.
std::vector<std::size_t> outside_consensus(const std::vector<EquatorReading>& readings, double window_radps,
                                           double usual_sd_rad, double false_alarms);

}  // namespace strobe::reduction
