#include "host/view/render.hpp"

#include <fmt/format.h>
#include <array>
#include <cmath>
#include <utility>

#include "common/reduction/uncertainty.hpp"
#include "host/config/notes.hpp"
#include "host/series/select.hpp"
#include "host/session/advice.hpp"
#include "host/session/shot.hpp"
#include "host/session/shot_table.hpp"
#include "host/text/text.hpp"
#include "host/view/series_view.hpp"
#include "host/view/spatial_view.hpp"
#include "host/view/timing.hpp"

namespace strobe::host {
namespace {

using reduction::Quantity;
using reduction::total_sd;
using strobe_msgs::status_t;
using Lines = std::vector<std::string>;

constexpr std::size_t kNotificationsShown = 5;

std::string state_name(const status_t& status) {
  switch (status.state) {
    case status_t::IDLE:
      return "idle";
    case status_t::ARMED: {
      const double left_s = to_seconds(from_ns(status.arm_expires_ns) - from_ns(status.mono_ns));
      return fmt::format("ARMED, for {:.0f} s more", std::max(0.0, left_s));
    }
    case status_t::FIRING:
      return "FIRING";
    case status_t::FAULT:
      return "FAULT";
    case status_t::SPENT:
      return "arming spent, arm again";
    case status_t::STOPPED:
      return "STOPPED, until a person gives the command to fire anew";
    default:
      return "unknown state";
  }
}

std::string rejected_commands_text(const status_t& s) {
  std::string words;
  for (const RejectedCommandLabel& label : kRejectedCommandLabels) {
    if (s.*label.count <= 0) continue;
    words +=
        fmt::format("{}{} {}", words.empty() ? "   commands ignored: " : ", ", s.*label.count, label.words);
  }
  return words;
}

std::string unverified_text(const ViewModel& model) {
  if (!model.verified) return "UNVERIFIED: without the lab's key, anybody's messages are shown";
  std::string words;
  for (std::size_t i = 0; i < authentication::kUnverifiedCount; ++i) {
    const auto why = static_cast<authentication::Unverified>(i);
    if (model.unverified[why] > 0)
      words += fmt::format("{}{} {}", words.empty() ? "packets ignored: " : ", ", model.unverified[why],
                           authentication::words(why));
  }
  return words;
}

/// The court pace is the ITF's for shots as it prescribes them only.
bool is_shown(const reduction::Readout& readout, Quantity q, bool all) {
  if (all || is_essential(q)) return true;
  return q == Quantity::court_pace && readout.value[q] && readout.court_pace_conforming;
}

std::string plus_minus(const std::optional<double>& number, double uncertainty) {
  return number ? left("± " + rounded(*number, uncertainty), kNumberWidth) : left("", kNumberWidth);
}

/// The value with two digits of its standard uncertainty, `all`: and what that is made of.
std::string shot_row(std::string_view words, std::string_view unit, const reduction::Numbers& numbers,
                     Quantity q, bool all) {
  const auto total = total_sd(numbers, q);
  const double digits = total.value_or(0.0);
  std::string line = left(words, kNameWidth) +
                     right(numbers.value[q] ? rounded(*numbers.value[q], digits) : "-", kNumberWidth) + " " +
                     plus_minus(total, digits) + " " + left(unit, kUnitWidth);
  if (!all) return line;
  return line + " " + plus_minus(numbers.sd[q], digits) + " " + plus_minus(numbers.sd_systematic[q], digits) +
         " " + plus_minus(reduction::expanded_uncertainty(numbers, q), digits);
}

std::string shot_row(const reduction::Readout& readout, Quantity q, bool all) {
  const auto& label = kQuantityLabels[static_cast<std::size_t>(q)];
  return shot_row(label.words, label.unit, readout, q, all);
}

std::string shot_row(std::string_view words, std::string_view unit, const reduction::DerivedNumber& number,
                     bool all) {
  // In the place of any number.
  reduction::Numbers numbers;
  numbers.value[Quantity::v_lo_mps] = number.value;
  numbers.sd[Quantity::v_lo_mps] = number.sd;
  numbers.sd_systematic[Quantity::v_lo_mps] = number.sd_systematic;
  return shot_row(words, unit, numbers, Quantity::v_lo_mps, all);
}

/// Of a ball that was dropped; `all`: and what is told of the third dimension.
Lines more_rows(const reduction::Readout& readout, bool all) {
  Lines lines;
  if (const auto& drop = readout.drop) {
    lines.push_back(shot_row("fall height", "m", drop->fall_height_m, all));
    lines.push_back(shot_row("rebound height", "m", drop->rebound_height_m, all));
  }
  for (std::size_t i = 0; all && readout.spatial && i < reduction::kSpatialCount; ++i)
    if (const auto& number = readout.spatial->number[i])
      lines.push_back(shot_row(kSpatialLabels[i].words, kSpatialLabels[i].unit, *number, true));
  return lines;
}

std::string series_cells(const QuantitySummary& s) {
  const double total = s.total_sd.value_or(s.standard_error.value_or(s.shared_sd));
  const auto cell = [&](const std::optional<double>& number) {
    return right(number ? rounded(*number, total) : "", kNumberWidth);
  };
  if (s.n == 0) return right("-", kNumberWidth) + right("", 4 * kNumberWidth + 5);
  return cell(s.mean) + cell(s.expanded_uncertainty) + cell(s.scatter_sd) + cell(s.standard_error) +
         cell(s.shared_known ? std::optional(s.shared_sd) : std::nullopt) + right(std::to_string(s.n), 5);
}

void append(Lines& lines, const Lines& more) { lines.insert(lines.end(), more.begin(), more.end()); }

std::string headline(const Shot& shot_result, bool all) {
  std::string text = fmt::format("shot {}", shot_result.shot_id);
  if (shot_result.dry) text += "   dry";
  if (shot_result.readout.regime) text += "   " + std::string(name(*shot_result.readout.regime));
  if (all && shot_result.readout.value[Quantity::court_pace] && !shot_result.readout.court_pace_conforming)
    text += "   court pace indicative";
  if (shot_result.rejected) text += "   REJECTED";
  if (!shot_result.verified) text += "   unverified";
  return text;
}

/// Flags in words, what to do about them, and what is recorded of the shot.
Lines remarks(const Shot& shot_result, bool all, std::size_t width) {
  Lines lines;
  const auto add = [&](const std::string& text) { append(lines, wrapped(text, width)); };
  for (const std::string& sentence : spatial_words(shot_result.readout)) add(sentence);
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (shot_result.readout.flags.has(flag))
      add("! " + words(flag, shot_result.readout, shot_result.train.faults));
  }
  if (const auto& cause = shot_result.readout.likely_cause) add("! " + words(*cause));
  if (!shot_result.problem.empty()) add("! " + shot_result.problem);
  if (const std::string what = advice(shot_result); !what.empty()) add("What to do: " + what);
  const auto& flashes = shot_result.readout.flashes;
  if (all && flashes && flashes->coded) {
    // Rivals that are hopeless are left out of the sum, so that 0 is not to be taken at its word.
    const double misassigned_percent = 100.0 * flashes->misassignment_probability;
    const std::string others =
        misassigned_percent < 0.01 ? "less than 0.01" : fmt::format("{:.2g}", misassigned_percent);
    lines.push_back(fmt::format("code: flashes {} to {} show the ball; that it was others is {} % probable",
                                flashes->first, flashes->last, others));
  }
  std::string notes;
  for (const std::string_view key : kNamedNotes) {
    const auto note = shot_result.readout.record.find(std::string(key));
    if (note == shot_result.readout.record.end() || note->second.empty()) continue;
    notes += fmt::format("{}{} {}", notes.empty() ? "" : ", ", key, note->second);
  }
  if (!notes.empty()) lines.push_back("record: " + notes);
  return lines;
}

bool has_numbers(const Shot& shot_result) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    if (shot_result.readout.value[static_cast<Quantity>(i)]) return true;
  }
  return false;
}

