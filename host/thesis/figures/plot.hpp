// A figure as data: panels of series, measured or computed, in two dimensions. Plain values.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace strobe::report {

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

struct Series {
  std::string name;    ///< in the data file, e.g. "zero_23 integration exact"
  std::string legend;  ///< empty: not in the legend
  Stroke stroke = Stroke::solid;
  std::string colour;  ///< "#rrggbb"
  int symbol = 7;      ///< gnuplot's point type, for points
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
};

struct Figure {
  int number = 0;
  std::string title;
  std::string caption;  ///< what points, bars and bands mean
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

}  // namespace strobe::report
