#include <cmath>
#include <string>

#include "host/thesis/figures.hpp"
#include "tests/host/thesis/loaded_thesis.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::thesis;
using namespace strobe::figures;
using strobe::testing::loaded_thesis;

namespace {

std::vector<Figure> figures_of(const std::vector<std::string>& sets) {
  const auto all = make_figures(loaded_thesis(thesis::Version::corrected), sets);
  CHECK_TEXT(all.has_value(), all ? "" : all.error().message.c_str());
  return *all;
}

std::vector<std::string> main_sets() { return {std::begin(kMainSets), std::end(kMainSets)}; }

void check_whole(const Figure& figure) {
  const std::string at = "figure " + std::to_string(figure.number);
  CHECK_TEXT(!figure.title.empty() && !figure.caption.empty() && !figure.panels.empty(), at.c_str());
  for (const Panel& panel : figure.panels) {
    for (const std::string& label : {panel.x_label, panel.y_label})
      CHECK_TEXT(label.find(", ") != std::string::npos, (at + ": no unit in " + label).c_str());
    CHECK_TEXT(!panel.series.empty(), at.c_str());
    for (const Series& s : panel.series) {
      CHECK_TEXT(!s.points.empty(), (at + ": " + s.name).c_str());
      for (const PlotPoint& p : s.points) {
        CHECK_TEXT(std::isfinite(p.x) && std::isfinite(p.y), (at + ": " + s.name).c_str());
        CHECK_TEXT(std::isnan(p.low) || (p.low <= p.y && p.y <= p.high), (at + ": " + s.name).c_str());
      }
    }
  }
}

}  // namespace

TEST_GROUP(ThesisFigures){};

TEST(ThesisFigures, AreFourteenNumbered4To17) {
  int expected = kFirstFigure;
  for (const Figure& figure : figures_of(main_sets())) LONGS_EQUAL(expected++, figure.number);
  LONGS_EQUAL(kLastFigure + 1, expected);
}

TEST(ThesisFigures, HaveUnitsAndFiniteValuesWithinTheirBands) {
  for (const Figure& figure : figures_of(main_sets())) check_whole(figure);
}

TEST(ThesisFigures, CanBeHadOfEverySet) {
  for (const auto& c : loaded_thesis(thesis::Version::corrected).used.conditions) {
    const std::vector<Figure> all = figures_of({c.name()});
    LONGS_EQUAL(kLastFigure - kFirstFigure + 1, all.size());
    for (const Figure& figure : all) check_whole(figure);
  }
}

// What is measured can be told from what is computed: points have names of their own, and only they are
// points.
TEST(ThesisFigures, ShowMeasuredValuesAsPointsAndComputedOnesAsLines) {
  for (const Figure& figure : figures_of(main_sets())) {
    if (figure.number == 17) continue;  // computed against measured: all are points
    for (const Panel& panel : figure.panels)
      for (const Series& s : panel.series) {
        const bool measured =
            s.name.find("measured") != std::string::npos || s.name.find("images") != std::string::npos;
        CHECK_TEXT(measured == (s.stroke == Stroke::points), s.name.c_str());
      }
  }
}

// The integrated distance of the thesis's form ends at (vx_TD - mu |vy_TD|) dwell.
TEST(ThesisFigures, DrawTheDistanceThatTheClosedFormGives) {
  const auto& c = *loaded_thesis(thesis::Version::corrected).used.condition("zero_23");
  const double expected_cm =
      1e2 * (c.vx_td_mps.mean + c.mu.mean * c.vy_td_mps.mean) * c.dwell_time_ms.mean / 1e3;
  int drawn = 0;
  for (const Figure& figure : figures_of({"zero_23"})) {
    if (figure.number != 10) continue;
    for (const Series& s : figure.panels.at(0).series) {
      if (s.name != "zero_23 simplified") continue;
      DOUBLES_EQUAL(expected_cm, s.points.back().y, 1e-9);
      ++drawn;
    }
  }
  LONGS_EQUAL(1, drawn);
}
