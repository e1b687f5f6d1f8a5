// A figure as data: panels of series, measured or computed, in two dimensions; and the same with its axes,
// ready to be drawn: every number that the drawing shows is in it. Pure; thread-safe.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace strobe::figures {

inline constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

/// low and high: the error bar of a measured point, or the edges of a band; NaN where there is none.
struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
  double low = kNoValue;
  double high = kNoValue;
};

/// Measured values are points, computed ones lines; a line with low and high has a band beneath it.
enum class Stroke { points, solid, dashed, dotted, dash_dotted };

/// Of points: filled, or open.
enum class Symbol { circle, square, triangle, open_circle, open_square, open_triangle };
constexpr Symbol open_symbol(Symbol filled) { return static_cast<Symbol>(static_cast<int>(filled) + 3); }

struct Series {
  std::string name;    ///< in the data file, e.g. "zero_23 integration exact"
  std::string legend;  ///< empty: not in the legend
  Stroke stroke = Stroke::solid;
  std::string colour;              ///< "#rrggbb"
  Symbol symbol = Symbol::circle;  ///< of points
  std::vector<PlotPoint> points{};
};

struct Panel {
  std::string title{};
  std::string x_label{};
  std::string y_label{};
  std::vector<Series> series{};
  std::optional<std::pair<double, double>> x_range{};
  std::optional<std::pair<double, double>> y_range{};
  bool zero_line = false;
  bool log_x = false, log_y = false;  ///< logarithmic; values that are not positive are left out
};

struct Figure {
  int number = 0;
  std::string title{};
  std::string caption{};  ///< what points, bars and bands mean
  int columns = 1;
  std::vector<Panel> panels{};
  int legend_columns = 3;
};

/// One colour for each spin and method, distinguishable by the colour-blind (M. Okabe and K. Ito).
namespace colours {
inline constexpr const char* kZero = "#0072B2";
inline constexpr const char* kTop = "#D55E00";
inline constexpr const char* kBack = "#009E73";
inline constexpr const char* kMeasured = "#222222";
inline constexpr const char* kCubic = "#E69F00";
inline constexpr const char* kConstrained = "#CC79A7";
inline constexpr const char* kIntegration = "#0072B2";
inline constexpr const char* kMechanics = "#009E73";
}  // namespace colours

struct Tick {
  double at = 0.0;
  std::string text;
};

struct Axis {
  double low = 0.0;  ///< low < high, both finite
  double high = 1.0;
  std::vector<Tick> ticks{};  ///< ascending, within
  bool logarithmic = false;   ///< low > 0

  /// Where the value stands: 0 at `low`, 1 at `high`.
  double position(double value) const;
};

struct ChartPanel {
  Panel panel;
  Axis x, y;
  bool is_empty = false;  ///< nothing to draw
};

struct Chart {
  std::string key;
  std::string title;
  std::string caption;
  int columns = 1;         ///< of panels, 1 to 4
  int legend_columns = 3;  ///< at least 1
  std::vector<ChartPanel> panels;
};

/// Room for all values, with ticks at round numbers; where they are all equal, some about them. Values that
/// are not finite, or beyond 1e100 either way, are left out; without any it is 0 to 1.
Axis axis_for(const std::vector<double>& values);

/// The same limits, kept as they are; low < high, both finite.
Axis axis_between(double low, double high);

/// Likewise a logarithmic one, with ticks at powers of ten, or at 1, 2 and 5 times those where there are few.
/// Values must be positive, too; without any it is 0.1 to 1.
Axis log_axis_for(const std::vector<double>& values);

/// Axes by what the panels hold, or the ranges that they state. A panel with names has these as x ticks, at
/// 1, 2, 3 ...
Chart make_chart(std::string key, Figure figure, const std::vector<std::string>& x_names = {});

}  // namespace strobe::figures
