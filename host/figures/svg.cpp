#include "host/figures/svg.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "common/config/files.hpp"
#include "host/figures/escape.hpp"

namespace strobe::figures {

namespace {

// In units of the drawing, whose width is the page's.
constexpr double kWidth = 720.0;
constexpr double kLeft = 54.0;
constexpr double kRight = 12.0;
constexpr double kTop = 22.0;
constexpr double kBottom = 40.0;
constexpr double kLegendLine = 17.0;
constexpr double kMark = 3.2;     // half the size of a mark
constexpr double kLetter = 0.62;  // width of a letter, on average, over the font's size

double panel_height(int columns) { return columns == 1 ? 270.0 : columns == 2 ? 235.0 : 146.0; }

struct Frame {
  double left, top, right, bottom;
  const Axis& x;
  const Axis& y;

  double at_x(double value) const { return left + x.position(value) * (right - left); }
  double at_y(double value) const { return bottom - y.position(value) * (bottom - top); }
  bool holds(const PlotPoint& p) const {
    const double slack_x = 1e-9 * (x.high - x.low), slack_y = 1e-9 * (y.high - y.low);
    return p.x >= x.low - slack_x && p.x <= x.high + slack_x && p.y >= y.low - slack_y &&
           p.y <= y.high + slack_y;  // false for NaN
  }
  double clamped_y(double value) const { return at_y(std::clamp(value, y.low, y.high)); }
};

std::string line(double x1, double y1, double x2, double y2, const char* stroke, double width) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
      "stroke-width=\"{}\"/>\n",
      x1, y1, x2, y2, stroke, width);
}

std::string text(double x, double y, const char* anchor, double size, const std::string& words,
                 const std::string& more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{}\"{}>{}</text>\n", x,
                     y, anchor, size, more, escaped(words));
}

const char* dashes(Stroke stroke) {
  switch (stroke) {
    case Stroke::dashed:
      return " stroke-dasharray=\"6 3\"";
    case Stroke::dotted:
      return " stroke-dasharray=\"1.5 2.5\"";
    case Stroke::dash_dotted:
      return " stroke-dasharray=\"7 3 1.5 3\"";
    default:
      return "";
  }
}

std::string mark(double x, double y, Symbol symbol, const std::string& colour) {
  const bool is_open = symbol >= Symbol::open_circle;
  const std::string paint =
      fmt::format("fill=\"{}\" stroke=\"{}\" stroke-width=\"1\"", is_open ? "#ffffff" : colour, colour);
  const double s = kMark;
  if (symbol == Symbol::square || symbol == Symbol::open_square)
    return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" {}/>\n", x - s, y - s,
                       2 * s, 2 * s, paint);
  if (symbol == Symbol::triangle || symbol == Symbol::open_triangle)
    return fmt::format("<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}Z\" {}/>\n", x, y - s * 1.2,
                       x + s * 1.1, y + s, x - s * 1.1, y + s, paint);
  return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" {}/>\n", x, y, s, paint);
}

std::string points_of(const Series& series, const Frame& frame) {
  std::string out;
  for (const PlotPoint& p : series.points) {
    if (!frame.holds(p)) continue;
    const double x = frame.at_x(p.x);
    if (std::isfinite(p.low) && std::isfinite(p.high))
      out += line(x, frame.clamped_y(p.low), x, frame.clamped_y(p.high), series.colour.c_str(), 1.0);
    out += mark(x, frame.at_y(p.y), series.symbol, series.colour);
  }
  return out;
}

std::string curve_of(const Series& series, const Frame& frame) {
  std::string path;
  bool begun = false;
  for (const PlotPoint& p : series.points) {
    const bool inside = frame.holds(p);
    if (inside) path += fmt::format("{}{:.1f} {:.1f}", begun ? "L" : "M", frame.at_x(p.x), frame.at_y(p.y));
    begun = inside;
  }
  if (path.empty()) return {};
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"{}/>\n", path,
                     series.colour, dashes(series.stroke));
}

std::string band_of(const Series& series, const Frame& frame) {
  std::string there, back;
  for (const PlotPoint& p : series.points) {
    if (!frame.holds(p) || !std::isfinite(p.low) || !std::isfinite(p.high)) continue;
    const double x = frame.at_x(p.x);
    there += fmt::format("{}{:.1f} {:.1f}", there.empty() ? "M" : "L", x, frame.clamped_y(p.high));
    back = fmt::format("L{:.1f} {:.1f}", x, frame.clamped_y(p.low)) + back;
  }
  if (there.empty()) return {};
  return fmt::format("<path d=\"{}{}Z\" fill=\"{}\" fill-opacity=\"0.15\" stroke=\"none\"/>\n", there, back,
                     series.colour);
}

