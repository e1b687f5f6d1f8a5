// What turns a set's fractions into real units. Pure; thread-safe; allocates.
#pragma once

#include "common/contact/analysis.hpp"
#include "common/data/thesis_data.hpp"

namespace strobe::report {

/// Dwell time and distance are the condition's. The total rotation is not printed: it is the one with which
/// the images fit the integrated rotation best (contact::Score). Where the thesis's can be told from the
/// corrected entries of its Table 13 it is -51.0 degrees (zero_23) and -9.7 (back_22); this gives -54 and -8.
contact::Scale scale_of(const contact::ContactSet& set, const thesis::Condition& condition);

}  // namespace strobe::report
