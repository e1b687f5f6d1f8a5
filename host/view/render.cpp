#include "host/view/render.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "host/config/notes.hpp"
#include "host/session/rejection.hpp"
#include "host/view/quantities.hpp"
#include "host/view/rejected_commands.hpp"
#include "host/view/text.hpp"
#include "host/view/timing.hpp"

namespace strobe::host {
namespace {

using reduction::Quantities;
using reduction::Quantity;
using strobe_msgs::status_t;
using Lines = std::vector<std::string>;

constexpr std::size_t kNameWidth = 17;
constexpr std::size_t kUnitWidth = 6;
constexpr std::size_t kNumberWidth = 10;
constexpr std::size_t kNotificationsShown = 5;

Lines fitted(Lines lines, std::size_t width) {
  for (std::string& line : lines) {
    line = cut(line, width);
    while (!line.empty() && line.back() == ' ') line.pop_back();
  }
  return lines;
}

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
      return "spent, to be armed anew";
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

/// Why nothing can be fired, if it cannot: the caller's words, else the firmware's.
std::string blocking_reason_of(const ViewModel& model) {
  if (!model.blocking_reason.empty()) return model.blocking_reason;
  if (!model.status) return "no firmware heard";
  if (model.silent) return fmt::format("the firmware has been silent for {:.0f} s", model.status_age_s);
  return model.status->message;
}

std::string value_text(const Quantities& values, const Quantities& sds, Quantity q) {
  return values[q] ? rounded(*values[q], sds[q].value_or(0.0)) : "-";
}

std::string sd_text(const std::optional<double>& sd, double scale) {
  return sd ? "± " + rounded(*sd, scale) : "";
}

std::string shot_row(const reduction::Readout& readout, Quantity q) {
  const QuantityLabel& label = kQuantityLabels[static_cast<std::size_t>(q)];
  const double sd = readout.sd[q].value_or(0.0);
  // Given the diameter, these do not depend on it: a systematic sd of rounding size is none.
  const auto& systematic = readout.sd_systematic[q];
  const bool shown = systematic && *systematic > 1e-3 * sd;
  return left(label.words, kNameWidth) + right(value_text(readout.value, readout.sd, q), kNumberWidth) + " " +
         left(sd_text(readout.sd[q], sd), kNumberWidth) + " " +
         left(shown ? sd_text(systematic, sd > 0.0 ? sd : *systematic) : "", kNumberWidth) + " " +
         left(label.unit, kUnitWidth);
}

std::string series_cells(const reduction::RunningStatistics& series) {
  if (series.count() == 0) return right("-", kNumberWidth) + right("", kNumberWidth + 9 + 5);
  const double sd = series.population_sd();
  const std::string variation = series.count() > 1 && std::isfinite(series.coefficient_of_variation())
                                    ? fmt::format("{:.1f} %", 100.0 * series.coefficient_of_variation())
                                    : "";
  return right(rounded(series.mean(), sd), kNumberWidth) +
         right(series.count() > 1 ? "± " + rounded(sd, sd) : "", kNumberWidth) + right(variation, 9) +
         right(std::to_string(series.count()), 5);
}

/// The thesis's column of each quantity, in the order of Quantity; null: it has none.
using C = thesis::Condition;
constexpr std::array<thesis::MeanSd C::*, reduction::kQuantityCount> kThesisColumns{&C::theta_in_deg,
                                                                                    &C::theta_out_deg,
                                                                                    &C::vx_td_mps,
                                                                                    &C::vy_td_mps,
                                                                                    &C::v_td_mps,
                                                                                    &C::omega_td_radps,
                                                                                    &C::vx_lo_mps,
                                                                                    &C::vy_lo_mps,
                                                                                    &C::v_lo_mps,
                                                                                    &C::omega_lo_radps,
                                                                                    nullptr,
                                                                                    &C::e,
                                                                                    &C::mu,
                                                                                    &C::dwell_time_ms,
                                                                                    &C::dwell_distance_cm,
                                                                                    nullptr};

/// Tables 2-4 hold the incoming, 5-7 the rebounding ball, 8-10 the parameters; one each for zero, top, back
/// spin.
int first_table(const thesis::Condition& c) { return c.spin == "top" ? 3 : c.spin == "back" ? 4 : 2; }

std::string thesis_cells(const thesis::Condition& condition, Quantity q,
                         const reduction::RunningStatistics& series) {
  const auto column = kThesisColumns[static_cast<std::size_t>(q)];
  if (!column) return "";
  const thesis::MeanSd* printed = &(condition.*column);
  std::string cells = right(fmt::format("{:.2f}", printed->mean), kNumberWidth) +
                      right(fmt::format("± {:.2f}", printed->sd), kNumberWidth);
  if (series.count() > 0 && printed->sd > 0.0) {
    cells += right(fmt::format("{:+.1f} sd", (series.mean() - printed->mean) / printed->sd), 10);
  }
  return cells;
}

void append(Lines& lines, const Lines& more) { lines.insert(lines.end(), more.begin(), more.end()); }

std::string headline(const ShotResult& shot_result) {
  std::string text = fmt::format("shot {}", shot_result.shot_id);
  if (shot_result.dry) text += "   dry";
  if (shot_result.readout.regime) text += "   " + std::string(name(*shot_result.readout.regime));
  if (shot_result.readout.value[Quantity::court_pace] && !shot_result.readout.court_pace_conforming) {
    text += "   court pace indicative";
  }
  if (shot_result.rejected) text += "   REJECTED";
  if (!shot_result.verified) text += "   unverified";
  return text;
}

Lines remarks(const ShotResult& shot_result) {
  Lines lines;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (shot_result.readout.flags.has(flag)) lines.push_back("! " + std::string(words(flag)));
  }
  if (!shot_result.problem.empty()) lines.push_back("! " + shot_result.problem);
  const auto& flashes = shot_result.readout.flashes;
  if (flashes && flashes->coded) {
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

bool has_numbers(const ShotResult& shot_result) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    if (shot_result.readout.value[static_cast<Quantity>(i)]) return true;
  }
  return false;
}

std::string shot_header() {
  return left("", kNameWidth) + right("value", kNumberWidth) + " " + left("± sd", kNumberWidth) + " " +
         left("± ball", kNumberWidth) + " " + left("unit", kUnitWidth);
}

constexpr std::string_view kSeriesHeader = "      mean        sd  variation   n";

Lines shot_beside_series(const ViewModel& model) {
  Lines lines{shot_header() + std::string(kSeriesHeader)};
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    lines.push_back(shot_row(model.last->readout, q) + series_cells(model.series.of(q)));
  }
  return lines;
}

}  // namespace

