// The images of a ball in contact with the surface, as fractions of what happens between touchdown and
// lift-off: time, distance along the surface, drop of the top of the ball over its diameter (negative),
// rotation. Plain values. Parsing is pure, thread-safe, and allocates.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::contact {

struct ContactRow {
  double time_fraction = 0.0;
  double x_fraction = 0.0;
  double y_fraction = 0.0;
  std::optional<double> rotation_fraction;  ///< absent: left out by a correction

  bool operator==(const ContactRow&) const = default;
};

struct ContactSet {
  std::string name;
  std::vector<ContactRow> rows;  ///< not necessarily in order of time
};

/// One of the two rows that hold by definition: touchdown (0,0,0,0) or lift-off (1,1,0,1).
bool is_end_point(const ContactRow& row);

/// From CSV text with the header time_fraction,x_fraction,y_fraction,rotation_fraction. Fractions outside 0…1
/// are kept: they were measured so. Refused: a missing or other header, a wrong number of columns, anything
/// that is not a finite number of magnitude below 1e6, no rows. The message says "SOURCE:LINE: column: what".
Result<ContactSet> parse_contact_csv(std::string_view text, std::string_view source);

}  // namespace strobe::contact
