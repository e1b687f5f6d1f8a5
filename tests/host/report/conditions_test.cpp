// No mean over what differs: shots are divided by all that their records, rigs, calibrations and plans say.
#include <fmt/format.h>
#include <rapidcheck.h>

#include <memory>
#include <set>

#include "host/report/content.hpp"
#include "host/report/report.hpp"
#include "host/series/select.hpp"
#include "tests/host/report/made_session.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::report;
using namespace strobe::report_test;

namespace {

/// Gives the shot one of three values of what conditions differ in.
void set(host::Shot& shot, std::string_view key, int value) {
  host::RigFile rig = *shot.rig;
  if (key == "rig") {
    rig.rig = fmt::format("rig{}", value);
  } else if (key == "calibration") {
    rig.analysis.px_per_m = 4000.0 + value;
  } else if (key == "plan") {
    shot.summary->plan.period_ns = 3'000'000 + 100'000 * value;
  } else if (key == "spin" || key == "angle_deg" || key == "temperature_c" || key == "surface_angle_deg") {
    shot.readout.record[std::string(key)] = fmt::format("{}", 20 + value);
  } else {
    shot.readout.record[std::string(key)] = fmt::format("some {}", value);
  }
  shot.rig = std::make_shared<const host::RigFile>(rig);
}

std::vector<const host::Shot*> counted(const ConditionGroup& group) {
  std::vector<const host::Shot*> shots;
  for (const ReportShot& each : group.counted) shots.push_back(each.in_series.get());
  return shots;
}

}  // namespace

TEST_GROUP(Conditions){};

TEST(Conditions, AreDividedByEachThingThatShotsDifferIn) {
  for (const std::string_view key : host::kConditionKeys) {
    auto session = made_session({.shots = 4});
    for (std::size_t i = 0; i < 4; ++i) set(session.shots[i], key, i < 2 ? 0 : 1);
    ReportInput input = input_of(session);
    const Content divided = content_of(input);
    LONGS_EQUAL_TEXT(2, divided.conditions.size(), std::string(key).c_str());
    CHECK_TEXT(divided.conditions[0].label != divided.conditions[1].label, std::string(key).c_str());
    if (key == "spin" || key == "angle_deg") continue;
    input.over = {std::string(key)};
    const Content pooled = content_of(input);
    LONGS_EQUAL_TEXT(1, pooled.conditions.size(), std::string(key).c_str());
    STRCMP_CONTAINS(("over " + std::string(key)).c_str(), pooled.conditions[0].label.c_str());
  }
}

TEST(Conditions, AreNotNamedByWhatAllShotsHaveInCommon) {
  auto session = made_session({.shots = 2});
  for (host::Shot& shot : session.shots) shot.readout.record["surface_name"] = "acrylic";
  const ReportInput input = input_of(session);
  const Content content = content_of(input);
  LONGS_EQUAL(1, content.conditions.size());
  CHECK_EQUAL("no spin, 23°", content.conditions[0].label);
}

TEST(Conditions, HoldNoMixtureWhateverDiffers) {
  const bool held = rc::check("no mean over what differs", [] {
    static const host::StoredSession made = made_session({.shots = 6});
    host::StoredSession session = made;
    for (host::Shot& shot : session.shots)
      for (const std::string_view key : host::kConditionKeys)
        set(shot, key, *rc::gen::weightedElement<int>({{6, 0}, {1, 1}, {1, 2}}));
    const ReportInput input = input_of(session);
    std::set<std::string> labels;
    for (const ConditionGroup& group : content_of(input).conditions) {
      RC_ASSERT(host::differing_keys(counted(group)).empty());
      RC_ASSERT(labels.insert(group.label).second);
    }
  });
  CHECK(held);
}

TEST(Conditions, OfOneSpinAndAngleAreComparedAndNoneOverWhatDiffersIsJudged) {
  auto session = made_session({.shots = 6});
  for (std::size_t i = 0; i < 6; ++i)
    session.shots[i].readout.record["surface_name"] = i < 3 ? "acrylic" : "cushion";
  ReportInput input = input_of(session);
  input.limits = {parse_limit("e=0.1..0.9").value()};
  const auto divided = render_html(build_report(input));
  for (const char* text : {"no spin, 23°, cushion less no spin, 23°, acrylic", "conforms"})
    STRCMP_CONTAINS(text, divided.c_str());
  input.over = {"surface_name"};
  const auto pooled = render_html(build_report(input));
  STRCMP_CONTAINS("not decided: a mean over what differs", pooled.c_str());
  CHECK(pooled.find(" less ") == pooled.npos);
}
