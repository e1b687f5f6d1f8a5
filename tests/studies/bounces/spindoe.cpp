#include "tests/studies/bounces/spindoe.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "common/impact/spatial/spatial_contact.hpp"

namespace strobe::studies {

namespace {

constexpr double kRadius_m = 0.020;
constexpr int kMaxPositions = 14, kMinPositions = 8;
constexpr double kMaxSpin_radps = 800.0;  ///< beyond it a spin is taken for a mistake
constexpr double kMaxNoise_m = 0.004;
constexpr double kMaxAcross = 0.1;
constexpr double kAlpha = 0.655, kShare = kAlpha / (1.0 + kAlpha);
constexpr double kSpinShare_sd = 0.02;     ///< assumed; the dataset states none

struct Position {
  double t_s = 0.0;
  Eigen::Vector3d at;
};

/// Coefficients of 1, t, t² (rows) by axis (columns), with the cofactors of the fit.
struct Quadratic {
  Eigen::Matrix3d c;
  Eigen::Matrix3d cofactor;
  double squares = 0.0;
  int count = 0;

  Eigen::Vector3d velocity(double t_s) const { return c.row(1).transpose() + 2.0 * t_s * c.row(2).transpose(); }
  double velocity_sd(double t_s, double noise_m) const {
    const Eigen::Vector3d d(0.0, 1.0, 2.0 * t_s);
    return noise_m * std::sqrt(d.dot(cofactor * d));
  }
};

Quadratic fitted(const std::vector<Position>& all, int from, int to, double origin_s) {
  const int n = to - from;
  Eigen::MatrixX3d design(n, 3), at(n, 3);
  for (int i = 0; i < n; ++i) {
    const Position& p = all[static_cast<std::size_t>(from + i)];
    const double t = p.t_s - origin_s;
    design.row(i) << 1.0, t, t * t;
    at.row(i) = p.at.transpose();
  }
  Quadratic out;
  out.cofactor = (design.transpose() * design).inverse();
  out.c = out.cofactor * (design.transpose() * at);
  out.squares = (at - design * out.c).squaredNorm();
  out.count = n;
  return out;
}

struct Split {
  Quadratic before, after;
  double bounce_s = 0.0;  ///< after the origin of both
  double noise_m = 0.0;
};

/// Where the heights of both are equal nearest to the origin.
std::optional<double> meeting(const Quadratic& a, const Quadratic& b) {
  const Eigen::Vector3d d = (a.c - b.c).col(2);
  double t = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double slope = d[1] + 2.0 * d[2] * t;
    if (slope == 0.0) return std::nullopt;
    t -= (d[0] + d[1] * t + d[2] * t * t) / slope;
  }
  return std::abs(t) < 0.02 ? std::optional(t) : std::nullopt;
}

std::optional<Split> split(const std::vector<Position>& flight) {
  std::optional<Split> best;
  double least = 0.0, lowest = 1e9;
  for (const Position& p : flight) lowest = std::min(lowest, p.at.z());
  const int n = static_cast<int>(flight.size());
  for (int k = kMinPositions; k <= n - kMinPositions; ++k) {
    const Position& last = flight[static_cast<std::size_t>(k - 1)];
    if (last.at.z() > lowest + 0.05) continue;
    const double origin = flight[static_cast<std::size_t>(k)].t_s;
    Split one{.before = fitted(flight, std::max(0, k - kMaxPositions), k, origin),
              .after = fitted(flight, k, std::min(n, k + kMaxPositions), origin)};
    const double squares = one.before.squares + one.after.squares;
    if (best && squares >= least) continue;
    const auto t = meeting(one.before, one.after);
    if (!t) continue;
    one.bounce_s = *t;
    one.noise_m = std::sqrt(squares / (3.0 * (one.before.count + one.after.count - 6)));
    best = one;
    least = squares;
  }
  return best;
}

Result<std::vector<std::vector<double>>> numbers_in(const std::string& path, char separator, bool head) {
  std::ifstream in(path);
  if (!in) return fail(path + ": cannot be read");
  std::vector<std::vector<double>> rows;
  std::string line;
  if (head) std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<double> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, separator);) {
      const auto value = std::strtod(cell.c_str(), nullptr);
      row.push_back(value);
    }
    if (row.size() == 4) rows.push_back(std::move(row));
  }
  return rows;
}

