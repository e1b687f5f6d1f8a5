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

bool more_exact(const Row& a, const Row& b) {
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

tl::expected<Row, Nearest> choose(std::span<const Row> rows, const Demand& demand) {
  const auto meets = [&](const Row& row) { return demand.met_by(row); };
  const auto chosen = demand.tolerance ? best(rows, meets, cheaper) : best(rows, meets, more_exact);
  if (chosen) return *chosen;
  const auto in_time = [&](const Row& row) { return demand.in_time(row); };
  const auto exact_enough = [&](const Row& row) { return demand.exact_enough(row); };
  const auto any = [](const Row&) { return true; };
  return tl::unexpected(Nearest{.exactest_in_time = best(rows, in_time, more_exact),
                                .fastest_exact_enough = best(rows, exact_enough, cheaper),
                                .fastest = best(rows, any, cheaper),
                                .exactest = best(rows, any, more_exact)});
}

std::string title(const Row& row) {
  return row.parameter.empty() ? row.method : row.method + " " + row.parameter;
}

std::string promise(const Row& row) {
  return percent(row.error) + " " + row.error_unit + " in " + brief(row.cost_us) + " us";
}

std::string demand_text(const Demand& demand) {
  std::string text = demand.tolerance ? tolerance_text(*demand.tolerance) : "";
  if (demand.deadline_us) {
    if (!text.empty()) text += " and ";
    text += brief(*demand.deadline_us) + " us";
  }
  return text.empty() ? "no demand" : text;
}

std::string reason(std::span<const Row> rows, const Demand& demand) {
  const std::string of = rows.size() == 1 ? "" : " of " + std::to_string(rows.size()) + " methods";
  const std::string what = demand.tolerance ? "the cheapest" : "the most exact";
  return rows.size() == 1 ? "the only method, and it meets " + demand_text(demand)
                          : what + of + " that meets " + demand_text(demand);
}

std::string refusal(const Nearest& nearest, const Demand& demand) {
  if (!nearest.fastest) return "the frontier holds no method that could be taken";
  const auto with_promise = [](const Row& row) { return title(row) + " (" + promise(row) + ")"; };
  std::string text = "no method meets " + demand_text(demand);
  if (demand.deadline_us)
    text += nearest.exactest_in_time
                ? "; in time the most exact is " + with_promise(*nearest.exactest_in_time)
                : "; the fastest of all is " + with_promise(*nearest.fastest);
  if (demand.tolerance)
    text += nearest.fastest_exact_enough
                ? "; exact enough the fastest is " + with_promise(*nearest.fastest_exact_enough)
                : "; the most exact of all is " + with_promise(*nearest.exactest);
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
