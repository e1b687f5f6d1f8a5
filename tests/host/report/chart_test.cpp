// Axes, ticks, and drawings of whatever there is to draw.
#include <rapidcheck.h>

#include <regex>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/figures/figure.hpp"
#include "host/figures/svg.hpp"
#include "tests/host/report/parsed_html.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::figures;
using strobe::report_test::parse_html;

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string ticks_of(const Axis& axis) {
  std::string out;
  for (const Tick& tick : axis.ticks) out += (out.empty() ? "" : " ") + tick.text;
  return out;
}

Chart chart_of(std::vector<PlotPoint> points, Stroke stroke = Stroke::points) {
  Panel panel{.x_label = "x", .y_label = "y"};
  panel.series.push_back(
      {.name = "s", .legend = "s", .stroke = stroke, .colour = "#123456", .points = std::move(points)});
  return make_chart("c", {.number = 0, .title = "t", .caption = "", .panels = {panel}});
}

strobe::report_test::ParsedHtml drawn(const Chart& chart) {
  std::string svg = "<div>";
  for (const std::string& row : svg_rows(chart)) svg += row;
  svg += "</div>";
  CHECK_TEXT(svg.find("nan") == svg.npos && svg.find("inf") == svg.npos, svg.c_str());
  auto parsed = parse_html(svg);
  CHECK_TEXT(parsed.well_formed, parsed.problem.c_str());
  return parsed;
}

}  // namespace

TEST_GROUP(ReportAxis){};

TEST(ReportAxis, TicksAreRoundNumbersWithTheDecimalsThatTellThemApart) {
  CHECK_EQUAL(std::string("0.0 0.2 0.4 0.6 0.8 1.0"), ticks_of(axis_between(0.0, 1.0)));
  CHECK_EQUAL(std::string("-20 -10 0 10 20"), ticks_of(axis_between(-23.0, 24.0)));
  CHECK_EQUAL(std::string("15.60 15.62 15.64 15.66 15.68"), ticks_of(axis_between(15.59, 15.69)));
  CHECK_EQUAL(std::string("0 1e+06 2e+06 3e+06 4e+06"), ticks_of(axis_between(-1.0, 4.1e6)));
}

TEST(ReportAxis, HasRoomAboutOneValueAndAboutEqualOnes) {
  for (const auto& values : {std::vector<double>{5.0}, {5.0, 5.0, 5.0}, {0.0}, {-1e-12}, {1e90, 1e90}}) {
    const Axis axis = axis_for(values);
    CHECK(axis.low < values[0] && values[0] < axis.high);
    CHECK(axis.ticks.size() >= 2);
  }
}

TEST(ReportAxis, LeavesOutWhatIsNoNumber) {
  const Axis axis = axis_for({kNone, 1.0, INFINITY, 2.0, -INFINITY, 1e300});
  CHECK(axis.low > 0.9 && axis.low < 1.0 && axis.high > 2.0 && axis.high < 2.1);
  const Axis none = axis_for({kNone, INFINITY});
  DOUBLES_EQUAL(0.0, none.low, 0.0);
  DOUBLES_EQUAL(1.0, none.high, 0.0);
}

TEST(ReportAxis, HoldsAnyValuesWithAHandfulOfTicksWithin) {
  CHECK(rc::check("axis holds its values", [] {
    const auto values = *rc::gen::container<std::vector<double>>(rc::gen::map(
        rc::gen::pair(rc::gen::inRange(-100000, 100000), rc::gen::inRange(-60, 60)),
        [](const std::pair<int, int>& number) { return number.first * std::pow(10.0, number.second); }));
    const Axis axis = axis_for(values);
    RC_ASSERT(std::isfinite(axis.low));
    RC_ASSERT(axis.low < axis.high);
    for (const double value : values) RC_ASSERT(value >= axis.low && value <= axis.high);
    RC_ASSERT(axis.ticks.size() >= 2U);
    RC_ASSERT(axis.ticks.size() <= 8U);
    const double slack = 1e-6 * (axis.high - axis.low);
    for (const Tick& tick : axis.ticks)
      RC_ASSERT(tick.at >= axis.low - slack && tick.at <= axis.high + slack);
  }));
}

TEST(ReportAxis, ALogarithmicOneHasTicksAtPowersOfTenOrCloser) {
  CHECK_EQUAL(std::string("0.001 0.01 0.1 1 10 100"),
              ticks_of(log_axis_for({1e-3, 0.5, 0.0, -1.0, kNone, 120.0})));
  CHECK_EQUAL(std::string("1e-12 1e-10 1e-08 1e-06 0.0001 0.01 1"), ticks_of(log_axis_for({1e-12, 2.0})));
  CHECK_EQUAL(std::string("2 5 10"), ticks_of(log_axis_for({1.5, 11.0})));
  const Axis axis = log_axis_for({1e-3, 120.0});
  CHECK(axis.low < 1e-3 && axis.high > 120.0);
  DOUBLES_EQUAL(0.5, axis.position(std::sqrt(axis.low * axis.high)), 1e-12);
  CHECK(log_axis_for({}).low > 0.0);
}

