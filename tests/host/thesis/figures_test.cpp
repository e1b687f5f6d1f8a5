#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "host/thesis/figures/figures.hpp"
#include "host/thesis/figures/gnuplot.hpp"
#include "tests/host/thesis/loaded_thesis.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::report;
using strobe::testing::loaded_thesis;
using strobe::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::vector<Figure> figures_of(const std::vector<std::string>& sets) {
  const auto all = figures(loaded_thesis(thesis::Version::corrected), sets);
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

Figure simple() {
  Figure figure{.number = 4, .title = "Bob's ball", .caption = "c"};
  figure.panels = {
      {.title = "t",
       .x_label = "x, m",
       .y_label = "y, m",
       .series = {{.name = "a, b",
                   .legend = "a",
                   .stroke = Stroke::points,
                   .colour = "#000000",
                   .points = {{0.1, 0.2, 0.15, 0.25}}},
                  {.name = "line", .legend = "l", .colour = "#000000", .points = {{0, 0}, {1, 1}}}}}};
  return figure;
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

TEST_GROUP(Gnuplot) { TemporaryFolder folder; };

TEST(Gnuplot, IsGivenDataInColumnsAndTextInQuotes) {
  const Figure figure = simple();
  CHECK_EQUAL("series,x,y,low,high\na; b,0.1,0.2,0.15,0.25\n\n\nline,0,0,,\nline,1,1,,\n", csv_text(figure));
  CHECK(script_text(figure).find("'Figure 4. Bob''s ball'") != std::string::npos);
}

TEST(Gnuplot, DrawsSvgAndPngAndLeavesDataAndScriptBesideThem) {
  const auto gnuplot = find_gnuplot();
  CHECK_TEXT(gnuplot.has_value(), gnuplot ? "" : gnuplot.error().message.c_str());
  const auto drawn = draw(simple(), folder / "new" / "folder", *gnuplot);
  CHECK_TEXT(drawn.has_value(), drawn ? "" : drawn.error().message.c_str());
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder / "new" / "folder"))
    names.insert(entry.path().filename().string());
  CHECK_EQUAL((std::set<std::string>{"figure_04.csv", "figure_04.gp", "figure_04.png", "figure_04.svg"}),
              names);
}

TEST(Gnuplot, ThatFailsLeavesNothing) {
  const auto drawn = draw(simple(), folder / "out", "/bin/false");
  CHECK_FALSE(drawn.has_value());
  CHECK(drawn.error().message.find("figure_04.gp") != std::string::npos);
  CHECK(fs::is_empty(folder / "out"));
}

TEST(Gnuplot, ThatDrawsNothingIsNoticed) {
  const auto drawn = draw(simple(), folder / "out", "/bin/true");
  CHECK_EQUAL("gnuplot did not finish figure_04.svg: no message", drawn.error().message);
  CHECK(fs::is_empty(folder / "out"));
}

TEST(Gnuplot, NeedsAFolder) {
  strobe::testing::write_text(folder / "file", "");
  const auto drawn = draw(simple(), folder / "file" / "inside", "/bin/true");
  CHECK(drawn.error().message.find("inside: cannot be made") != std::string::npos);
}
