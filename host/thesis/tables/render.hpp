// A table as text for people and as JSON for scripts. Pure; thread-safe; allocates.
#pragma once

#include <string>

#include "host/thesis/table.hpp"

namespace strobe::report {

/// Title, one or two lines for each row (printed, recomputed; a * marks differences larger than rounding),
/// then every difference with its reason, then the notes.
std::string text(const Table& table);

/// One object without line breaks: table, title, columns (key, unit), rows (label and, by the columns' keys,
/// printed, printed_sd, computed, sd, difference, last_digits, difference_over_sd, reason, allowed, remark;
/// absent values left out), notes. Numbers are printed shortest-round-trip.
std::string json(const Table& table);

}  // namespace strobe::report
