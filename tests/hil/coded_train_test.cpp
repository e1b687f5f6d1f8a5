// A coded train through the shipped programs: from the plan file to the lines, the journal and the readout.
#include <algorithm>
#include <string>

#include "tests/hil/raw_host.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;
using strobe_msgs::event_t;
using strobe_msgs::shot_t;

namespace {

// 52 flashes at 3.0 and 3.2 ms in turn; the ball is at the plate between flashes 25 and 27.
const std::string kPlan =
    "intervals_us = [3000, 3200]\nshutter_open_ms = 160\nimpact_at_ms = 80\n"
    "omit = [10, 40]\nonly_a = [5, 24]\nonly_b = [30]\n";
constexpr int kFlashes = 50;

/// Lamps of the k-th flash that is left of the train.
int lamps_of(int k) {
  const int in_train = k + (k >= 10 ? 1 : 0) + (k + 1 >= 40 ? 1 : 0);
  return in_train == 5 || in_train == 24 ? 1 : in_train == 30 ? 2 : 3;
}

const shot_t* whole_shot(const LogContents& journal, bool dry) {
  for (const shot_t& shot : journal.shots)
    if (!shot.aborted && (shot.plan.dry != 0) == dry) return &shot;
  return nullptr;
}

double shortest_call_us(const shot_t& shot) {
  std::int64_t shortest_ns = INT64_MAX;
  for (const auto& flash : shot.flashes)
    shortest_ns = std::min(shortest_ns, flash.issue_end_ns - flash.issue_start_ns);
  return static_cast<double>(shortest_ns) * 1e-3;
}

}  // namespace

TEST_GROUP(CodedTrain){};

TEST(CodedTrain, IsFiredAsPlannedSeenByItsLampsAndReadOut) {
  RigFixtureOptions options;
  options.rig_edits = {{"#xsync = ", "xsync = "}};
  ReadyRig bench(options);
  write_text(bench.folder() / "plan.toml", kPlan);
  const std::string plan = bench.folder() / "plan.toml";

  const auto fired = ran(bench.fire(1, 0, {"--plan", plan}));
  const nlohmann::json readout = readouts(fired.out).back();
  CHECK_FALSE(readout.at("vx_td_mps").is_null());
  CHECK(readout.at("first_flash").get<int>() >= 0);
  CHECK(readout.at("last_flash").get<int>() > readout.at("first_flash").get<int>());
  CHECK(readout.at("last_flash").get<int>() < kFlashes);
  const double misassignment = readout.at("misassignment_probability").get<double>();
  CHECK_EQUAL(misassignment > 0.01, has_flag(readout, "flash_index_ambiguous"));
  const auto dry = ran(bench.fire(1, 0, {"--plan", plan, "--dry"}));

  const LogContents journal = read_log(bench.journal());
  const shot_t* shot = whole_shot(journal, false);
  CHECK(shot != nullptr);
  LONGS_EQUAL(kFlashes, shot->plan.code_count);
  LONGS_EQUAL(kFlashes, shot->flash_count);
  int of_a = 0, of_b = 0;
  for (int k = 0; k < kFlashes; ++k) {
    const auto& flash = shot->flashes[static_cast<std::size_t>(k)];
    LONGS_EQUAL(lamps_of(k), flash.lamps);
    LONGS_EQUAL(shot->plan.code[static_cast<std::size_t>(k)].offset_ns,
                flash.commanded_ns - shot->flashes[0].commanded_ns);
    of_a += flash.lamps & 1;
    of_b += flash.lamps >> 1;
    if (flash.lamps == 1) CHECK_EQUAL(shot_t::NO_TIME, flash.observed_b_ns);
    if (flash.lamps == 2) CHECK_EQUAL(shot_t::NO_TIME, flash.observed_a_ns);
  }
  LONGS_EQUAL(kFlashes - 1, of_a);
  LONGS_EQUAL(kFlashes - 2, of_b);
  for (const event_t& event : journal.events) {
    if (event.kind != event_t::FLASH || event.shot_id != shot->shot_id) continue;
    const int lamps = lamps_of(event.flash_index);
    LONGS_EQUAL(lamps == 1   ? event_t::LINE_STROBE_A
                : lamps == 2 ? event_t::LINE_STROBE_B
                             : event_t::LINE_NONE,
                event.line);
  }

  // The simulated shutter opens and closes 45 ms after its line, give or take 0.1 ms (sd).
  LONGS_EQUAL(+shot_t::FEEDBACK_SEEN, shot->shutter_feedback);
  DOUBLES_EQUAL(45.0, static_cast<double>(shot->shutter_open_ns - shot->shutter_on_ns) * 1e-6, 1.0);
  DOUBLES_EQUAL(45.0, static_cast<double>(shot->shutter_close_ns - shot->shutter_off_ns) * 1e-6, 1.0);

  const auto changes = bench.finish();
  LONGS_EQUAL(of_a, changes.rises("STROBE_A", shot->start_ns, shot->shutter_close_ns));
  LONGS_EQUAL(of_b, changes.rises("STROBE_B", shot->start_ns, shot->shutter_close_ns));

  // The simulated lamps flash 12 us (sd 1 us at the most) after their lines, which change within the call: so
  // much before its end as it takes at the longest that is used. Where every call but one was interrupted
  // there is none.
  const auto report = parse_json_lines(dry.out).back();
  LONGS_EQUAL(kFlashes - 1, report.at("planned_a").get<int>());
  LONGS_EQUAL(kFlashes - 2, report.at("seen_by_b").get<int>());
  const double longest_call_us = 1.0 + 2.0 * shortest_call_us(*whole_shot(journal, true));
  for (const char* lamp : {"lamp_delay_a_us", "lamp_delay_b_us"}) {
    const auto& delay = report.at("calibration").at(lamp);
    if (delay.is_null()) continue;
    CHECK(delay.at("mean").get<double>() <= 15.0);
    CHECK(delay.at("mean").get<double>() >= 9.0 - longest_call_us);
  }
  DOUBLES_EQUAL(45.0, report.at("calibration").at("shutter_opening_lag_ms").get<double>(), 1.0);
}
