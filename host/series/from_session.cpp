#include "host/series/from_session.hpp"

#include <fmt/format.h>

#include <functional>
#include <utility>

#include "common/reduction/mixture.hpp"
#include "host/assembly/assemble.hpp"

namespace strobe::host {
namespace {

std::string text_of(const std::optional<double>& number) { return number ? fmt::format("{}", *number) : "-"; }

/// A calibration file is thousands of digits: shots keep a number that stands for it.
std::string calibration_of(const RigFile& rig) {
  const std::string text = fmt::format("{}\n{} {}", calibration_text(rig.camera),
                                       text_of(rig.analysis.px_per_m), text_of(rig.analysis.px_per_m_sd));
  return fmt::format("{:016x}", std::hash<std::string>{}(text));
}

std::string ball_of(const RigFile& rig, const reduction::Record& record) {
  const auto name = record.find("ball_name");
  return fmt::format("{}\n{} {} {}", name == record.end() ? "" : name->second, rig.ball.diameter_m,
                     rig.ball.diameter_sd_m, text_of(rig.ball.mass_kg));
}

}  // namespace

SeriesShot series_shot(const ShotResult& result, reduction::Budget budget, const RigFile& rig) {
  SeriesShot shot;
  shot.name = std::to_string(result.shot_id);
  shot.readout = result.readout;
  shot.budget = std::move(budget);
  shot.calibration = calibration_of(rig);
  shot.ball = ball_of(rig, result.readout.record);
  shot.rejected = result.rejected;
  return shot;
}

std::optional<reduction::Frame> matched_frame(const StoredShot& shot) {
  if (!shot.summary || shot.digitizations.empty()) return std::nullopt;
  AssembledShot assembled =
      assemble(*shot.summary, shot.digitizations.back().frame, assembly_settings(*shot.rig));
  if (assembled.frame.images.empty()) return std::nullopt;
  return std::move(assembled.frame);
}

reduction::Budget budget_of(const StoredShot& shot) {
  const auto frame = matched_frame(shot);
  return frame ? reduction::mixture_budget(*frame, shot.result.readout) : reduction::Budget{};
}

std::vector<SeriesShot> series_shots(const StoredSession& session, const std::string& session_name) {
  std::vector<SeriesShot> shots;
  shots.reserve(session.shots.size());
  for (const StoredShot& stored : session.shots) {
    const bool counts = !stored.result.rejected;
    SeriesShot& shot = shots.emplace_back(
        series_shot(stored.result, counts ? budget_of(stored) : reduction::Budget{}, *stored.rig));
    shot.name = stored.name;
    shot.session = session_name;
  }
  return shots;
}

}  // namespace strobe::host
