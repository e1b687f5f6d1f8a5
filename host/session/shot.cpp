#include "host/session/shot.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/messages/json_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/units/angles.hpp"

namespace strobe::host {
namespace {

using reduction::Flag;
using reduction::FlagSet;
using strobe_msgs::shot_t;

Shot of(const shot_t& shot, const FlashTimes& times) {
  Shot result;
  result.boot_id = shot.boot_id;
  result.host_id = shot.host_id;
  result.shot_id = shot.shot_id;
  result.dry = shot.plan.dry;
  result.train = train_report(shot, times);
  result.summary = shot;
  return result;
}

}  // namespace

nlohmann::ordered_json shot_json(const Shot& shot) {
  nlohmann::ordered_json object =
      shot.dry ? train_report_json(shot.train, shot.shot_id) : messages::readout_json(shot.readout);
  object["boot_id"] = fmt::format("{:x}", static_cast<std::uint64_t>(shot.boot_id));
  object["rejected"] = messages::or_null(shot.rejected);
  object["verified"] = shot.verified;
  return object;
}

Shot measured_shot(const shot_t& shot, const strobe_msgs::frame_t& frame, const FlagSet& more,
                   const AssemblySettings& settings) {
  ShotReadout measured = shot_readout(shot, frame, settings);
  Shot result = of(shot, measured.times);
  measured.readout.flags.merge(more);
  result.rejected = rejection_reason(measured.readout,
                                     {settings.analysis.match_tolerance_percent, settings.ball.diameter_m},
                                     result.train.faults);
  result.readout = std::move(measured.readout);
  result.matched = std::move(measured.matched);
  result.problem = shot.aborted ? shot.abort_reason : std::move(measured.problem);
  result.digitizations.push_back({frame, frame.source == "hand", "", "", {}, {}});
  return result;
}

Shot unmeasured_shot(const shot_t& shot, const FlagSet& more, std::string problem) {
  Shot result = of(shot, flash_times(shot));
  FlagSet flags = shot_flags(shot);
  flags.merge(more);
  result.readout = empty_readout(shot, flags);
  result.rejected = rejection_reason(result.readout);
  result.problem = std::move(problem);
  return result;
}

Shot dry_shot(const shot_t& shot) {
  Shot result = of(shot, flash_times(shot));
  result.readout = empty_readout(shot, shot_flags(shot));
  result.problem = shot.abort_reason;
  if (shot.aborted) result.rejected = std::string(words(Flag::shot_aborted));
  return result;
}

Shot interrupted_shot(const ShotKey& key, std::int64_t host_id, bool dry, std::string why) {
  shot_t shot{};
  shot.boot_id = key.boot_id;
  shot.shot_id = key.shot_id;
  shot.host_id = host_id;
  shot.plan.dry = dry;
  shot.aborted = true;
  shot.abort_reason = std::move(why);
  FlagSet flags;
  flags.set(Flag::events_missing);
  Shot result = unmeasured_shot(shot, flags, shot.abort_reason);
  result.summary.reset();
  return result;
}

namespace {

/// In the order of Flag.
constexpr std::array<std::string_view, reduction::kFlagCount> kWords{
    "a flash that shows the ball came late; its measured time was used",
    "a flash among those that show the ball was missing",
    "a lamp flashed twice among the flashes that show the ball",
    "which flash made which image is not certain, and the numbers depend on it",
    "another spin explains the equators as well: the ball may have turned a half turn more or less between "
    "images",
    "too few images of the ball",
    "an image did not fit and was left out",
    "too few to recognize a bad one: fewer than four images or equators on a leg, diameters on the "
    "photograph "
    "or points on the surface",
    "no image in contact",
    "an image given as airborne overlaps the surface and was left out",
    "the points do not make a surface and a path that meets it",
    "uncertainties are estimated from this shot's own residuals",
    "the shot was aborted",
    "the photograph did not come in time",
    "a flash sensor missed flashes that show the ball",
    "flash times are not plausible",
    "events of the shot were lost",
    "the shutter's contact (line xsync) did not show it opening and closing as it should",
    "the train's code leaves open which of its flashes made the images",
    "the air matters, but a leg is too long to be fitted with drag and lift",
    "a surface point did not lie on the line through the others and was left out",
    "the surface line is in doubt: its points disagree, or an image in contact contradicts it",
    "the balls' diameters contradict the calibrated scale, which was believed as far as its sd says",
    "the measurements scatter more than their stated noise explains: uncertainties are too small",
    "the calibrated scale came without an sd and was taken as exact: uncertainties lack its share",
    "a ball spinning faster than any in play would look the same; nobody stated how fast it can spin",
    "the ball flew slower or faster than its kind's drag and lift were measured at",
    "the ball's spin is not about the camera's axis: it was found in three dimensions",
    "the ball came towards the camera, or went away from it",
};

using reduction::Quantity;

/// What a share of it is small to an operator. Returns nullopt if it is not known.
std::optional<double> natural_scale(const reduction::Readout& readout, Quantity q,
                                    const MatchTolerance& tolerance) {
  switch (q) {
    case Quantity::theta_in_deg:
    case Quantity::theta_out_deg:
      return degrees(1.0);
    case Quantity::omega_td_radps:
    case Quantity::omega_lo_radps:
      if (!readout.value[Quantity::v_td_mps]) return std::nullopt;
      return *readout.value[Quantity::v_td_mps] / (0.5 * tolerance.ball_diameter_m);
    case Quantity::e:
    case Quantity::mu:
      return 1.0;
    case Quantity::court_pace:
      return 100.0;
    case Quantity::dwell_time_ms:
      return readout.value[q];
    case Quantity::dwell_distance_cm:  // of a drop it is zero
      if (!readout.value[q]) return std::nullopt;
      return std::max(std::abs(*readout.value[q]), 100.0 * 0.1 * tolerance.ball_diameter_m);
    default:
      return readout.value[Quantity::v_td_mps];
  }
}

/// The number that depends most on which flashes made the images, if it does by more than the tolerance.
std::optional<std::string> match_reason(const reduction::Readout& readout, const MatchTolerance& tolerance) {
  if (!readout.assignments) {
    if (readout.flags.has(Flag::flash_match_ambiguous))
      return std::string(words(Flag::flash_match_ambiguous));
    return std::nullopt;
  }
  double worst = 0.0;
  std::optional<Quantity> which;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto scale = natural_scale(readout, q, tolerance);
    const auto& between = readout.assignments->sd[q];
    if (!between || !scale) continue;
    const double percent = 100.0 * 2.0 * *between / std::abs(*scale);
    if (percent <= std::max(worst, tolerance.percent)) continue;
    worst = percent;
    which = q;
  }
  if (!which) return std::nullopt;
  return fmt::format("{} ({} by {:.2g} %)", words(Flag::flash_match_ambiguous), name(*which), worst);
}

/// "flash 41", "flashes 41, 44, 60 and 5 more": of those that show the ball, where it is known which do.
std::string listed(std::vector<int> flashes, const reduction::Readout& readout) {
  constexpr std::size_t kMax = 4;
  if (readout.flashes) {
    std::erase_if(flashes,
                  [&](int flash) { return flash < readout.flashes->first || flash > readout.flashes->last; });
  }
  if (flashes.empty()) return "";
  std::string text = flashes.size() == 1 ? "flash " : "flashes ";
  for (std::size_t i = 0; i < std::min(kMax, flashes.size()); ++i)
    text += fmt::format("{}{}", i == 0 ? "" : ", ", flashes[i]);
  return text + (flashes.size() > kMax ? fmt::format(" and {} more", flashes.size() - kMax) : "");
}

}  // namespace

