#include "host/web/json/series_page_json.hpp"

#include <nlohmann/json.hpp>

#include "tests/support/string_from.hpp"

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