/// Font size and middle of an upright label: about the frame's, but within the panel, and smaller where it is
/// too long for that.
std::pair<double, double> upright_place(const std::string& label, const Frame& frame) {
  const double low = frame.top - kTop + 2.0, high = frame.bottom + kBottom - 2.0;
  const double letters = static_cast<double>(std::max<std::size_t>(1, label.size()));
  const double size = std::min(11.0, (high - low) / (kLetter * letters));
  const double half = 0.5 * kLetter * letters * size;
  return {std::round(10.0 * size) / 10.0,
          std::clamp(0.5 * (frame.top + frame.bottom), low + half, std::max(low + half, high - half))};
}

std::string axes(const ChartPanel& panel, const Frame& frame) {
  std::string out;
  for (const Tick& tick : frame.y.ticks) {
    const double y = frame.at_y(tick.at);
    out += line(frame.left, y, frame.right, y, "#e2e2e2", 0.7);
    out += text(frame.left - 5, y + 3.5, "end", 10, tick.text);
  }
  double free = frame.left - kLeft;  // of labels, which do not overlap
  for (const Tick& tick : frame.x.ticks) {
    const double x = frame.at_x(tick.at);
    out += line(x, frame.bottom, x, frame.bottom + 4, "#444444", 0.8);
    const double half = 0.5 * kLetter * 10.0 * static_cast<double>(tick.text.size());
    if (x - half < free) continue;
    out += text(x, frame.bottom + 15, "middle", 10, tick.text);
    free = x + half + 3.0;
  }
  if (panel.panel.zero_line && frame.y.low < 0.0 && frame.y.high > 0.0)
    out += line(frame.left, frame.at_y(0.0), frame.right, frame.at_y(0.0), "#888888", 0.9);
  out += line(frame.left, frame.bottom, frame.right, frame.bottom, "#444444", 1.0);
  out += line(frame.left, frame.top, frame.left, frame.bottom, "#444444", 1.0);
  out += text(0.5 * (frame.left + frame.right), frame.bottom + 31, "middle", 11, panel.panel.x_label);
  const double at = frame.left - kLeft + 12;
  const auto [size, centre] = upright_place(panel.panel.y_label, frame);
  out += text(at, centre, "middle", size, panel.panel.y_label,
              fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", at, centre));
  if (!panel.panel.title.empty())
    out += text(0.5 * (frame.left + frame.right), frame.top - 8, "middle", 11, panel.panel.title,
                " font-weight=\"bold\"");
  return out;
}

std::string panel_of(const ChartPanel& panel, const Frame& frame) {
  std::string out = axes(panel, frame);
  if (panel.is_empty)
    return out + text(0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom), "middle", 12,
                      "no data", " fill=\"#777777\"");
  std::string curves, points;
  for (const Series& series : panel.panel.series) {
    if (series.stroke == Stroke::points) {
      points += points_of(series, frame);
    } else {
      out += band_of(series, frame);
      curves += curve_of(series, frame);
    }
  }
  return out + curves + points;
}

std::string legend_of(const std::vector<const Series*>& entries, int columns, double top) {
  std::string out;
  const double width = (kWidth - 20.0) / columns;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Series& series = *entries[i];
    const double x = 14.0 + width * static_cast<double>(i % static_cast<std::size_t>(columns));
    const double y = top + kLegendLine * (0.5 + static_cast<double>(i / static_cast<std::size_t>(columns)));
    if (series.stroke == Stroke::points) {
      out += mark(x + 11, y, series.symbol, series.colour);
    } else {
      out += fmt::format(
          "<path d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\" fill=\"none\" stroke=\"{}\" "
          "stroke-width=\"1.6\"{}/>\n",
          x, y, x + 22, y, series.colour, dashes(series.stroke));
    }
    out += text(x + 28, y + 3.5, "start", 10.5, series.legend);
  }
  return out;
}

