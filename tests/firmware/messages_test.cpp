#include "firmware/publisher/messages.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(FirmwareMessages){};

TEST(FirmwareMessages, TellEachFlashsLampsAndTheShutter) {
  ShotRecord record;
  record.flashes.resize(2);
  record.flashes[1].lamps = Lamps::b;
  record.shutter_on = from_ns(7);
  record.shutter_off = from_ns(8);
  record.shutter_feedback = ShutterFeedback::late;
  Rig rig;
  rig.lamps.delay_b_us = 13.5;
  const auto shot = to_message(record, rig, 7, {1, 9}, {});
  CHECK_EQUAL(3, shot.flashes[0].lamps);
  CHECK_EQUAL(2, shot.flashes[1].lamps);
  CHECK_EQUAL(7, shot.shutter_on_ns);
  CHECK_EQUAL(8, shot.shutter_off_ns);
  CHECK_EQUAL(+strobe_msgs::shot_t::FEEDBACK_LATE, shot.shutter_feedback);
  DOUBLES_EQUAL(12.0, shot.lamp_delay_a_us, 0.0);
  DOUBLES_EQUAL(13.5, shot.lamp_delay_b_us, 0.0);
}

TEST(FirmwareMessages, SayWhatWasNotSeen) {
  ShotRecord record;
  record.flashes.resize(2);
  record.flashes[1].observed_a = from_ns(123);
  const auto shot = to_message(record, Rig(), 7, {1, 9}, {});
  CHECK_EQUAL(2, shot.flash_count);
  CHECK_EQUAL(1, shot.flashes[1].flash_index);
  CHECK_EQUAL(123, shot.flashes[1].observed_a_ns);
  CHECK_EQUAL(strobe_msgs::flash_t::NO_TIME, shot.flashes[1].observed_b_ns);
  CHECK_EQUAL(strobe_msgs::flash_t::NO_TIME, shot.flashes[0].issue_end_ns);
  CHECK_EQUAL(strobe_msgs::shot_t::NO_TIME, shot.trigger_ns);
  CHECK_EQUAL(strobe_msgs::shot_t::NO_TIME, shot.gate_ns);
  CHECK_FALSE(shot.aborted);
  CHECK_FALSE(shot.sensor_a_fitted);
}

TEST(FirmwareMessages, PutACommandsNotesOverTheRigFiles) {
  const auto notes = merged({{"operator", ""}, {"ball_name", "new"}}, {{"operator", "M"}, {"spin", "zero"}});
  CHECK_EQUAL(3u, notes.size());
  CHECK_EQUAL(std::string("M"), notes[0].value);
  CHECK_EQUAL(std::string("new"), notes[1].value);
  CHECK_EQUAL(std::string("spin"), notes[2].key);
}
