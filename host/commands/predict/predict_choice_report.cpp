#include "host/commands/predict/predict_choice_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/messages/or_null.hpp"
#include "host/commands/frontier/choice_json.hpp"

namespace strobe::host {

namespace {

using nlohmann::ordered_json;

ordered_json checked_json(ordered_json out, const TriedModel& tried) {
  out["error_estimate"] = messages::or_null(tried.error_estimate);
  out["checked_by"] = tried.checked_by ? row_json(*tried.checked_by) : ordered_json(nullptr);
  return out;
}

std::string promise_text(const ImpactChoice& choice) {
  const double error_percent = choice.promise.error * 100.0;
  switch (choice.promise.basis) {
    case PromiseBasis::check:
      return fmt::format("promised for this impact: {:.2g}%, by the check", error_percent);
    case PromiseBasis::error_control:
      return fmt::format("promised for this impact: {:.2g}%, by the method's own error control",
                         error_percent);
    case PromiseBasis::worst_measured:
      break;
  }
  return fmt::format(
      "promised: {:.2g}%, the worst of all contacts measured; nothing is known of this impact's",
      error_percent);
}

std::string check_text(const TriedModel& tried) {
  return fmt::format("{:.2g}% on this impact, by {}", *tried.error_estimate * 100.0,
                     frontier::label(*tried.checked_by));
}

}  // namespace

ordered_json choice_json(const ImpactChoice& choice, const frontier::Requirement& requirement) {
  ordered_json out{{"study", choice.taken.row.study},
                   {"tolerance", messages::or_null(requirement.tolerance)},
                   {"deadline_us", messages::or_null(requirement.deadline_us)}};
  out.update(row_json(choice.taken.row));
  out["error_unit"] = choice.taken.row.error_unit;
  out["reason"] = choice.reason;
  out = checked_json(std::move(out), choice.taken);
  out["within_tolerance"] = messages::or_null(choice.within_tolerance);
  out["outside_measured"] = choice.outside;
  out["replaced"] = ordered_json::array();
  for (const TriedModel& tried : choice.replaced)
    out["replaced"].push_back(checked_json(row_json(tried.row), tried));
  out["total_expected_cost_us"] = choice.expected_cost_us;
  out["promised_error"] = choice.promise.error;
  out["promised_by"] = name(choice.promise.basis);
  return out;
}

std::vector<std::string> choice_lines(const ImpactChoice& choice, const frontier::Requirement& requirement) {
  std::vector<std::string> lines;
  const TriedModel& taken = choice.taken;
  for (const TriedModel& tried : choice.replaced)
    lines.push_back(fmt::format("not {}: error {}", frontier::label(tried.row), check_text(tried)));
  lines.push_back(fmt::format("chosen {}: {}{}; at most {} as measured", frontier::label(taken.row),
                              choice.replaced.empty() ? "" : "what the check ran, instead of ", choice.reason,
                              frontier::accuracy_and_cost(taken.row)));
  if (taken.error_estimate)
    lines.push_back("error " + check_text(taken));
  else
    lines.push_back(requirement.deadline_us
                        ? "not checked on this impact: no time for a more exact run"
                        : "not checked on this impact: no more exact method was measured");
  lines.push_back(promise_text(choice));
  if (!choice.outside.empty())
    lines.push_back(fmt::format("outside of what was measured: {}", fmt::join(choice.outside, ", ")));
  return lines;
}

}  // namespace strobe::host
