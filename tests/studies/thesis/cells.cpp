#include "tests/studies/thesis/cells.hpp"

#include <array>
#include <numbers>

namespace strobe::studies {

using reduction::Quantity;

bool is_lift_off_motion(Quantity quantity) {
  return quantity == Quantity::vx_lo_mps || quantity == Quantity::vy_lo_mps ||
         quantity == Quantity::omega_lo_radps;
}

reduction::Quantities quantities_of(const impact::Motion& touchdown, const impact::Motion& lift_off,
                                    double dwell_s, double dwell_distance_m) {
  reduction::Quantities q;
  q[Quantity::vx_lo_mps] = lift_off.vx_mps;
  q[Quantity::vy_lo_mps] = lift_off.vy_mps;
  q[Quantity::v_lo_mps] = std::hypot(lift_off.vx_mps, lift_off.vy_mps);
  q[Quantity::theta_out_deg] = std::atan2(lift_off.vy_mps, lift_off.vx_mps) * 180.0 / std::numbers::pi;
  q[Quantity::omega_lo_radps] = lift_off.omega_radps;
  q[Quantity::e] = -lift_off.vy_mps / touchdown.vy_mps;
  q[Quantity::mu] = (touchdown.vx_mps - lift_off.vx_mps) / (lift_off.vy_mps - touchdown.vy_mps);
  q[Quantity::dwell_time_ms] = 1e3 * dwell_s;
  q[Quantity::dwell_distance_cm] = 1e2 * dwell_distance_m;
  return q;
}

std::vector<Cell> cells_of(const thesis::Condition& c, const reduction::Quantities& predicted,
                           Vertical vertical) {
  struct Published {
    Quantity quantity;
    const thesis::MeanSd& number;
    bool vertical;
  };
  const std::array<Published, 9> published{{{Quantity::vx_lo_mps, c.vx_lo_mps, false},
                                            {Quantity::vy_lo_mps, c.vy_lo_mps, true},
                                            {Quantity::v_lo_mps, c.v_lo_mps, false},
                                            {Quantity::theta_out_deg, c.theta_out_deg, false},
                                            {Quantity::omega_lo_radps, c.omega_lo_radps, false},
                                            {Quantity::e, c.e, true},
                                            {Quantity::mu, c.mu, false},
                                            {Quantity::dwell_time_ms, c.dwell_time_ms, true},
                                            {Quantity::dwell_distance_cm, c.dwell_distance_cm, false}}};
  std::vector<Cell> cells;
  for (const Published& p : published) {
    if (!predicted[p.quantity]) continue;
    cells.push_back({c.name(), p.quantity, *predicted[p.quantity], p.number.mean, p.number.sd,
                     p.vertical && vertical == Vertical::measured});
  }
  return cells;
}

}  // namespace strobe::studies