/// Axes along the slip; nullopt where nothing slips.
TableTennisBounce bounce_of(int flight, const Split& s, const Eigen::Vector3d& stored_spin) {
  const Eigen::Vector3d spin(stored_spin.x(), -stored_spin.y(), stored_spin.z());
  const Eigen::Vector3d in = s.before.velocity(s.bounce_s), out = s.after.velocity(s.bounce_s);
  const auto slip_of = [&in](const Eigen::Vector3d& omega) {
    return Eigen::Vector2d(in.x() - kRadius_m * omega.y(), in.y() + kRadius_m * omega.x());
  };
  const Eigen::Vector2d slip = slip_of(spin), along = slip.normalized();
  const Eigen::Vector2d change(out.x() - in.x(), out.y() - in.y());
  const double impulse = out.z() - in.z();
  const auto across = [&](const Eigen::Vector2d& d) { return (change.x() * d.y() - change.y() * d.x()) / impulse; };
  const double vx = along.x() * in.x() + along.y() * in.y();
  const double in_sd = s.before.velocity_sd(s.bounce_s, s.noise_m), out_sd = s.after.velocity_sd(s.bounce_s, s.noise_m);
  TableTennisBounce b{.flight = flight, .noise_m = s.noise_m};
  b.bounce = {.name = fmt::format("flight_{:03}", flight),
              .ball = "table_tennis",
              .surface = "table",
              .vx_td_mps = {vx, in_sd},
              .vy_td_mps = {in.z(), in_sd},
              .omega_td_radps = {(slip.norm() - vx) / kRadius_m, kSpinShare_sd * spin.norm()},
              .vx_lo_mps = published::Measured{along.x() * out.x() + along.y() * out.y(), out_sd},
              .vy_lo_mps = published::Measured{out.z(), out_sd}};
  b.across = across(along);
  b.across_as_stored = across(slip_of(stored_spin).normalized());
  return b;
}

SpatialBounce spatial_of(int flight, const Split& s, const Eigen::Vector3d& stored_spin) {
  const Eigen::Vector3d in = s.before.velocity(s.bounce_s), out = s.after.velocity(s.bounce_s);
  Eigen::Matrix3d axes;
  axes.row(0) = Eigen::Vector3d(in.x(), in.y(), 0.0).normalized();
  axes.row(1) = Eigen::Vector3d::UnitZ();
  axes.row(2) = axes.row(0).cross(axes.row(1));
  const double by_spin = kSpinShare_sd * kRadius_m * stored_spin.norm() * kShare;
  return {.flight = flight,
          .across = false,
          .touchdown = {axes * in, axes * Eigen::Vector3d(stored_spin.x(), -stored_spin.y(), stored_spin.z())},
          .lift_off_mps = axes * out,
          .sd_mps = std::hypot(s.before.velocity_sd(s.bounce_s, s.noise_m), s.after.velocity_sd(s.bounce_s, s.noise_m), by_spin)};
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

double slip_of(const published::Bounce& b) { return b.vx_td_mps.value + kRadius_m * b.omega_td_radps.value; }

struct SpatialModel {
  std::string name;
  double first, last;  ///< of the grid of its second coefficient
};

/// Along the surface, of a table-tennis ball. The mechanics without offset and with a tennis ball's tangential dashpot.
Eigen::Vector2d error_of(const SpatialModel& model, bool in_space, const SpatialBounce& b, const Eigen::Vector2d& c) {
  const ball::Ball ball{.diameter_m = 2.0 * kRadius_m, .mass_kg = 0.0027, .alpha = kAlpha};
  impact::SpatialMotion td = b.touchdown;
  if (!in_space) td.spin_radps = Eigen::Vector3d(0.0, 0.0, td.spin_radps.z());
  const double e = std::min(1.0, -b.lift_off_mps.y() / td.velocity_mps.y());
  Eigen::Vector2d v;
  if (model.name == "ode")
    v = impact::along_surface(impact::spatial_lift_off(ball, td,
                                                       {.e = e, .dwell_s = 1e-3, .mu = c[0], .stiffness_ratio = c[1], .offset_share = 0.0},
                                                       1e-6)
                                  ->velocity_mps);
  else
    v = impact::along_surface(impact::grip(ball, td, impact::Coefficients{.e = e, .mu = c[0], .e_x = c[1]})->lift_off.velocity_mps);
  return v - impact::along_surface(b.lift_off_mps);
}

Eigen::Vector2d fitted_to(const SpatialModel& model, bool in_space, const std::vector<SpatialBounce>& half) {
  Eigen::Vector2d best;
  double least = HUGE_VAL;
  const int fine = model.first == model.last ? 0 : 16;
  for (int i = 0; i <= 80; ++i) {
    for (int k = 0; k <= fine; ++k) {
      const Eigen::Vector2d c(0.05 + 0.005 * i, model.first + (model.last - model.first) * k / std::max(fine, 1));
      double sum = 0.0;
      for (const SpatialBounce& b : half) sum += error_of(model, in_space, b, c).norm();
      if (sum < least) best = c;
      least = std::min(sum, least);
    }
  }
  return best;
}

}  // namespace

