#include <string_view>

#include "tests/studies/thesis/report.hpp"

namespace strobe::studies {

std::string reason(const Cell& cell) {
  using reduction::Quantity;
  const std::string_view c = cell.condition;
  const bool contact =
      cell.quantity == Quantity::dwell_time_ms || cell.quantity == Quantity::dwell_distance_cm;
  if (c == "back_17")
    return "A set apart: it slides throughout, with mu .625 where the two others that do have .50 and .52,\n"
           "   and e is .77 where sets as slow have .88. Constants fitted to all sets leave vx 4.4 sd off.";
  if (c == "back_40")
    return "Its printed spreads are among the least of all sets (vx .10 m/s, less than digitizing by hand\n"
           "   leaves), and its spin is less than a line between its neighbours at 35 and 45 degrees gives.";
  if (c == "back_35")
    return "Its e, .711, is below those of the faster sets at 40 and 45 degrees (.733, .750), and its dwell\n"
           "   time of 5.02 ms that of a slower one: no function that falls with the speed passes all three.";
  if (c == "top_48" && contact)
    return "Its dwell time, 3.86 ms, is below those of slower and of faster sets (4.49 at 42 degrees, 4.05\n"
           "   at 61): no function that falls with the speed passes all three. The distance goes with it.";
  if (c == "top_23")
    return "The printed spread of .47 degree is half of what those of vx and vy give (.8): by the common\n"
           "   one it is no exception. Its e, .905, is the largest of all.";
  if (c == "zero_60" && (cell.quantity == Quantity::vy_lo_mps || cell.quantity == Quantity::e))
    return "Its e, .716, is above that of the slower set at 49 degrees (.707), and its spread of vy small.";
  if (cell.quantity == Quantity::dwell_distance_cm)
    return "Distances of steep shots come out short in most sets, by a tenth or so: not explained.";
  return "No reason found in the tables.";
}

}  // namespace strobe::studies