TEST_GROUP(ReportChart){};

TEST(ReportChart, IsWrittenWithItsNumbersToAFolderThatIsMadeForIt) {
  const strobe::testing::TemporaryFolder folder;
  Panel panel{.title = "t", .x_label = "x, m", .y_label = "y, m"};
  panel.series = {{.name = "a, b",
                   .legend = "a",
                   .stroke = Stroke::points,
                   .colour = "#000000",
                   .points = {{0.1, 0.2, 0.15, 0.25}}},
                  {.name = "line", .legend = "l", .colour = "#000000", .points = {{0, 0}, {1, 1}}}};
  const Figure figure{.number = 4, .title = "Bob's <ball>", .caption = "c", .panels = {panel}};
  CHECK(write_figure(figure, folder / "new" / "folder", "figure_04").has_value());
  CHECK_EQUAL(std::string("series,x,y,low,high\na; b,0.1,0.2,0.15,0.25\n\n\nline,0,0,,\nline,1,1,,\n"),
              strobe::testing::read_text(folder / "new" / "folder" / "figure_04.csv"));
  const auto parsed = parse_html(strobe::testing::read_text(folder / "new" / "folder" / "figure_04.svg"));
  CHECK_TEXT(parsed.well_formed, parsed.problem.c_str());
  STRCMP_CONTAINS("Figure 4. Bob's <ball>\n", parsed.text.c_str());
  strobe::testing::write_text(folder / "file", "");
  STRCMP_CONTAINS("inside: cannot be made",
                  write_figure(figure, folder / "file" / "inside", "f").error().message.c_str());
}

TEST(ReportChart, DrawsAMarkForEachPointAndABarForEachSd) {
  const auto parsed = drawn(chart_of({{1.0, 2.0, 1.5, 2.5}, {2.0, 3.0, 2.5, 3.5}, {3.0, kNone}}));
  LONGS_EQUAL(2 + 1, parsed.count("circle"));  // the legend's, too
}

TEST(ReportChart, SaysWhereThereIsNothingToDraw) {
  STRCMP_CONTAINS("no data", drawn(chart_of({})).text.c_str());
  STRCMP_CONTAINS("no data", drawn(chart_of({{kNone, 1.0}, {1.0, kNone}, {INFINITY, 1.0}})).text.c_str());
  CHECK(drawn(chart_of({{1.0, 1.0}})).text.find("no data") == std::string::npos);
  CHECK(drawn(make_chart("empty", Figure{})).well_formed);
}

TEST(ReportChart, ALineIsInterruptedWhereAValueIsMissing) {
  const auto parsed = drawn(chart_of({{0, 0}, {1, 1}, {2, kNone}, {3, 1}, {4, 2}}, Stroke::solid));
  bool interrupted = false;
  for (const auto& element : parsed.elements) {
    const auto path = element.attributes.find("d");
    if (path == element.attributes.end()) continue;
    interrupted = interrupted || std::count(path->second.begin(), path->second.end(), 'M') == 2;
  }
  CHECK(interrupted);
}

TEST(ReportChart, IsDrawnRowByRowWithOneLegend) {
  Figure figure{.number = 0, .title = "t", .caption = "", .columns = 3};
  for (int i = 0; i < 7; ++i)
    figure.panels.push_back({.x_label = "x",
                             .y_label = "label " + std::to_string(i),
                             .series = {{.name = "s",
                                         .legend = i == 0 ? "the legend" : "",
                                         .stroke = Stroke::points,
                                         .colour = "#123456",
                                         .points = {{1.0, 2.0}}}}});
  const auto rows = svg_rows(make_chart("c", figure));
  LONGS_EQUAL(3, rows.size());
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK_EQUAL(i == 2, rows[i].find("the legend") != std::string::npos);
    for (int k = 0; k < 7; ++k)
      CHECK_EQUAL(i == static_cast<std::size_t>(k) / 3, rows[i].find("label " + std::to_string(k)) != std::string::npos);
  }
}