Result<TableTennis> read_spindoe(const std::string& folder) {
  const auto index = numbers_in(folder + "/index.csv", ',', true);
  if (!index) return tl::unexpected(index.error());
  TableTennis out;
  for (const std::vector<double>& row : *index) {
    const int number = static_cast<int>(row[0]);
    const auto rows = numbers_in(fmt::format("{}/{:03}.csv", folder, number), ';', false);
    if (!rows) return tl::unexpected(rows.error());
    ++out.flights;
    std::vector<Position> flight;
    for (const std::vector<double>& p : *rows)
      if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]) && std::isfinite(p[3]))
        flight.push_back({p[0], {p[1], p[2], p[3]}});
    const Eigen::Vector3d spin(row[1], row[2], row[3]);
    const auto found = split(flight);
    const double height = found ? found->before.c(0, 2) + found->before.c(1, 2) * found->bounce_s : 1.0;
    if (!found || found->before.velocity(found->bounce_s).z() > -0.5 ||
        found->after.velocity(found->bounce_s).z() < 0.3 || std::abs(height) > 0.03) {
      ++out.without_bounce;
      continue;
    }
    const int implausible = out.implausible;
    const TableTennisBounce b = bounce_of(number, *found, spin);
    const double e = *b.bounce.restitution();
    SpatialBounce spatial = spatial_of(number, *found, spin);
    spatial.across = std::abs(b.across) > kMaxAcross;
    if (spin.norm() > kMaxSpin_radps || b.noise_m > kMaxNoise_m || e > 1.05 || e < 0.6)
      ++out.implausible;
    else if (spatial.across)
      ++out.across;
    else
      out.bounces.push_back(b);
    if (out.implausible == implausible) out.in_space.push_back(spatial);
  }
  return out;
}

Judged judged_by(const TableTennis& flights) {
  Judged out;
  std::vector<double> ratios;
  double across = 0.0, as_stored = 0.0;
  const published::Ball ball{.name = "table_tennis",
                             .build = published::Build::shell,
                             .diameter_m = 2.0 * kRadius_m,
                             .mass_kg = 0.0027,
                             .alpha = {kAlpha, 0.01},
                             .source = "40 mm; a shell between that of no and of .5 mm thickness"};
  for (const TableTennisBounce& b : flights.bounces) {
    const published::Bounce& bounce = b.bounce;
    if (b.flight % 2 == 0) {
      ++out.telling;
      across += b.across * b.across;
      as_stored += b.across_as_stored * b.across_as_stored;
      const double impulse = bounce.vy_lo_mps->value - bounce.vy_td_mps.value;
      if (slip_of(bounce) > 1.5 * 0.4 * 2.5 * impulse) ratios.push_back(*bounce.impulse_ratio());
      continue;
    }
    out.cases.push_back({.ball = ball, .bounce = bounce, .friction = {.surface = "table", .row = {}, .reason = "even flights"}});
  }
  out.mu = ratios.empty() ? 0.0 : median(ratios);
  out.across_rms = std::sqrt(across / std::max(out.telling, 1));
  out.across_as_stored_rms = std::sqrt(as_stored / std::max(out.telling, 1));
  std::vector<double> deviations;
  for (const double r : ratios) deviations.push_back(std::abs(r - out.mu));
  const double sd = ratios.empty() ? 0.0 : 1.4826 * median(deviations);  // of one bounce: tables and balls differ
  for (bounces::Case& c : out.cases) {
    c.friction.mu = out.mu;
    c.friction.elsewhere = published::Measured{out.mu, sd};
  }
  return out;
}

std::vector<SpatialTally> judged_in_space(const std::vector<SpatialBounce>& bounces, bool with_across) {
  std::array<std::vector<SpatialBounce>, 2> halves;
  for (const SpatialBounce& b : bounces)
    if (with_across || !b.across) halves[static_cast<std::size_t>(b.flight % 2)].push_back(b);
  std::vector<SpatialTally> out;
  for (const SpatialModel& model : {SpatialModel{"rigid", 0.0, 0.0}, {"grip", -0.8, 0.8}, {"ode", 0.25, 16.25}}) {
    for (const bool in_space : {true, false}) {
      SpatialTally t{.model = model.name, .in_space = in_space};
      const std::array fit{fitted_to(model, in_space, halves[0]), fitted_to(model, in_space, halves[1])};
      t.even = fit[0];
      t.odd = fit[1];
      std::vector<double> sizes;
      for (const std::size_t half : {0u, 1u}) {
        const Eigen::Vector2d& c = fit[1 - half];
        std::array<std::vector<double>, 2> scatter;
        for (const SpatialBounce& b : halves[1 - half])
          for (const int i : {0, 1})
            scatter[static_cast<std::size_t>(i)].push_back(std::abs(error_of(model, in_space, b, c)[i]));
        const Eigen::Vector2d sd = 1.4826 * Eigen::Vector2d(median(scatter[0]), median(scatter[1]));
        for (const SpatialBounce& b : halves[half]) {
          const Eigen::Vector2d r = error_of(model, in_space, b, c);
          ++t.count;
          t.vx_rms_mps += r.x() * r.x();
          t.vz_rms_mps += r.y() * r.y();
          sizes.push_back(r.norm());
          for (const int i : {0, 1}) t.within += std::abs(r[i]) <= 1.96 * std::hypot(sd[i], b.sd_mps) ? 0.5 : 0.0;
        }
      }
      t.vx_rms_mps = std::sqrt(t.vx_rms_mps / t.count);
      t.vz_rms_mps = std::sqrt(t.vz_rms_mps / t.count);
      t.within /= t.count;
      t.median_mps = median(sizes);
      out.push_back(t);
    }
  }
  return out;
}

}  // namespace strobe::studies
