#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/messages/or_null.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/commands/frontier/choice_json.hpp"
#include "host/commands/reduce/reduce_choice.hpp"

namespace strobe::host {

namespace {

using nlohmann::ordered_json;

}  // namespace

std::string choice_json(const EstimatorChoice& choice, const frontier::Requirement& requirement) {
  ordered_json out{{"study", choice.row.study},
                   {"tolerance", messages::or_null(requirement.tolerance)},
                   {"deadline_us", messages::or_null(requirement.deadline_us)}};
  out.update(row_json(choice.row));
  out["error_unit"] = choice.row.error_unit;
  out["reason"] = choice.reason;
  out["largest_sd"] = choice.noise ? ordered_json(choice.noise->share) : ordered_json(nullptr);
  out["largest_sd_of"] = choice.noise ? ordered_json(name(choice.noise->quantity)) : ordered_json(nullptr);
  out["noise_beyond_tolerance"] = choice.noise_beyond_tolerance;
  out["outside_measured"] = choice.outside;
  out["replaced"] = choice.replaced ? row_json(*choice.replaced) : ordered_json(nullptr);
  out["total_expected_cost_us"] = choice.expected_cost_us;
  return messages::json_text(out);
}

std::vector<std::string> choice_lines(const EstimatorChoice& choice) {
  std::vector<std::string> lines;
  if (choice.replaced)
    lines.push_back(fmt::format("not {}: its sd on this frame is beyond the tolerance",
                                frontier::label(*choice.replaced)));
  lines.push_back(fmt::format("chosen {}: {}{}; adds {} as measured", frontier::label(choice.row),
                              choice.replaced ? "the most exact in time, instead of " : "", choice.reason,
                              frontier::accuracy_and_cost(choice.row)));
  if (choice.noise_beyond_tolerance)
    lines.push_back(fmt::format("the photograph's own noise is beyond the tolerance: sd of {} {:.2g}%",
                                name(choice.noise->quantity), choice.noise->share * 100.0));
  if (!choice.outside.empty())
    lines.push_back(fmt::format("outside of what was measured: {}", fmt::join(choice.outside, ", ")));
  return lines;
}

}  // namespace strobe::host