// A letter is 0.6 of the font's size wide, as in DejaVu Sans; a drawing is 720 wide.
TEST(ReportChart, LabelsStayWithinThePanelAndApart) {
  std::vector<std::string> names;
  for (int i = 1; i <= 20; ++i) names.push_back(std::to_string(i) + "/1f2e4d");
  Figure figure{.number = 0, .title = "t", .caption = "", .columns = 3};
  for (int i = 0; i < 3; ++i) figure.panels.push_back({.x_label = "shot", .y_label = "spin touchdown of the ball, rad/s"});
  const std::string svg = svg_rows(make_chart("c", figure, names)).at(0);
  const std::regex label("<text x=\"([0-9.]+)\" y=\"([0-9.]+)\" text-anchor=\"middle\" font-size=\"([0-9.]+)\"( transform)?[^>]*>([^<]*)<");
  double end = 0.0;
  int shots = 0;
  for (std::sregex_iterator it(svg.begin(), svg.end(), label), none; it != none; ++it) {
    const double x = std::stod((*it)[1]), y = std::stod((*it)[2]);
    const std::string words = (*it)[5];
    const double half = 0.3 * std::stod((*it)[3]) * static_cast<double>(words.size());
    if ((*it)[4].matched) {  // upright
      CHECK_TRUE(y - half >= 0.0 && y + half <= 146.0);
    } else if (words.find('/') != words.npos) {
      if (x < end) end = 0.0;  // the next panel
      CHECK_TRUE(x - half > end);
      end = x + half;
      ++shots;
    }
  }
  CHECK_TRUE(shots >= 3 && shots < 3 * 20);
}

TEST(ReportChart, NamesOfManyShotsAreThinnedOut) {
  std::vector<std::string> names;
  for (int i = 1; i <= 300; ++i) names.push_back(std::to_string(i));
  Figure figure;
  figure.panels.emplace_back();
  const Chart chart = make_chart("c", figure, names);
  CHECK(chart.panels[0].x.ticks.size() <= 25);
  CHECK_EQUAL(std::string("1"), chart.panels[0].x.ticks[0].text);
  DOUBLES_EQUAL(300.5, chart.panels[0].x.high, 0.0);
}

/// The first number pair of the only path that has this look.
std::pair<double, double> end_of_path(const std::string& svg, const std::string& look) {
  const std::regex path("<path d=\"M[-0-9. ]+L([-0-9.]+) ([-0-9.]+)\" fill=\"none\" " + look);
  std::smatch found;
  CHECK_TEXT(std::regex_search(svg, found, path), svg.c_str());
  return {std::stod(found[1]), std::stod(found[2])};
}

TEST(ReportChart, DrawsABallWithItsAxisAsItIsSeen) {
  const std::string shaft = "stroke=\"#D55E00\" stroke-width=\"2\"", dot = "stroke-linecap=\"round\"";
  // x right, y up: an axis upwards and towards whoever looks ends above the ball's centre, its back below.
  const std::string front = balls_svg("t", {{.spin = {0.0, 3.0, 3.0}, .lines = {"a<b", "c"}}});
  CHECK_TRUE(parse_html("<div>" + front + "</div>").well_formed);
  STRCMP_CONTAINS("a&lt;b", front.c_str());
  STRCMP_CONTAINS(dot.c_str(), front.c_str());
  CHECK_TRUE(end_of_path(front, shaft).second > 75.0);  // the hidden half is drawn first
  // Away from whoever looks: a cross at the pole that is seen, which is the arrow's other end.
  const std::string back = balls_svg("t", {{.spin = {0.0, 3.0, -3.0}}});
  CHECK_TRUE(back.find(dot) == back.npos);
  CHECK_TRUE(end_of_path(back, shaft).second < 75.0);
  // Without a spin a ball alone, and of none nothing that is no number.
  const std::string still = balls_svg("t", {{}, {.spin = {0.0, 0.0, 1.0}}, {.spin = {0.0, 0.0, -1e-9}}});
  CHECK_TRUE(parse_html("<div>" + still + "</div>").well_formed && still.find("nan") == still.npos);
}

TEST(ReportChart, AnyPointsGiveAWellFormedDrawing) {
  CHECK(rc::check("drawing is well-formed", [] {
    const auto number =
        rc::gen::oneOf(rc::gen::arbitrary<double>(),
                       rc::gen::element(0.0, 1.0, -1.0, kNone, INFINITY, 1e308, -1e308, 5e-324));
    const auto values = *rc::gen::container<std::vector<double>>(number);
    std::vector<PlotPoint> points;
    for (std::size_t i = 0; i + 3 < values.size(); ++i)
      points.push_back({values[i], values[i + 1], values[i + 2], values[i + 3]});
    for (const Stroke stroke : {Stroke::points, Stroke::solid, Stroke::dotted}) {
      const std::string svg = svg_rows(chart_of(points, stroke)).at(0);
      RC_ASSERT(parse_html(svg).well_formed);
      RC_ASSERT(svg.find("nan") == svg.npos);
      RC_ASSERT(svg.find("inf") == svg.npos);
    }
  }));
}
