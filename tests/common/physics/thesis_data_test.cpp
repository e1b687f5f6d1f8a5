#include <cmath>
#include <numbers>
#include <string>

#include "tests/common/physics/thesis_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using strobe::testing::thesis_data;
using thesis::Version;

namespace {

double degrees(double rad) { return rad * 180.0 / std::numbers::pi; }

}  // namespace

TEST_GROUP(ThesisData) {
  const thesis::Data& printed = thesis_data(Version::as_printed);
  const thesis::Data& corrected = thesis_data(Version::corrected);
};

TEST(ThesisData, HoldsTwentyOneConditionsWithAContactSetEach) {
  LONGS_EQUAL(21, corrected.conditions.size());
  LONGS_EQUAL(21, corrected.contact.size());
  for (const auto& condition : corrected.conditions)
    CHECK_EQUAL(1, corrected.contact.count(condition.name()));
}

TEST(ThesisData, IsLeftAsPrintedWhenAsked) {
  DOUBLES_EQUAL(0.16, printed.condition("zero_68")->dwell_distance_cm.mean, 0.0);
  DOUBLES_EQUAL(0.89, printed.condition("top_18")->e.mean, 0.0);
  LONGS_EQUAL(10, printed.contact.at("back_45").rows.size());
  DOUBLES_EQUAL(0.0518, printed.contact.at("back_17").rows[1].y_fraction, 0.0);
}

// A mean angle is not the angle of the mean velocities: it differs by the spread of the replicates. A quarter
// of a degree is a tenth of the widest spread, and 0.4 and 0.7 degree were the errors.
TEST(ThesisData, AnglesOfZero23FitTheVelocitiesOnceCorrected) {
  const auto& c = *corrected.condition("zero_23");
  DOUBLES_EQUAL(degrees(std::atan2(c.vy_td_mps.mean, c.vx_td_mps.mean)), c.theta_in_deg.mean, 0.005);
  DOUBLES_EQUAL(degrees(std::atan2(c.vy_lo_mps.mean, c.vx_lo_mps.mean)), c.theta_out_deg.mean, 0.005);
}

TEST(ThesisData, NoMeanSpeedIsBelowTheHypotenuseOfItsMeansOnceCorrected) {
  for (const auto& c : corrected.conditions) {
    // Three roundings to two decimals: half a hundredth each.
    CHECK_TEXT(c.v_td_mps.mean > std::hypot(c.vx_td_mps.mean, c.vy_td_mps.mean) - 0.015, c.name().c_str());
    CHECK_TEXT(c.v_lo_mps.mean > std::hypot(c.vx_lo_mps.mean, c.vy_lo_mps.mean) - 0.015, c.name().c_str());
  }
  const auto& before = *printed.condition("zero_17");
  CHECK(before.v_lo_mps.mean < std::hypot(before.vx_lo_mps.mean, before.vy_lo_mps.mean) - 0.1);
}

TEST(ThesisData, DwellDistancesLieBetweenThoseOfTheTwoSpeedsOnceCorrected) {
  for (const auto& c : corrected.conditions) {
    const double time_s = c.dwell_time_ms.mean / 1e3;
    // Within the replicates' spread of the product, about a tenth.
    CHECK_TEXT(c.dwell_distance_cm.mean / 1e2 < 1.1 * c.vx_td_mps.mean * time_s, c.name().c_str());
    CHECK_TEXT(c.dwell_distance_cm.mean / 1e2 > 0.9 * c.vx_lo_mps.mean * time_s, c.name().c_str());
  }
}

TEST(ThesisData, ContactRowsAreInOrderAndTheTopGoesDownOnceCorrected) {
  for (const auto& [name, set] : corrected.contact) {
    double before = -1.0;
    for (const auto& row : set.rows) {
      CHECK_TEXT(row.time_fraction > before, name.c_str());
      CHECK_TEXT(row.time_fraction <= 1.0, name.c_str());
      CHECK_TEXT(row.y_fraction < 0.01,
                 name.c_str());  // two digitized tops lie a little above where they started
      before = row.time_fraction;
    }
  }
}

TEST(ThesisData, ExcludedRowsAndRotationsAreGone) {
  LONGS_EQUAL(9, corrected.contact.at("back_45").rows.size());
  LONGS_EQUAL(printed.contact.at("back_68").rows.size() - 5, corrected.contact.at("back_68").rows.size());
  LONGS_EQUAL(printed.contact.at("zero_49").rows.size() - 1, corrected.contact.at("zero_49").rows.size());
  int without_rotation = 0;
  for (const auto& row : corrected.contact.at("back_22").rows)
    without_rotation += row.rotation_fraction ? 0 : 1;
  LONGS_EQUAL(1, without_rotation);
  LONGS_EQUAL(printed.contact.at("back_22").rows.size(), corrected.contact.at("back_22").rows.size());
}

TEST(ThesisData, EveryCorrectionOfTheDataHasAReasonAndChangesSomething) {
  for (const auto& correction : corrected.corrections) {
    CHECK(!correction.reason.empty());
    if (correction.table != "contact") continue;
    const auto& set = printed.contact.at(correction.set);
    const auto changed = thesis::corrected(set, std::span(&correction, 1));
    CHECK(changed.has_value());
    CHECK_TEXT(changed->rows != set.rows, (correction.set + " " + correction.row).c_str());
  }
}

TEST(ThesisData, ACorrectionThatDoesNotFindWhatItCorrectsIsAnError) {
  thesis::Correction stale{"zero_68", "tables_02_to_10", "", "dwell_distance_cm", "0.17", "1.61", "why", 4};
  auto result = thesis::corrected(printed.conditions, std::span(&stale, 1));
  CHECK_EQUAL("corrections:4: printed: is not what the data has", result.error().message);
  stale.field = "height";
  result = thesis::corrected(printed.conditions, std::span(&stale, 1));
  CHECK_EQUAL("corrections:4: field: zero_68 has no number named height", result.error().message);
  const thesis::Correction row{"zero_49", "contact", "1.0054", "row", "", "exclude", "why", 5};
  const auto set = thesis::corrected(printed.contact.at("zero_49"), std::span(&row, 1));
  CHECK_EQUAL("corrections:5: row: zero_49: has no row at that time", set.error().message);
}

TEST(ThesisData, RefusesTablesThatAreNotTheTables) {
  std::string text = strobe::testing::thesis_file("tables_02_to_10.csv");
  CHECK(thesis::parse_conditions(text, "t.csv").has_value());
  text.replace(text.find("15.62"), 5, "fifty");
  CHECK_EQUAL("t.csv:2: vx_td_mps: 'fifty' is not a number",
              thesis::parse_conditions(text, "t.csv").error().message);
}

TEST(ThesisData, AFolderThatIsNotThereIsNamed) {
  const auto data = thesis::load("/no/such/folder", Version::corrected);
  CHECK_EQUAL("/no/such/folder/corrections.csv: No such file or directory", data.error().message);
}
