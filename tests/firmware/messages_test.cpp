#include "firmware/publisher/messages.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

TEST_GROUP(FirmwareMessages){};

TEST(FirmwareMessages, TellAllOfAnEvent) {
  Event event;
  event.kind = EventKind::estop;
  event.line = Line::estop;
  event.level = 1;
  event.shot_id = 3;
  event.flash_index = 4;
  event.device_time = from_ns(5);
  event.commanded = from_ns(6);
  event.issue_start = from_ns(7);
  event.issue_end = from_ns(8);
  event.detail = "words";
  const auto message = to_message(event, 9, 10);
  CHECK_EQUAL(+strobe_msgs::event_t::SCHEMA_VERSION, message.schema_version);
  CHECK_EQUAL(+strobe_msgs::event_t::ESTOP, message.kind);
  CHECK_EQUAL(+strobe_msgs::event_t::LINE_ESTOP, message.line);
  CHECK_EQUAL(1, message.level);
  CHECK_EQUAL(3, message.shot_id);
  CHECK_EQUAL(4, message.flash_index);
  CHECK_EQUAL(5, message.device_time_ns);
  CHECK_EQUAL(6, message.commanded_ns);
  CHECK_EQUAL(7, message.issue_start_ns);
  CHECK_EQUAL(8, message.issue_end_ns);
  CHECK_EQUAL(9, message.boot_id);
  CHECK_EQUAL(10, message.sequence);
  CHECK_EQUAL(std::string("words"), message.detail);
}

TEST(FirmwareMessages, TellAllOfAShot) {
  ShotRecord record;
  record.shot_id = 1;
  record.host_id = 2;
  record.plan.period = nanoseconds(3);
  record.start = from_ns(4);
  record.shutter_open = from_ns(5);
  record.shutter_close = from_ns(6);
  record.trigger = from_ns(7);
  record.gate = from_ns(8);
  record.queue_overflows = 9;
  record.kernel_overflows = 10;
  record.abort_reason = "why";
  record.flashes.resize(1);
  record.flashes[0] = {Lamps::a, from_ns(11), from_ns(12), from_ns(13), from_ns(14), from_ns(15), 16};
  Rig rig;
  rig.line(Line::sensor_b).fitted = true;
  rig.tolerance.late = microseconds(17);
  const auto shot = to_message(record, rig, 18, {19, 20}, {{"key", "value"}});
  CHECK_EQUAL(+strobe_msgs::shot_t::SCHEMA_VERSION, shot.schema_version);
  CHECK(shot.shot_id == 1 && shot.host_id == 2 && shot.plan.period_ns == 3 && shot.start_ns == 4);
  CHECK(shot.shutter_open_ns == 5 && shot.shutter_close_ns == 6 && shot.trigger_ns == 7 && shot.gate_ns == 8);
  CHECK(shot.queue_overflows == 9 && shot.kernel_overflows == 10);
  CHECK_TRUE(shot.aborted);
  CHECK_EQUAL(std::string("why"), shot.abort_reason);
  const auto& flash = shot.flashes.at(0);
  CHECK(flash.commanded_ns == 11 && flash.issue_start_ns == 12 && flash.issue_end_ns == 13);
  CHECK(flash.observed_a_ns == 14 && flash.observed_b_ns == 15 && flash.extra_edges == 16);
  CHECK(!shot.sensor_a_fitted && shot.sensor_b_fitted);
  DOUBLES_EQUAL(17.0, shot.late_tolerance_us, 0.0);
  CHECK(shot.boot_id == 18 && shot.first_sequence == 19 && shot.last_sequence == 20);
  CHECK_EQUAL(1, shot.note_count);
  CHECK_EQUAL(std::string("key"), shot.notes.at(0).key);
  CHECK_EQUAL(std::string("value"), shot.notes.at(0).value);
}

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
  CHECK_EQUAL(+strobe_msgs::shot_t::NO_TIME, shot.trigger_ns);
  CHECK_EQUAL(+strobe_msgs::shot_t::NO_TIME, shot.gate_ns);
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