std::vector<const Series*> legend_entries(std::span<const ChartPanel> panels) {
  std::vector<const Series*> entries;
  for (const ChartPanel& panel : panels)
    for (const Series& series : panel.panel.series)
      if (!series.legend.empty()) entries.push_back(&series);
  return entries;
}

std::size_t panels_in_a_row(const Chart& chart) {
  return std::clamp<std::size_t>(chart.panels.size(), 1,
                                 static_cast<std::size_t>(std::max(1, chart.columns)));
}

std::string drawing_of(const std::string& title, double height, const std::string& content) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1:.0f}\" width=\"{0}\" "
      "height=\"{1:.0f}\" role=\"img\" font-family=\"sans-serif\" fill=\"#222222\" "
      "aria-label=\"{2}\">\n{3}</svg>\n",
      kWidth, height, escaped(title), content);
}

/// Of some of the chart's panels, whole rows. above: room for a title over them, drawn as `head`.
std::string drawing(const Chart& chart, std::span<const ChartPanel> panels,
                    const std::vector<const Series*>& entries, double above, const std::string& head) {
  const std::size_t columns = panels_in_a_row(chart);
  const double width = kWidth / static_cast<double>(columns),
               height = panel_height(static_cast<int>(columns));
  std::string body;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const double x = width * static_cast<double>(i % columns);
    const double y = above + height * static_cast<double>(i / columns);
    const Frame frame{x + kLeft,   y + kTop,   x + width - kRight, y + height - kBottom,
                      panels[i].x, panels[i].y};
    body += panel_of(panels[i], frame);
  }
  const std::size_t rows = (panels.size() + columns - 1) / columns;
  const double below = above + height * static_cast<double>(rows);
  const int legend_columns = std::max(1, chart.legend_columns);
  const auto lines = (entries.size() + static_cast<std::size_t>(legend_columns) - 1) /
                     static_cast<std::size_t>(legend_columns);
  const double total = below + kLegendLine * static_cast<double>(lines) + 4.0;
  return drawing_of(chart.title, total, head + body + legend_of(entries, legend_columns, below));
}

/// From a ball's centre, in its radii, to the drawing's units; y down.
struct BallPlace {
  static constexpr double kRadius = 43.0;
  double x = 0.0, y = 0.0;

  std::string point(const Eigen::Vector3d& v) const {
    return fmt::format("{:.1f} {:.1f}", x + kRadius * v.x(), y - kRadius * v.y());
  }
  std::string path(const std::vector<Eigen::Vector3d>& way, const char* look) const {
    std::string d;
    for (const Eigen::Vector3d& v : way) d += (d.empty() ? "M" : "L") + point(v);
    return fmt::format("<path d=\"{}\" fill=\"none\" {}/>\n", d, look);
  }
  /// A point at the end of an arrow, as the way there is seen; none of a way towards whoever looks.
  std::string head(const Eigen::Vector3d& tip, const Eigen::Vector3d& way, const char* colour) const {
    const Eigen::Vector3d flat(way.x(), way.y(), 0.0);
    if (flat.norm() < 0.05 * way.norm()) return {};
    const Eigen::Vector3d along = 0.2 * flat.normalized(), aside(-0.4 * along.y(), 0.4 * along.x(), 0.0);
    return fmt::format("<path d=\"M{}L{}L{}Z\" fill=\"{}\"/>\n", point(tip + along), point(tip + aside),
                       point(tip - aside), colour);
  }
};

/// The half of the great circle across the axis that is seen, in the direction of the turn.
std::vector<Eigen::Vector3d> seen_turn(const Eigen::Vector3d& axis) {
  constexpr int kSteps = 24;
  const double slant = std::hypot(axis.x(), axis.y());
  const Eigen::Vector3d begin =
      slant > 1e-6 ? Eigen::Vector3d(-axis.y() / slant, axis.x() / slant, 0.0) : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d middle = axis.cross(begin);
  std::vector<Eigen::Vector3d> way;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = std::numbers::pi * i / kSteps;
    way.push_back(std::cos(angle) * begin + std::sin(angle) * middle);
  }
  return way;
}

