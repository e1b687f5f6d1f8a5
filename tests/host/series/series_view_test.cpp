// What a person and a program read of a series.
#include "host/view/series_view.hpp"

#include <nlohmann/json.hpp>

#include "host/view/series_json.hpp"
#include "tests/host/rendered_rows.hpp"
#include "tests/host/series/simulated_series.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using namespace strobe::test;
using reduction::Quantity;
using strobe::testing::row;

namespace {

SeriesSummary example() { return summarize("zero 23", series_shots({10.0, 12.0, 14.0}, 0.5)); }

}  // namespace

TEST_GROUP(SeriesView){};

// Total sqrt(4/3 + 1/4) = 1.258, of which two digits.
TEST(SeriesView, HasMeanIntervalTotalScatterStandardErrorAndSharedPart) {
  const auto lines = render_summary(example(), std::nullopt, 120);
  CHECK_EQUAL(std::string("zero 23: 3 shots counted"), lines[0]);
  CHECK_EQUAL(std::string("vx touchdown m/s 12.0 4.2 1.3 2.0 1.2 0.5 3"), row(lines, "vx touchdown"));
  CHECK_EQUAL(std::string(""), row(lines, "impulse ratio mu"));
}

TEST(SeriesView, TellsOfOneShotThatItHasNoScatter) {
  const auto lines = render_summary(summarize("a", series_shots({10.0}, 0.5)), std::nullopt, 120);
  CHECK_EQUAL(std::string("a: 1 shot counted"), lines[0]);
  CHECK_TRUE(!row(lines, "(one shot has no scatter").empty());
}

TEST(SeriesView, NamesOutliersWithTheRule) {
  const auto summary = summarize("a", series_shots({10.0, 10.1, 9.9, 10.05, 9.95, 14.0}));
  const auto lines = render_summary(summary, std::nullopt, 120);
  STRCMP_CONTAINS("shot 6 stands apart in vx touchdown", row(lines, "! shot 6").c_str());
  STRCMP_CONTAINS("Grubbs's test, 1 %", row(lines, "  (Grubbs").c_str());
}

TEST(SeriesView, HasTheBudgetOfAMean) {
  const SeriesSummary summary = example();
  const auto& vx = summary.quantities[static_cast<std::size_t>(Quantity::vx_td_mps)];
  const auto lines = render_budget("zero 23, mean", vx.budget, Quantity::vx_td_mps, 120);
  // 4/3 of 19/12 is 84.2 %.
  CHECK_EQUAL(std::string("scatter of the shots A 1.2 84.2 % 2.0"), row(lines, "scatter"));
  CHECK_EQUAL(std::string("scale B 1 % +0.5/% 0.5 15.8 % yes"), row(lines, "scale"));
  CHECK_EQUAL(std::string("total 1.3"), row(lines, "total"));
}

TEST(SeriesView, ComparesAndSaysWhatWouldDecide) {
  const Series first = series_of(series_shots({10.0, 12.0, 14.0}));
  const Series second = series_of(series_shots({11.0, 12.0, 14.0}));
  const auto lines = render_comparison("a", "b", compare(first, second), 120);
  CHECK_EQUAL(std::string("a less b"), lines[0]);
  STRCMP_CONTAINS("not decided", row(lines, "vx touchdown").c_str());
  CHECK_EQUAL(1U, render_comparison("a", "b", compare(first, Series{}), 120).size());
}

TEST(SeriesView, SaysWhatFurtherShotsAreToFindAndInWordsWhereNobodyFiresSoMany) {
  const Series first = series_of(series_shots({10.0, 12.0, 14.0}));
  const Series second = series_of(series_shots({11.0, 12.0, 14.0}));
  reduction::Quantities asked;
  asked[Quantity::vx_td_mps] = 0.01;
  const auto lines = render_comparison("a", "b", compare(first, second, asked), 120);
  STRCMP_CONTAINS("more than 10,000 not decided", row(lines, "vx touchdown").c_str());
  STRCMP_CONTAINS("to find 0.01 m/s in vx touchdown; in others the difference found, with a probability of 80 %",
                  row(lines, "(further").c_str());
  for (const std::string& line : lines) CHECK_TRUE(line.find("…") == line.npos);
  STRCMP_CONTAINS("to find the difference found, with a probability of 90 %",
                  row(render_comparison("a", "b", compare(first, second, {}, 0.9), 120), "(further").c_str());
}

