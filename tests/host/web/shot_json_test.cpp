#include <nlohmann/json.hpp>
#include <rapidcheck.h>

#include "host/assembly/assemble.hpp"
#include "host/session/shot_table.hpp"
#include "host/web/session_table.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::Shot;
using nlohmann::ordered_json;
using reduction::Quantity;

Shot measured() {
  auto made = host_test::make_shot({});
  made.shot.boot_id = 0x2a;
  made.shot.shot_id = 3;
  made.frame.boot_id = 0x2a;
  made.frame.shot_id = 3;
  made.frame.source = "auto";
  host::AssemblySettings settings;
  settings.machine_lag_s = host_test::kMachineLag_s;
  Shot result = host::measured_shot(made.shot, made.frame, {}, settings);
  result.readout.record = {{"spin", "zero"}, {"angle_deg", "23"}, {"remarks", "<b>\"wet\"</b>,\n"}};
  return result;
}

std::string table(const std::vector<Shot>& results) {
  std::string text = host::results_header() + "\n";
  for (Shot result : results) {
    result.utc = "2026-01-31T09:30:00.000Z";
    result.name = std::to_string(result.shot_id);
    text += host::results_line(result) + "\n";
  }
  return text;
}

}  // namespace

TEST_GROUP(ShotJson){};

TEST(ShotJson, OfAResultIsThatOfItsRow) {
  Shot result = measured();
  result.rejected = "a flash, or \"two\", late";
  result.readout.flags.set(reduction::Flag::late_flash);
  result.readout.flags.set(reduction::Flag::sensor_missing);
  const auto rows = web::shot_rows(host::parse_results(table({result})));
  LONGS_EQUAL(1, rows.size());
  result.name = "3";
  result.utc = "2026-01-31T09:30:00.000Z";
  const auto row = web::shot_row(result);
  CHECK_EQUAL(web::shot_json(row, "today").dump(), web::shot_json(rows[0], "today").dump());
}

TEST(ShotJson, HasWhatAPersonAsksFirst) {
  Shot result = measured();
  result.name = "3";
  const ordered_json shot = web::shot_json(web::shot_row(result), std::nullopt);
  CHECK_TRUE(shot["session"].is_null());
  CHECK_EQUAL("3", shot["name"].get<std::string>());
  CHECK_EQUAL("2a", shot["boot_id"].get<std::string>());
  CHECK_TRUE(shot["counted"].get<bool>());
  CHECK_TRUE(shot["rejected"].is_null());
  CHECK_EQUAL("zero", shot["spin"].get<std::string>());
  DOUBLES_EQUAL(23.0, shot["angle_deg"].get<double>(), 0.0);
  DOUBLES_EQUAL(15.62, shot["values"]["vx_td_mps"]["value"].get<double>(), 0.2);
  const double noise = result.readout.sd[Quantity::vx_td_mps].value();
  CHECK_TRUE(shot["values"]["vx_td_mps"]["sd"].get<double>() > noise);  // and the ball's tolerance
  CHECK_TRUE(shot["values"]["court_pace"]["value"].is_null());
}

TEST(ShotJson, OfADryShotCountsForNothing) {
  Shot result;
  result.dry = true;
  const ordered_json shot = web::shot_json(web::shot_row(result), "s");
  CHECK_FALSE(shot["counted"].get<bool>());
  CHECK_TRUE(shot["digitization"].is_null());
  CHECK_TRUE(shot["values"]["e"]["sd"].is_null());
}

TEST(ShotJson, RowsHaveTheNamesThatTheScreenHas) {
  Shot first = measured(), again = measured();
  again.boot_id = 0x1f2e4d0000000000;
  const auto rows = web::shot_rows(host::parse_results(table({first, again, first})));
  LONGS_EQUAL(2, rows.size());  // each shot once
  CHECK_EQUAL("3", rows[0].name);
  CHECK_EQUAL("3/1f2e4d", rows[1].name);
}

TEST(ShotJson, RowsOfAnEarlierVersionLackWhatItLacked) {
  std::string text = table({measured()});
  // digitization, shot, and the third dimension's
  for (std::size_t i = 0; i < 2 + 3 * reduction::kSpatialCount; ++i) {
    text.erase(text.rfind(',', text.find('\n')), text.find('\n') - text.rfind(',', text.find('\n')));
    const std::size_t last = text.rfind(',');
    text.erase(last, text.size() - 1 - last);
  }
  const auto rows = web::shot_rows(host::parse_results(text));
  LONGS_EQUAL(1, rows.size());
  CHECK_EQUAL("", rows[0].digitization);
  CHECK_EQUAL("3", rows[0].name);
  CHECK_TRUE(rows[0].value[Quantity::e].has_value());
}

