#include <fmt/format.h>

#include <cmath>

#include "common/flight/parabola.hpp"
#include "common/units/angles.hpp"
#include "host/design/design_view.hpp"
#include "host/figures/svg.hpp"
#include "host/session/shot_table.hpp"

namespace strobe::host {
namespace {

using figures::Figure;
using figures::Panel;
using Curve = figures::Series;
using figures::Stroke;
using reduction::Quantity;

constexpr int kMaxBalls = 60;
constexpr double kEllipseShown = 100.0;
// Width over height of a figure's only panel in a row (host/figures/svg.cpp).
constexpr double kPanelAspect = 3.14;
constexpr std::array kColours{figures::colours::kZero, figures::colours::kTop, figures::colours::kBack,
                              figures::colours::kCubic, figures::colours::kConstrained};

std::string words_of(Quantity q) {
  const QuantityLabel& label = kQuantityLabels[static_cast<std::size_t>(q)];
  return std::string(label.words) + (label.unit.empty() ? "" : ", " + std::string(label.unit));
}

/// A closed curve about a point.
Curve ring(const reduction::PointPx& centre, double a_px, double b_px, std::string name, const char* colour) {
  constexpr int kCorners = 48;
  Curve s{std::move(name), "", Stroke::solid, colour};
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    s.points.push_back({centre.x + a_px * std::cos(angle), centre.y + b_px * std::sin(angle)});
  }
  return s;
}

/// One scale for both axes, from the photograph's lower edge to the highest image.
void set_view(const SetUp& s, const reduction::Frame& frame, Panel& panel) {
  double top_px = s.surface_y_px;
  for (const reduction::BallImage& image : frame.images)
    top_px = std::max(top_px, image.centre_px.y + image.diameter_px);
  const double height_px = std::max(top_px, s.width_px / kPanelAspect);
  const double beside_px = 0.5 * (height_px * kPanelAspect - s.width_px);
  panel.x_range = {-beside_px, s.width_px + beside_px};
  panel.y_range = {0.0, height_px};
  Curve edges{"photograph", "", Stroke::dotted, figures::colours::kMeasured};
  const double seen_px = std::min(s.height_px, height_px);
  for (const auto& [x, y] : {std::pair{0.0, seen_px}, {0.0, 0.0}, {s.width_px, 0.0}, {s.width_px, seen_px}})
    edges.points.push_back({x, y});
  panel.series.push_back(std::move(edges));
}

/// Where the images of the mean ball will lie.
Result<Figure> images_figure(const DesignReport& report, const PlanFile& plan, const std::string& title) {
  const SetUp& s = report.design.set_up;
  const ExpectedBall& ball = report.design.ball;
  const auto course = BallCourse::make(ball, {}, flight::gravity_mps2(s.surface_angle_rad));
  if (!course) return tl::unexpected(course.error());
  const ExpectedShot shot = expected_shot(*course, {}, expected_train(plan.shot(), s, ball), ball, s);
  Panel panel{.title = title, .x_label = "x, px", .y_label = "y, px"};
  set_view(s, shot.frame, panel);
  for (const reduction::BallImage& image : shot.frame.images) {
    const double radius_px = 0.5 * image.diameter_px;
    const char* colour = image.leg == Leg::incoming ? figures::colours::kZero : figures::colours::kTop;
    panel.series.push_back(ring(image.centre_px, radius_px, radius_px, "image", colour));
    const auto& cov = *image.centre_cov_px2;
    panel.series.push_back(ring(image.centre_px, kEllipseShown * std::sqrt(cov[0]),
                                kEllipseShown * std::sqrt(cov[3]), "centre", figures::colours::kMeasured));
  }
  Curve surface{"surface", "", Stroke::dashed, figures::colours::kMeasured};
  for (const reduction::PointPx& p : shot.frame.surface_px) surface.points.push_back({p.x, p.y});
  panel.series.push_back(std::move(surface));
  Figure figure{.title = "Where the images of the mean ball will lie"};
  figure.caption = fmt::format(
      "Outlines before (blue) and after the bounce; the centres' standard ellipses {:.0f} times "
      "as large as they will be.",
      kEllipseShown);
  figure.panels.push_back(std::move(panel));
  return figure;
}

/// Half width of each mean's interval over its value at the design, by one thing that is varied.
template <typename DesignAt>
Result<Panel> panel_of(const DesignReport& report, bool legend, const std::string& x_label,
                       const std::vector<double>& places, const DesignAt& design_at) {
  Panel panel{.x_label = x_label, .y_label = "± 95 %, over this design's"};
  for (std::size_t k = 0; k < report.quantities.size(); ++k)
    panel.series.push_back({words_of(report.quantities[k]), legend ? words_of(report.quantities[k]) : "",
                            Stroke::solid, kColours[k % kColours.size()]});
  for (const double at : places) {
    const Design design = design_at(at);
    if (plan_problem(design.plan.shot(), design.set_up.limits)) continue;
    const auto p = predict(design, {.balls = 32, .budgets = 4, .match = false});
    if (!p) return tl::unexpected(p.error());
    for (std::size_t k = 0; k < report.quantities.size(); ++k) {
      const auto &then = p->of(report.quantities[k]), &now = report.prediction.of(report.quantities[k]);
      if (then && now && p->readable_share() > 0.5)
        panel.series[k].points.push_back(
            {at, then->expanded(design.shots) / now->expanded(report.design.shots)});
    }
  }
  return panel;
}

std::vector<double> geometric(double from, double to, int count) {
  std::vector<double> places;
  for (int i = 0; i < count; ++i)
    places.push_back(from * std::pow(to / from, static_cast<double>(i) / (count - 1)));
  return places;
}

Result<Figure> uncertainty_figure(const DesignReport& report) {
  Figure figure{.title = "What the uncertainty depends on"};
  figure.caption =
      "One thing is varied, the rest is as in this design; no point where half of the balls cannot be read.";
  figure.columns = 3;
  std::vector<double> balls;
  for (int n = 4; n <= kMaxBalls; n += n < 12 ? 1 : 4) balls.push_back(n);
  const auto by_balls = panel_of(report, true, "balls", balls, [&](double n) {
    Design design = report.design;
    design.shots = static_cast<int>(n);
    return design;
  });
  const double period_ms = 1e3 * to_seconds(report.design.plan.even.period);
  const auto by_period = panel_of(report, false, "flash period, ms, even",
                                  geometric(0.4 * period_ms, 3.0 * period_ms, 24), [&](double ms) {
                                    Design design = report.design;
                                    design.plan.intervals.clear();
                                    design.plan.even.period = microseconds{std::llround(1e3 * ms)};
                                    return design;
                                  });
  const double scale = report.design.set_up.px_per_m;
  const auto by_scale = panel_of(report, false, "scale, px/m, on this sensor",
                                 geometric(0.4 * scale, 2.5 * scale, 24), [&](double px_per_m) {
                                   Design design = report.design;
                                   design.set_up = with_lens(design.set_up, px_per_m / scale);
                                   return design;
                                 });
  for (const auto* panel : {&by_balls, &by_period, &by_scale}) {
    if (!*panel) return tl::unexpected(panel->error());
    figure.panels.push_back(**panel);
  }
  return figure;
}

}  // namespace

Result<void> write_design_figures(const DesignReport& report, const std::filesystem::path& folder) {
  auto images = images_figure(report, report.design.plan, "as it is");
  if (!images) return tl::unexpected(images.error());
  if (report.best && report.best->remark.empty()) {
    auto best = images_figure(report, report.best->plan, "best train");
    if (!best) return tl::unexpected(best.error());
    images->panels.push_back(std::move(best->panels.front()));
  }
  if (auto written = figures::write_figure(*images, folder, "images"); !written) return written;
  if (report.prediction.readable == 0) return {};
  const auto uncertainty = uncertainty_figure(report);
  if (!uncertainty) return tl::unexpected(uncertainty.error());
  return figures::write_figure(*uncertainty, folder, "uncertainty");
}

}  // namespace strobe::host
