// Series of shots with budgets that tests can do sums with.
#pragma once

#include <string>
#include <vector>

#include "host/series/series.hpp"

namespace strobe::test {

/// `value` of vx at touchdown and of e. A scale of 1 % makes vx larger by `by_scale`, and e not; the ball's diameter e by
/// `by_ball`.
inline host::Shot series_shot(const std::string& name, double vx, double e = 0.8, double by_scale = 0.0,
                                    double by_ball = 0.0) {
  using namespace reduction;
  host::Shot shot;
  shot.name = name;
  shot.calibration = "the camera's";
  shot.ball = "ball 1";
  shot.readout.value[Quantity::vx_td_mps] = vx;
  shot.readout.value[Quantity::e] = e;
  BudgetSource centres{.source = Source::centres};
  centres.effect[static_cast<std::size_t>(Quantity::vx_td_mps)] = 0.3;
  BudgetSource scale{.source = Source::scale, .input_sd = 1.0, .input_unit = "%"};
  scale.effect[static_cast<std::size_t>(Quantity::vx_td_mps)] = by_scale;
  BudgetSource ball{.source = Source::ball_diameter, .input_sd = 0.5, .input_unit = "mm"};
  ball.effect[static_cast<std::size_t>(Quantity::e)] = by_ball;
  shot.budget.sources = {centres, scale, ball};
  return shot;
}

inline std::vector<host::Shot> series_shots(const std::vector<double>& vx, double by_scale = 0.0) {
  std::vector<host::Shot> shots;
  for (const double v : vx) shots.push_back(series_shot(std::to_string(shots.size() + 1), v, 0.8, by_scale));
  return shots;
}

inline host::Series series_of(const std::vector<host::Shot>& shots) {
  host::Series series;
  for (const host::Shot& shot : shots) series.add(shot);
  return series;
}

}  // namespace strobe::test