Lines render_firmware(const ViewModel& model, std::size_t width) {
  Lines lines;
  if (model.status) {
    const status_t& s = *model.status;
    lines.push_back(fmt::format("firmware {}   key {}   e-stop {}   real time {}", state_name(s),
                                s.key_active ? "on" : "OFF", s.estop_active ? "PRESSED" : "released",
                                s.real_time ? "yes" : "NO"));
    lines.push_back(fmt::format("lost: queue {}, kernel {}, link {}{}", s.queue_overflows, s.kernel_overflows,
                                model.events_missing, rejected_commands_text(s)));
    lines.push_back(clock_line(model.clock, model.status_age_s));
    append(lines, render_timing(s));
  }
  if (const std::string unverified = unverified_text(model); !unverified.empty()) lines.push_back(unverified);
  if (const std::string blocking_reason = blocking_reason_of(model); !blocking_reason.empty())
    lines.push_back("MISSING: " + blocking_reason);
  if (!model.activity.empty()) lines.push_back(model.activity);
  return fitted(std::move(lines), width);
}

Lines render_shot(const ShotResult& shot_result, std::size_t width) {
  Lines lines{headline(shot_result)};
  if (shot_result.dry) append(lines, describe(shot_result.train));
  if (has_numbers(shot_result)) {
    lines.push_back(shot_header());
    for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
      lines.push_back(shot_row(shot_result.readout, static_cast<Quantity>(i)));
    }
  }
  append(lines, remarks(shot_result));
  return fitted(std::move(lines), width);
}

Lines render_series(const SeriesStatistics& series, const std::optional<thesis::Condition>& condition,
                    std::size_t width) {
  Lines lines{fmt::format("series of {} shots", series.shots())};
  std::string header = left("", kNameWidth) + left("unit", kUnitWidth) + std::string(kSeriesHeader);
  if (condition) {
    const int table = first_table(*condition);
    header += fmt::format("    thesis {} {}, Tables {}, {}, {}", condition->spin, condition->angle_label_deg,
                          table, table + 3, table + 6);
  }
  lines.push_back(header);
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const QuantityLabel& label = kQuantityLabels[i];
    std::string line =
        left(label.words, kNameWidth) + left(label.unit, kUnitWidth) + series_cells(series.of(q));
    if (condition) line += thesis_cells(*condition, q, series.of(q));
    lines.push_back(line);
  }
  return fitted(std::move(lines), width);
}

Lines render(const ViewModel& model, std::size_t width) {
  Lines lines{model.title};
  append(lines, render_firmware(model, width));
  lines.emplace_back();
  const std::size_t both = columns(shot_header()) + kSeriesHeader.size();
  if (!model.last) {
    lines.push_back("no shot yet");
  } else if (has_numbers(*model.last) && width >= both) {
    lines.push_back(headline(*model.last) + fmt::format("   series of {} shots", model.series.shots()));
    append(lines, shot_beside_series(model));
    append(lines, remarks(*model.last));
  } else {
    append(lines, render_shot(*model.last, width));
  }
  lines.emplace_back();
  const std::size_t first =
      model.notifications.size() > kNotificationsShown ? model.notifications.size() - kNotificationsShown : 0;
  for (std::size_t i = first; i < model.notifications.size(); ++i)
    lines.push_back("· " + model.notifications[i]);
  return fitted(std::move(lines), width);
}

}  // namespace strobe::host
