#include "host/series/wanted.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace strobe::host {
namespace {

/// Above 0 and finite.
std::optional<double> positive_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value > 0.0 && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

double Wanted::size(double mean) const { return is_relative ? 1e-2 * value * std::abs(mean) : value; }

Result<reduction::Quantity> find_quantity(const std::string& name) {
  const auto& names = reduction::kQuantityNames;
  const auto begins = [&](std::string_view known) { return known.starts_with(name + "_"); };
  auto found = std::ranges::find(names, name);
  if (found == names.end() && std::ranges::count_if(names, begins) == 1)
    found = std::ranges::find_if(names, begins);
  if (found == names.end()) return fail(fmt::format("no \"{}\" among {}", name, fmt::join(names, " ")));
  return static_cast<reduction::Quantity>(found - names.begin());
}

Result<std::vector<Wanted>> parse_wanted(std::string_view option, const std::vector<std::string>& texts,
                                         Percent percent, const std::string& default_quantity) {
  std::vector<Wanted> all;
  for (const std::string& text : texts) {
    const std::string where = fmt::format("{} {}: ", option, text);
    const std::size_t colon = text.find(':');
    const std::string name = colon == text.npos ? default_quantity : text.substr(0, colon);
    std::string_view number = std::string_view(text).substr(colon == text.npos ? 0 : colon + 1);
    if (name.empty()) return fail(where + "of which quantity? As e:0.005 or omega_lo_radps:5");
    const auto quantity = find_quantity(name);
    if (!quantity) return fail(where + quantity.error().message);
    Wanted wanted{*quantity, 0.0, percent == Percent::allowed && number.ends_with('%')};
    if (wanted.is_relative) number.remove_suffix(1);
    const auto value = positive_number(number);
    if (!value)
      return fail(where + (percent == Percent::allowed ? "must be a number above 0, or one with %"
                                                       : "must be a number above 0"));
    wanted.value = *value;
    if (std::ranges::find(all, wanted.quantity, &Wanted::quantity) != all.end())
      return fail(where + "this quantity is named twice");
    all.push_back(wanted);
  }
  return all;
}

std::string wanted_text(const std::vector<Wanted>& wanted) {
  std::string text;
  for (const Wanted& each : wanted)
    text += fmt::format("{}{}:{}{}", text.empty() ? "" : ",", reduction::name(each.quantity), each.value,
                        each.is_relative ? "%" : "");
  return text;
}

}  // namespace strobe::host