std::string_view words(Flag flag) { return kWords[static_cast<std::size_t>(flag)]; }

std::string words(Flag flag, const reduction::Readout& readout, const FlashFaults& faults) {
  const std::string sentence(words(flag));
  std::string which;
  if (flag == Flag::late_flash) which = listed(faults.late, readout);
  if (flag == Flag::double_flash) which = listed(faults.doubled, readout);
  if (flag == Flag::missing_flash) which = listed(faults.missing, readout);
  if (flag == Flag::sensor_missing) {
    const std::string a = listed(faults.unseen_by_a, readout), b = listed(faults.unseen_by_b, readout);
    which = (a.empty() ? "" : "A " + a) + (a.empty() || b.empty() ? "" : "; ") + (b.empty() ? "" : "B " + b);
  }
  return which.empty() ? sentence : sentence + " (" + which + ")";
}

std::string words(const reduction::LikelyCause& cause) {
  const std::string value = fmt::format("{:.3g} ± {:.1g}", cause.value, cause.sd);
  switch (cause.cause) {
    case reduction::Cause::air:
      return "likely cause: the air; with drag and lift " + value + " times those assumed all agrees";
    case reduction::Cause::scale:
      return "likely cause: the calibrated scale; with " + value + " % more px/m all agrees";
    case reduction::Cause::ball_diameter:
      return "likely cause: the ball's diameter; with " + value + " % more all agrees";
    case reduction::Cause::inclination:
      return "likely cause: the inclination of surface or camera; with " + value +
             " degrees more than stated all agrees";
    case reduction::Cause::flash_period:
      return "likely cause: the clock; with " + value + " % more between flashes all agrees";
  }
  return {};
}

std::optional<std::string> rejection_reason(const reduction::Readout& readout,
                                            const MatchTolerance& tolerance, const FlashFaults& faults) {
  constexpr std::array kRejecting{Flag::shot_aborted,       Flag::no_photograph, Flag::too_few_images,
                                  Flag::missing_flash,      Flag::double_flash,  Flag::clock_suspect,
                                  Flag::degenerate_geometry};
  for (const Flag flag : kRejecting) {
    if (readout.flags.has(flag)) return words(flag, readout, faults);
  }
  if (const auto reason = match_reason(readout, tolerance)) return reason;
  return std::nullopt;
}

}  // namespace strobe::host