std::string ball_with_axis(const BallPlace& at, const Eigen::Vector3d& spin) {
  constexpr double kTip = 1.45;
  const char* const kAxis = "stroke=\"#D55E00\" stroke-width=\"2\"";
  const std::string disc =
      fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"#f3f3f3\" stroke=\"#444444\"/>\n",
                  at.x, at.y, BallPlace::kRadius);
  if (!(spin.norm() > 0.0)) return disc;
  const Eigen::Vector3d axis = spin.normalized(), front = axis.z() < 0.0 ? Eigen::Vector3d(-axis) : axis;
  const double hidden = std::min(kTip, 1.0 / std::max(1e-9, std::hypot(front.x(), front.y())));
  const std::string head = at.head(kTip * axis, axis, "#D55E00");
  const bool comes_out = axis.z() >= 0.0;
  std::string out = at.path({Eigen::Vector3d::Zero(), -kTip * front}, kAxis) + (comes_out ? "" : head) + disc;
  const std::vector<Eigen::Vector3d> turn = seen_turn(axis);
  out += at.path(turn, "stroke=\"#0072B2\" stroke-width=\"1.4\"");
  out += at.head(turn[14], turn[15] - turn[13], "#0072B2");
  out += at.path({front, -hidden * front}, "stroke=\"#D55E00\" stroke-width=\"1\" stroke-dasharray=\"3 3\"");
  out += at.path({front, kTip * front}, kAxis) + (comes_out ? head : "");
  if (comes_out)
    return out + at.path({front, front}, "stroke=\"#D55E00\" stroke-width=\"7\" stroke-linecap=\"round\"");
  const Eigen::Vector3d a(0.07, 0.07, 0.0), b(0.07, -0.07, 0.0);
  return out + at.path({front - a, front + a}, kAxis) + at.path({front - b, front + b}, kAxis);
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); }

}  // namespace

std::vector<std::string> svg_rows(const Chart& chart) {
  const std::size_t columns = panels_in_a_row(chart);
  std::vector<std::string> rows;
  for (std::size_t from = 0; from == 0 || from < chart.panels.size(); from += columns) {
    const auto row = std::span(chart.panels).subspan(from, std::min(columns, chart.panels.size() - from));
    const bool last = from + columns >= chart.panels.size();
    rows.push_back(
        drawing(chart, row, last ? legend_entries(chart.panels) : std::vector<const Series*>{}, 0.0, ""));
  }
  return rows;
}

std::string balls_svg(const std::string& title, const std::vector<SpinningBall>& balls) {
  constexpr double kCell = 0.5 * kWidth, kHeight = 150.0, kLine = 17.0;
  std::string body;
  double x = 0.0, y = 0.0;
  for (const SpinningBall& ball : balls) {
    body += ball_with_axis({x + 78.0, y + 75.0}, Eigen::Vector3d(ball.spin.data()));
    double below = y + 34.0;
    for (const std::string& words : ball.lines) {
      body += text(x + 158.0, below, "start", 11.5, words, below > y + 34.0 ? "" : " font-weight=\"bold\"");
      below += kLine;
    }
    x = x > 0.0 ? 0.0 : kCell;
    if (x == 0.0) y += kHeight;
  }
  return drawing_of(title, y + (x > 0.0 ? kHeight : 0.0), body);
}

std::string csv_text(const Figure& figure) {
  std::string out = "series,x,y,low,high\n";
  bool first = true;
  for (const Panel& panel : figure.panels) {
    for (const Series& s : panel.series) {
      if (!first) out += "\n\n";
      first = false;
      std::string name = s.name;
      std::ranges::replace(name, ',', ';');
      for (const PlotPoint& p : s.points)
        out += fmt::format("{},{},{},{},{}\n", name, number(p.x), number(p.y), number(p.low), number(p.high));
    }
  }
  return out;
}

Result<void> write_figure(const Figure& figure, const std::filesystem::path& folder, const std::string& stem,
                          const std::vector<std::string>& x_names) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(folder.string() + ": cannot be made: " + error.message());
  constexpr double kHead = 44.0;
  const std::string title =
      figure.number > 0 ? fmt::format("Figure {}. {}", figure.number, figure.title) : figure.title;
  const std::string head = "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n" +
                           text(12, 18, "start", 13, title, " font-weight=\"bold\"") +
                           text(12, 34, "start", 10, figure.caption, " fill=\"#555555\"");
  if (auto written = config::write_file(folder / (stem + ".csv"), csv_text(figure)); !written) return written;
  const Chart chart = make_chart(stem, figure, x_names);
  return config::write_file(folder / (stem + ".svg"),
                            drawing(chart, chart.panels, legend_entries(chart.panels), kHead, head));
}

}  // namespace strobe::figures
