#include "host/view/thesis_row.hpp"

#include <fmt/format.h>

#include <array>

#include "host/view/table_layout.hpp"

namespace strobe::host {
namespace {

/// The thesis's column of each quantity, in the order of Quantity; null: it has none.
using C = thesis::Condition;
constexpr std::array<thesis::MeanSd C::*, reduction::kQuantityCount> kThesisColumns{&C::theta_in_deg,
                                                                                    &C::theta_out_deg,
                                                                                    &C::vx_td_mps,
                                                                                    &C::vy_td_mps,
                                                                                    &C::v_td_mps,
                                                                                    &C::omega_td_radps,
                                                                                    &C::vx_lo_mps,
                                                                                    &C::vy_lo_mps,
                                                                                    &C::v_lo_mps,
                                                                                    &C::omega_lo_radps,
                                                                                    nullptr,
                                                                                    &C::e,
                                                                                    &C::mu,
                                                                                    &C::dwell_time_ms,
                                                                                    &C::dwell_distance_cm,
                                                                                    nullptr};

/// Tables 2-4 hold the incoming, 5-7 the rebounding ball, 8-10 the parameters; one each for zero, top, back
/// spin.
int first_table(const thesis::Condition& c) { return c.spin == "top" ? 3 : c.spin == "back" ? 4 : 2; }

}  // namespace

std::string thesis_title(const thesis::Condition& condition) {
  const int table = first_table(condition);
  return fmt::format("thesis {} {}, Tables {}, {}, {}", condition.spin, condition.angle_label_deg, table,
                     table + 3, table + 6);
}

std::optional<thesis::MeanSd> thesis_number(const thesis::Condition& condition, reduction::Quantity q) {
  const auto column = kThesisColumns[static_cast<std::size_t>(q)];
  return column ? std::optional(condition.*column) : std::nullopt;
}

std::string thesis_cells(const thesis::Condition& condition, reduction::Quantity q,
                         const std::optional<double>& mean) {
  const auto printed = thesis_number(condition, q);
  if (!printed) return "";
  std::string cells = right(fmt::format("{:.2f}", printed->mean), kNumberWidth) +
                      right(fmt::format("± {:.2f}", printed->sd), kNumberWidth);
  if (mean && printed->sd > 0.0)
    cells += right(fmt::format("{:+.1f} sd", (*mean - printed->mean) / printed->sd), 10);
  return cells;
}

}  // namespace strobe::host
