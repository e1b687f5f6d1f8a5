// The data file and the script of a figure.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "host/thesis/figures/gnuplot.hpp"

namespace strobe::report {

namespace {

// Pixels of the SVG; the PNG has kPngScale times as many.
constexpr int kPanelHeights[] = {500, 390, 330};  // by the number of rows
constexpr int kTop = 64;
constexpr int kLegendLine = 24;
constexpr int kLeft = 88;
constexpr int kRight = 24;
constexpr int kBelowPanel = 62;
constexpr int kAbovePanel = 30;
constexpr double kPngScale = 1.6;

std::string number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); }

/// Within single quotes gnuplot takes everything literally but the quote itself.
std::string literal(std::string_view text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

bool has_band(const Series& s) {
  return s.stroke != Stroke::points && !s.points.empty() && std::isfinite(s.points.front().low);
}

bool has_bars(const Series& s) {
  return s.stroke == Stroke::points && !s.points.empty() && std::isfinite(s.points.front().low);
}

int dash_type(Stroke stroke) {
  switch (stroke) {
    case Stroke::dashed:
      return 2;
    case Stroke::dotted:
      return 3;
    case Stroke::dash_dotted:
      return 4;
    default:
      return 1;
  }
}

std::string style(const Series& s) {
  if (s.stroke == Stroke::points)
    return fmt::format("{} pt {} ps 1.0 lw 1.2 lc rgb {}", has_bars(s) ? "with yerrorbars" : "with points",
                       s.symbol, literal(s.colour));
  return fmt::format("with lines lw 2.2 dt {} lc rgb {}", dash_type(s.stroke), literal(s.colour));
}

struct Place {
  int width;
  int height;
  int legend;
  int panel_height;
};

Place place_of(const Figure& figure) {
  const int panels = static_cast<int>(figure.panels.size());
  const int rows = (panels + figure.columns - 1) / figure.columns;
  int entries = 0;
  for (const Panel& panel : figure.panels)
    for (const Series& s : panel.series) entries += s.legend.empty() ? 0 : 1;
  const int lines = (entries + figure.legend_columns - 1) / figure.legend_columns;
  const int panel_height = kPanelHeights[std::min(rows, 3) - 1];
  const int width = figure.columns >= 3 ? 1320 : 1000;
  const int legend = lines * kLegendLine + 16;
  return {width, kTop + rows * panel_height + legend, legend, panel_height};
}

std::string range(const std::optional<std::pair<double, double>>& r) {
  return r ? fmt::format("[{}:{}]", r->first, r->second) : "[*:*]";
}

std::string panel_text(const Figure& figure, std::size_t i, const Place& place, int& index) {
  const Panel& panel = figure.panels[i];
  const int column = static_cast<int>(i) % figure.columns;
  const int row = static_cast<int>(i) / figure.columns;
  const double width = static_cast<double>(place.width) / figure.columns;
  const double height = place.height;
  const double top = 1.0 - (kTop + row * place.panel_height + kAbovePanel) / height;
  const double bottom = 1.0 - (kTop + (row + 1) * place.panel_height - kBelowPanel) / height;
  std::string out = "\n";
  out += fmt::format("set lmargin at screen {:.4f}; set rmargin at screen {:.4f}\n",
                     (column * width + kLeft) / place.width, ((column + 1) * width - kRight) / place.width);
  out += fmt::format("set tmargin at screen {:.4f}; set bmargin at screen {:.4f}\n", top, bottom);
  out += fmt::format("set title {} offset 0,-0.5\n", literal(panel.title));
  out += fmt::format("set xlabel {}\nset ylabel {}\n", literal(panel.x_label), literal(panel.y_label));
  out += fmt::format("set xrange {}\nset yrange {}\n", range(panel.x_range), range(panel.y_range));
  out += panel.zero_line ? "set xzeroaxis lt 1 lw 1 lc rgb '#888888'\n" : "unset xzeroaxis\n";
  // Bands under lines, lines under points.
  std::string bands;
  std::string lines;
  std::string points;
  for (const Series& s : panel.series) {
    const std::string source = fmt::format("data index {} using ", index++);
    if (has_band(s))
      bands += fmt::format("  {}2:4:5 with filledcurves fs transparent solid 0.16 noborder fc rgb {}, \\\n",
                           source, literal(s.colour));
    std::string& strokes = s.stroke == Stroke::points ? points : lines;
    strokes += fmt::format("  {}{} {}, \\\n", source, has_bars(s) ? "2:3:4:5" : "2:3", style(s));
  }
  std::string plots = bands + lines + points;
  plots.erase(plots.rfind(", \\"));
  return out + "plot \\\n" + plots + "\n";
}

std::string legend_text(const Figure& figure, const Place& place) {
  std::string entries;
  for (const Panel& panel : figure.panels)
    for (const Series& s : panel.series)
      if (!s.legend.empty())
        entries += fmt::format(", \\\n  keyentry {} title {}", style(s), literal(s.legend));
  if (entries.empty()) return {};
  std::string out = "\nunset title; unset xlabel; unset ylabel; unset xtics; unset ytics; unset border\n";
  out += "unset xzeroaxis; unset grid\n";
  out += fmt::format(
      "set lmargin at screen 0; set rmargin at screen 1; set bmargin at screen 0; set tmargin at screen "
      "{:.4f}\n",
      static_cast<double>(place.legend) / place.height);
  out += fmt::format("set key center center horizontal maxcols {} samplen 3 spacing 1.15 width 1\n",
                     figure.legend_columns);
  return out + "set xrange [0:1]; set yrange [0:1]\nplot NaN notitle" + entries + "\nunset key\n";
}

}  // namespace

