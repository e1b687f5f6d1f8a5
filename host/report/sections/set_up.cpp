// Rig, ball, camera, runs.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

using host::CameraTable;
using host::StoredSession;

std::string number_text(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:.6g}{}", *value, unit) : std::string();
}

std::string with_sd(double value, const std::optional<double>& sd, const char* unit) {
  return sd ? fmt::format("{:.7g} ± {:.3g}{}", value, *sd, unit)
            : fmt::format("{:.7g}{}, sd not stated", value, unit);
}

Facts rig_facts(const StoredSession& session, const std::string& key) {
  const auto& ball = session.rig.ball;
  const auto& analysis = session.rig.analysis;
  const auto& plan = session.rig.plan;
  return {"rig" + key,
          "Rig and ball",
          {fact("rig", "Rig", session.rig.rig), fact("folder", "Session's folder", folder_name(session)),
           number_fact("ball_diameter_m", "Ball's diameter", ball.diameter_m,
                       with_sd(1e3 * ball.diameter_m, 1e3 * ball.diameter_sd_m, " mm (sd of its tolerance)")),
           stated_fact("ball_mass_kg", "Ball's mass",
                       number_text(ball.mass_kg ? std::optional(1e3 * *ball.mass_kg) : std::nullopt, " g")),
           stated_fact("surface_angle_deg", "Inclination of the surface",
                       number_text(analysis.surface_angle_deg, " degrees")),
           fact("flash_period", "Shortest interval of flashes in the rig's plan",
                fmt::format("{:.3f} ms", 1e-6 * static_cast<double>(plan.even.period.count()))),
           fact("spacing", "Intervals of flashes", plan.spacing == host::Spacing::coded ? "coded" : "even")}};
}

std::string age(const CameraTable& camera, const std::string& day) {
  if (!camera.calibrated || day.size() != 10) return {};
  const auto epoch = WallTime{};
  const auto then = host::days_since(*camera.calibrated, epoch), tested = host::days_since(day, epoch);
  if (!then || !tested) return {};
  const auto days = *then - *tested;
  return fmt::format(
      "{} days before the first test{}", days,
      static_cast<double>(days) > camera.max_age_days ? ": older than the rig's max_age_days" : "");
}

Facts camera_facts(const StoredSession& session, const std::string& key, const std::string& first_day) {
  const CameraTable& camera = session.rig.camera;
  const auto scale = session.rig.analysis.px_per_m ? session.rig.analysis.px_per_m : camera.px_per_m;
  const auto sd = session.rig.analysis.px_per_m ? session.rig.analysis.px_per_m_sd : camera.px_per_m_sd;
  Facts facts{"camera" + key, "Camera", {}};
  facts.facts.push_back(stated_fact("calibrated", "Calibrated on", camera.calibrated.value_or("")));
  if (const std::string words = age(camera, first_day); !words.empty())
    facts.facts.push_back(fact("calibration_age", "Age of the calibration", words));
  Fact of_scale = stated_fact("px_per_m", "Scale in the balls' plane",
                              scale ? with_sd(*scale, sd, " px/m") : std::string());
  of_scale.number = scale;
  if (scale && !sd) of_scale.text += " (a first guess, refined on each photograph by the ball's diameter)";
  facts.facts.push_back(std::move(of_scale));
  facts.facts.push_back(
      stated_fact("residual_px", "Residual of the calibration, rms", number_text(camera.residual_px, " px")));
  facts.facts.push_back(
      stated_fact("tilt_deg", "Tilt of the optical axis", number_text(camera.tilt_deg, " degrees")));
  facts.facts.push_back(stated_fact("board", "Board", camera.board.value_or("")));
  facts.facts.push_back(stated_fact("photographs", "Photographs of the board",
                                    camera.photographs ? fmt::format("{}", *camera.photographs) : ""));
  if (camera.width_px && camera.height_px)
    facts.facts.push_back(fact("size_px", "Size of photographs",
                               fmt::format("{} x {} px", *camera.width_px, *camera.height_px)));
  return facts;
}

Table runs_table(const StoredSession& session, const std::string& key) {
  Table table{"runs" + key,
              "Runs",
              {{"utc", "begun (UTC)", "", false},
               {"operator", "started by", "", false},
               {"version", "strobe", "", false},
               {"shots", "shots asked for", ""},
               {"notes", "notes", "", false}},
              {},
              {}};
  for (const host::RunRecord& run : session.runs) {
    std::string notes;
    for (const auto& [name, value] : run.notes) notes += (notes.empty() ? "" : "; ") + name + " " + value;
    table.rows.push_back({{text_cell(run.utc), text_cell(run.operator_name), text_cell(run.version),
                           count_cell(run.shots), text_cell(notes)}});
  }
  return table;
}

/// Without comments that fill whole lines, and empty lines.
std::string essence(const std::string& text) {
  std::string out;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    const std::string line = text.substr(from, end - from);
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != line.npos && line[first] != '#') out += line + "\n";
    from = end + 1;
  }
  return out;
}

}  // namespace

Section set_up(const Content& content) {
  Section section{"set_up", "Set-up and calibration", {}};
  int number = 0;
  for (const StoredSession& session : content.input.sessions) {
    const std::string key = content.input.sessions.size() == 1 ? "" : fmt::format("_{}", ++number);
    section.blocks.emplace_back(rig_facts(session, key));
    section.blocks.emplace_back(camera_facts(session, key, content.first_day));
    if (Table runs = runs_table(session, key); !runs.rows.empty())
      section.blocks.emplace_back(std::move(runs));
    section.blocks.emplace_back(
        Listing{"rig_file" + key, "Rig file as used, without comments", essence(session.rig.text)});
    if (!session.plan_text.empty())
      section.blocks.emplace_back(Listing{"plan_file" + key, "Plan as used", essence(session.plan_text)});
  }
  return section;
}

}  // namespace strobe::lab_report