std::string shot_header(bool all) {
  std::string line = left("", kNameWidth) + right("value", kNumberWidth) + " " + left("± sd", kNumberWidth) +
                     " " + left("unit", kUnitWidth);
  if (!all) return line;
  return line + " " + left("± noise", kNumberWidth) + " " + left("± ball,air", kNumberWidth) + " " +
         left("± 95 %", kNumberWidth);
}

constexpr std::string_view kSeriesHeader = "      mean    ± 95 %   scatter std error    shared    n";

std::string count_words(const Series& series) {
  return fmt::format("series of {} {}", series.counted(), series.counted() == 1 ? "shot" : "shots");
}

Lines shot_beside_series(const ViewModel& model) {
  const SeriesSummary summary = model.series.summary("");
  Lines lines{shot_header(false) + std::string(kSeriesHeader)};
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    if (is_shown(model.last->readout, q, model.all))
      lines.push_back(shot_row(model.last->readout, q, false) + series_cells(summary.quantities[i]));
  }
  append(lines, more_rows(model.last->readout, false));
  return lines;
}

}  // namespace

Lines render_firmware(const ViewModel& model, std::size_t width) {
  Lines lines;
  if (!model.danger.empty()) lines.push_back("!!! " + model.danger);
  if (model.status) {
    const status_t& s = *model.status;
    lines.push_back(fmt::format("firmware {}   key {}   e-stop {}   real time {}", state_name(s),
                                s.key_active ? "on" : "OFF", s.estop_active ? "PRESSED" : "released",
                                s.real_time ? "yes" : "NO"));
    lines.push_back(fmt::format("lost events: queue {}, kernel {}, link {}{}", s.queue_overflows,
                                s.kernel_overflows, model.events_missing, rejected_commands_text(s)));
    lines.push_back(clock_line(model.clock, model.status_age_s));
    if (model.all) append(lines, render_timing(s));
  }
  if (const std::string unverified = unverified_text(model); !unverified.empty()) lines.push_back(unverified);
  const std::string blocking_reason = why_nothing_can_be_fired(model);
  if (!blocking_reason.empty() && blocking_reason != model.danger)
    lines.push_back("cannot fire: " + blocking_reason);
  if (!model.activity.empty()) lines.push_back(model.activity);
  return fitted(std::move(lines), width);
}