std::string file_stem(const Figure& figure) { return fmt::format("figure_{:02}", figure.number); }

std::string csv_text(const Figure& figure) {
  const auto name_of = [](const Series& s) {
    std::string name = s.name;
    std::replace(name.begin(), name.end(), ',', ';');
    return name;
  };
  std::string out = "series,x,y,low,high\n";
  bool first = true;
  for (const Panel& panel : figure.panels) {
    for (const Series& s : panel.series) {
      if (!first) out += "\n\n";
      first = false;
      for (const PlotPoint& p : s.points)
        out += fmt::format("{},{},{},{},{}\n", name_of(s), number(p.x), number(p.y), number(p.low),
                           number(p.high));
    }
  }
  return out;
}

std::string script_text(const Figure& figure) {
  const Place place = place_of(figure);
  const std::string stem = file_stem(figure);
  std::string out = fmt::format("# Figure {}. {}\n# {}\n# To draw it again: gnuplot {}.gp\n", figure.number,
                                figure.title, figure.caption, stem);
  out += fmt::format("data = '{}.csv'\n", stem);
  out += "do for [kind in 'svg png'] {\nreset\nset datafile separator ','\nset encoding utf8\n";
  out += fmt::format(
      "if (kind eq 'svg') {{ set terminal svg size {},{} font 'sans-serif,15' background '#ffffff'; small = "
      "',12' }}\n",
      place.width, place.height);
  out += fmt::format(
      "if (kind eq 'png') {{ set terminal pngcairo size {},{} font 'sans,11' fontscale {} linewidth {} "
      "pointscale {} background '#ffffff'; small = ',9' }}\n",
      std::lround(place.width * kPngScale), std::lround(place.height * kPngScale), kPngScale, kPngScale,
      kPngScale);
  out += fmt::format("set output '{}.'.kind\nset multiplot\n", stem);
  out += "set border 3 lc rgb '#444444'; set tics nomirror out; set grid lt 1 lw 0.6 lc rgb '#dddddd'\n";
  out += "unset key; set xtics; set ytics\n";
  out += fmt::format("set label 1 {} at screen 0.02, screen {:.4f} left front\n",
                     literal(fmt::format("Figure {}. {}", figure.number, figure.title)),
                     1.0 - 22.0 / place.height);
  out += fmt::format(
      "set label 2 {} at screen 0.02, screen {:.4f} left front font small textcolor rgb "
      "'#555555'\n",
      literal(figure.caption), 1.0 - 48.0 / place.height);
  int index = 0;
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    out += panel_text(figure, i, place, index);
    if (i == 0) out += "unset label 1; unset label 2\n";
  }
  out += legend_text(figure, place);
  return out + "unset multiplot\nset output\n}\n";
}

}  // namespace strobe::report
