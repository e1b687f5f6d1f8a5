#include "tests/studies/efficiency/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

namespace strobe::studies {

namespace {

using reduction::Quantity;

struct Column {
  Quantity quantity;
  const char* title;
};
constexpr std::array kColumns{Column{Quantity::vx_td_mps, "vx_TD"},
                              Column{Quantity::vy_td_mps, "vy_TD"},
                              Column{Quantity::omega_td_radps, "omega_TD"},
                              Column{Quantity::vx_lo_mps, "vx_LO"},
                              Column{Quantity::vy_lo_mps, "vy_LO"},
                              Column{Quantity::omega_lo_radps, "omega_LO"},
                              Column{Quantity::e, "e"},
                              Column{Quantity::mu, "mu"},
                              Column{Quantity::dwell_time_ms, "dwell t"},
                              Column{Quantity::dwell_distance_cm, "dwell x"}};

using Measure = std::function<double(const Score&)>;

struct NamedMeasure {
  const char* title;
  Measure of;
};

const std::vector<NamedMeasure>& measures() {
  static const std::vector<NamedMeasure> all{
      {"rms error/bound", [](const Score& s) { return s.by_bound; }},
      {"typical error/bound", [](const Score& s) { return s.typical; }},
      {"bias/bound", [](const Score& s) { return s.bias; }},
      {"rms error/stated sd", [](const Score& s) { return s.by_sd; }},
      {"share within 68.27 %", [](const Score& s) { return s.within_68; }},
      {"share within the 95 % interval", [](const Score& s) { return s.within_95; }}};
  return all;
}

const Score& score(const Condition& condition, std::size_t method, Quantity q) {
  return condition.of_method[method][static_cast<std::size_t>(q)];
}

/// Over the conditions.
struct Spread {
  double least = 0.0, median = 0.0, most = 0.0;
};

Spread spread(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return {kUnknown, kUnknown, kUnknown};
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return {values.front(), 0.5 * (values[(n - 1) / 2] + values[n / 2]), values.back()};
}

std::string number(double value) {
  if (std::isnan(value)) return "-";
  const double size = std::abs(value);
  if (size >= 9999.5) return fmt::format("{:.1e}", value);
  return size >= 99.95 ? fmt::format("{:.0f}", value)
                       : fmt::format("{:.{}f}", value, size >= 9.995 ? 1 : (size >= 1.9995 ? 2 : 3));
}

std::string header(const char* first) {
  std::string line = fmt::format("{:<34}", first);
  for (const Column& column : kColumns) line += fmt::format(" {:>17}", column.title);
  return line + "\n";
}

/// Whether some quantity has that measure by that method.
bool has(const Result& result, std::size_t method, const NamedMeasure& measure) {
  return std::ranges::any_of(kColumns, [&](const Column& column) {
    return !std::isnan(measure.of(score(result.conditions.front(), method, column.quantity)));
  });
}

template <typename Cell>
std::string row(const std::string& first, Cell cell) {
  std::string line = fmt::format("{:<34}", first);
  for (const Column& column : kColumns) line += fmt::format(" {:>17}", cell(column.quantity));
  return line + "\n";
}

std::string range(const Spread& s) {
  if (std::isnan(s.median)) return "-";
  return fmt::format("{} ({}-{})", number(s.median), number(s.least), number(s.most));
}

}  // namespace

std::string summary(const Result& result) {
  std::string text = fmt::format("\n== {}: {}\n   median (least-most) over {} conditions of {} shots\n",
                                 result.scenario.name, result.scenario.what, result.conditions.size(),
                                 score(result.conditions.front(), 0, Quantity::vx_td_mps).shots);
  for (const NamedMeasure& measure : measures()) {
    text += header(measure.title);
    for (std::size_t m = 0; m < result.methods.size(); ++m) {
      if (!has(result, m, measure)) continue;
      text += row("  " + result.methods[m].name, [&](Quantity q) {
        std::vector<double> values;
        for (const Condition& c : result.conditions) values.push_back(measure.of(score(c, m, q)));
        return range(spread(values));
      });
    }
  }
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    int absent = 0;
    for (const Condition& c : result.conditions) absent += score(c, m, Quantity::vx_td_mps).absent;
    if (absent > 0)
      text += fmt::format("  {}: {} shots without numbers, left out\n", result.methods[m].name, absent);
  }
  return text;
}

std::string times_worse(const Result& result) {
  std::string text = header("rms error/best's rms error");
  for (std::size_t m = 1; m < result.methods.size(); ++m) {
    text += row("  " + result.methods[m].name, [&](Quantity q) {
      std::vector<double> values;
      for (const Condition& c : result.conditions) values.push_back(score(c, m, q).rms / score(c, 0, q).rms);
      return range(spread(values));
    });
  }
  return text;
}

std::string long_table(const Result& result) {
  std::string text;
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    for (const NamedMeasure& measure : measures()) {
      if (!has(result, m, measure)) continue;
      text += fmt::format("\n-- {}, {}: {}\n{:<10}", result.scenario.name, result.methods[m].name,
                          measure.title, "");
      for (const Column& column : kColumns) text += fmt::format(" {:>8}", column.title);
      text += "\n";
      for (const Condition& c : result.conditions) {
        text += fmt::format("{:<10}", c.name);
        for (const Column& column : kColumns)
          text += fmt::format(" {:>8}", number(measure.of(score(c, m, column.quantity))));
        text += "\n";
      }
    }
  }
  return text;
}

std::string json_lines(const Result& result) {
  std::string text;
  for (const Condition& c : result.conditions) {
    for (std::size_t m = 0; m < result.methods.size(); ++m) {
      for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
        const Score& s = c.of_method[m][i];
        if (s.shots == 0) continue;
        text += nlohmann::json{{"scenario", result.scenario.name},
                               {"condition", c.name},
                               {"method", result.methods[m].name},
                               {"quantity", std::string(reduction::kQuantityNames[i])},
                               {"shots", s.shots},
                               {"absent", s.absent},
                               {"rms", s.rms},
                               {"rms_by_bound", s.by_bound},
                               {"typical_by_bound", s.typical},
                               {"bias_by_bound", s.bias},
                               {"rms_by_sd", s.by_sd},  // not known: null
                               {"within_68", s.within_68},
                               {"within_95", s.within_95}}
                    .dump() +
                "\n";
      }
    }
  }
  return text;
}

}  // namespace strobe::studies
