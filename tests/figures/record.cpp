#include "tests/figures/record.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <regex>
#include <set>

namespace strobe::figures {
namespace {

double rounded(double x, int digits) { return std::stod(fmt::format("{:.{}g}", x, digits)); }

/// What is wrong with a figure of the record; empty if nothing is.
std::string fault_of(const Json& figure) {
  for (const char* key : {"what", "command", "text", "measured", "machine"})
    if (!figure.contains(key) || !figure[key].is_string()) return fmt::format("has no text \"{}\"", key);
  if (!figure.contains("values") || !figure["values"].is_object()) return "has no \"values\"";
  for (const auto& [name, value] : figure["values"].items()) {
    if (!value.contains("value") || !value["value"].is_number())
      return fmt::format("{} has no \"value\"", name);
    if (!value.contains("tolerance") || !value["tolerance"].is_number())
      return fmt::format("{} has no \"tolerance\"", name);
  }
  return {};
}

Result<std::string> replaced_between(const std::string& text, const std::regex& begin, const std::string& end,
                                     const auto& make) {
  std::string result;
  std::size_t from = 0;
  std::smatch match;
  while (std::regex_search(text.begin() + static_cast<std::ptrdiff_t>(from), text.end(), match, begin)) {
    const auto body = static_cast<std::size_t>(match[0].second - text.begin());
    const std::size_t close = text.find(end, body);
    if (close == std::string::npos) return fail(fmt::format("{} has no {}", match.str(), end));
    const Result<std::string> made = make(match[1].str());
    if (!made) return made;
    result += text.substr(from, body - from) + *made + end;
    from = close + end.size();
  }
  return result + text.substr(from);
}

}  // namespace

Result<Json> load(const std::filesystem::path& file) {
  std::ifstream stream(file);
  const Json record = Json::parse(stream, nullptr, false);
  if (record.is_discarded() || !record.contains("figures") || !record.contains("groups"))
    return fail(fmt::format("{}: cannot be read, or is not a record of figures", file.string()));
  for (const auto& [name, figure] : record["figures"].items())
    if (const std::string fault = fault_of(figure); !fault.empty())
      return fail(fmt::format("{}: {} {}", file.string(), name, fault));
  return record;
}

Result<std::string> stated(const Json& figure) {
  static const std::regex name(R"(\{(\w+)\})");
  std::string text = figure["text"];
  std::smatch match;
  while (std::regex_search(text, match, name)) {
    const std::string key = match[1];
    if (!figure["values"].contains(key)) return fail(fmt::format("no value is named {}", key));
    text = match.prefix().str() + fmt::format("{}", figure["values"][key]["value"].get<double>()) +
           match.suffix().str();
  }
  return text;
}

Result<std::string> table_of(const Json& record, const std::string& group) {
  if (!record["groups"].contains(group)) return fail("no group of figures is named " + group);
  std::set<std::string> machines;
  std::string table = "| what | measured | when | command |\n|---|---|---|---|\n";
  for (const std::string name : record["groups"][group]) {
    if (!record["figures"].contains(name)) return fail("no figure is named " + name);
    const Json& figure = record["figures"][name];
    const Result<std::string> text = stated(figure);
    if (!text) return fail(name + ": " + text.error().message);
    table += fmt::format("| {} | {} | {} | `{}` |\n", figure["what"].get<std::string>(), *text,
                         figure["measured"].get<std::string>(), figure["command"].get<std::string>());
    machines.insert(figure["machine"].get<std::string>());
  }
  return table + fmt::format("\nOn: {}.\n", fmt::join(machines, "; "));
}

Result<std::string> regenerated(const std::string& text, const Json& record) {
  static const std::regex tables(R"(<!-- figures: (\w+) -->)");
  static const std::regex texts(R"(<!-- figure: (\w+) -->)");
  const auto with_tables =
      replaced_between(text, tables, "<!-- end of figures -->", [&](const std::string& group) {
        return table_of(record, group).map([](const std::string& table) { return "\n" + table; });
      });
  if (!with_tables) return with_tables;
  return replaced_between(*with_tables, texts, "<!-- end of figure -->",
                          [&](const std::string& name) -> Result<std::string> {
                            if (!record["figures"].contains(name)) return fail("no figure is named " + name);
                            return stated(record["figures"][name]);
                          });
}

std::optional<double> found_in(const std::string& output, const Json& value) {
  if (!value.contains("pattern")) return std::nullopt;
  const std::regex pattern(value["pattern"].get<std::string>());
  std::vector<double> found;
  for (std::sregex_iterator match(output.begin(), output.end(), pattern), end; match != end; ++match)
    found.push_back(std::stod((*match)[1]));
  if (found.empty()) return std::nullopt;
  const std::string take = value.value("take", "last");
  double taken = found.back();
  if (take == "min") taken = *std::min_element(found.begin(), found.end());
  if (take == "max") taken = *std::max_element(found.begin(), found.end());
  if (take == "median") {
    std::sort(found.begin(), found.end());
    taken = found[found.size() / 2];
  }
  if (take == "sum") taken = std::accumulate(found.begin(), found.end(), 0.0);
  return rounded(taken * value.value("factor", 1.0), value.value("digits", 3));
}

Change compare(double recorded, double measured, const Json& value) {
  const double allowed = value["tolerance"].get<double>() * std::abs(recorded);
  if (std::abs(measured - recorded) <= allowed) return Change::same;
  const std::string worse = value.value("worse", "either");
  const bool is_higher = measured > recorded;
  return worse == "either" || (worse == "higher") == is_higher ? Change::worse : Change::moved;
}

}  // namespace strobe::figures