TEST(SeriesView, SaysThatASeriesWasEndedByWhatItSaid) {
  auto shots = series_shots({10.0, 12.0, 14.0, 13.0, 11.0});
  for (Shot& shot : shots) shot.until_known = "vx_td_mps:3";
  const auto summary = summarize("a", shots);
  STRCMP_CONTAINS("--until-known vx_td_mps:3 decided how many shots there are",
                  row(render_summary(summary, std::nullopt, 120), "(--until-known").c_str());
  CHECK_EQUAL("vx_td_mps:3", series_json(summary, std::nullopt)["until_known"].get<std::string>());
  CHECK_TRUE(series_json(example(), std::nullopt)["until_known"].is_null());
}

TEST(SeriesView, SaysWhereHalfOfItsShotsAreNotSquareToTheCamera) {
  auto shots = series_shots({10.0, 12.0, 14.0, 13.0, 11.0});
  const auto tilt = [](Shot& shot, double deg) {
    shot.readout.flags.set(reduction::Flag::axis_tilted);
    shot.readout.spatial.emplace()[reduction::SpatialQuantity::spin_axis_tilt_td_deg] = {deg, 0.1, 0.0};
  };
  tilt(shots[0], 10.0), tilt(shots[1], 12.0);
  CHECK_TRUE(alignment_words(summarize("a", shots)).empty());
  tilt(shots[4], 17.0);
  shots[3].rejected = "late";
  tilt(shots[3], 80.0);
  const SeriesSummary summary = summarize("a", shots);
  LONGS_EQUAL(1, alignment_words(summary).size());
  STRCMP_CONTAINS("3 of 4 shots have a spin axis off the camera's, by 13 deg on average: square up",
                  row(render_summary(summary, std::nullopt, 160), "! 3 of 4").c_str());
  CHECK_EQUAL(alignment_words(summary).front(), series_json(summary, std::nullopt)["alignment"][0].get<std::string>());
}

TEST(SeriesView, SumsUpWhatMadeShotsLate) {
  auto shots = series_shots({10.0, 12.0, 14.0, 13.0, 11.0, 12.0});
  const char* reasons[] = {"flash 3 would have been 1712 us late: the core stood still for 1690 us",
                           "trigger would have been 1900 us late: kworker/1:2 (pid 71) ran for 1890 us",
                           "flash 9 would have been 5000 us late: kworker/1:2 (pid 80) ran for 4990 us",
                           "flash 9 would have been 5000 us late", "the key is off"};
  const auto words = [&] {
    return row(render_summary(summarize("a", shots), std::nullopt, 160), "! ");
  };
  for (int i = 0; i < 5; ++i) {
    if (i == 0) STRCMP_EQUAL("", words().c_str());
    shots[i].rejected = "the shot was aborted";
    shots[i].summary.emplace().abort_reason = reasons[i];
    if (i == 0) STRCMP_EQUAL("! 1 shot was aborted for lateness: the core stood still 1", words().c_str());
  }
  STRCMP_EQUAL("! 3 shots were aborted for lateness: kworker/1:2 2, the core stood still 1", words().c_str());
  shots[5].rejected = "no image of the ball";
  STRCMP_EQUAL("! 3 shots were aborted for lateness: kworker/1:2 2, the core stood still 1", words().c_str());
}

TEST(SeriesView, TellsAProgramTheSame) {
  const auto json = series_json(example(), std::nullopt);
  CHECK_EQUAL(3, json["counted"].get<int>());
  const auto& vx = json["quantities"]["vx_td_mps"];
  DOUBLES_EQUAL(12.0, vx["mean"].get<double>(), 1e-12);
  DOUBLES_EQUAL(0.5, vx["shared_sd"].get<double>(), 1e-12);
  CHECK_EQUAL(std::string("A"), vx["budget"][0]["type"].get<std::string>());
  CHECK_TRUE(vx["budget"][1]["degrees_of_freedom"].is_null());
  CHECK_TRUE(json["quantities"]["mu"]["mean"].is_null());
  CHECK_TRUE(json["thesis"].is_null());
  const Series one = series_of(series_shots({10.0, 12.0}));
  const auto compared = comparison_json("a", "b", compare(one, one));
  DOUBLES_EQUAL(0.0, compared["quantities"]["vx_td_mps"]["difference"].get<double>(), 0.0);
  CHECK_TRUE(compared["quantities"]["mu"].is_null());
}
