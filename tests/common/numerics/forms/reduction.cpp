#include <array>
#include <vector>

#include "common/geometry/line.hpp"
#include "common/reduction/propagate.hpp"
#include "common/reduction/surface_crossing.hpp"
#include "tests/common/numerics/forms/forms.hpp"
#include "tests/common/numerics/forms/wide.hpp"

namespace strobe::numerics {

namespace {

/// Longer axis of the points' moments: the eigenvector of their larger moment.
struct WideLine {
  Wide x0, y0, cosine, sine;
};

WideLine line_through(const std::vector<Eigen::Vector2d>& points) {
  Wide x0 = 0, y0 = 0, xx = 0, xy = 0, yy = 0;
  for (const Eigen::Vector2d& p : points) {
    x0 += Wide(p.x()) / points.size();
    y0 += Wide(p.y()) / points.size();
  }
  for (const Eigen::Vector2d& p : points) {
    xx += (p.x() - x0) * (p.x() - x0);
    xy += (p.x() - x0) * (p.y() - y0);
    yy += (p.y() - y0) * (p.y() - y0);
  }
  const Wide larger = (xx + yy + sqrt((xx - yy) * (xx - yy) + 4 * xy * xy)) / 2;
  Wide c = xx > yy ? Wide(larger - yy) : xy, s = xx > yy ? xy : Wide(larger - xx);
  const Wide sign = c < 0 ? -1 : 1, length = sqrt(c * c + s * s);
  return {x0, y0, sign * c / length, sign * s / length};
}

/// The same from sums of the coordinates as they stand.
double textbook_tilt(const std::vector<Eigen::Vector2d>& points) {
  const double n = static_cast<double>(points.size());
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (const Eigen::Vector2d& p : points) {
    x += p.x();
    y += p.y();
    xx += p.x() * p.x();
    xy += p.x() * p.y();
    yy += p.y() * p.y();
  }
  return 0.5 * std::atan2(2.0 * (n * xy - x * y), (n * xx - x * x) - (n * yy - y * y));
}

void surface_frame(std::span<const double> x, Tally& tally) {
  const double tilt = x[0] / 180.0 * kPi, span = x[1], offset = x[2], noise = x[3];
  std::vector<Eigen::Vector2d> points;
  for (const double along : {-0.5, -0.31, 0.27, 0.5}) {
    const double across = noise * (along < 0.0 ? 0.4 - along : along - 0.7);
    points.push_back({offset + span * along * std::cos(tilt) - across * std::sin(tilt),
                      offset + span * along * std::sin(tilt) + across * std::cos(tilt)});
  }
  const double px_per_m = 4000.0;
  const geometry::SurfaceFrame got{*geometry::fit_line(points), px_per_m};
  const WideLine want = line_through(points);
  const double plain = textbook_tilt(points);
  compare(tally, "sine of the tilt", got.line.tilt.sin(), std::sin(plain), want.sine, 1);
  compare(tally, "cosine of the tilt", got.line.tilt.cos(), std::cos(plain), want.cosine, 1);
  // A ball's centre half a span above the line.
  const Eigen::Vector2d ball{offset + 0.2 * span, offset + 0.5 * span};
  const Wide height = ((ball.y() - want.y0) * want.cosine - (ball.x() - want.x0) * want.sine) / px_per_m;
  compare(tally, "height of a point", got.from_image(ball).y(), {}, height, Wide(span) / px_per_m);
}

template <typename T>
struct Readouts {
  T e, mu, angle, speed, dwell;
};

/// The readout's formulas. `height` over the touchdown's, falling at vy under gravity g.
template <typename T>
Readouts<T> readouts(const std::array<T, 5>& v, double g) {
  const T &vx_td = v[0], &vy_td = v[1], &vx_lo = v[2], &vy_lo = v[3], &height = v[4];
  const T there = T(0.0) - sqrt(vy_td * vy_td + 2.0 * (height * g));
  return {T(0.0) - vy_lo / vy_td, (vx_td - vx_lo) / (vy_lo - vy_td), atan2(vy_td, vx_td), hypot(vx_td, vy_td),
          T(0.0) - 2.0 * height / (vy_td + there)};
}

void derivatives(std::span<const double> x, Tally& tally) {
  const double angle = x[1] / 180.0 * kPi, vx = x[0] * std::cos(angle), vy = -x[0] * std::sin(angle);
  const std::array<double, 5> values{vx, vy, vx * x[2], -vy * x[3], x[4] * vy * vy};
  const double g = 9.80665;
  std::array<reduction::Dual<5>, 5> dual;
  std::array<Wide, 5> wide;
  for (std::size_t i = 0; i < 5; ++i) {
    dual[i] = reduction::Dual<5>::variable(values[i], i);
    wide[i] = values[i];
  }
  const auto got = readouts(dual, g);
  const auto want = readouts(wide, g);
  const std::array<const reduction::Dual<5>*, 5> numbers{&got.e, &got.mu, &got.angle, &got.speed, &got.dwell};
  const std::array<const Wide*, 5> wanted{&want.e, &want.mu, &want.angle, &want.speed, &want.dwell};
  const std::array<const char*, 5> names{"e", "mu", "angle", "speed", "time"};
  const Wide mu_scale = (abs(wide[0]) + abs(wide[2])) / (wide[3] - wide[1]);
  for (std::size_t k = 0; k < 5; ++k)
    compare(tally, names[k], numbers[k]->value, {}, *wanted[k], k == 1 ? mu_scale : Wide(0));
  for (std::size_t i = 0; i < 5; ++i) {
    // Central differences over 1e-14 of the argument: 1e-28 of error.
    if (wide[i] == 0) continue;
    const Wide h = abs(wide[i]) * Wide(1e-14);
    auto up = wide, down = wide;
    up[i] += h;
    down[i] -= h;
    const auto above = readouts(up, g), below = readouts(down, g);
    const std::array<Wide, 5> slopes{
        (above.e - below.e) / (2 * h), (above.mu - below.mu) / (2 * h), (above.angle - below.angle) / (2 * h),
        (above.speed - below.speed) / (2 * h), (above.dwell - below.dwell) / (2 * h)};
    for (std::size_t k = 0; k < 5; ++k) {
      // A slope's natural scale: the number over the argument.
      const Wide scale = (k == 1 ? mu_scale : Wide(abs(*wanted[k]))) / abs(wide[i]);
      compare(tally, std::string("slopes of ") + names[k], numbers[k]->grad[i], {}, slopes[k], scale);
    }
  }
}

void court_pace(std::span<const double> x, Tally& tally) {
  const Wide e_23 = Wide(x[0]) + Wide("0.003") * (23 - Wide(x[2]));
  compare(tally, "rating", reduction::court_pace_rating(x[0], x[1], x[2]), {},
          100 * (1 - Wide(x[1])) + 150 * (Wide("0.81") - e_23), 100 * (1 + Wide(x[1])));
}

}  // namespace

std::vector<Form> reduction_forms() {
  return {
      {"surface frame",
       "1; heights: the line's length",
       "differences to a point of the line, then their mean",
       {either_sign("tilt_deg", 1e-6, 89.0), logarithmic("span_px", 100.0, 1e4),
        either_sign("offset_px", 1.0, 1e7, {1e7, -1e7}), logarithmic("noise_px", 1e-3, 3.0)},
       surface_frame},
      {"readouts and their slopes",
       "itself; mu: (|vx_td| + |vx_lo|)/J; slopes: that over the argument",
       "exact slopes by dual numbers, no differences",
       {logarithmic("speed_mps", 1e-6, 1e3), logarithmic("angle_deg", 0.01, 89.99),
        even("vx_lo/vx_td", -0.5, 1.5), logarithmic("e", 1e-3, 1.0), logarithmic("height*1/vy2", 1e-9, 1.0)},
       derivatives},
      {"court pace",
       "100·(1 + mu)",
       "",
       {unit_interval("e"), logarithmic("mu", 1e-6, 10.0), even("temperature_degC", -20.0, 60.0)},
       court_pace},
  };
}

}  // namespace strobe::numerics
