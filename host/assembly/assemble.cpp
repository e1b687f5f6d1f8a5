#include "host/assembly/assemble.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/flight/parabola.hpp"
#include "common/geometry/leg_classification.hpp"
#include "common/geometry/line.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "common/messages/record.hpp"
#include "common/reduction/matching/flash_match.hpp"
#include "common/units/angles.hpp"
#include "host/assembly/camera_map.hpp"
#include "host/assembly/flash_times.hpp"
#include "host/config/notes.hpp"
#include "host/digitize/core/statistics.hpp"

namespace strobe::host {
namespace {

using reduction::BallImage;
using reduction::Flag;
using reduction::FlagSet;
using reduction::Frame;
using strobe_msgs::frame_t;
using strobe_msgs::shot_t;

// A machine that has warmed up repeats its lag to about 10 ms, where the rig file does not say better.
constexpr double kMachineLagScale_s = 0.010;
// The digitizer misses three airborne images in 36,921 (host/digitize/README.md); of images in contact, which
// are fewer, no more is known than that they are found nearly as well.
constexpr double kMissedByDigitizer = 0.001;

double surface_angle_deg(const shot_t& shot, const AssemblySettings& settings) {
  if (settings.analysis.surface_angle_deg) return *settings.analysis.surface_angle_deg;
  return note_number(record_of(shot), "surface_angle_deg").value_or(0.0);
}

/// What the frame takes from the shot and the rig: all but the times of its images.
void set_rig(Frame& frame, const shot_t& shot, const AssemblySettings& settings) {
  frame.shot_id = shot.shot_id;
  frame.record = record_of(shot);
  frame.ball_diameter_m = settings.ball.diameter_m;
  frame.ball_diameter_sd_m = settings.ball.diameter_sd_m;
  frame.ball_mass_kg = settings.ball.mass_kg;
  frame.ball_alpha = settings.ball.alpha;
  frame.fastest_spin_radps = settings.ball.fastest_spin_radps;
  frame.ball_alpha_sd = settings.ball.alpha_sd;
  if (settings.ball.kind) frame.air_law = settings.ball.kind->air;
  frame.line_drawn = settings.ball.line;
  if (!frame.px_per_m) {
    frame.px_per_m = settings.analysis.px_per_m;
    frame.px_per_m_sd = settings.analysis.px_per_m_sd;
  }
  set_calibration(settings.camera, frame);
  frame.surface_angle_deg = surface_angle_deg(shot, settings);
  frame.temperature_c = note_number(frame.record, "temperature_c");
}

/// Speed along the path from the first two airborne images, for the time from gate to plate.
std::optional<double> incoming_speed_mps(const matching::Track& track, const FlashTimes& times) {
  if (track.images.size() < 2 || times.seen.size() < 2) return std::nullopt;
  const matching::TrackPoint& a = track.images[0];
  const matching::TrackPoint& b = track.images[1];
  if (b.leg != Leg::incoming) return std::nullopt;
  const double step_m = (b.centre_px - a.centre_px).norm() / track.px_per_m;
  const double interval_s = to_seconds(times.seen[1].time - times.seen[0].time);
  if (!(step_m > 0.0) || !(interval_s > 0.0)) return std::nullopt;
  return step_m / interval_s;
}

std::optional<matching::ArrivalPrior> arrival_prior(const shot_t& shot, const matching::Track& track,
                                                    const FlashTimes& times,
                                                    const AssemblySettings& settings) {
  const MonoTime origin = times.seen.front().time, gate = from_ns(shot.gate_ns),
                 trigger = from_ns(shot.trigger_ns);
  const auto speed = incoming_speed_mps(track, times);
  if (known(gate) && settings.analysis.gate_distance_m && speed) {
    // The speed itself is known to a few per cent only before the match.
    const double flight_s = *settings.analysis.gate_distance_m / *speed;
    const double scale_s = std::hypot(settings.analysis.gate_distance_sd_m / *speed, 0.05 * flight_s);
    return matching::ArrivalPrior{to_seconds(gate - origin) + flight_s, scale_s};
  }
  if (known(trigger) && settings.machine_lag_s) {
    const auto& sd = settings.analysis.machine_lag_sd_s;
    // As narrow in its middle as a normal density with that sd.
    const double scale_s = sd ? std::numbers::sqrt2 * *sd : kMachineLagScale_s;
    return matching::ArrivalPrior{to_seconds(trigger - origin) + *settings.machine_lag_s, scale_s};
  }
  return std::nullopt;
}

/// Flags of the flashes from the first to the last that shows the ball. A double flash also counts where
/// another plausible match puts it among them, and a double or missing flash next to them: if it made an
/// image after all, a leg's images are one flash off.
FlagSet flash_flags(const FlashTimes& times, const matching::FlashMatch& match, int first, int last) {
  FlagSet flags;
  const auto next_to = [first, last](int index) { return index >= first - 1 && index <= last + 1; };
  MonoTime previous = kNoTime;
  for (std::size_t i = 0; i < times.seen.size(); ++i) {
    const ObservedFlash& flash = times.seen[i];
    const bool shows = flash.index >= first && flash.index <= last;
    // A second flash of a lamp leaves the intervals as they are: only the images could tell which it was.
    const bool possible = i < match.possibly_imaged.size() && match.possibly_imaged[i] != 0;
    if (flash.doubled && (shows || possible || next_to(flash.index))) flags.set(Flag::double_flash);
    if (!shows) continue;
    if (flash.late) flags.set(Flag::late_flash);
    if (flash.sensor_silent) flags.set(Flag::sensor_missing);
    if (flash.before_its_pulse || flash.time <= previous) flags.set(Flag::clock_suspect);
    previous = flash.time;
  }
  for (const int index : times.missing) {
    if (next_to(index)) flags.set(Flag::missing_flash);
  }
  return flags;
}

void set_times(Frame& frame, const FlashTimes& times, const matching::FlashAssignment& assignment) {
  const auto flash = [&](std::size_t image) -> const ObservedFlash& {
    return times.seen[static_cast<std::size_t>(assignment.flash[image])];
  };
  for (std::size_t i = 0; i < frame.images.size(); ++i) {
    frame.images[i].time_s = to_seconds(flash(i).time - flash(0).time);
    frame.images[i].time_sd_s = flash(i).time_sd_s;
    frame.images[i].flash_index = flash(i).index;
  }
}

/// From the first on. An image that no flash made under this hypothesis is in contact, where no number
/// depends on its time: it is put between those beside it, so that the times ascend.
std::vector<double> times_after_first(const FlashTimes& times, const std::vector<int>& flash) {
  const auto time_s = [&](std::size_t i) {
    const auto at = [&](std::size_t k) { return times.seen[static_cast<std::size_t>(flash[k])].time; };
    return to_seconds(at(i) - at(0));
  };
  std::vector<double> result;
  result.reserve(flash.size());
  for (std::size_t i = 0; i < flash.size(); ++i) {
    std::size_t next = i;
    while (flash[next] == matching::kNoFlash) ++next;
    const double share = 1.0 / static_cast<double>(next - i + 1);
    result.push_back(next == i ? time_s(i) : result.back() + share * (time_s(next) - result.back()));
  }
  return result;
}

std::vector<reduction::AssignedTimes> assigned_times(const FlashTimes& times,
                                                     const matching::FlashMatch& match) {
  std::vector<reduction::AssignedTimes> assigned;
  assigned.reserve(match.hypotheses.size());
  for (const matching::FlashAssignment& hypothesis : match.hypotheses)
    assigned.push_back({times_after_first(times, hypothesis.flash), hypothesis.weight});
  return assigned;
}

/// What the matching has to know of the ball besides its images.
void set_physics(matching::Track& track, const Frame& frame, const FlashTimes& times) {
  const ball::Ball ball{frame.ball_diameter_m, frame.ball_mass_kg.value_or(ball::kThesisMass_kg),
                        frame.ball_alpha.value_or(ball::kMeasuredAlpha)};
  track.air = flight::aerodynamics(ball, flight::air_density_kgpm3(frame.temperature_c.value_or(20.0)), {},
                                   frame.air_law.value_or(flight::AirLaw{}));
  for (const ObservedFlash& flash : times.seen) track.time_sd_s = std::max(track.time_sd_s, flash.time_sd_s);
}

AssembledShot unmatched(AssembledShot& shot, Flag flag, std::string problem) {
  shot.flags.set(flag);
  shot.problem = std::move(problem);
  shot.frame.images.clear();
  return std::move(shot);
}

/// Flagged where it is a ball's by its looks: it then contradicts the others.
void leave_out(std::size_t image, matching::Track& track, AssembledShot& shot) {
  const auto at = static_cast<std::ptrdiff_t>(image);
  if (track.images[image].probability > 0.5) shot.flags.set(Flag::outlier_image);
  track.images.erase(track.images.begin() + at);
  shot.frame.images.erase(shot.frame.images.begin() + at);
}

/// The images that no flash made under the likeliest hypothesis.
void leave_out_unmatched(matching::FlashMatch& match, matching::Track& track, AssembledShot& shot) {
  for (std::size_t i = track.images.size(); i-- > 0;) {
    if (match.hypotheses.front().flash[i] != matching::kNoFlash) continue;
    leave_out(i, track, shot);
    for (matching::FlashAssignment& one : match.hypotheses)
      one.flash.erase(one.flash.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

/// Which flashes made the images. One that none made is left out of track and shot.
std::optional<matching::FlashMatch> matched(const FlashTimes& times,
                                            const std::optional<matching::ArrivalPrior>& prior,
                                            matching::Track& track, AssembledShot& shot) {
  std::vector<double> times_s;
  times_s.reserve(times.seen.size());
  for (const ObservedFlash& flash : times.seen)
    times_s.push_back(to_seconds(flash.time - times.seen.front().time));
  auto match = matching::match_flashes(times_s, track, prior);
  if (!match) return std::nullopt;
  if (auto found = matching::find_false_image(times_s, track, prior, *match)) {
    leave_out(found->image, track, shot);
    match = std::move(found->match);
  }
  leave_out_unmatched(*match, track, shot);
  return match;
}

bool no_sensor_fired(const FlashTimes& times, const shot_t& shot) {
  return !times.measured && !times.seen.empty() && (shot.sensor_a_fitted || shot.sensor_b_fitted);
}

}  // namespace

matching::DwellLimits contact_of(const BallSettings& ball) {
  return ball.kind ? matching::DwellLimits::about(ball.kind->contact.dwell_s)
                   : matching::DwellLimits::of_diameter(ball.diameter_m);
}

AssemblySettings assembly_settings(const RigFile& rig) {
  return {rig.ball, rig.analysis, rig.machine_lag_s, rig.camera, false};
}

reduction::Record record_of(const shot_t& shot) {
  return messages::record_from_notes(shot.notes).value_or(reduction::Record{});
}

FlagSet shot_flags(const shot_t& shot) {
  FlagSet flags;
  if (shot.aborted) flags.set(Flag::shot_aborted);
  if (shot.queue_overflows > 0 || shot.kernel_overflows > 0) flags.set(Flag::events_missing);
  if (shot.shutter_feedback == shot_t::FEEDBACK_MISSING || shot.shutter_feedback == shot_t::FEEDBACK_LATE)
    flags.set(Flag::shutter_suspect);
  return flags;
}

reduction::Readout empty_readout(const shot_t& shot, const FlagSet& flags) {
  reduction::Readout readout;
  readout.shot_id = shot.shot_id;
  readout.method = "best";
  readout.flags = flags;
  readout.record = record_of(shot);
  return readout;
}

AssembledShot assemble(const shot_t& shot, const frame_t& message, const AssemblySettings& settings) {
  AssembledShot result;
  result.flags = shot_flags(shot);
  result.times = flash_times(shot, settings.analysis.flash_time_sd_s);
  const FlashTimes& times = result.times;
  auto frame = messages::frame_from_lcm(message);
  if (!frame) return unmatched(result, Flag::degenerate_geometry, frame.error().message);
  result.frame = std::move(*frame);
  set_rig(result.frame, shot, settings);
  if (result.frame.images.empty())
    return unmatched(result, Flag::too_few_images,
                     "no image of the ball on the photograph whose leg could be told");
  auto track = matching::image_track(result.frame);
  if (!track) {
    return unmatched(result, Flag::degenerate_geometry,
                     result.frame.surface_px.empty()
                         ? "no surface line on the photograph"
                         : "the frame has no surface line or an image without a size");
  }
  if (no_sensor_fired(times, shot)) result.flags.set(Flag::sensor_missing);
  if (times.seen.empty())
    return unmatched(result, Flag::missing_flash, "images, but no flash was seen or issued");
  if (!times.in_order) {
    result.flags.set(Flag::clock_suspect);
    return unmatched(result, Flag::flash_match_ambiguous, "flash times are out of order");
  }
  if (message.source == "auto") track->missed_share = kMissedByDigitizer;
  const bool dropped = matching::allow_for_drop(*track);
  set_physics(*track, result.frame, times);
  track->dwell = contact_of(settings.ball);
  const auto match = matched(times, arrival_prior(shot, *track, times, settings), *track, result);
  if (!match) return unmatched(result, Flag::flash_match_ambiguous, "more images than flashes were seen");
  if (!matching::is_steady(*track, *match))
    return unmatched(result, Flag::flash_match_ambiguous,
                     dropped
                         ? "no fall and rise along one line passes through the images: steps of one to two "
                           "diameters from flash to flash tell them apart (plan: drop_height_m)"
                         : "no steady flight passes through the images");
  assert(match->hypotheses.front().flash.size() == result.frame.images.size());
  set_times(result.frame, times, match->hypotheses.front());
  result.hypotheses = assigned_times(times, *match);
  const reduction::ImagedFlashes flashes{*result.frame.images.front().flash_index,
                                         *result.frame.images.back().flash_index,
                                         match->misassignment_probability, shot.plan.code_count > 0};
  if (flashes.coded && flashes.misassignment_probability > matching::kMaxMisassignmentProbability)
    result.flags.set(Flag::flash_index_ambiguous);
  result.flags.merge(flash_flags(times, *match, flashes.first, flashes.last));
  result.flashes = flashes;
  return result;
}

ShotReadout shot_readout(const shot_t& shot, const frame_t& frame, const AssemblySettings& settings) {
  AssembledShot assembled = assemble(shot, frame, settings);
  if (assembled.frame.images.empty())
    return {empty_readout(shot, assembled.flags), assembled.problem, std::move(assembled.times)};
  auto readout = reduction::reduce_hypotheses(assembled.frame, assembled.hypotheses);
  if (!readout) {
    assembled.flags.set(Flag::degenerate_geometry);
    return {empty_readout(shot, assembled.flags), readout.error().message, std::move(assembled.times)};
  }
  readout->flags.merge(assembled.flags);
  readout->flashes = assembled.flashes;
  ShotReadout result{std::move(*readout), assembled.problem, std::move(assembled.times)};
  if (settings.budgets) result.matched = std::move(assembled.frame);
  return result;
}

}  // namespace strobe::host
