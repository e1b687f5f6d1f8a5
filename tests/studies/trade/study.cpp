#include "tests/studies/trade/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace strobe::studies::trade {

namespace {

/// Errors of a few roundings of a double are equal.
constexpr double kUnit = 5e-16;

/// Costs this close count as equal.
constexpr double kCostMargin = 0.05;

/// Errors below this are rounding, which does not fall with a tolerance.
constexpr double kRounding = 1e-13;

std::optional<double> number_after(const std::string& parameter, const std::string& name) {
  if (parameter.rfind(name + "=", 0) != 0) return std::nullopt;
  return std::stod(parameter.substr(name.size() + 1));
}

/// Rows of one integrator must get better from one tolerance (or step count) to the next finer one.
void check_falling(const Study& study, const std::string& name, std::vector<std::string>& broken) {
  for (const Row& coarse : study.rows) {
    for (const Row& fine : study.rows) {
      if (coarse.method != fine.method || coarse.source != Source::numerical) continue;
      const auto a = number_after(coarse.parameter, name);
      const auto b = number_after(fine.parameter, name);
      if (!a || !b) continue;
      const bool finer = name == "steps" ? *b >= 8.0 * *a : *b <= *a / 8.0;
      if (finer && fine.practical.rms > std::max(coarse.practical.rms, kRounding))
        broken.push_back(fmt::format("{}: {} errs by {:.2e}, more than {} by {:.2e}", study.name, label(fine),
                                     fine.practical.rms, coarse.parameter, coarse.practical.rms));
    }
  }
}

}  // namespace

double error_of(const Row& row) { return std::max(row.practical.worst, row.thesis.worst); }

std::string label(const Row& row) {
  return row.parameter.empty() ? row.method : row.method + " " + row.parameter;
}

std::vector<std::optional<Dominated>> dominated(const Study& study) {
  std::vector<std::optional<Dominated>> all;
  for (const Row& row : study.rows) {
    const double margin = row.source == Source::noise ? 0.02 : 1e-9;
    std::optional<Dominated> found;
    for (std::size_t i = 0; i < study.rows.size(); ++i) {
      const Row& other = study.rows[i];
      if (&other == &row) continue;
      const double slower = row.cost_us / other.cost_us;
      const double worse = std::max(error_of(row), kUnit) / std::max(error_of(other), kUnit);
      if (slower < 1.0 - kCostMargin || worse < 1.0 - margin) continue;
      if (slower <= 1.0 + kCostMargin && worse <= 1.0 + margin) continue;
      if (!found || slower * worse > found->slower * found->worse)
        found = Dominated{.by = i, .slower = std::max(1.0, slower), .worse = std::max(1.0, worse)};
    }
    all.push_back(found);
  }
  return all;
}

std::vector<std::size_t> beyond_own(const Study& study, const std::string& without) {
  std::vector<std::size_t> beyond;
  for (std::size_t i = 0; i < study.rows.size(); ++i) {
    const Row& row = study.rows[i];
    if (!row.general) continue;
    const bool beaten = std::ranges::any_of(study.rows, [&](const Row& own) {
      return !own.general && own.method != without && own.cost_us <= row.cost_us * (1.0 + kCostMargin) &&
             std::max(error_of(own), kUnit) <= std::max(error_of(row), kUnit) * (1.0 + 1e-9);
    });
    if (!beaten) beyond.push_back(i);
  }
  return beyond;
}

std::vector<std::string> broken_invariants(const std::vector<Study>& studies) {
  std::vector<std::string> broken;
  for (const Study& study : studies) {
    check_falling(study, "tolerance", broken);
    check_falling(study, "steps", broken);
    for (const Row& row : study.rows) {
      const auto promised = number_after(row.parameter, "tolerance");
      if (row.method == "planned" && promised && error_of(row) > *promised)
        broken.push_back(fmt::format("{}: {} differs by {:.2e}", study.name, label(row), error_of(row)));
      if (!(std::isfinite(error_of(row)) && row.cost_us > 0.0))
        broken.push_back(fmt::format("{}: {} has no finite error or cost", study.name, label(row)));
      const bool rounds = row.practical.worst < 100.0 * kRounding;
      if (!rounds && study.reference > 0.01 * row.practical.worst)
        broken.push_back(fmt::format("{}: the reference errs by {:.2e}, too much to judge {} by ({:.2e})",
                                     study.name, study.reference, label(row), row.practical.worst));
    }
  }
  return broken;
}

}  // namespace strobe::studies::trade
