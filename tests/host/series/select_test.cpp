// Which shots make a series.
#include "host/series/select.hpp"

#include "tests/host/series/simulated_series.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using namespace strobe::test;

namespace {

SeriesShot noted(const std::string& session, const std::string& name, const std::string& spin,
                 const std::string& angle) {
  SeriesShot shot = series_shot(name, 10.0);
  shot.session = session;
  shot.readout.record["spin"] = spin;
  if (!angle.empty()) shot.readout.record["angle_deg"] = angle;
  return shot;
}

std::vector<SeriesShot> shots() {
  return {noted("a", "1", "zero", "23"), noted("a", "2", "top", "18"), noted("b", "1", "zero", "9"),
          noted("b", "3", "zero", "23.0"), noted("b", "4", "zero", "")};
}

std::string names(const ShotGroup& group) {
  std::string all = group.name + ":";
  for (const SeriesShot& shot : group.shots) all += " " + shot.full_name();
  return all;
}

SelectedShots selected(const Selection& selection) {
  auto result = select_shots(shots(), selection);
  if (!result) FAIL(result.error().message.c_str());
  return *result;
}

std::string complaint(const Selection& selection) {
  return testing::error_of(select_shots(shots(), selection));
}

}  // namespace

TEST_GROUP(Selection){};

TEST(Selection, IsAllShotsInOneGroupUnlessAskedOtherwise) {
  const SelectedShots all = selected({});
  CHECK_EQUAL(1U, all.groups.size());
  CHECK_EQUAL(std::string(": a:1 a:2 b:1 b:3 b:4"), names(all.groups[0]));
}

TEST(Selection, GroupsByNotesWithNumbersInTheirOrder) {
  const SelectedShots all = selected({.where = {}, .without = {}, .by = {"spin", "angle"}});
  CHECK_EQUAL(4U, all.groups.size());
  CHECK_EQUAL(std::string("top 18: a:2"), names(all.groups[0]));
  CHECK_EQUAL(std::string("zero 9: b:1"), names(all.groups[1]));
  CHECK_EQUAL(std::string("zero 23: a:1 b:3"), names(all.groups[2]));
  CHECK_EQUAL(std::string("zero (no angle_deg): b:4"), names(all.groups[3]));
}

TEST(Selection, GroupsBySessions) {
  const SelectedShots all = selected({.where = {}, .without = {}, .by = {"session"}});
  CHECK_EQUAL(std::string("b: b:1 b:3 b:4"), names(all.groups[1]));
}

TEST(Selection, FiltersByNotesAndCountsTheOthers) {
  const SelectedShots some =
      selected({.where = {{"spin", "zero"}, {"angle_deg", "23"}}, .without = {}, .by = {}});
  CHECK_EQUAL(std::string(": a:1 b:3"), names(some.groups[0]));
  CHECK_EQUAL(3, some.other);
}

TEST(Selection, LeavesShotsOutByName) {
  const SelectedShots some = selected({.where = {}, .without = {"3", "a:1", "b:3"}, .by = {}});
  CHECK_EQUAL(std::string(": a:2 b:1 b:4"), names(some.groups[0]));
  CHECK_EQUAL(2U, some.left_out.size());
  CHECK_EQUAL(std::string("b:3"), some.left_out[0]);
}

TEST(Selection, RefusesNamesThatNoShotOrSeveralHave) {
  CHECK_EQUAL(std::string("--without: no shot 7"), complaint({.where = {}, .without = {"7"}, .by = {}}));
  CHECK_EQUAL(std::string("--without: shot 1: several sessions have one: a:1, b:1"),
              complaint({.where = {}, .without = {"1"}, .by = {}}));
}

TEST(Selection, ReadsConditions) {
  CHECK_EQUAL(std::string("angle_deg"), parse_where("angle=23")->first);
  CHECK_EQUAL(std::string("a=b"), parse_where("remarks=a=b")->second);
  CHECK_FALSE(parse_where("spin").has_value());
  CHECK_FALSE(parse_where("=zero").has_value());
}