TEST(ShotJson, TornLinesAndAnyBytesAreNoRows) {
  std::string text = table({measured(), measured()});
  text.resize(text.size() - 5);
  LONGS_EQUAL(1, web::shot_rows(host::parse_results(text)).size());
  LONGS_EQUAL(0, web::shot_rows(host::parse_results("utc,boot_id\n\"\"\"\n,,,\n\xff\xfe")).size());
  const auto odd = web::shot_rows(host::parse_results("now,2a,1,,1e999,nan,x\n"));
  LONGS_EQUAL(1, odd.size());
  CHECK_FALSE(odd[0].value[Quantity::theta_in_deg].has_value());
}

TEST(ShotJson, OfAnyBytesIsTextThatReadsBack) {
  const std::string good = table({measured()});
  CHECK_TRUE(rc::check("of a table with a piece of it replaced", [&] {
    std::string text = good;
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    text.replace(at, *rc::gen::inRange<std::size_t>(0, 40), *rc::gen::arbitrary<std::string>());
    for (const web::ShotRow& row : web::shot_rows(host::parse_results(text))) {
      const std::string line = web::shot_json(row, text.substr(at, 9))
                                   .dump(-1, ' ', false, ordered_json::error_handler_t::replace);
      RC_ASSERT(ordered_json::parse(line)["values"].size() == reduction::kQuantityCount);
    }
  }));
}

TEST(ShotJson, QuantitiesAreInTheScreensOrder) {
  const ordered_json quantities = web::quantities_json();
  LONGS_EQUAL(reduction::kQuantityCount, quantities.size());
  CHECK_EQUAL("theta_in_deg", quantities[0]["name"].get<std::string>());
  CHECK_EQUAL("angle in", quantities[0]["label"].get<std::string>());
  CHECK_TRUE(quantities[0]["essential"].get<bool>());
  CHECK_FALSE(quantities[15]["essential"].get<bool>());
}

namespace {

using namespace strobe;
using nlohmann::ordered_json;
using reduction::Quantity;

web::ShotRow row(int number, double e) {
  web::ShotRow shot;
  shot.name = std::to_string(number);
  shot.value[Quantity::e] = e;
  shot.spin = "zero";
  shot.angle_deg = 23.0;
  return shot;
}

}  // namespace

TEST_GROUP(SeriesPageJson){};

TEST(SeriesPageJson, HasAPointForEachShotAndLimitsFromThoseThatCount) {
  std::vector<web::ShotRow> rows{row(1, 0.80), row(2, 0.82), row(3, 0.50), row(4, 0.81), row(5, 0.83)};
  rows[2].rejected = "an image did not fit";
  rows.push_back(row(6, 0.1));
  rows.back().dry = true;
  const ordered_json page = web::series_page_json({}, std::nullopt, rows);
  LONGS_EQUAL(5, page["points"].size());
  CHECK_FALSE(page["points"][2]["counted"].get<bool>());
  DOUBLES_EQUAL(0.815, page["limits"]["e"]["mean"].get<double>(), 1e-12);
  // Ranges .02, .01, .02: 3 * (.05 / 3) / 1.128379
  DOUBLES_EQUAL(0.815 + 0.0443113, page["limits"]["e"]["upper"].get<double>(), 1e-6);
  CHECK_TRUE(page["limits"]["mu"].is_null());
  CHECK_TRUE(page["thesis"].is_null());
}

TEST(SeriesPageJson, StandsBesideTheThesisWhereAllHaveOneSpinAndAngle) {
  std::vector<web::ShotRow> rows{row(1, 0.80), row(2, 0.82)};
  const auto condition = web::condition_of(rows);
  CHECK_TRUE(condition.has_value());
  const ordered_json page = web::series_page_json({}, condition, rows);
  DOUBLES_EQUAL(condition->e.mean, page["thesis"]["e"]["value"].get<double>(), 0.0);
  CHECK_FALSE(page["thesis"].contains("slip_lo_mps"));
  rows[1].angle_deg = 45.0;
  CHECK_FALSE(web::condition_of(rows).has_value());
  rows[1].angle_deg.reset();
  CHECK_FALSE(web::condition_of(rows).has_value());
  CHECK_FALSE(web::condition_of({}).has_value());
}
