// The images of a ball in contact with the surface, as fractions of the contact: time over the dwell time,
// displacement along the surface over the dwell distance, height of the top of the ball less that at
// touchdown over the diameter (negative), rotation over that from touchdown to lift-off. Plain values.
// Parsing is pure, thread-safe, and allocates.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::data {

/// Residuals below this share of the values are rounding, and tell nothing of the images' errors.
inline constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();

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
  int repeated = 0;  ///< rows of the file that were those of earlier ones to the last digit: no images more
};

/// One of the two rows that hold by definition: touchdown (0,0,0,0) or lift-off (1,1,0,1).
bool is_end_point(const ContactRow& row);

/// A measured image with a time fraction in 0…1.
bool is_interior(const ContactRow& row);

/// Parses CSV text with the header time_fraction,x_fraction,y_fraction,rotation_fraction. Valid: time
/// fractions in -0.05…1.05 (measured ones reach 1.005), other fractions of magnitude below 1e6. Of equal rows
/// the first is kept. Fails on a missing or other header, a wrong number of columns, a value out of range,
/// and no rows, as "SOURCE:LINE: column: what is wrong".
Result<ContactSet> parse_contact_csv(std::string_view text, std::string_view source);

}  // namespace strobe::data
