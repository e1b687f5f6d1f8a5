#include "tests/host/report/made_session.hpp"

#include <fmt/format.h>

#include <memory>

#include "host/assembly/assemble.hpp"
#include "tests/host/synthetic_shot.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::report_test {

namespace {

strobe_msgs::note_t note(const std::string& key, const std::string& value) {
  strobe_msgs::note_t out;
  out.key = key;
  out.value = value;
  return out;
}

host::Shot stored_shot(int number, const MadeSession& settings, const host::RigFile& rig) {
  host_test::Scenario scenario;
  scenario.seed = static_cast<std::uint32_t>(number);
  scenario.touchdown_s += 0.37e-3 * number;  // so that images show all of the contact
  auto made = host_test::make_shot(scenario);
  made.shot.shot_id = made.frame.shot_id = number;
  made.shot.notes = {note("spin", settings.spin), note("angle_deg", settings.angle),
                     note("ball_name", "new")};
  if (!settings.note.empty()) made.shot.notes.push_back(note("remarks", settings.note));
  made.shot.note_count = static_cast<int>(made.shot.notes.size());
  for (auto& image : made.frame.images) {
    if (!settings.tops || image.leg != strobe_msgs::ball_image_t::LEG_CONTACT) continue;
    image.top_x_px = image.centre_x_px;
    image.top_y_px = image.centre_y_px + 0.45 * image.diameter_px;
  }
  host::Shot stored;
  stored.rig = std::make_shared<const host::RigFile>(rig);
  stored.name = std::to_string(number);
  stored.utc = fmt::format("2026-11-21T10:{:02}:00Z", number);
  stored.summary = made.shot;
  host::Digitization digitization;
  digitization.frame = made.frame;
  digitization.utc = stored.utc;
  stored.digitizations.push_back(digitization);
  auto readout = host::shot_readout(made.shot, made.frame, host::assembly_settings(rig));
  stored.boot_id = made.shot.boot_id;
  stored.shot_id = number;
  stored.readout = std::move(readout.readout);
  stored.train = host::train_report(made.shot);
  return stored;
}

}  // namespace

host::StoredSession made_session(const MadeSession& settings) {
  const auto rig =
      host::read_rig("rig = \"bench\"\n" + settings.rig_lines + "[machine]\nlag_ms = 310\n", "rig.toml");
  CHECK_TEXT(rig.has_value(), rig ? "" : rig.error().message.c_str());
  host::StoredSession session;
  session.folder = "today";
  session.rig = *rig;
  session.plan_text = "period_us = 3000\n";
  host::RunRecord run;
  run.utc = "2026-11-21T09:59:00Z";
  run.host_id = 5;
  run.version = "1.0";
  run.operator_name = "jo@lab";
  run.shots = settings.shots;
  run.notes = {{"spin", settings.spin}};
  session.runs.push_back(run);
  for (int i = 1; i <= settings.shots; ++i) {
    session.shots.push_back(stored_shot(i, settings, session.rig));
    if (i > settings.shots - settings.rejected)
      session.shots.back().rejected = "a flash <was> missing";
  }
  session.verified = true;
  return session;
}

report::ReportInput input_of(host::StoredSession session) {
  report::ReportInput input;
  input.sessions.push_back(std::move(session));
  input.version = "1.2.3";
  return input;
}

}  // namespace strobe::report_test
