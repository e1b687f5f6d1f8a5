#include "common/frontier/frontier.hpp"

#include <array>
#include <charconv>

#include "common/units/tolerance.hpp"

namespace strobe::frontier {

namespace {

/// Three digits: costs and errors are measured, no more of them holds.
std::string brief(double number) {
  std::array<char, 32> text{};
  const bool whole = number >= 1e3 && number < 1e9;
  const auto [end, error] =
      whole ? std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed, 0)
            : std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::general, 3);
  return error == std::errc{} ? std::string(text.data(), end) : "?";
}

std::string percent(double share) { return brief(share * 100.0) + "%"; }

/// The best of those that meet the condition by `better`, the first of equals.
template <typename Condition, typename Better>
std::optional<Row> best(std::span<const Row> rows, Condition condition, Better better) {
  const Row* found = nullptr;
  for (const Row& row : rows) {
    if (condition(row) && (found == nullptr || better(row, *found))) found = &row;
  }
  return found == nullptr ? std::nullopt : std::optional(*found);
}

bool cheaper(const Row& a, const Row& b) {
  return a.cost_us != b.cost_us ? a.cost_us < b.cost_us : a.error < b.error;
}

bool more_accurate(const Row& a, const Row& b) {
  return a.error != b.error ? a.error < b.error : a.cost_us < b.cost_us;
}

}  // namespace

std::vector<Row> of_study(std::span<const Row> rows, std::string_view study) {
  std::vector<Row> found;
  for (const Row& row : rows) {
    if (row.study == study) found.push_back(row);
  }
  return found;
}

std::optional<std::string_view> parameter_value(std::string_view parameter, std::string_view name) {
  while (!parameter.empty()) {
    const auto end = parameter.find(';');
    const std::string_view part = parameter.substr(0, end);
    const auto equals = part.find('=');
    if (equals != std::string_view::npos && part.substr(0, equals) == name) return part.substr(equals + 1);
    parameter.remove_prefix(end == std::string_view::npos ? parameter.size() : end + 1);
  }
  return std::nullopt;
}

tl::expected<Row, NearestMethods> choose(std::span<const Row> rows, const Requirement& requirement) {
  const auto meets = [&](const Row& row) { return requirement.is_met_by(row); };
  const auto chosen = requirement.tolerance ? best(rows, meets, cheaper) : best(rows, meets, more_accurate);
  if (chosen) return *chosen;
  const auto meets_deadline = [&](const Row& row) { return requirement.meets_deadline(row); };
  const auto meets_tolerance = [&](const Row& row) { return requirement.meets_tolerance(row); };
  const auto any = [](const Row&) { return true; };
  return tl::unexpected(NearestMethods{.most_accurate_in_time = best(rows, meets_deadline, more_accurate),
                                       .fastest_accurate_enough = best(rows, meets_tolerance, cheaper),
                                       .fastest = best(rows, any, cheaper),
                                       .most_accurate = best(rows, any, more_accurate)});
}

std::string label(const Row& row) {
  return row.parameter.empty() ? row.method : row.method + " " + row.parameter;
}

std::string accuracy_and_cost(const Row& row) {
  return percent(row.error) + " " + row.error_unit + " in " + brief(row.cost_us) + " us";
}

std::string requirement_text(const Requirement& requirement) {
  std::string text = requirement.tolerance ? tolerance_text(*requirement.tolerance) : "";
  if (requirement.deadline_us) {
    if (!text.empty()) text += " and ";
    text += brief(*requirement.deadline_us) + " us";
  }
  return text.empty() ? "no requirement" : text;
}

std::string reason(std::span<const Row> rows, const Requirement& requirement) {
  const std::string of = rows.size() == 1 ? "" : " of " + std::to_string(rows.size()) + " methods";
  const std::string what = requirement.tolerance ? "the cheapest" : "the most exact";
  return rows.size() == 1 ? "the only method, and it meets " + requirement_text(requirement)
                          : what + of + " that meets " + requirement_text(requirement);
}

std::string failure_text(const NearestMethods& nearest, const Requirement& requirement) {
  if (!nearest.fastest) return "the frontier holds no method that could be taken";
  const auto with_accuracy = [](const Row& row) { return label(row) + " (" + accuracy_and_cost(row) + ")"; };
  std::string text = "no method meets " + requirement_text(requirement);
  if (requirement.deadline_us)
    text += nearest.most_accurate_in_time
                ? "; in time the most exact is " + with_accuracy(*nearest.most_accurate_in_time)
                : "; the fastest of all is " + with_accuracy(*nearest.fastest);
  if (requirement.tolerance)
    text += nearest.fastest_accurate_enough
                ? "; exact enough the fastest is " + with_accuracy(*nearest.fastest_accurate_enough)
                : "; the most exact of all is " + with_accuracy(*nearest.most_accurate);
  return text;
}

std::vector<std::string> outside(std::span<const Range> ranges, std::string_view study,
                                 std::span<const Quantity> quantities) {
  std::vector<std::string> names;
  for (const Quantity& quantity : quantities) {
    for (const Range& range : ranges) {
      if (range.study != study || range.quantity != quantity.name) continue;
      if (!(quantity.value >= range.lowest && quantity.value <= range.highest))
        names.push_back(range.quantity);
    }
  }
  return names;
}

}  // namespace strobe::frontier