Lines render_shot(const Shot& shot_result, std::size_t width, bool all) {
  Lines lines{headline(shot_result, all)};
  if (shot_result.dry) append(lines, describe(shot_result.train));
  if (has_numbers(shot_result)) {
    lines.push_back(shot_header(all));
    for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
      const auto q = static_cast<Quantity>(i);
      if (is_shown(shot_result.readout, q, all)) lines.push_back(shot_row(shot_result.readout, q, all));
    }
    append(lines, more_rows(shot_result.readout, all));
  }
  if (const auto& launch = shot_result.readout.launch) {
    constexpr std::array<std::string_view, reduction::kLaunchQuantities.size()> kWords{
        "launch speed", "launch angle", "launch vx", "launch vy", "launch spin"};
    lines.push_back(shot_header(all));
    for (std::size_t i = 0; i < kWords.size(); ++i) {
      const Quantity q = reduction::kLaunchQuantities[i].quantity;
      lines.push_back(
          shot_row(kWords[i], kQuantityLabels[static_cast<std::size_t>(q)].unit, *launch, q, all));
    }
  }
  append(lines, remarks(shot_result, all, width));
  return fitted(std::move(lines), width);
}

Lines render_series(const Series& series, const std::optional<thesis::Condition>& condition,
                    std::size_t width, bool all) {
  return render_summary(series.summary("series"), condition, width, all);
}

Lines render(const ViewModel& model, std::size_t width) {
  Lines lines{model.title};
  append(lines, render_firmware(model, width));
  lines.emplace_back();
  const std::size_t both = columns(shot_header(false)) + columns(kSeriesHeader);
  if (!model.last) {
    lines.push_back("no shot yet");
  } else if (has_numbers(*model.last) && width >= both) {
    lines.push_back(headline(*model.last, model.all) + "   " + count_words(model.series));
    append(lines, shot_beside_series(model));
    append(lines, remarks(*model.last, model.all, width));
  } else {
    append(lines, render_shot(*model.last, width, model.all));
  }
  lines.emplace_back();
  const std::size_t first =
      model.notifications.size() > kNotificationsShown ? model.notifications.size() - kNotificationsShown : 0;
  for (std::size_t i = first; i < model.notifications.size(); ++i)
    lines.push_back("· " + model.notifications[i]);
  return fitted(std::move(lines), width);
}

namespace {

constexpr std::size_t kMaxNotifications = 50;

}  // namespace

void ViewModel::add(const Shot& result) {
  ++shots;
  last = result;
  if (result.dry) return;
  if (!result.rejected) {
    if (series.counted() > 0 && !differing_keys({&series_condition, &result}).empty()) {
      series = Series();
      add_notification("shots of another condition: the series begins anew");
    }
    series_condition.rig = result.rig;
    series_condition.readout.record = result.readout.record;
  }
  series.add(result);
}

void ViewModel::add_notification(const std::string& text) {
  notifications.push_back(text);
  if (notifications.size() > kMaxNotifications) notifications.erase(notifications.begin());
}

std::optional<std::string> ViewModel::update(Session& session, HostTime now) {
  status = session.status();
  danger = session.danger();
  silent = !session.live_status(now);
  status_age_s = to_seconds(now - session.status_heard());
  events_missing = session.ledger().missing();
  const bool suspect_before = clock.suspect;
  clock = session.clock().state();
  if (!clock.suspect || suspect_before) return std::nullopt;
  return fmt::format("the firmware's clock drifts by {:.0f} ppm against this computer's: not plausible",
                     *clock.drift_ppm);
}

std::string why_nothing_can_be_fired(const ViewModel& model) {
  if (!model.blocking_reason.empty()) return model.blocking_reason;
  if (!model.status) return "no firmware heard";
  if (model.silent) return fmt::format("the firmware has been silent for {:.0f} s", model.status_age_s);
  return model.status->message;
}

}  // namespace strobe::host
